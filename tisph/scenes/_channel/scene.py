"""The flow in a plane channel: geometry, wall motion, drive, fluid and exact solution."""

from dataclasses import dataclass, replace

import numpy as np

from tisph.exact.linear_viscoelasticity import apparent_viscosity
from tisph.geometry.motion import Schedule, StressControlledWall, WallMotion
from tisph.scenes._channel import diagnostics, extra_series, flow, layers, views
from tisph.scenes._layers import PolymerParameters
from tisph.scenes._scene import Scene


@dataclass(frozen=True, kw_only=True)
class Channel(Scene):
    """Geometry, wall motion, drive, fluid and exact solution; every number in the config's units.

    ``acceleration`` acts on the fluid along x; ``polymer`` is None without one. ``initial_state`` is ``rest`` (the
    fluid starts from rest at t = 0), ``developed`` (the flow has developed before t = 0, under the walls' velocities
    before) or ``exact`` (the flow that started at t = 0, taken up at ``start_time``).
    """

    gap: float
    length: float
    bottom: WallMotion | StressControlledWall | Schedule
    top: WallMotion | StressControlledWall | Schedule
    acceleration: float = 0.0
    polymer: PolymerParameters | None = None
    initial_state: str
    start_time: float

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        bottom, top = (flow.wall(wall) for wall in (config.walls.bottom, config.walls.top))
        return cls(
            **cls.fluid_of(config),
            gap=config.geometry.gap,
            length=config.geometry.length,
            bottom=bottom,
            top=top,
            acceleration=config.drive.acceleration,
            polymer=PolymerParameters.of(config.fluid.polymer),
            initial_state=config.initial.state,
            start_time=config.start_time,
            columns=config.columns,
            rows=config.particles_across,
        )

    periodic = (True, False)
    parallel = True
    flow_quantities = ("slope", "intercept", "centreline", "wall_shear_bottom", "wall_shear_top")
    time_formula = "νt/H²"

    @property
    def extent(self):
        """Length and gap."""
        return self.length, self.gap

    @property
    def walls(self):
        """Both walls, the upper one first; of a stress-controlled one, how it moves in the reference."""
        return tuple((side, flow.reference_motion(self, getattr(self, side))) for side in ("top", "bottom"))

    @property
    def driven_side(self):
        """Which wall is stress-controlled: 0 the bottom, 1 the top one; None where the velocities of both are given."""
        return next((side for side, wall in enumerate((self.bottom, self.top)) if wall.stress_controlled), None)

    @property
    def fields(self):
        """The velocity along x, and the stresses of a polymer."""
        return ("u", "stress_xx", "stress_xy", "stress_yy") if self.polymer else ("u",)

    @property
    def frame_velocity(self):
        """Velocity along x of the frame that the flow has of its own, to which speeds and errors refer.

        Of a fluid at rest before the start it is that rest, 0. In one that is developed between walls it is the
        velocity of the first wall, from the bottom, that keeps it, or of the bottom wall before it changes; 0 where a
        wall oscillates, which it does about rest.
        """
        walls = (self.bottom, self.top)
        if not self.starts_developed or any(wall.oscillates or wall.stress_controlled for wall in walls):
            return 0.0
        before = [self._velocity_before(wall) for wall in walls]
        kept = [old for wall, old in zip(walls, before, strict=True) if wall.cosine == old]
        return (kept or before)[0]

    @property
    def wall_speed(self):
        """The largest speed that a wall has, or had before t = 0, relative to ``frame_velocity``."""
        return max(flow.largest_speed(self, wall) for wall in (self.bottom, self.top))

    @property
    def velocity_scale(self):
        """The largest of ``wall_speed`` and of |acceleration| gap^2 / (12 nu), the mean speed of the driven flow."""
        return max(self.wall_speed, abs(self.acceleration) * self.gap**2 / (12 * self.kinematic_viscosity))

    @property
    def peak_velocity(self):
        """Bound of the developed flow's speed: ``wall_speed`` + |acceleration| gap^2 / (8 nu), or a given velocity."""
        developed = self.wall_speed + abs(self.acceleration) * self.gap**2 / (8 * self.kinematic_viscosity)
        return max(developed, self.given_velocity or 0.0)

    @property
    def reference_length(self):
        """The gap."""
        return self.gap

    @property
    def elasticity(self):
        """Elasticity number, relaxation time * kinematic viscosity / gap^2; 0 without polymer."""
        return self.polymer.relaxation_time / self.viscous_time if self.polymer else 0.0

    @property
    def time_scale(self):
        """``viscous_time``, in which momentum diffuses across the channel."""
        return self.viscous_time

    @property
    def polymer_viscosity(self):
        """Kinematic viscosity that the polymer adds; 0 without polymer."""
        return self.kinematic_viscosity * (1.0 - self.polymer.solvent_fraction) if self.polymer else 0.0

    @property
    def elastic_speed(self):
        """Speed sqrt(polymer viscosity / relaxation time) of shear waves in the polymer; 0 without polymer."""
        return float(np.sqrt(self.polymer_viscosity / self.polymer.relaxation_time)) if self.polymer else 0.0

    @property
    def starts_developed(self):
        """Whether the flow before t = 0 is a developed one, not rest."""
        given = self.bottom.before is not None or self.top.before is not None
        return self.initial_state == "developed" or (self.initial_state == "exact" and given)

    @property
    def superposes(self):
        """Whether flows of other walls and times of start add up to this one: the law is linear, velocities are given.

        A wall that oscillates starts no developed flow but that of a Newtonian fluid.
        """
        walls = self.bottom, self.top
        linear = self.rheology is None or (
            self.rheology.type == "oldroyd_b" and not any(wall.oscillates for wall in walls)
        )
        return linear and not any(wall.stress_controlled for wall in walls)

    @property
    def wall_jumps(self):
        """By how much the velocities of the (bottom, top) wall jump when the run starts, from those of the fluid."""
        if self.start_time > 0:
            return 0.0, 0.0
        walls = (self.bottom, self.top)
        return tuple(
            0.0 if wall.stress_controlled else wall.velocity(0.0) - self._velocity_before(wall) for wall in walls
        )

    def _velocity_before(self, wall):
        if wall.before is not None:
            return wall.before
        return wall.velocity(0.0) if self.starts_developed else 0.0

    def in_flow_frame(self):
        """The same flow as it is seen from a frame that moves with ``frame_velocity``."""
        if self.frame_velocity == 0.0:
            return self
        bottom, top = (wall.relative_to(self.frame_velocity) for wall in (self.bottom, self.top))
        return replace(self, bottom=bottom, top=top)

    def apparent_viscosity(self, viscosity, angular_frequency):
        """Stress at a wall that oscillates, over its speed over the gap, of a fluid of the complex ``viscosity``."""
        return apparent_viscosity(viscosity, angular_frequency, self.density, self.gap)

    def exact_velocity(self, y, t):
        """Exact velocity along x at heights ``y`` and times ``t`` (they broadcast), on the run's clock."""
        return self._flow.velocity(y, t)

    def exact_wall_shear(self, t):
        """Exact shear stress, of solvent and polymer together, at (bottom, top) wall at time(s) ``t``.

        Infinite at t = 0 on a wall whose velocity jumps then.
        """
        walls = np.reshape([0.0, self.gap], (2, *[1] * np.ndim(t)))  # at once: what costs is a time, not a height
        return tuple(self.density * self._flow.shear_stress(walls, t))

    def viscous_stress(self, shear_rate):
        """Shear stress of the solvent at a ``shear_rate``, or of a fluid whose viscosity depends on it."""
        if self.rheology is None or self.polymer:
            return self.density * self.solvent_viscosity * shear_rate
        law = self.rheology.law(self.kinematic_viscosity, self.density)
        return self.density * law.viscosity(shear_rate**2) * shear_rate

    def exact_polymer_stress(self, y, t):
        """Exact polymer stresses (S_xx, S_xy) [mass/(length time^2)], shaped as ``exact_velocity``."""
        xx, xy, _ = self.density * self._flow.polymer_stress(y, t)
        return xx, xy

    def exact_transverse_stress(self, y, t):
        """Exact polymer stress S_yy, 0 but for fluids with a second normal stress difference."""
        return self.density * self._flow.polymer_stress(y, t)[2]

    def exact_polymer_shear_stress(self, y, t):
        """Exact polymer stress S_xy alone."""
        return self.exact_polymer_stress(y, t)[1]

    def exact(self, field, x, y, t):
        """Exact value of one of ``fields``, which do not depend on ``x``."""
        if field == "u":
            return self.exact_velocity(y, t)
        if field == "stress_xy":
            return self.exact_polymer_shear_stress(y, t)
        if field == "stress_xx":
            return self.exact_polymer_stress(y, t)[0]
        return self.exact_transverse_stress(y, t)

    def initial(self, x, y):
        """Velocities, and stresses of a polymer, when the run starts."""
        u = self.initial_velocity(y)
        fields = {"u": u, "v": np.zeros_like(u)}
        if self.polymer:
            xx, xy = self.initial_polymer_stress(y)
            yy = self.exact_transverse_stress(y, self.start_time)
            fields |= {"stress_xx": xx, "stress_xy": xy, "stress_yy": yy}
        return fields

    diagnostics = diagnostics.diagnostics
    extra_series = property(extra_series.extra_series)
    movie_ends = views.movie_ends
    movie_profiles = views.movie_profiles
    movie_series = views.movie_series
    parameters = views.parameters
    profiles = views.profiles
    thinnest_layer = layers.thinnest_layer
    time_series = views.probes
    vanishing_scale = property(views.vanishing_scale)

    def description(self):
        """Gap and length."""
        return {"gap": self.gap, "length": self.length}

    def initial_velocity(self, y):
        """Velocity along x at heights ``y`` when the run starts."""
        return self.exact_velocity(y, self.start_time)

    def initial_polymer_stress(self, y):
        """Polymer stresses (S_xx, S_xy) at heights ``y`` when the run starts."""
        return self.exact_polymer_stress(y, self.start_time)

    def initial_conformation_excess(self, y):
        """C of each of the polymer's modes at heights ``y`` (heights,) when the run starts, see ``rheology``.

        List of arrays (components, heights).
        """
        return self._flow.conformation_excess(y, self.start_time)

    def probe_positions(self, count, x="centre"):
        """Arrays (x, y) of ``count`` probes on a vertical line, at heights (k + 1/2) gap / count.

        ``x`` is a distance along the channel, or ``centre``.
        """
        position = 0.5 * self.length if x == "centre" else x
        return np.full(count, float(position)), (np.arange(count) + 0.5) * self.gap / count

    @property
    def _flow(self):
        return flow.reference_flow(self)
