"""Circular Couette flow: fluid between two coaxial cylinders that turn steadily, start, oscillate or follow a table.

Particles fill the annulus evenly, the first layer half a spacing from the walls. Motion starts, or changes, at t = 0.
The run's clock starts at ``start_time``: at the initial time of the config for the state ``exact``, else at 0. The
fluid is any of ``tisph/rheology``. The reference (``tisph/exact/start_up.py``) is solved once; its stresses are in
polar components: around the axis (theta), shear, and along the radius.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from tisph.config import schema
from tisph.config.base import Model, Positive, Problem, Signed, findings, refusals, refuse
from tisph.config.fields import Member
from tisph.config.motion import (
    Amplitude,
    SlipLength,
    Spacing,
    Times,
    Values,
    check_as_many,
    check_schedule,
    frictionless_findings,
    slip_length_of,
)
from tisph.config.motion import WallMotion as WallKeys
from tisph.exact._fluids import Rheology, fluid_of
from tisph.exact.start_up import CircularStartUp, Wall, slipping
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, Schedule, WallMotion
from tisph.measures.fits import fluid_mean
from tisph.measures.flow import Size
from tisph.measures.metrics import field_error, relative_difference
from tisph.scenes._initial import Initial, start_problems, still_problem
from tisph.scenes._scene import BodyScene, age, bodies_in
from tisph.scenes._scene import Scene as AnyScene
from tisph.scenes._views import (
    ExtraSeries,
    Profile,
    Radius,
    TimeSeries,
    planar_diagnostics,
    pressure_profile,
    vorticity_profile,
)
from tisph.snapshot import STRESSES, Snapshot

MINUS = "\N{MINUS SIGN}"


@lru_cache(maxsize=8)
def _solved(
    rheology: Rheology | None,
    kinematic_viscosity: float,
    density: float,
    inner_radius: float,
    outer_radius: float,
    inner: Any,
    outer: Any,
    before: Any,
) -> CircularStartUp:
    fluid = fluid_of(rheology, kinematic_viscosity, density)
    moved = any(wall.oscillates or wall.velocity(0.0) for wall in before)
    return CircularStartUp(inner_radius, outer_radius, fluid, inner, outer, before if moved else None)


def cartesian(stress: Any, x: Any, y: Any) -> np.ndarray:
    """Return the components xx, xy, yy (3, ...) of a symmetric tensor from its polar ones.

    ``stress`` (3, ...): components around the axis, shear, and along the radius, at ``x``, ``y`` from the axis.
    """
    cosine, sine = _directions(x, y)
    around, shear, along = stress
    both = sine * cosine
    return np.stack(
        [
            around * sine**2 - 2 * shear * both + along * cosine**2,
            (along - around) * both + shear * (cosine**2 - sine**2),
            around * cosine**2 + 2 * shear * both + along * sine**2,
        ]
    )


def polar(stress: Any, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the shear stress S_r-theta and N1 = S_theta-theta - S_rr of a ``stress`` (3, ...): xx, xy, yy."""
    cosine, sine = _directions(x, y)
    xx, xy, yy = stress
    twice = 2 * sine * cosine, cosine**2 - sine**2
    return 0.5 * (yy - xx) * twice[0] + xy * twice[1], (yy - xx) * twice[1] - 2 * xy * twice[0]


