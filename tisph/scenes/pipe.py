"""Pipe flow: along a pipe, or between two coaxial pipes, and around their axis; started, driven, oscillating, turning.

An acceleration along the axis drives the fluid, constant, oscillating or both; walls move along the axis and turn
around it at constant speeds. Motion starts, or changes, at t = 0. The flow does not depend on the place along the
axis. In a Newtonian fluid the flows along and around the axis add up; other fluids have only one of the two. See
``tisph/exact/start_up.py`` for the reference.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Problem, Signed, refusals, refuse
from tisph.config.ends import Ends
from tisph.config.motion import SlipLength, Spacing, frictionless_findings, slip_length_of
from tisph.exact._fluids import Rheology, fluid_of
from tisph.exact.start_up import CircularStartUp, PipeStartUp, slipping
from tisph.geometry.body import Body
from tisph.geometry.motion import RigidMotion, Schedule, WallMotion
from tisph.measures.metrics import field_error
from tisph.scenes import _axisymmetric
from tisph.scenes._axisymmetric import AxisymmetricScene, cylinder
from tisph.scenes._initial import Initial, PulsatingDrive, start_problems, still_problem
from tisph.scenes._views import Profile, TimeSeries
from tisph.snapshot import STRESSES, Snapshot


class Geometry(Model):
    """Radius and length of the pipe [length]; ``inner_radius`` of a second one inside, 0 without."""

    radius: Positive
    length: Positive
    inner_radius: NonNegative = 0.0

    @model_validator(mode="after")
    def _check_order(self) -> "Geometry":
        if not self.inner_radius < self.radius:
            text = f"must be less than geometry.radius {self.radius:g}"
            raise refusals([(("inner_radius",), text, self.inner_radius)])
        return self


class Cylinder(Model):
    """Velocity along the axis [length/time] and angular velocity around it [1/time] of a wall, from t = 0 on.

    ``slip_length`` and ``spacing``: see ``config/motion.py``.
    """

    unset_keys = ("slip_length", "spacing")

    velocity: Signed = 0.0
    angular_velocity: Signed = 0.0
    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _check_friction(self) -> "Cylinder":
        refuse(frictionless_findings(self, ("velocity", "angular_velocity")))
        return self


class Walls(Model):
    """The walls of the pipe: ``outer``, and ``inner`` where there is one."""

    unset_keys = ("inner",)

    outer: Cylinder = Cylinder()
    inner: Cylinder | None = None


AROUND = ("stress_tt", "stress_yt", "stress_yy")
"""Stress components of flow around the axis, in the order of ``Coaxial.polymer_stress``."""


class Config(_axisymmetric.Config):
    """A whole run of flow in a pipe."""

    geometry: Geometry
    walls: Walls = Walls()
    drive: Annotated[PulsatingDrive, Field(default_factory=lambda: PulsatingDrive.model_validate({}))]
    ends: Ends | None = None
    initial: Initial = Initial()

    unset_keys = (*_axisymmetric.Config.unset_keys, "ends")
    across_name = "the pipe from the innermost radius to the outermost"

    @property
    def has_exact_velocity(self) -> bool:
        """Whether the exact velocity is known: not behind an inlet."""
        return self.ends is None

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the box is periodic in x and y."""
        return self.ends is None, False

    @property
    def singular(self) -> bool:
        """Whether the velocity of the inlet jumps at walls."""
        inlet = self.ends.inlet if self.ends else None
        return inlet is not None and inlet.jumps_at_walls(on_axis=not self.inner_radius)

    @property
    def inner_radius(self) -> float:
        """Radius of the inner wall [length], 0 without."""
        return self.geometry.inner_radius

    @property
    def outer_radius(self) -> float:
        """Radius of the outer wall [length]."""
        return self.geometry.radius

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    @property
    def flow(self) -> str:
        """See ``schema.Config.flow``."""
        return "Flow through a pipe with open ends" if self.ends else super().flow

    @property
    def placed_walls(self) -> dict[str, Body]:
        """Walls by name, the inner one first."""
        given = {"inner": self.walls.inner or Cylinder()} if self.inner_radius else {}
        radii, length = (self.inner_radius, self.outer_radius), self.geometry.length
        walls = {**given, "outer": self.walls.outer}
        return {name: _wall(name, wall, radii, length) for name, wall in walls.items()}

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        yield from super().problems()
        inner, outer = self.walls.inner or Cylinder(), self.walls.outer
        if self.walls.inner and not self.inner_radius:
            yield "walls.inner", "needs a geometry.inner_radius above 0"
        if self.ends:
            from tisph.scenes._ends import stream_problems

            yield from stream_problems(self, {f"walls.{name}": wall for name, wall in self.placed_walls.items()})
            if self.drive.varies:
                yield f"drive.{self.drive.varies}", "must be left out: the inlet drives the flow"
            if self.initial.state == "exact":
                yield "initial.state", "must be rest or developed: with open ends no exact flow is known"
            return
        yield from start_problems(self, ())
        loose = all(wall.slip_length == "infinite" for wall in ([inner] if self.inner_radius else []) + [outer])
        if loose and (self.drive.acceleration or self.drive.accelerations):
            text = "must be 0 where no wall has friction (slip_length: infinite): nothing holds the fluid"
            yield "drive.acceleration", text
        along = bool(inner.velocity or outer.velocity or self.drive.acceleration or self.drive.varies)
        around = bool(inner.angular_velocity or outer.angular_velocity)
        if not along and not around:
            yield from still_problem(self, "drive", "give an acceleration, or let a wall move")
        if along and around and not self.fluid.newtonian:
            yield "fluid.rheology.type", "must be newtonian where fluid flows both along the axis and around it"
        yield from self.drive.start_problems(self)


