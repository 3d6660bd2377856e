"""The flow in a plane channel: geometry, wall motion, drive, fluid, exact solution, measures and views.

Walls have given motions, or are stress-controlled. The reference flow (``exact/start_up.py``) is solved once.

Layers: the motion of a wall, or of the drive of a fluid at rest, that starts or changes at t = 0 diffuses into the
fluid to the depth sqrt(nu t). The layer at an oscillating wall counts with half its penetration depth, sqrt(nu/(2 w)):
with so many spacings its error equals the error of a diffusing layer (``benchmarks/resolution.py``). In a polymeric
fluid a start is at first the front of a shear wave, see ``PolymerParameters.diffusive_fraction``.

A straight-line fit through the probes, the measure of the verification page, does not show errors that are symmetric
about mid-gap. It is always reported together with the errors of the whole profile.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tisph.config.motion import slip_length_of
from tisph.config.schema import Config
from tisph.exact._fluids import Rheology, fluid_of
from tisph.exact.heated_shear import StartUp as HeatedStartUp
from tisph.exact.heated_shear import Wall as HeatedWall
from tisph.exact.linear_viscoelasticity import apparent_viscosity
from tisph.exact.start_up import Flow, StartUp, Wall, slipping
from tisph.exact.uniform_shear import UniformShear
from tisph.geometry.motion import Schedule, StressControlledMotion, StressControlledWall, WallMotion
from tisph.measures.channel import ChannelFlow, Probes, integral, interpolate, wall_shear, wall_velocity
from tisph.measures.flow import PolymerParameters
from tisph.measures.heat import sheared, wall_of_shear
from tisph.measures.metrics import fit_line, relative_difference
from tisph.measures.substance import TEMPERATURE, Condition, Substance
from tisph.scenes._scene import Scene, age
from tisph.scenes._views import ExtraSeries, Line, Profile, TimeSeries
from tisph.snapshot import STRESSES, Snapshot

SIDES = ("bottom", "top")

MINUS = "\N{MINUS SIGN}"

CENTRELINE_POINTS = 32
"""Points along the channel over which the velocity at mid-gap is averaged."""

_TIMES, _HEIGHTS = 40, 51  # at which the flow is checked for reversal
_WALL_TIMES = 2000  # for the extremes of wall velocities, which peak there and are cheap
_SMALL = 0.01  # of the largest speed: a slower flow counts as none


@lru_cache(maxsize=8)
def _solved(
    rheology: Rheology | None, kinematic_viscosity: float, density: float, flow: Flow, before: Flow | None
) -> StartUp:
    return StartUp(fluid_of(rheology, kinematic_viscosity, density), flow, before)


@lru_cache(maxsize=8)
def _heated(
    gap: float, bottom: Any, top: Any, density: float, viscosity: float, acceleration: float, heat: Substance
) -> HeatedStartUp:
    """Return the flow of a Newtonian fluid from rest, with its temperature, between walls of given motion."""

    def wall(motion: Any, condition: Condition, y: float) -> HeatedWall:
        return wall_of_shear(condition, np.array([0.0, y]), 0.0, lambda t: float(motion.velocity(t)))

    walls = wall(bottom, heat.conditions[0], 0.0), wall(top, heat.conditions[1], gap)
    law = lambda temperature, rate: density * viscosity * heat.factor(temperature)  # noqa: E731
    flow = sheared(heat, (0.0, gap), walls, law, density, acceleration)
    breaks = {float(time) for motion in (bottom, top) for time in motion.jump_times if time > 0.0}
    return HeatedStartUp(flow, float(heat.initial.given), sorted(breaks))


def wall_of(wall: Any) -> WallMotion | StressControlledWall | Schedule:
    """Return the motion of a ``wall`` of a config, or its stress."""
    if wall.velocities:
        return Schedule(wall.times, wall.velocities)
    return StressControlledWall.from_config(wall) if wall.stress_controlled else WallMotion.from_config(wall)


def n1(snapshot: Any) -> np.ndarray:
    """Return the polymer's first normal stress difference S_xx - S_yy (particles,)."""
    return snapshot.stress_xx - snapshot.stress_yy