def _directions(x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return cosine and sine of the angle of places, in double precision."""
    x, y = (np.asarray(part, dtype=float) for part in (x, y))
    return x / np.hypot(x, y), y / np.hypot(x, y)


@dataclass(frozen=True, kw_only=True)
class BetweenCylinders(BodyScene):
    """Two cylinders with the angular velocities ``inner`` and ``outer``; all quantities in the config's units.

    The axis of the outer one is at ``centre``, the axis of the inner one by ``offset`` farther along x.
    ``initial_state`` is ``rest``, ``developed`` or ``exact`` (the flow that began at t = 0, at ``start_time``).
    ``slip_lengths``: of the inner and the outer cylinder.
    """

    inner_radius: float
    outer_radius: float
    centre: tuple[float, float]
    inner: WallMotion | Schedule
    outer: WallMotion | Schedule
    initial_state: str
    start_time: float
    offset: float = 0.0
    slip_lengths: tuple[float, float] = (0.0, 0.0)

    periodic = (False, False)
    names = ("inner", "outer")
    time_formula = "νt/H²"

    @classmethod
    def from_config(cls, config: "Config") -> "BetweenCylinders":
        """Return the scene that a validated config describes."""
        inner, outer = (turning_of(wall) for wall in (config.walls.inner, config.walls.outer))
        return cls(
            **cls.fluid_of(config),
            inner_radius=config.geometry.inner_radius,
            outer_radius=config.geometry.outer_radius,
            centre=config.geometry.centre,
            offset=config.geometry.offset,
            inner=inner,
            outer=outer,
            initial_state=config.initial.state,
            start_time=config.start_time,
            slip_lengths=(slip_length_of(config.walls.inner), slip_length_of(config.walls.outer)),
        )

    @property
    def named_loads(self) -> dict[str, tuple[int, int]]:
        """See ``Scene.named_loads``: the torques."""
        return {"torque_inner": (0, 2), "torque_outer": (1, 2)}

    @property
    def origin(self) -> tuple[float, float]:
        """Lowest corner of the box around the outer cylinder."""
        return self.centre[0] - self.outer_radius, self.centre[1] - self.outer_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Diameter of the outer cylinder, twice."""
        return 2 * self.outer_radius, 2 * self.outer_radius

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The two cylinders."""
        shapes = Circle(self.inner_radius), Circle(self.outer_radius, fluid_side="inside")
        axis = self.centre[0] + self.offset, self.centre[1]
        turning = RigidMotion(rotation=self.inner), RigidMotion(rotation=self.outer)
        inner, outer = self.slip_lengths
        return (
            Body(shapes[0], axis, motion=turning[0], slip_length=inner),
            Body(shapes[1], self.centre, motion=turning[1], slip_length=outer),
        )

    def mean(self, snapshot: Snapshot, values: np.ndarray) -> float:
        """See ``Scene.mean``: of polynomials in angle and distance from the cylinders (``fits.fluid_mean``).

        A particle is on the line between points of the two cylinders at the same angle, at the fraction s of it: on a
        circle of radius R1 + s gap, whose axis is at the fraction s from the inner axis to the outer one. The area of
        d(angle) ds is radius * stretch.
        """
        gap, inner = self.reference_length, self.inner_radius
        x, y = snapshot.x - self.centre[0] - self.offset, snapshot.y - self.centre[1]
        half, square = inner * gap - self.offset * x, gap**2 - self.offset**2
        s = (np.sqrt(half**2 + square * (x**2 + y**2 - inner**2)) - half) / square
        angle, radius = np.arctan2(y, x + s * self.offset), inner + s * gap
        stretch = gap - self.offset * np.cos(angle)
        places = np.stack([angle / (2.0 * np.pi), s], axis=1)
        rows = np.array([np.pi * (inner + self.outer_radius), gap]) / self.spacing
        whole = fluid_mean(places, values * radius * stretch, snapshot.weight, rows, (True, False))
        return whole / (gap * (inner + 0.5 * gap))

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times above 0 at which the angular velocity of a cylinder, or its slope, jumps."""
        return tuple(sorted({*self.inner.jump_times, *self.outer.jump_times}))

    @property
    def reference_length(self) -> float:
        """Difference of the radii."""
        return self.outer_radius - self.inner_radius

    @property
    def velocity_scale(self) -> float:
        """Speed of the fastest wall, at any time or before the start."""
        return max(self.inner_radius * self.inner.largest_speed, self.outer_radius * self.outer.largest_speed)

    @property
    def time_scale(self) -> float:
        """Viscous time of the gap."""
        return self.viscous_time

    @property
    def vanishing_scale(self) -> bool:
        """Whether the cylinders oscillate, or come to rest."""
        walls = self.inner, self.outer
        return any(wall.oscillates for wall in walls) or not any(wall.cosine for wall in walls)

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: layers at cylinders that started or oscillate."""
        layers: list[tuple[float, str, float]] = []
        walls = ("inner", self.inner), ("outer", self.outer)
        for (name, wall), spacing in zip(walls, self.wall_spacings, strict=True):
            started = self.before(wall) != wall.velocity(0.0) and not self.stays_steady
            since = age(wall, t) if started or wall.jump_times else math.inf
            if since < math.inf:
                layers.append((self.layer_depth(since), f"the layer at the {name} cylinder", spacing))
            if wall.oscillates:
                viscosity = self.kinematic_viscosity
                if self.rheology and not self.polymer and wall.angular_frequency:
                    viscosity = self.spreading_viscosity(1 / wall.angular_frequency)
                moved = 0.5 * wall.penetration_depth(viscosity)
                layers.append((moved, f"the layer at the oscillating {name} cylinder", spacing))
        return min(layers, key=lambda layer: layer[0] / layer[2], default=(math.inf, "", 1.0))

    def before(self, wall: WallMotion | Schedule) -> float:
        """Return the angular velocity of a cylinder before t = 0."""
        if wall.before is not None:
            return wall.before
        return float(wall.velocity(0.0)) if self.initial_state == "developed" else 0.0

    @property
    def stays_steady(self) -> bool:
        """Whether the flow stays as it was before t = 0."""
        return self.initial_state == "developed" and all(
            wall.before in (None, wall.cosine) for wall in (self.inner, self.outer)
        )

    def description(self) -> dict[str, Any]:
        """Return radii and centre."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "centre": list(self.centre)}

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        lines = scales(self, (self.inner_radius, self.outer_radius), "the gap", "of the fastest wall")
        if self.polymer:
            lines.append(("Weissenberg number", f"{self.weissenberg:.4g}  (relaxation time * U / H)"))
            lines.append(("elasticity number", f"{self.elasticity:.4g}  (relaxation time * nu / H^2)"))
        return lines


def turning_of(wall: Any) -> WallMotion | Schedule:
    """Return the motion of a cylinder of a config."""
    if wall.angular_velocities:
        return Schedule(wall.times, wall.angular_velocities)
    return WallMotion.from_config(wall)


def scales(
    scene: AnyScene, radii: tuple[float, float], gap: str, speed: str, known: bool = True
) -> list[tuple[str, str]]:
    """Return pairs (label, text) for a flow between ``radii``.

    ``gap`` names the reference length H in words, ``speed`` the cause of the reference velocity U; ``known``: whether U
    is exact.
    """
    if scene.given_velocity:
        speed, known = "given by the config", True
    about, digits = ("", 6) if known else ("about ", 2)
    length, time = scene.units.length, scene.units.time
    return [
        ("Reynolds number", f"{about}{scene.reynolds:.{digits}g}  (U H / nu)"),
        (scene.velocity_name("speed U"), f"{about}{scene.reference_velocity:.{digits}g} {length}/{time}, {speed}"),
        ("length H", f"{scene.reference_length:.6g} {length}, {gap}"),
        ("kinematic viscosity nu", f"{scene.kinematic_viscosity:.6g} {length}^2/{time}"),
        ("radii", f"{radii[0]:.6g} and {radii[1]:.6g} {length}"),
        ("viscous time", f"{scene.viscous_time:.6g} {time}  (H^2 / nu)"),
    ]


@dataclass(frozen=True, kw_only=True)
class Annulus(BetweenCylinders):
    """Two coaxial cylinders, with a reference of the flow between them at all times."""

    flow_quantities = ("torque_inner", "torque_outer")

    @property
    def fields(self) -> tuple[str, ...]:
        """Velocity and pressure, and the stresses of a polymer."""
        return ("u", "v", "pressure", *(STRESSES if self.polymer else ())) if self.isothermal else ()

    def radii(self, x: Any, y: Any) -> np.ndarray:
        """Return the distance of places from the axis."""
        return np.hypot(np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1]))

    def around(self, snapshot: Snapshot) -> np.ndarray:
        """Return the velocity around the axis (particles,)."""
        x, y = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return (x * snapshot.v - y * snapshot.u) / np.hypot(x, y)

    def exact_around(self, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact velocity around the axis."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.velocity(radius, t)

    def exact_vorticity(self, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact vorticity dv/dx - du/dy (1/time), the shear rate r d(u/r)/dr plus 2 u/r."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.shear_rate(radius, t) + 2 * self.exact_around(x, y, t) / radius

    def exact(self, field: str, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact value of one of ``fields``; the pressure has zero mean."""
        if field == "pressure":
            return self._exact_pressure(x, y, t)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        if field in STRESSES:
            return cartesian(self.exact_polymer_stress(x, y, t), *away)[STRESSES.index(field)]
        part = -away[1] if field == "u" else away[0]
        return part / np.hypot(*away) * self.exact_around(x, y, t)

    def exact_polymer_stress(self, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the exact stress (3, ...) of the polymer in polar components: around the axis, shear, along r."""
        return self.density * self._flow.polymer_stress(self.radii(x, y), t)

    def _exact_pressure(self, x: Any, y: Any, t: Any) -> np.ndarray:
        def at(time: float) -> np.ndarray:
            return self._flow.pressure(self.radii(x, y), time, density=self.density)

        times = np.unique(t)
        if len(times) == 1:
            return at(times[0]) + np.zeros(np.shape(t))
        return np.concatenate([np.broadcast_to(at(time), np.shape(x)) for time in times], axis=-1)

    @property
    def initial_conformation_excess(self) -> Any:
        """Function of places x, y (n,) that returns C (components, n) of each polymer mode when the run starts.

        The components are xx, xy, yy (and zz). None from rest, where C = 0.
        """
        return None if self.initial_state == "rest" else self._excess_at

    def _excess_at(self, x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        modes = self._flow.conformation_excess(radius, self.start_time)
        return [np.concatenate([cartesian(mode[:3], *away), mode[3:]]) for mode in modes]

    def polymer_stress(self, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Return the polymer's shear stress S_r-theta and N1 = S_theta-theta - S_rr, each (particles,)."""
        away = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return polar([getattr(snapshot, name) for name in STRESSES], *away)

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the exact velocity, and stress of a polymer, when the run starts."""
        names = ("u", "v", *(STRESSES if self.polymer else ()))
        return {name: self.exact(name, x, y, self.start_time) for name in names}

    def exact_torques(self, t: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the torques of the fluid on the inner and the outer cylinder, per length of the axis."""
        return self._flow.torque(t, density=self.density)

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return errors of pressure and stresses, torques with their references, and ``planar_diagnostics``.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), the mean of p - p_exact being subtracted.
        ``torque_inner`` and ``torque_outer``: of the fluid on the cylinders, per length of the axis, each also
        ``_exact``. With polymer ``shear_stress_l2`` and ``normal_stress_l2``, relative errors of its shear stress and
        N1 in polar components.
        """
        numbers: dict[str, Any] = {"l2_pressure": field_error(self, snapshot, "pressure")}
        if self.polymer and self.isothermal:
            around, exact_shear, along = self.exact_polymer_stress(snapshot.x, snapshot.y, snapshot.t)
            shear, normal = self.polymer_stress(snapshot)
            numbers["shear_stress_l2"] = relative_difference(shear, exact_shear, snapshot.weight)
            numbers["normal_stress_l2"] = relative_difference(normal, around - along, snapshot.weight)
        exact = self.exact_torques(snapshot.t)
        for index, name in enumerate(("inner", "outer")):
            numbers[f"torque_{name}"] = bodies_in(snapshot).torque[index]
            numbers[f"torque_{name}_exact"] = exact[index]
        return {**numbers, **planar_diagnostics(self, snapshot)[1]}

    @property
    def _flow(self) -> CircularStartUp:
        """The exact flow from rest, or from the developed flow of the motion of the cylinders before t = 0."""
        walls = self.inner, self.outer
        before = walls if self.stays_steady else tuple(Wall(self.before(wall)) for wall in walls)
        fluid = self.rheology, self.kinematic_viscosity, self.density
        walls, before = (
            tuple(map(slipping, pair, self.slip_lengths, 2 * [self.kinematic_viscosity])) for pair in (walls, before)
        )
        return _solved(*fluid, self.inner_radius, self.outer_radius, *walls, before)

    # Views ------------------------------------------------------------------------------------------------------------

    def profiles(self) -> list[Profile]:
        """Return velocity around the axis and pressure; with polymer also its shear stress and N1."""
        return [profile for name, profile in self.movie_profiles().items() if name != "vorticity"]

    def movie_profiles(self) -> dict[str, Profile]:
        """Return velocity around the axis, vorticity and pressure over the radius, and the stresses of a polymer."""
        radius = Radius(ends=(self.inner_radius, self.outer_radius), place=self.centre)
        scale = (self.reference_velocity, self.velocity_name("speed of the fastest wall"))
        found = {
            "speed": Profile("u_θ", "velocity", radius, of=self.around, exact=self.exact_around, scale=scale),
            "vorticity": vorticity_profile(self, radius, self.exact_vorticity),
            "pressure": pressure_profile(self, radius),
        }
        if not self.polymer:
            return {name: self.compared(profile) for name, profile in found.items()}

        def exact_normal_stress(x: Any, y: Any, t: Any) -> np.ndarray:
            around, _, along = self.exact_polymer_stress(x, y, t)
            return around - along

        found["shear_stress"] = Profile(
            name="polymer shear stress Srθ",
            unit="stress",
            line=radius,
            of=lambda snapshot: self.polymer_stress(snapshot)[0],
            exact=lambda x, y, t: self.exact_polymer_stress(x, y, t)[1],
        )
        found["normal_stress_difference"] = Profile(
            name=f"first normal stress difference N1 = Sθθ {MINUS} Srr",
            unit="stress",
            line=radius,
            of=lambda snapshot: self.polymer_stress(snapshot)[1],
            exact=exact_normal_stress,
        )
        return {name: self.compared(profile) for name, profile in found.items()}

    def movie_fields(self, name: str) -> tuple[str, ...]:
        """See ``Scene.movie_fields``; the shear stress around the axis needs all stress components."""
        return ("stress_xx", "stress_yy") if name == "shear_stress" else super().movie_fields(name)

    def time_series(self) -> TimeSeries:
        """Return the torques on the cylinders."""
        inner = 2 * math.pi * self.inner_radius**2
        scale = inner * self.dynamic_viscosity * self.reference_velocity / self.reference_length
        series = TimeSeries(
            content="torque of the fluid on the cylinders over time t",
            name="torque per length",
            unit="torque",
            scale=scale,
            columns=["torque_inner", "torque_outer"],
            labels=[("inner cylinder", None), ("outer cylinder", None)],
            exact_columns=["torque_inner_exact", "torque_outer_exact"],
            measure=lambda snapshot: snapshot.bodies.torque,
            exact=lambda times: np.stack(self.exact_torques(np.asarray(times)), axis=1),
            angular_frequency=max(self.inner.angular_frequency, self.outer.angular_frequency),
        )
        return self.compared(series)

    @property
    def extra_series(self) -> ExtraSeries | None:
        """First normal stress difference of a polymer at both cylinders, with its reference."""
        if not self.polymer:
            return None
        columns = ["n1_inner", "n1_outer"]

        def measure(snapshot: Snapshot) -> np.ndarray:
            found = bodies_in(snapshot).normal_stress
            return np.full(2, np.nan) if found is None else found

        def exact(times: np.ndarray, _: np.ndarray) -> np.ndarray:
            radii = np.array([[self.inner_radius], [self.outer_radius]])
            around, _, along = self.density * self._flow.polymer_stress(radii, np.asarray(times))
            return (around - along).T

        return ExtraSeries(
            columns=columns, measure=measure, final_columns=[f"{name}_exact" for name in columns], final=exact
        )


WallTreatment = Member("walls", usual="adami")

TURN = "give walls.inner or walls.outer an angular_velocity other than 0"
"""Remedy where no cylinder moves."""

Scene = Annulus
"""The name under which a run looks up the scene of a module of this folder."""


class Radii(Model):
    """Radii of the cylinders [length]."""

    inner_radius: Positive
    outer_radius: Positive

    @model_validator(mode="after")
    def _check_order(self) -> "Radii":
        if not self.inner_radius < self.outer_radius:
            text = f"must be greater than geometry.inner_radius {self.inner_radius:g}"
            raise refusals([(("outer_radius",), text, self.outer_radius)])
        return self


class Geometry(Radii):
    """Radii of the cylinders [length], and where their common axis is."""

    centre: Annotated[tuple[Signed, Signed], Field(strict=False)] = (0.0, 0.0)

    offset: ClassVar[float] = 0.0


class Turning(WallKeys):
    """Angular velocity of a wall from t = 0 on, counterclockwise: constant, or oscillating, or given at times.

    ``angular_velocity`` [radians/time], and ``angular_velocity_before`` for another value before t = 0; or
    ``amplitude`` [radians/time] * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t; or
    ``angular_velocities`` at ``times``, linear in between and constant before and after. Two equal times make a jump.
    """

    speed_key = "angular_velocity"
    other_keys = ("angular_velocities",)
    exclusive_keys = ("angular_velocity", "amplitude", "angular_velocities")
    unset_keys: ClassVar[tuple[str, ...]] = ("angular_velocity_before", "angular_frequency", "phase", "times")

    angular_velocity: Signed | None = None
    angular_velocity_before: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    times: Times | None = None
    angular_velocities: Values | None = None

    @model_validator(mode="after")
    def _check_schedule(self) -> "Turning":
        scheduled = self.angular_velocities is not None
        alien = ("angular_velocity_before", "angular_frequency", "phase") if scheduled else ("times",)
        word = "not" if scheduled else "only"
        refuse(findings(self, alien, f"is {word} for a wall with angular_velocities at times"))
        if scheduled:
            check_as_many(self, "angular_velocities")
            check_schedule(self, "angular_velocities")
        return self


class Cylinder(Turning):
    """Angular velocity of a cylinder; ``slip_length`` and ``spacing``: see ``config/motion.py``."""

    unset_keys = (*Turning.unset_keys, "slip_length", "spacing")

    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _check_friction(self) -> "Cylinder":
        keys = "angular_velocity", "angular_velocity_before", "amplitude", "angular_velocities"
        refuse(frictionless_findings(self, keys))
        return self


class Cylinders(Model):
    """The two cylinders."""

    inner: Cylinder = Cylinder()
    outer: Cylinder = Cylinder()


class Walls(Cylinders):
    """The two cylinders, and how scheme ``wcsph`` treats their walls: null for its own choice."""

    treatment: Annotated[Any, WallTreatment] | None = None


class Config(schema.Config):
    """A whole run of circular Couette flow."""

    geometry: Geometry
    walls: Walls
    initial: Initial = Initial()

    periodic = (False, False)
    has_exact_velocity = True
    across_name = "the gap between the cylinders"

    @property
    def across(self) -> float:
        """The gap."""
        return self.geometry.outer_radius - self.geometry.inner_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Diameter of the outer cylinder, twice."""
        return 2 * self.geometry.outer_radius, 2 * self.geometry.outer_radius

    @property
    def area(self) -> float:
        """Area between the cylinders."""
        return math.pi * (self.geometry.outer_radius + self.geometry.inner_radius) * self.across

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature of the walls."""
        return self.geometry.inner_radius

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    @property
    def members(self) -> dict[str, Any]:
        """Members of every scene, and the wall treatment if the config has one."""
        return {**({"walls": self.walls.treatment} if self.walls.treatment else {}), **super().members}

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        rheology, names = self.fluid.rheology, ("inner", "outer")
        swinging = any(getattr(self.walls, name).amplitude is not None for name in names)
        if not self.fluid.newtonian and swinging and self.initial.state == "developed":
            text = f"the periodic flow of {rheology.type} between cylinders that oscillate is not built in"
            yield "initial.state", f"must be rest or exact: {text}"
        walls = self.walls.inner, self.walls.outer
        speeds = {speed for wall in walls for speed in (wall.speed, wall.speed_before)} - {None}
        if speeds <= {0.0} and not any(wall.amplitude or wall.angular_velocities for wall in walls):
            yield from still_problem(self, "walls", TURN)
        yield from start_problems(self, names)
        scheduled = [name for name in names if getattr(self.walls, name).angular_velocities]
        if scheduled and self.initial.state != "rest":
            yield "initial.state", f"must be rest where a wall has velocities at times (walls.{scheduled[0]})"