@dataclass(frozen=True, kw_only=True)
class Scene(AxisymmetricScene):
    """A pipe under ``acceleration`` + ``pulsation``(t) along the axis, the latter None without a part that varies.

    ``initial_state`` is ``rest``, ``developed`` or ``exact``.
    """

    acceleration: float
    pulsation: WallMotion | Schedule | None
    initial_state: str

    @property
    def fields(self) -> tuple[str, ...]:
        """Velocity, stresses of a polymer, and pressure unless a polymer flows along the axis."""
        return self._known_fields if self.isothermal else ()

    @property
    def _known_fields(self) -> tuple[str, ...]:
        """The fields of the flow at one temperature."""
        if not self.polymer:
            return "u", "v", "w", "pressure"
        return ("u", "v", "w", *STRESSES) if self._flows[0] else ("u", "v", "w", "pressure", *AROUND)

    @classmethod
    def from_config(cls, config: "Config") -> Any:
        """Return the scene that a validated config describes; with open ends a ``StreamOfRevolution``."""
        walls = config.placed_walls
        if config.ends:
            from tisph.scenes._region_of_revolution import StreamOfRevolution

            return StreamOfRevolution.around(config, {}, walls)
        return cls(
            **cls.fluid_of(config),
            length=config.geometry.length,
            inner_radius=config.inner_radius,
            outer_radius=config.outer_radius,
            names=tuple(walls),
            bodies=tuple(walls.values()),
            **config.drive.parts,
            initial_state=config.initial.state,
            start_time=config.start_time,
        )

    @property
    def body_force(self) -> Callable | None:
        """Function of places and a time that returns the part of the acceleration that varies; None without one."""
        return self._pulsating if self.pulsation else None

    @property
    def jump_times(self) -> tuple[float, ...]:
        """See ``FlowDefaults.jump_times``: of walls and drive."""
        return tuple(sorted({*super().jump_times, *self.drive.jump_times}))

    def _pulsating(self, x: np.ndarray, y: np.ndarray, t: float) -> tuple[np.ndarray, ...]:
        assert self.pulsation is not None
        return self.pulsation.velocity(t) + np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)

    @property
    def velocity_scale(self) -> float:
        """Speed of the fastest wall, or the largest velocity that the drive may cause in a Newtonian fluid."""
        square = self.reference_length**2 * self._largest_driven if self.acceleration or self.pulsation else 0.0
        driven = abs(self.acceleration) * square / self.kinematic_viscosity + self.pulsating_velocity(square)
        return max(super().velocity_scale, driven)

    @property
    def _largest_driven(self) -> float:
        """Largest velocity of a Newtonian fluid over drive H^2/nu, as between planes if there is an inner wall.

        Without slip it is 1/4 in a pipe and 1/8 between planes. With slip lengths b it is 1/4 + b/(2 H), and between
        planes c^2/2 + b c for the smaller b, c = (1/2 + b'/H)/(1 + b/H + b'/H) for the larger b'.
        """
        slips = sorted(body.slip_length / self.reference_length for body in self.bodies)
        if not self.inner_radius:
            return 0.25 + 0.5 * slips[0]
        c = (0.5 + slips[1]) / (1.0 + sum(slips)) if slips[1] < math.inf else 1.0
        return 0.5 * c**2 + slips[0] * c

    @property
    def vanishing_scale(self) -> bool:
        """Whether the drive varies."""
        return self.pulsation is not None

    @property
    def flow_quantities(self) -> tuple[str, ...]:
        """Loads on the walls."""
        return self._columns

    def thinnest_layer(self, t: float) -> tuple[float, str]:
        """See ``Scene.thinnest_layer``: the layer at walls after the start, or of an oscillating drive."""
        layers = []
        if self.initial_state != "developed":
            layers.append((self.layer_depth(t), "the layer at the wall"))
        if self.driven_periodically:
            assert self.pulsation is not None
            moved = 0.5 * self.pulsation.penetration_depth(self.kinematic_viscosity)
            layers.append((moved, "the layer at the wall of a flow that oscillates"))
        return min(layers, default=(math.inf, ""))

    @property
    def _flows(self) -> "tuple[PipeStartUp | None, CircularStartUp | None]":
        """The references along and around the axis, each None if nothing moves that way."""
        inner, outer = self.bodies if self.inner_radius else (self.bodies[0], self.bodies[0])
        axial, turning = (
            tuple(slipping(motion, wall.slip_length, self.kinematic_viscosity) for motion, wall in motions)
            for motions in (
                ((inner.motion.x, inner), (outer.motion.x, outer)),
                ((inner.spin, inner), (outer.spin, outer)),
            )
        )
        developed = self.initial_state == "developed"
        fluid = self.rheology, self.kinematic_viscosity, self.density
        drive = self.acceleration, self.pulsation
        return _solved(*fluid, (self.inner_radius, self.outer_radius), axial, turning, drive, developed)

    def exact(self, field: str, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact value of one of ``fields``; the pressure, at one time, has zero mean."""
        along, around = self._flows
        places = np.asarray(y) + 0.0 * np.asarray(x)
        if field == "u" and along:
            return along.velocity(places, t)
        if field == "w" and around:
            return around.velocity(places, t)
        if field == "pressure" and around:
            return around.pressure(places, t, density=self.density)
        if field not in ("u", "v", "w", "pressure"):
            flow, names = (along, STRESSES) if along else (around, AROUND)
            assert flow is not None
            return self.density * flow.polymer_stress(places, t)[names.index(field)]
        return np.zeros(np.broadcast(places, t).shape)

    @property
    def initial_conformation_excess(self) -> Callable | None:
        """Function of places x, y (n,) that returns C (components, n) of each polymer mode at the start of the run.

        None from rest, where C = 0.
        """
        if not self.polymer or self.initial_state == "rest":
            return None
        return self._excess_at

    def _excess_at(self, x: np.ndarray, y: np.ndarray) -> list[Any]:
        along, around = self._flows
        if along:
            return along.conformation_excess(y, self.start_time)
        assert around is not None
        modes = around.conformation_excess(y, self.start_time)
        none = np.zeros_like(y)
        return [(mode[3] if len(mode) > 3 else none, none, mode[2], mode[0], none, mode[1]) for mode in modes]

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the exact velocity, and stresses of a polymer, when the run starts."""
        exact = {name: self.exact(name, x, y, self.start_time) for name in self._known_fields if name != "pressure"}
        return {**super().initial(x, y), **exact}

    def exact_loads(self, t: Any) -> dict[str, Any]:
        """Return the references of ``loads`` by name, at times ``t``."""
        along, around = self._flows
        none = (np.zeros(np.shape(t)), np.zeros(np.shape(t)))
        forces = along.force(t, density=self.density) if along else none
        torques = around.torque(t, density=self.density) if around else none
        found = {}
        for index, name in zip((0, 1)[2 - len(self.names) :], self.names, strict=True):
            found[f"force_{name}"] = self.length * forces[index]
            found[f"torque_{name}"] = self.length * torques[index]
        return found

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return loads on the walls, each also ``_exact``, and errors ``l2_NAME`` of pressure and stresses.

        ``force_NAME``: force of the fluid along the axis on one period of a wall; ``torque_NAME``: torque around the
        axis. ``mean_velocity``: along the axis.
        """
        exact = {f"{name}_exact": value for name, value in self.exact_loads(snapshot.t).items()}
        return {
            **{f"l2_{name}": field_error(self, snapshot, name) for name in self.fields[3:]},
            **self.loads(snapshot),
            **exact,
            "mean_velocity": self.mean_velocity(snapshot),
            **self.spread(snapshot),
        }

    @property
    def _columns(self) -> tuple[str, ...]:
        kinds = [kind for kind, flow in zip(("force", "torque"), self._flows, strict=True) if flow]
        return tuple(f"{kind}_{name}" for kind in kinds for name in self.names)

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        return super().parameters(cause="the largest velocity, at most, that the drive gives a Newtonian fluid")

    def profiles(self) -> list[Profile]:
        """Return the velocities over the radius."""
        scale = (self.reference_velocity, "reference velocity")
        shown = [name for name, flow in zip("uw", self._flows, strict=True) if flow]

        def reference(name: str) -> Callable:
            return lambda x, y, t: self.exact(name, x, y, t)

        line = self.radial_line()
        profiles = [self.radial_profile(name, line, exact=reference(name), scale=scale) for name in shown]
        return [self.compared(profile) for profile in profiles]

    def time_series(self) -> TimeSeries:
        """Return the loads on the walls."""
        columns = self._columns

        def exact(times: np.ndarray) -> np.ndarray:
            loads = self.exact_loads(np.asarray(times))
            return np.stack([loads[name] for name in columns], axis=1)

        series = self.loads_series(
            columns,
            labels=[(name.replace("_", " on the ") + " wall", None) for name in columns],
            exact_columns=[f"{name}_exact" for name in columns],
            exact=exact,
            angular_frequency=self.pulsation.angular_frequency if self.pulsation else 0.0,
        )
        return self.compared(series)


def _wall(name: str, wall: Any, radii: tuple[float, float], length: float) -> Body:
    """Return the body of one of the walls."""
    motion = {"motion": RigidMotion(x=WallMotion(wall.velocity)), "spin": WallMotion(wall.angular_velocity)}
    return cylinder(radii[name == "outer"], length, name == "outer", slip_length=slip_length_of(wall), **motion)


@lru_cache(maxsize=8)
def _solved(
    rheology: Rheology | None,
    kinematic_viscosity: float,
    density: float,
    radii: tuple[float, float],
    axial: tuple[Any, Any],
    turning: tuple[Any, Any],
    drive: tuple[float, WallMotion | None],
    developed: bool,
) -> tuple[PipeStartUp | None, CircularStartUp | None]:
    """Return the flows along and around the axis, each None where nothing moves that way."""
    fluid = fluid_of(rheology, kinematic_viscosity, density)
    along = around = None
    if any(wall.largest_speed for wall in turning):
        around = CircularStartUp(radii[0], radii[1], fluid, turning[0], turning[1], turning if developed else None)
    acceleration, pulsation = drive
    if not around or acceleration or pulsation or any(wall.largest_speed for wall in axial):
        before = axial if developed else None
        along = PipeStartUp(radii, fluid, axial, before, acceleration=acceleration, pulsation=pulsation)
    return along, around