@dataclass(frozen=True, kw_only=True)
class Channel(ChannelFlow, Scene):
    """Geometry, wall motion, drive, fluid and exact solution; all quantities in the config's units.

    ``initial_state`` is ``rest`` (the fluid starts from rest at t = 0), ``developed`` (the flow has developed before
    t = 0, under the walls' velocities before) or ``exact`` (the flow that started at t = 0, from ``start_time`` on).
    """

    initial_state: str
    start_time: float
    pulsation: WallMotion | Schedule | None = None

    periodic = (True, False)
    parallel = True
    flow_quantities = ("slope", "intercept", "centreline", "wall_shear_bottom", "wall_shear_top")
    time_formula = "νt/H²"

    @classmethod
    def from_config(cls, config: Config) -> "Channel":
        """Return the scene that a validated config describes."""
        bottom, top = (slip_length_of(getattr(config.walls, side)) for side in SIDES)
        return cls(
            **cls.fluid_of(config),
            gap=config.geometry.gap,
            length=config.geometry.length,
            bottom=wall_of(config.walls.bottom),
            top=wall_of(config.walls.top),
            **config.drive.parts,
            polymer=PolymerParameters.of(config.fluid.polymer),
            slip_lengths=(bottom, top),
            initial_state=config.initial.state,
            start_time=config.start_time,
            columns=config.columns,
            rows=config.particles_across,
        )

    @property
    def walls(self) -> tuple[tuple[str, Any], ...]:
        """Both walls, the upper one first; for a stress-controlled wall, its motion in the reference."""
        motions: dict[str, Any] = {"top": self.top, "bottom": self.bottom}
        if self.driven_side is not None:
            wall, height = self.pair[self.driven_side], self.gap * self.driven_side
            moved = StressControlledMotion(wall, self._largest_speed(wall), lambda t: self.exact_velocity(height, t))
            motions[SIDES[self.driven_side]] = moved
        return tuple(motions.items())

    @property
    def seeks_wall_velocity(self) -> bool:
        """Whether the velocity of the fluid at a wall is unknown: the wall is stress-controlled, or the fluid slips."""
        return self.driven_side is not None or any(self.slip_lengths)

    @property
    def reference_walls(self) -> tuple[Any, ...]:
        """The (bottom, top) wall of the exact solution, per unit density."""
        walls = (wall.over(self.density) if wall.stress_controlled else wall for wall in self.pair)
        return tuple(self._slipping(*each) for each in zip(walls, self.slip_lengths, strict=True))

    def _slipping(self, wall: Any, slip_length: float) -> Any:
        return slipping(wall, slip_length, self.kinematic_viscosity)

    @property
    def fields(self) -> tuple[str, ...]:
        """The velocity along x, and the stresses of a polymer."""
        if not self.comparable:
            return ()
        known = ("u", *STRESSES) if self.polymer else ("u",)
        return (*known, TEMPERATURE) if self._heated_flow else known

    @property
    def comparable(self) -> bool:
        """See ``FlowInBox.comparable``: of a fluid that heats up from rest, with constant conditions, flow is known."""
        return self.isothermal or self._heated_flow is not None

    @property
    def _heated_flow(self) -> HeatedStartUp | None:
        """Velocity and temperature of a Newtonian fluid at rest at first, where walls have constant conditions."""
        heat, rest = self.temperature, self.initial_state == "rest" and self.start_time == 0.0
        plain = self.rheology is None and not self.seeks_wall_velocity and not self.pulsation
        if heat is None or not (rest and plain and self.inertia):
            return None
        formulas = [heat.initial, *(condition.value or condition.flux for condition in heat.conditions)]
        if heat.has_source or any(formula is None or isinstance(formula.given, str) for formula in formulas):
            return None
        return _heated(self.gap, self.bottom, self.top, self.density, self.kinematic_viscosity, self.acceleration, heat)

    def _of_heated_flow(self, name: str, y: Any, t: Any) -> np.ndarray:
        """Return the velocity, temperature or shear stress, by its ``name``, of the heated flow; they broadcast."""
        flow: Any = self._heated_flow
        y, t = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        found = np.empty(y.shape)
        for time in np.unique(t):
            found[t == time] = getattr(flow.at(float(time)), name)(y[t == time])
        return found

    # Scales -----------------------------------------------------------------------------------------------------------

    @property
    def frame_velocity(self) -> float:
        """Velocity along x of the frame in which the initial flow is at rest; speeds and errors refer to this frame.

        0 for a fluid at rest before the start, or if a wall oscillates, which it does about rest. If the flow between
        the walls has developed, the velocity of the first wall, from the bottom, whose velocity does not change; or the
        bottom wall's velocity before it changes.
        """
        if not self.starts_developed or any(wall.oscillates or wall.stress_controlled for wall in self.pair):
            return 0.0
        before = [self._velocity_before(wall) for wall in self.pair]
        kept = [old for wall, old in zip(self.pair, before, strict=True) if wall.cosine == old]
        return (kept or before)[0]

    @property
    def wall_speed(self) -> float:
        """The largest speed that a wall has, or had before t = 0, relative to ``frame_velocity``."""
        return max(self._largest_speed(wall) for wall in self.pair)

    def _largest_speed(self, wall: Any) -> float:
        """Return the largest speed of a wall, or the speed at which a Newtonian fluid has the stress of the wall."""
        if wall.stress_controlled:
            return wall.largest_stress * self.gap / self.dynamic_viscosity
        return wall.relative_to(self.frame_velocity).largest_speed

    @property
    def velocity_scale(self) -> float:
        """The larger of ``wall_speed`` and the mean speed |acceleration| gap^2 / (12 nu) of the driven flow.

        Slip makes it faster by the factor 12/(1/(1/2 + b_0/gap) + 1/(1/2 + b_1/gap)) - 2 of the slip lengths b.
        """
        mean = abs(self.acceleration) * self.gap**2 / (12 * self.kinematic_viscosity)
        mean = mean * self._slip_factor + self.pulsating_velocity(self.gap**2 / 12 * self._slip_factor)
        return max(self.wall_speed, mean)

    @property
    def _slip_factor(self) -> float:
        halves = (0.5 + slip_length / self.gap for slip_length in self.slip_lengths)
        return 12.0 / sum(1.0 / half for half in halves) - 2.0

    @property
    def peak_velocity(self) -> float:
        """Bound of the flow's speed: ``wall_speed`` + |acceleration| gap^2 / (8 nu), or a given velocity.

        An acceleration that oscillates from t = 0 on adds at most twice its amplitude over its angular frequency.
        """
        driven = abs(self.acceleration) * self.gap**2 / (8 * self.kinematic_viscosity)
        developed = self.wall_speed + driven * self._slip_factor
        developed += self.pulsating_velocity(self.gap**2 / 8 * self._slip_factor, inviscid=2.0)
        return max(developed, self.given_velocity or 0.0)

    @property
    def reference_length(self) -> float:
        """The gap."""
        return self.gap

    @property
    def time_scale(self) -> float:
        """``viscous_time``, in which momentum diffuses across the channel."""
        return self.viscous_time

    @property
    def elastic_speed(self) -> float:
        """Speed sqrt(polymer viscosity / relaxation time) of shear waves in the polymer; 0 without polymer."""
        return float(np.sqrt(self.polymer_viscosity / self.polymer.relaxation_time)) if self.polymer else 0.0

    @property
    def vanishing_scale(self) -> bool:
        """Whether the exact velocity has both signs at some time, or decays.

        This depends on the flow alone, not on the length of a run: the same flow has the same error measure everywhere.
        """
        if self.pulsation or any(wall.oscillates or wall.stress_controlled for wall in self.pair):
            return True
        slowest = max(self.viscous_time, self.polymer.relaxation_time if self.polymer else 0.0)
        # The slowest mode decays as exp(-pi^2 t*): at t* = 3 nothing of a start is left.
        times = self.start_time + 3.0 * slowest * np.linspace(0.0, 1.0, _TIMES) ** 2
        u = self.exact_velocity(np.linspace(0.0, self.gap, _HEIGHTS)[:, None], times[None, :])
        u -= self.frame_velocity
        small = _SMALL * np.abs(u).max()
        return bool((u.min() < -small and u.max() > small) or np.abs(u[:, -1]).max() <= small)

    # Start ------------------------------------------------------------------------------------------------------------

    @property
    def starts_developed(self) -> bool:
        """Whether the flow before t = 0 is a developed one, not rest."""
        given = self.bottom.before is not None or self.top.before is not None
        return self.initial_state == "developed" or (self.initial_state == "exact" and given)

    def _velocity_before(self, wall: Any) -> float:
        if wall.before is not None:
            return wall.before
        return wall.velocity(0.0) if self.starts_developed else 0.0

    @property
    def wall_jumps(self) -> tuple[float, ...]:
        """Jumps of the velocities of the (bottom, top) wall at the start of the run, from the velocity of the fluid."""
        if self.start_time > 0:
            return 0.0, 0.0
        return tuple(
            0.0 if wall.stress_controlled else wall.velocity(0.0) - self._velocity_before(wall) for wall in self.pair
        )

    @property
    def superposes(self) -> bool:
        """Whether flows of other walls and start times add up to this one: a linear law, and given wall velocities.

        The developed flow of an oscillating wall is known only for a Newtonian fluid.
        """
        known = self.rheology is None or not (self.pulsation or any(wall.oscillates for wall in self.pair))
        return self.linear and known and not self.seeks_wall_velocity

    def in_flow_frame(self) -> "Channel":
        """Return the same flow in a frame that moves with ``frame_velocity``."""
        if self.frame_velocity == 0.0:
            return self
        bottom, top = (wall.relative_to(self.frame_velocity) for wall in self.pair)
        return replace(self, bottom=bottom, top=top)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the velocities, and stresses of a polymer, when the run starts."""
        u = self.initial_velocity(y)
        fields = {"u": u, "v": np.zeros_like(u)}
        if self.polymer:
            fields |= dict(zip(STRESSES, self.exact_polymer_stress(y, self.start_time), strict=True))
        return fields

    def initial_velocity(self, y: np.ndarray) -> np.ndarray:
        """Return the velocity along x at heights ``y`` when the run starts."""
        return self.exact_velocity(y, self.start_time)

    def initial_conformation_excess(self, y: np.ndarray) -> list[np.ndarray]:
        """Return C (components, heights) of each polymer mode at heights ``y`` (heights,) when the run starts."""
        return self._flow.conformation_excess(y, self.start_time)

    def thinnest_layer(self, t: float) -> tuple[float, str]:
        """Return depth [length] and name of the thinnest layer at time ``t`` on the run's clock.

        Infinite, and no name, in a developed flow that does not change.
        """
        named = tuple(zip(SIDES, self.pair, strict=True))
        ages = {name: self._age(wall, t) for name, wall in named}
        layers, since = [], min(ages.values())
        if since < math.inf:
            names = [name for name, time in ages.items() if time < math.inf]
            place = f"the layer at the {names[0]} wall" if len(names) == 1 else "the layer at each wall"
            share = self.polymer.diffusive_fraction(since) if self.polymer else 1.0
            depth = math.sqrt(share * self.kinematic_viscosity * since)
            in_the_fluid = share < 1.0 and self.elastic_speed * since > depth
            layers.append((depth, "the front of the shear wave" if in_the_fluid else place))
        for name, wall in named:
            if wall.oscillates:
                half = 0.5 * wall.penetration_depth(self.kinematic_viscosity)
                layers.append((half, f"the layer at the oscillating {name} wall"))
        if self.pulsation:
            half = 0.5 * self.pulsation.penetration_depth(self.kinematic_viscosity)
            layers.append((half, "the layer at the walls of a flow that oscillates"))
        return min(layers, default=(math.inf, ""))

    def _age(self, wall: Any, t: float) -> float:
        """Return the time at ``t`` since wall or drive changed with a jump; infinite if they never did."""
        if self.starts_developed:
            return t if wall.before is not None and wall.before != wall.cosine else math.inf
        still = not (wall.oscillates or wall.stress_controlled or wall.cosine)
        found = math.inf if still else age(wall, t)
        if self.pulsation:
            found = min(found, age(self.pulsation, t))
        return min(found, t) if self.acceleration else found

    # Exact solution ---------------------------------------------------------------------------------------------------

    @property
    def _flow(self) -> StartUp:
        """The exact flow from rest, or from the flow that had developed before t = 0."""
        bottom, top = self.reference_walls
        flow, before = Flow(self.gap, bottom, top, self.acceleration, pulsation=self.pulsation), None
        if self.starts_developed:
            walls = (
                wall if wall.oscillates else Wall(wall.cosine if wall.before is None else wall.before)
                for wall in self.pair
            )
            bottom, top = (self._slipping(*each) for each in zip(walls, self.slip_lengths, strict=True))
            before = Flow(self.gap, bottom, top, self.acceleration, pulsation=self.pulsation)
        return _solved(self.rheology, self.kinematic_viscosity, self.density, flow, before)

    def exact(self, field: str, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact value of one of ``fields``, which do not depend on ``x``."""
        if field == "u":
            return self.exact_velocity(y, t)
        if field == TEMPERATURE:
            return self._of_heated_flow(TEMPERATURE, y, t) + np.zeros(np.shape(x))
        return self.exact_polymer_stress(y, t)[STRESSES.index(field)]

    def exact_velocity(self, y: Any, t: Any) -> np.ndarray:
        """Return the exact velocity along x at heights ``y`` and times ``t`` (they broadcast), on the run's clock."""
        if not self.isothermal and self._heated_flow:
            later = np.asarray(t) > 0.0  # at the start walls move, and the fluid does not
            return np.where(later, self._of_heated_flow("velocity", y, np.where(later, t, 1.0)), 0.0)
        return self._flow.velocity(y, t)

    def exact_wall_shear(self, t: Any) -> tuple[Any, Any]:
        """Return the exact shear stress, of solvent and polymer together, at the (bottom, top) wall at time(s) ``t``.

        Infinite at t = 0 on a wall whose velocity jumps then.
        """
        # both walls in one call: each time is costly, a height is not
        walls = np.reshape([0.0, self.gap], (2, *[1] * np.ndim(t)))
        if not self.isothermal and self._heated_flow:
            bottom, top = np.where(np.asarray(t) > 0.0, self._of_heated_flow("shear_stress", walls, t), np.nan)
            return bottom, top
        bottom, top = self.density * self._flow.shear_stress(walls, t)
        return bottom, top

    def exact_polymer_stress(self, y: Any, t: Any) -> np.ndarray:
        """Return the exact polymer stresses S_xx, S_xy, S_yy (3, ...) [mass/(length time^2)]."""
        return self.density * self._flow.polymer_stress(y, t)

    def apparent_viscosity(self, viscosity: complex, angular_frequency: float) -> complex:
        """Return the stress at an oscillating wall over its speed/gap, in a fluid of the complex ``viscosity``."""
        return apparent_viscosity(viscosity, angular_frequency, self.density, self.gap)

    def driven_mean_velocity(self) -> float | None:
        """Return the mean velocity that the drive adds to the developed flow; None if the walls change that too.

        They do so if a wall is stress-controlled, or if a non-linear fluid slips or flows between walls of different
        velocities.
        """
        drive = self.acceleration
        if self.driven_side is not None or self.pulsation:
            return None
        if self.linear:
            return drive * self.gap**2 / (12.0 * self.kinematic_viscosity) * self._slip_factor
        if self.seeks_wall_velocity or any(wall.oscillates for wall in self.pair):
            return None
        if self.bottom.cosine != self.top.cosine:
            return None
        fluid = fluid_of(self.rheology, self.kinematic_viscosity, self.density)
        return math.copysign(UniformShear(fluid.flux, fluid.laws).mean_velocity(abs(drive), self.gap), drive)

    # Measures ---------------------------------------------------------------------------------------------------------

    def probe_positions(self, count: int, x: Any = "centre") -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (count,) of ``count`` probes on a vertical line, at heights (k + 1/2) gap / count.

        ``x``: a distance along the channel, or ``centre``.
        """
        position = 0.5 * self.length if x == "centre" else x
        return np.full(count, float(position)), (np.arange(count) + 0.5) * self.gap / count

    def description(self) -> dict[str, float]:
        """Return gap and length."""
        return {"gap": self.gap, "length": self.length}

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return further numbers of a snapshot; ``series`` begins with heights y and velocities u at the probes.

        With polymer ``shear_stress_l2`` = sqrt(sum (S-S_exact)^2 / sum S_exact^2) for S = S_xy, and
        ``normal_stress_l2`` for S = S_xx - S_yy. ``slope`` (1/time), ``intercept`` (velocity): least-squares line u(y)
        through the probes. ``centreline``: u at mid-gap, averaged along the channel. ``wall_shear_bottom``,
        ``wall_shear_top``: total shear stress on the fluid's side of the walls, see ``measures/channel.py``.
        ``plate_velocity``: velocity of a stress-controlled wall. ``slip_velocity_bottom``, ``slip_velocity_top``:
        velocity of the fluid at a wall with a slip length, less the velocity of the wall. Each also ``_exact``, the
        lines being fitted to exact velocities at the same probes. ``density_variation`` = max |density/density_0 - 1|;
        ``max_transverse_velocity`` = max |v|.
        """
        t = snapshot.t
        found: dict[str, Any] = {}
        if self.polymer and self.isothermal:
            exact: Any = snapshot.reference
            shear = np.asarray(snapshot.stress_xy)
            found["shear_stress_l2"] = relative_difference(shear, exact["stress_xy"], snapshot.weight)
            normal = exact["stress_xx"] - exact["stress_yy"]
            found["normal_stress_l2"] = relative_difference(n1(snapshot), normal, snapshot.weight)
        y, u = series[:2]
        slope, intercept = fit_line(y, u)
        slope_exact, intercept_exact = fit_line(y, self.exact_velocity(y, t))
        x, middle = (np.arange(CENTRELINE_POINTS) + 0.5) * self.length / CENTRELINE_POINTS, 0.5 * self.gap
        bottom, top = wall_shear(self, snapshot)
        bottom_exact, top_exact = self.exact_wall_shear(t)
        found |= {
            "slope": slope,
            "slope_exact": slope_exact,
            "intercept": intercept,
            "intercept_exact": intercept_exact,
            "centreline": np.mean(interpolate(snapshot, self, x, np.full(CENTRELINE_POINTS, middle))),
            "centreline_exact": self.exact_velocity(middle, t),
            "wall_shear_bottom": bottom,
            "wall_shear_bottom_exact": bottom_exact,
            "wall_shear_top": top,
            "wall_shear_top_exact": top_exact,
        }
        if self.driven_side is not None:
            found["plate_velocity"] = wall_velocity(self, self.driven_side, snapshot)
            found["plate_velocity_exact"] = self.exact_velocity(self.gap * self.driven_side, t)
        for side, wall in enumerate(self.pair):
            if self.slip_lengths[side]:
                name, motion = f"slip_velocity_{SIDES[side]}", wall.velocity(t)
                found[name] = wall_velocity(self, side, snapshot) - motion
                found[f"{name}_exact"] = self.exact_velocity(self.gap * side, t) - motion
        found["density_variation"] = np.max(np.abs(snapshot.density / self.density - 1))
        found["max_transverse_velocity"] = np.max(np.abs(snapshot.v))
        return found

    @property
    def extra_series(self) -> ExtraSeries | None:
        """Series of rheometry: stress at the walls, their velocities, N1 of a polymer, mean over the fluid, and strain.

        The strain is the displacement of the upper wall relative to the lower one, over the gap. The displacement of a
        stress-controlled wall is the integral of the velocities that the particles show. None for a Newtonian fluid of
        constant viscosity between walls that neither are stress-controlled nor follow a schedule.
        """
        plain = self.polymer is None and self.rheology is None and self.isothermal
        if plain and not any(wall.stress_controlled or wall.jump_times for wall in self.pair):
            return None
        columns = [f"{name}_{side}" for name in ("wall_shear", "wall_velocity") for side in SIDES]

        def measure(snapshot: Snapshot) -> np.ndarray:
            velocities = [
                wall_velocity(self, side, snapshot) if wall.stress_controlled else float(wall.velocity(snapshot.t))
                for side, wall in enumerate(self.pair)
            ]
            normal = [np.mean(n1(snapshot))] if self.polymer else []
            return np.array([*wall_shear(self, snapshot), *velocities, *normal])

        def final(times: np.ndarray, values: np.ndarray) -> np.ndarray:
            ways = [
                integral(times, values[:, 2 + side]) if wall.stress_controlled else wall.displacement(times)
                for side, wall in enumerate(self.pair)
            ]
            strain = (ways[1] - ways[0]) / self.gap
            if not self.comparable:
                return strain[:, None]
            exact = [*self.exact_wall_shear(times), *(wall.velocity(times) for _, wall in reversed(self.walls))]
            return np.column_stack([strain, *(np.where(np.isfinite(one), one, np.nan) for one in exact)])

        return ExtraSeries(
            columns=[*columns, "n1_mean"] if self.polymer else columns,
            measure=measure,
            final_columns=["strain", *(f"{name}_exact" for name in columns if self.comparable)],
            final=final,
        )

    # Views ------------------------------------------------------------------------------------------------------------

    def profiles(self) -> list[Profile]:
        """Return the velocity with its error; with polymer also its shear stress and N1."""
        return list(self.movie_profiles().values())

    def movie_profiles(self) -> dict[str, Profile]:
        """Return the velocity, and the stresses of a polymer, of all particles: nothing depends on x."""
        line = Line("y", (0.0, self.gap), place=0.5 * self.length)
        speed = Profile(
            name="u",
            unit="velocity",
            line=line,
            of=lambda snapshot: snapshot.u,
            exact=lambda x, y, t: self.exact_velocity(y, t),
            scale=(self.reference_velocity, "reference velocity U"),
        )
        if self.polymer is None:
            return {"speed": self.compared(speed)}

        def exact_normal_stress(x: Any, y: Any, t: Any) -> np.ndarray:
            xx, _, yy = self.exact_polymer_stress(y, t)
            return xx - yy

        shear = Profile(
            name="polymer shear stress Sxy",
            unit="stress",
            line=line,
            of=lambda snapshot: snapshot.stress_xy,
            exact=lambda x, y, t: self.exact_polymer_stress(y, t)[1],
        )
        normal = Profile(
            name=f"first normal stress difference N1 = Sxx {MINUS} Syy",
            unit="stress",
            line=line,
            of=n1,
            exact=exact_normal_stress,
        )
        found = {"speed": speed, "shear_stress": shear, "normal_stress_difference": normal}
        return {name: self.compared(profile) for name, profile in found.items()}

    def slip_wall_velocity(self, points: np.ndarray, t: float) -> np.ndarray:
        """See ``Scene.slip_wall_velocity``."""
        found = np.full(points.shape, np.nan)
        for side, wall in enumerate(self.pair):
            if self.slip_lengths[side]:
                found[np.isclose(points[:, 1], self.gap * side)] = float(wall.velocity(t)), 0.0
        return found

    def movie_ends(self, profile: Profile, end: float) -> Sequence[float]:
        """Return values that span the range of a ``profile`` to time ``end``, wall velocities included."""
        found = [*profile.extremes(self.start_time, end)]
        if profile.unit != "velocity":
            return found
        times = np.linspace(self.start_time, end, _WALL_TIMES)
        walls = [wall for _, wall in reversed(self.walls)]
        velocities = np.concatenate([wall.velocity(times) for wall in walls])
        if self.start_time == 0.0:  # the fluid still has the velocity of the wall before
            velocities = np.append(velocities, [wall.before for wall in walls if wall.before is not None])
        return [*found, float(velocities.min()), float(velocities.max())]

    def time_series(self, count: int, x: Any = "centre") -> TimeSeries:
        """Return the velocities at ``count`` heights on a vertical line; arguments as ``probe_positions``."""
        places = self.probe_positions(count, x)
        heights = places[1]
        series = TimeSeries(
            content="velocities u along x over time t at probes at heights y",
            name="u",
            unit="velocity",
            scale=self.reference_velocity,
            columns=[f"u(y={y:.6g})" for y in heights],
            labels=[("y/H", y / self.gap) for y in heights],
            exact_columns=[f"u_exact(y={y:.6g})" for y in heights],
            measure=Probes(self, *places).velocity,
            exact=lambda times: self.exact_velocity(heights, times[:, None]),
            places=heights,
            angular_frequency=max(wall.angular_frequency for _, wall in self.walls),
        )
        return self.compared(series)

    def movie_series(self) -> TimeSeries:
        """Return the velocities at three heights."""
        return self.time_series(3)

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        length, time = self.units.length, self.units.time
        by_walls = self.velocity_scale == self.wall_speed
        own = not self.given_velocity and (self.driven_side is not None or not by_walls)
        moving = f", in a frame that moves with {self.frame_velocity:.6g} {length}/{time}"
        frame = moving if self.frame_velocity else ""
        fluid = "" if self.linear or not own else ", in a Newtonian fluid of the viscosity nu"
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
                value = f"{mean:.{6 if self.linear else 4}g} {length}/{time}"
                text += f", of which the developed flow has the mean speed {value}"
            lines.append(("drive", text))
        if self.pulsation:
            kind = "oscillates with the amplitude" if self.pulsation.angular_frequency else "varies, up to"
            lines.append(("drive", f"{kind} {self.pulsation.largest_speed:.6g} {length}/{time}^2 along x"))
        for name, wall in reversed(self.walls):
            if wall.angular_frequency:
                depth = wall.penetration_depth(self.kinematic_viscosity)
                text = f"{depth:.4g} {length}, {depth / self.spacing:.3g} spacings  (sqrt(2 nu / w), {name} wall)"
                lines.append(("penetration depth", text))
        if self.polymer:
            lines.append(("Weissenberg number", f"{self.weissenberg:.4g}  (relaxation time * U / H)"))
            lines.append(("elasticity number", f"{self.elasticity:.4g}  (relaxation time * nu / H^2)"))
        return lines
