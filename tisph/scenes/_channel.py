"""The flow in a plane channel: geometry, wall motion, drive, fluid, exact solution, measures and views.

The walls move by motions that a config gives or by stresses; the reference flow (``exact/start_up.py``) is solved once.

Layers in which the exact flow changes from one velocity to another: the motion that starts or changes at t = 0, of a
wall or of the drive of a fluid at rest, diffuses into the fluid to the depth sqrt(nu t). A wall that oscillates moves a
layer that counts with half its penetration depth, sqrt(nu/(2 w)): with so many spacings its error is the one of a layer
that diffuses (``benchmarks/resolution.py``). In a fluid with polymer a start is at first the front of a shear wave, see
``PolymerParameters.diffusive_fraction``.

A straight-line fit through the probes, the measure of the verification page, cannot see errors that are symmetric about
mid-gap. It is given, and always beside the errors of the whole profile.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tisph.exact.linear_viscoelasticity import apparent_viscosity
from tisph.exact.start_up import Flow, StartUp, Wall, fluid_of
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.motion import Schedule, StressControlledMotion, StressControlledWall, WallMotion
from tisph.measures.channel import Probes, integral, interpolate, wall_shear, wall_velocity
from tisph.measures.metrics import fit_line, relative_difference
from tisph.scenes._layers import PolymerParameters, age
from tisph.scenes._scene import Scene
from tisph.scenes._views import ExtraSeries, Line, Profile, TimeSeries


@lru_cache(maxsize=8)
def _solved(rheology, kinematic_viscosity, density, flow, before):
    return StartUp(fluid_of(rheology, kinematic_viscosity, density), flow, before)


def wall_of(config):
    """The motion of a wall of a config, or the plate that it is."""
    if config.velocities:
        return Schedule(config.times, config.velocities)
    return StressControlledWall.from_config(config) if config.stress_controlled else WallMotion.from_config(config)


CENTRELINE_POINTS = 32
"""Points along the channel over which the velocity at mid-gap is averaged."""


SIDES = ("bottom", "top")


MINUS = "\N{MINUS SIGN}"
_TIMES, _HEIGHTS = 40, 51  # at which it is looked for a flow that reverses
_WALL_TIMES = 2000  # a wall that oscillates is looked at more often: it costs nothing, and there speeds peak
_SMALL = 0.01  # of the largest speed: a flow slower than that counts as none


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
        bottom, top = (wall_of(wall) for wall in (config.walls.bottom, config.walls.top))
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
        return tuple((side, self.reference_motion(getattr(self, side))) for side in ("top", "bottom"))

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
        return max(self._largest_speed(wall) for wall in (self.bottom, self.top))

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
        """The ``StartUp`` from rest, or, where it is ``developed``, on from what had developed before t = 0."""
        walls = [each.over(self.density) if each.stress_controlled else each for each in (self.bottom, self.top)]
        flow = Flow(self.gap, *walls, self.acceleration)
        before = Flow(self.gap, *self._walls_before(), self.acceleration) if self.starts_developed else None
        return _solved(self.rheology, self.kinematic_viscosity, self.density, flow, before)

    def _walls_before(self):
        """The walls (bottom, top) before t = 0 of a flow developed by then; an oscillation has lasted for long."""
        for wall in (self.bottom, self.top):
            yield wall if wall.oscillates else Wall(wall.cosine if wall.before is None else wall.before)

    def _largest_speed(self, wall):
        """That of a wall; of a stress-controlled one, the speed at which a Newtonian fluid would bear the stress."""
        if wall.stress_controlled:
            return wall.largest_stress * self.gap / self.dynamic_viscosity
        return wall.relative_to(self.frame_velocity).largest_speed

    def driven_mean_velocity(self):
        """Mean velocity that the drive adds to the developed flow; None where the walls have a part in it.

        That is so at walls that a stress moves, and in a fluid that is not linear between walls of different
        velocities.
        """
        bottom, top, drive = self.bottom, self.top, self.acceleration
        if bottom.stress_controlled or top.stress_controlled:
            return None
        if self.rheology is None or self.rheology.type == "oldroyd_b":
            return drive * self.gap**2 / (12.0 * self.kinematic_viscosity)
        if bottom.oscillates or top.oscillates or bottom.cosine != top.cosine:
            return None
        fluid = fluid_of(self.rheology, self.kinematic_viscosity, self.density)
        return math.copysign(UniformShear(fluid.flux, fluid.laws).mean_velocity(abs(drive), self.gap), drive)

    def reference_motion(self, wall):
        """The motion of a wall; of a stress-controlled one, as it moves in the reference."""
        if not wall.stress_controlled:
            return wall
        height = self.gap * self.driven_side
        return StressControlledMotion(wall, self._largest_speed(wall), lambda t: self.exact_velocity(height, t))

    def thinnest_layer(self, t):
        """Depth [length] of the thinnest layer at time ``t`` on the run's clock, and where it is, in words.

        Infinite, and nothing, in a developed flow that goes on as it was.
        """
        ages = {name: self._age(wall, t) for name, wall in self._named_walls()}
        layers, since = [], min(ages.values())
        if since < math.inf:
            names = [name for name, time in ages.items() if time < math.inf]
            place = f"the layer at the {names[0]} wall" if len(names) == 1 else "the layer at each wall"
            share = self.polymer.diffusive_fraction(since) if self.polymer else 1.0
            depth = math.sqrt(share * self.kinematic_viscosity * since)
            in_the_fluid = share < 1.0 and self.elastic_speed * since > depth
            layers.append((depth, "the front of the shear wave" if in_the_fluid else place))
        for name, wall in self._named_walls():
            if wall.oscillates:
                half = 0.5 * wall.penetration_depth(self.kinematic_viscosity)
                layers.append((half, f"the layer at the oscillating {name} wall"))
        return min(layers, default=(math.inf, ""))

    def _named_walls(self):
        return (("bottom", self.bottom), ("top", self.top))

    def _age(self, wall, t):
        """Time at ``t`` since what drives the fluid at a wall has jumped; infinite where it never has."""
        if self.starts_developed:
            return t if wall.before is not None and wall.before != wall.cosine else math.inf
        still = not (wall.oscillates or wall.stress_controlled or wall.cosine)
        found = math.inf if still else age(wall, t)
        return min(found, t) if self.acceleration else found

    def diagnostics(self, snapshot, series):
        """Numbers of a snapshot with its reference; ``series`` begins with heights y and velocities u at the probes.

        With polymer ``shear_stress_l2`` = sqrt(sum (S-S_exact)^2 / sum S_exact^2) of S = S_xy, and
        ``normal_stress_l2``, that of the first normal stress difference S_xx - S_yy; ``slope`` (1/time), ``intercept``
        (velocity) of the least-squares line u(y) through the probes; ``centreline``: u at mid-gap, averaged along the
        channel; ``wall_shear_bottom``, ``wall_shear_top``: total shear stress on the fluid's side of the walls, see
        ``measures/channel.py``; each also ``_exact``, the lines being fitted to exact velocities at the same probes;
        ``density_variation`` = max |density/density_0 - 1|; ``max_transverse_velocity`` = max |v|. None where one does
        not exist (a wall shear that is infinite).
        """
        return {
            **self._stress_errors(snapshot),
            **self._line_fits(snapshot.t, *series[:2]),
            **self._centreline(snapshot),
            **self._wall_shears(snapshot),
            **self._plate(snapshot),
            "density_variation": np.max(np.abs(snapshot.density / self.density - 1)),
            "max_transverse_velocity": np.max(np.abs(snapshot.v)),
        }

    def _stress_errors(self, snapshot):
        if self.polymer is None:
            return {}
        exact = snapshot.reference
        normal = exact["stress_xx"] - exact["stress_yy"]
        return {
            "shear_stress_l2": relative_difference(snapshot.stress_xy, exact["stress_xy"]),
            "normal_stress_l2": relative_difference(snapshot.stress_xx - snapshot.stress_yy, normal),
        }

    def _line_fits(self, t, y, u):
        slope, intercept = fit_line(y, u)
        slope_exact, intercept_exact = fit_line(y, self.exact_velocity(y, t))
        return {
            "slope": slope,
            "slope_exact": slope_exact,
            "intercept": intercept,
            "intercept_exact": intercept_exact,
        }

    def _centreline(self, snapshot):
        x = (np.arange(CENTRELINE_POINTS) + 0.5) * self.length / CENTRELINE_POINTS
        middle = 0.5 * self.gap
        velocity = interpolate(snapshot, self, x, np.full(CENTRELINE_POINTS, middle))
        return {
            "centreline": np.mean(velocity),
            "centreline_exact": self.exact_velocity(middle, snapshot.t),
        }

    def _plate(self, snapshot):
        """Velocity of the stress-controlled wall, if there is one."""
        if self.driven_side is None:
            return {}
        velocity = wall_velocity(self, self.driven_side, snapshot)
        return {
            "plate_velocity": velocity,
            "plate_velocity_exact": self.exact_velocity(self.gap * self.driven_side, snapshot.t),
        }

    def _wall_shears(self, snapshot):
        bottom, top = wall_shear(self, snapshot)
        bottom_exact, top_exact = self.exact_wall_shear(snapshot.t)
        return {
            "wall_shear_bottom": bottom,
            "wall_shear_bottom_exact": bottom_exact,
            "wall_shear_top": top,
            "wall_shear_top_exact": top_exact,
        }

    @property
    def extra_series(self):
        """What a rheometer reads in time: stress at the walls, their velocities, normal stress, strain.

        None of a Newtonian fluid between walls of which none is stress-controlled or follows a schedule.
        """
        plain = self.polymer is None and self.rheology is None
        if plain and not any(wall.stress_controlled or wall.jump_times for wall in (self.bottom, self.top)):
            return None
        columns = [f"{name}_{side}" for name in ("wall_shear", "wall_velocity") for side in SIDES]
        return ExtraSeries(
            columns=[*columns, "n1_mean"] if self.polymer else columns,
            measure=lambda snapshot: self._measure(snapshot),
            final_columns=["strain", *(f"{name}_exact" for name in columns)],
            final=lambda times, values: self._final(times, values),
        )

    def _measure(self, snapshot):
        """Shear stress and velocity of both walls, and N1 = S_xx - S_yy of the polymer, mean over the fluid."""
        velocities = [
            wall_velocity(self, side, snapshot) if wall.stress_controlled else float(wall.velocity(snapshot.t))
            for side, wall in enumerate((self.bottom, self.top))
        ]
        normal = [np.mean(snapshot.stress_xx - snapshot.stress_yy)] if self.polymer else []
        return np.array([*wall_shear(self, snapshot), *velocities, *normal])

    def _final(self, times, values):
        """Strain, the way of the upper wall less that of the lower one over the gap; exact stresses and velocities.

        That of a stress-controlled wall is the integral of the velocities that the particles show.
        """
        ways = [
            integral(times, values[:, 2 + side]) if wall.stress_controlled else wall.displacement(times)
            for side, wall in enumerate((self.bottom, self.top))
        ]
        walls = [wall for _, wall in reversed(self.walls)]
        exact = [*self.exact_wall_shear(times), *(wall.velocity(times) for wall in walls)]
        strain = (ways[1] - ways[0]) / self.gap
        return np.column_stack([strain, *(np.where(np.isfinite(one), one, np.nan) for one in exact)])

    def profiles(self):
        """Velocity with its error; with polymer also its shear stress and first normal stress difference N1."""
        speed = self._velocity()
        if self.polymer is None:
            return [speed]
        return [speed, self._shear_stress(), self._normal_stress()]

    def time_series(self, count, x="centre"):
        """Velocities at ``count`` heights on a vertical line; arguments as ``Channel.probe_positions``."""
        places = self.probe_positions(count, x)
        heights, probes = places[1], Probes(self, *places)
        return TimeSeries(
            content="velocities u along x over time t at probes at heights y",
            name="u",
            unit="velocity",
            scale=self.reference_velocity,
            columns=[f"u(y={y:.6g})" for y in heights],
            labels=[("y/H", y / self.gap) for y in heights],
            exact_columns=[f"u_exact(y={y:.6g})" for y in heights],
            measure=probes.velocity,
            exact=lambda times: self.exact_velocity(heights, times[:, None]),
            places=heights,
            angular_frequency=max(wall.angular_frequency for _, wall in self.walls),
            probes=probes,
        )

    def movie_profiles(self):
        """The velocity, and the stresses of a polymer."""
        names = "speed", "shear_stress", "normal_stress_difference"
        return dict(zip(names, self.profiles(), strict=False))

    def movie_ends(self, name, profile, end):
        """Smallest and largest value of a ``profile`` to time ``end``, those of the walls among velocities."""
        walls = () if profile.unit == "stress" else self._wall_extremes(end)
        return [*profile.extremes(self.start_time, end), *walls]

    def movie_series(self):
        """Velocities at three heights."""
        return self.time_series(3)

    @property
    def vanishing_scale(self):
        """Tell whether the exact velocity takes both signs at any time, or decays.

        The flow itself decides, not the length of a run: the same flow has the same error measure everywhere.
        """
        if any(wall.oscillates or wall.stress_controlled for wall in (self.bottom, self.top)):
            return True
        slowest = max(self.viscous_time, self.polymer.relaxation_time if self.polymer else 0.0)
        # The slowest mode decays as exp(-pi^2 t*): at t* = 3 nothing of a start is left.
        times = self.start_time + 3.0 * slowest * np.linspace(0.0, 1.0, _TIMES) ** 2
        u = self.exact_velocity(np.linspace(0.0, self.gap, _HEIGHTS)[:, None], times[None, :])
        u -= self.frame_velocity
        small = _SMALL * np.abs(u).max()
        return bool((u.min() < -small and u.max() > small) or np.abs(u[:, -1]).max() <= small)

    def parameters(self):
        """Pairs (label, text) of what the flow is, independent of particles."""
        length, time = self.units.length, self.units.time
        by_walls = self.velocity_scale == self.wall_speed
        linear = self.rheology is None or self.rheology.type == "oldroyd_b"
        driven = any(wall.stress_controlled for wall in (self.bottom, self.top))
        own = not self.given_velocity and (driven or not by_walls)
        moving = f", in a frame that moves with {self.frame_velocity:.6g} {length}/{time}"
        frame = moving if self.frame_velocity else ""
        fluid = "" if linear or not own else ", in a Newtonian fluid of the viscosity nu"
        speed = f"{self.reference_velocity:.6g} {length}/{time}{frame}{fluid}"
        lines = [
            ("Reynolds number", f"{self.reynolds:.6g}  (U H / nu)"),
            (self.velocity_name("wall speed U" if by_walls else "mean speed U"), speed),
            ("length H", f"{self.gap:.6g} {length}, the gap"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("viscous time H^2/nu", f"{self.viscous_time:.6g} {time}"),
        ]
        if self.acceleration:
            mean, text = self.driven_mean_velocity(), f"{self.acceleration:.6g} {length}/{time}^2 along x"
            if mean is not None:
                text += (
                    f", of which the developed flow has the mean speed {mean:.{6 if linear else 4}g} {length}/{time}"
                )
            lines.append(("drive", text))
        for name, wall in reversed(self.walls):
            if wall.angular_frequency:
                depth = wall.penetration_depth(self.kinematic_viscosity)
                text = f"{depth:.4g} {length}, {depth / self.spacing:.3g} spacings  (sqrt(2 nu / w), {name} wall)"
                lines.append(("penetration depth", text))
        if self.polymer:
            lines.append(("Weissenberg number", f"{self.weissenberg:.4g}  (relaxation time * U / H)"))
            lines.append(("elasticity number", f"{self.elasticity:.4g}  (relaxation time * nu / H^2)"))
        return lines

    def _line(self):
        """All particles: nothing depends on x."""
        return Line("y", (0.0, self.gap), place=0.5 * self.length)

    def _velocity(self):
        return Profile(
            name="u",
            unit="velocity",
            line=self._line(),
            of=lambda snapshot: snapshot.u,
            exact=lambda x, y, t: self.exact_velocity(y, t),
            scale=(self.reference_velocity, "reference velocity U"),
        )

    def _shear_stress(self):
        return Profile(
            name="polymer shear stress Sxy",
            unit="stress",
            line=self._line(),
            of=lambda snapshot: snapshot.stress_xy,
            exact=lambda x, y, t: self.exact_polymer_shear_stress(y, t),
        )

    def _normal_stress(self):
        return Profile(
            name=f"first normal stress difference N1 = Sxx {MINUS} Syy",
            unit="stress",
            line=self._line(),
            of=lambda snapshot: snapshot.stress_xx - snapshot.stress_yy,
            exact=lambda x, y, t: self.exact_polymer_stress(y, t)[0] - self.exact_transverse_stress(y, t),
        )

    def _wall_extremes(self, end):
        times = np.linspace(self.start_time, end, _WALL_TIMES)
        walls = [wall for _, wall in reversed(self.walls)]
        velocities = np.concatenate([wall.velocity(times) for wall in walls])
        if self.start_time == 0.0:  # the fluid still has the velocity that a wall had before
            velocities = np.append(velocities, [wall.before for wall in walls if wall.before is not None])
        return float(velocities.min()), float(velocities.max())
