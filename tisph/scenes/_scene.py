"""The protocol of a scene: box, fluid, start, scales, reference solution, and the quantities that a run reports.

A scene is one file of this folder with two names: ``Config``, the model of its config (``tisph/config/schema.py``),
and ``Scene``, a frozen dataclass derived from the ``Scene`` here, or a maker of one. Observers, results and pictures
use only the members below. A scene must define every member whose default raises NotImplementedError. All other
defaults describe a fluid at rest in a periodic box. ``BodyScene`` is the base of scenes with walls or bodies of any
shape.

All quantities are in the units of the config. Places ``x``, ``y`` and times ``t`` are arrays or numbers that broadcast
against each other.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.exact._fluids import Rheology, derivative, fluid_of
from tisph.geometry.body import Body
from tisph.geometry.ends import OpenEnd
from tisph.geometry.motion import REST, RigidMotion, Schedule, WallMotion
from tisph.geometry.outline import EndToEnd
from tisph.geometry.packing import pack
from tisph.geometry.region import Region
from tisph.scenes._views import COLOURS, ExtraSeries, MovieView, Profile, TimeSeries, movie_view
from tisph.snapshot import STRESSES, Bodies, Snapshot

FAINT = 0.015
"""Fraction of a velocity jump that is negligible: resolved samples may have this error (measures/resolution.py)."""

FIXED_POINT = 20
"""Iterations for the depth of a layer; each reduces its error to a third or less."""


@dataclass(frozen=True)
class PolymerParameters:
    """Relaxation time of a polymer [time], and the solvent's fraction of the total viscosity."""

    relaxation_time: float
    solvent_fraction: float

    @classmethod
    def of(cls, rheology: Rheology | None) -> "PolymerParameters | None":
        """Return the parameters of the first relaxation mode of a ``rheology``; None without polymer."""
        if rheology and rheology.carries_stress:
            return cls(rheology.relaxation_time, rheology.solvent_fraction)
        return None

    def diffusive_fraction(self, t: float) -> float:
        """Return the fraction of the total viscosity that has spread a start at t = 0 by the time ``t``.

        A start is first the front of a shear wave with the amplitude exp(-t/(2 relaxation_time)) (Maxwell's fluid: the
        damped wave equation u_tt + u_t/relaxation_time = modulus u_yy). While the amplitude is at least ``FAINT`` the
        solvent alone spreads the front.
        """
        return self.solvent_fraction if math.exp(-0.5 * t / self.relaxation_time) >= FAINT else 1.0


@dataclass(frozen=True)
class Reference:
    """A reference by ``name``, and its ``assumptions``: words -> whether the config meets them."""

    name: str
    assumptions: Mapping[str, bool]

    @property
    def applies(self) -> bool:
        """Whether the config meets all assumptions."""
        return all(self.assumptions.values())

    def __str__(self) -> str:
        if self.applies:
            return f"{self.name}, for {'; '.join(self.assumptions)}"
        return f"none: {self.name} is for {'; '.join(words for words, met in self.assumptions.items() if not met)}"


def age(wall: Any, t: float) -> float:
    """Return the time since a ``wall`` that starts at t = 0 last jumped before ``t``; infinite if it has only kinks."""
    if isinstance(wall, Schedule):
        return wall.age(t)
    return t - max((change for change in wall.jump_times if change < t), default=0.0)


class SceneDefaults:
    """Members of a scene with their values for a fluid at rest in a periodic box."""

    start_time: float = 0.0
    """Time at which the run's clock starts."""

    elastic_speed: float = 0.0
    """Speed of shear waves in the polymer [length/time]."""

    acceleration: float = 0.0
    """Body acceleration along x."""

    kept_mean_velocity: float | None = None
    """Mean velocity along x that a pressure gradient maintains; None where the acceleration is given."""

    body_force: Callable | None = None
    """Function of places x, y and a time that returns the components of an acceleration; None without one."""

    conformation_source: Callable | None = None
    """Function of places x, y and a time that returns a source of the conformation tensor; None without one."""

    initial_velocity: Callable | None = None
    """Function of x, y that returns the fluid's velocities (components, ...) before bodies start; None at rest."""

    has_own_start: bool = False
    """Whether the user supplied the initial velocity, which may have a divergence."""

    swirls: bool = False
    """Whether the fluid may turn around the axis of symmetry."""

    contact: tuple[float, float] | None = None
    """Distance [length] and pressure [mass/(length time^2)] of the repulsion between free bodies; None without it."""

    origin: tuple[float, float] = (0.0, 0.0)
    """Lowest corner of the box."""

    bodies: tuple[Body, ...] = ()
    """All bodies, and all walls that are not plane walls of a channel."""

    corners: tuple = ()
    """``exact.sliding_corner.CornerSingularity`` of each corner at which the velocities of two walls differ."""

    jump_times: tuple[float, ...] = ()
    """Times after the start at which the velocity of a body, or its acceleration, jumps."""

    initial_conformation_excess: Callable | None = None
    """Function of places that returns C of each polymer mode at the start of the run; None where C = 0."""

    periodic: tuple[bool, bool] = (True, True)
    """Whether the box is periodic in x and y."""

    axisymmetric: bool = False
    """Whether y is the distance from an axis of symmetry; velocities then have a component ``w``."""

    parallel: bool = False
    """Whether all flow is along x, so that a scheme may omit terms of cross-flow."""

    fields: tuple[str, ...] = ()
    """Names of the snapshot's fields for which ``exact`` has a reference; empty without a reference solution."""

    steepness: float = 0.0
    """Change of the logarithm of a polymer's stretch within a spacing that steady flow will have; 0 where unknown."""

    reference: Reference | None = None
    """Reference whose assumptions some configs of the scene do not meet; None if there is none of this kind."""

    flow_quantities: tuple[str, ...] = ()
    """Names of the ``diagnostics`` that are quantities of the flow, not errors: extrapolated to spacing 0."""

    extra_series: ExtraSeries | None = None
    """Further columns of ``history.csv``, which are not drawn."""

    frame_velocity: float = 0.0
    """Velocity along x of the flow's own frame, to which speeds and errors refer."""

    time_formula: str = "Ut/L"
    """Formula of the time over ``time_scale``, for labels."""


@dataclass(frozen=True, kw_only=True)
class Scene(SceneDefaults):
    """A fluid in the box 0 <= x <= width, 0 <= y <= height; all quantities in the config's units."""

    density: float
    """Density of the fluid."""

    kinematic_viscosity: float
    """Kinematic viscosity, of solvent and polymer together."""

    spacing: float
    """Distance between neighbouring particles at the start."""

    units: Any
    """``config.schema.Units``: labels of the units for plots and tables."""

    rheology: Rheology | None = None
    """Parameters of a non-Newtonian fluid, else None."""

    inertia: bool = True
    """Whether fluid and bodies have inertia; without it the flow is Stokes flow at every time."""

    given_velocity: float | None = None
    """Reference velocity from the config; None where ``velocity_scale`` is used."""

    columns: int = 0
    """Particles along x at the start, in a box without ``bodies``."""

    rows: int = 0
    """Particles along y at the start, in a box without ``bodies``."""

    @classmethod
    def from_config(cls, config: Any) -> "Scene":
        """Return the scene that a validated config describes."""
        raise NotImplementedError

    @staticmethod
    def fluid_of(config: Any) -> dict[str, Any]:
        """Return the fluid, spacing and units of a validated config, as arguments of a scene."""
        return {
            "density": config.fluid.density,
            "kinematic_viscosity": config.kinematic_viscosity,
            "spacing": config.spacing,
            "units": config.units,
            "inertia": config.fluid.inertia,
            "rheology": None if config.fluid.rheology.type == "newtonian" else config.fluid.rheology,
            "given_velocity": config.reference.velocity if config.reference else None,
        }

    @property
    def polymer(self) -> PolymerParameters | None:
        """Relaxation time and solvent fraction of a polymer solution, which set its time scales; else None."""
        return PolymerParameters.of(self.rheology)

    @property
    def components(self) -> int:
        """Number of velocity components: u and v, and w in axisymmetric flow."""
        return 3 if self.axisymmetric else 2

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the box."""
        raise NotImplementedError

    @property
    def particles(self) -> int:
        """Number of fluid particles."""
        return self.rows * self.columns

    @property
    def has_free_bodies(self) -> bool:
        """Whether the flow carries any of the ``bodies``."""
        return any(body.free for body in self.bodies)

    @property
    def has_open_ends(self) -> bool:
        """Whether fluid flows in and out."""
        return any(isinstance(body, OpenEnd) for body in self.bodies)

    @property
    def walls(self) -> tuple[tuple[str, Any], ...]:
        """Pairs (side, ``WallMotion``) of the plane walls, from top to bottom; the side is ``top`` or ``bottom``."""
        return ()

    @property
    def reference_length(self) -> float:
        """Length of the Reynolds number."""
        raise NotImplementedError

    @property
    def velocity_scale(self) -> float:
        """Velocity that walls, bodies, the drive or the start impose; 0 where they do not move the fluid."""
        raise NotImplementedError

    @property
    def reference_velocity(self) -> float:
        """Velocity over which errors are given: the config's reference velocity, else ``velocity_scale``."""
        return self.given_velocity or self.velocity_scale

    def velocity_name(self, own: str) -> str:
        """Return the name of the reference velocity in tables and pictures: ``own`` for the ``velocity_scale``."""
        return "reference velocity U" if self.given_velocity else own

    @property
    def peak_velocity(self) -> float:
        """Upper bound of the speed in the flow."""
        return max(self.reference_velocity, self.velocity_scale)

    @property
    def time_scale(self) -> float:
        """Time scale of the dimensionless time t* = t / time_scale."""
        return self.reference_length / self.reference_velocity

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """What movies show as the drive of the flow: its name, kind of unit, and components along x and y."""
        return "drive", "acceleration", (self.acceleration, 0.0)

    @property
    def viscous_time(self) -> float:
        """Time reference length^2 / kinematic viscosity in which momentum diffuses that far."""
        return self.reference_length**2 / self.kinematic_viscosity

    @property
    def reynolds(self) -> float:
        """Reynolds number, reference velocity * reference length / kinematic viscosity."""
        return self.reference_velocity * self.reference_length / self.kinematic_viscosity

    @property
    def dynamic_viscosity(self) -> float:
        """Density * kinematic viscosity, of solvent and polymer together."""
        return self.density * self.kinematic_viscosity

    @property
    def solvent_viscosity(self) -> float:
        """Kinematic viscosity of the solvent alone."""
        return self.kinematic_viscosity * (self.polymer.solvent_fraction if self.polymer else 1.0)

    @property
    def weissenberg(self) -> float:
        """Weissenberg number, relaxation time * reference velocity / reference length; 0 without polymer."""
        if self.polymer is None:
            return 0.0
        return self.polymer.relaxation_time * self.reference_velocity / self.reference_length

    @property
    def elasticity(self) -> float:
        """Elasticity number, relaxation time / viscous time; 0 without polymer."""
        return self.polymer.relaxation_time / self.viscous_time if self.polymer else 0.0

    @property
    def vanishing_scale(self) -> bool:
        """Whether the velocity crosses zero or decays, so that a relative error is not meaningful."""
        return False

    def spreading_viscosity(self, t: float) -> float:
        """Return the kinematic viscosity nu that spreads the motion of a wall to the depth sqrt(nu t) in a time ``t``.

        In an inelastic fluid nu is d(stress)/d(shear rate) / density at the shear rate U/sqrt(nu t), a fixed point. In
        a polymer solution nu is the solvent's viscosity until the front of the shear wave has decayed to ``FAINT``.
        """
        viscosity = self.kinematic_viscosity
        if self.polymer:
            return viscosity * self.polymer.diffusive_fraction(t)
        if self.rheology and t > 0.0:
            fluid, speed = fluid_of(self.rheology, viscosity, self.density), self.reference_velocity
            for _ in range(FIXED_POINT):
                rate = speed / math.sqrt(viscosity * t)
                viscosity = float(derivative(fluid.flux, rate))
        return viscosity

    def layer_depth(self, t: float) -> float:
        """Return the depth sqrt(nu t) [length] of the layer at a wall that started a time ``t`` ago."""
        return math.sqrt(self.spreading_viscosity(t) * t)

    def narrowest(self, t: float) -> tuple[tuple[float, str], tuple[float, str]]:
        """Return the smallest radius of a wall that bulges into the fluid, and the smallest gap at time ``t``.

        Each is a pair: size [length], infinite if there is none, and its name.
        """
        return (math.inf, ""), (math.inf, "")

    def section(self, x: np.ndarray) -> tuple[Any, Any]:
        """Return the lowest place, and the height, of the cross-sections at ``x`` (n,): numbers, or arrays (n,)."""
        low: Any = self.origin[1]
        height: Any = self.extent[1]
        high = low + height
        for body in self.bodies:
            if isinstance(body.shape, EndToEnd):
                if body.shape.ends[0, 0] < body.shape.ends[1, 0]:
                    low = body.shape.height(x)
                else:
                    high = body.shape.height(x)
                height = high - low
        return low, height

    def seen(self, snapshot: Snapshot) -> "Scene":
        """Return this scene with free bodies at their places in ``snapshot``, moving on with their velocities there."""
        return self

    def in_flow_frame(self) -> "Scene":
        """Return this scene in a frame that moves with ``frame_velocity``."""
        return self

    def thinnest_layer(self, t: float) -> tuple[float, str]:
        """Return the depth [length] of the thinnest layer in the flow at time ``t`` and its name; infinite if none."""
        return math.inf, ""

    def drift(self, snapshot: Snapshot) -> float:
        """Return the velocity error common to all fluid and bodies, over the bodies' velocity relative to the fluid.

        0 where walls fix the velocity.
        """
        return 0.0

    def lattice(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the cell centres x, y (particles,), row by row from the bottom."""
        y, x = np.meshgrid(np.arange(self.rows) + 0.5, np.arange(self.columns) + 0.5, indexing="ij")
        return self.spacing * x.ravel(), self.spacing * y.ravel()

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return cell centres x, y (particles,) displaced at random, uniformly within +- ``jitter`` * spacing.

        ``0 <= jitter < 0.5`` (else ValueError), so that each particle stays in its cell, and in the box. The same
        ``seed`` gives the same positions.
        """
        if not 0 <= jitter < 0.5:
            raise ValueError(f"jitter {jitter} is outside [0, 0.5)")
        x, y = self.lattice()
        shift_x, shift_y = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, x.size))
        return x + jitter * self.spacing * shift_x, y + jitter * self.spacing * shift_y

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields at the places ``x``, ``y`` (n,) at the start of the run, by name: at least u and v."""
        raise NotImplementedError

    def exact(self, field: str, x: Any, y: Any, t: Any) -> np.ndarray:
        """Return the reference of one of ``fields`` at places ``x``, ``y`` and times ``t``, which broadcast."""
        raise NotImplementedError

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return further entries of a sample in ``summary.json``, by name: numbers, booleans, words, or None.

        ``snapshot`` has its ``reference`` if the scene has one. ``series``: ``TimeSeries.places``, the values of
        ``TimeSeries.measure`` for the snapshot and, in a run, a pair (times (records,), values (records, numbers)) of
        the whole history, later times included.
        """
        return {}

    def description(self) -> dict[str, Any]:
        """Return the sizes of the scene by name, for the files of a run."""
        width, height = self.extent
        return {"width": width, "height": height}

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles, for ``tisph check``."""
        raise NotImplementedError

    def profiles(self) -> list[Profile]:
        """Return the profiles of ``profiles.png``."""
        raise NotImplementedError

    def time_series(self, **settings: Any) -> TimeSeries:
        """Return the series of ``history.csv`` and ``history.png``; ``settings``: ``Config.time_series``."""
        raise NotImplementedError

    def movie_profiles(self) -> dict[str, Profile]:
        """Return the profile of each quantity that may colour a movie, by name; ``speed``: a velocity profile."""
        profiles = self.profiles()
        return {profile.name: profile for profile in profiles if profile.unit == "velocity"} | {"speed": profiles[0]}

    def movie_series(self) -> TimeSeries:
        """Return the time series that a movie shows."""
        return self.time_series()

    def movie_ends(self, profile: Profile, end: float) -> Sequence[float]:
        """Return values that span the range of ``profile``, one of ``movie_profiles``, to time ``end``."""
        return profile.extremes(self.start_time, end)

    def movie_fields(self, name: str) -> tuple[str, ...]:
        """Return the fields that a movie coloured by ``name`` needs beside places, velocities and shear stress."""
        without = name == "viscosity" and not self.polymer  # which fields are those of a polymer's stress
        return () if without or name not in COLOURS else COLOURS[name].fields

    def movie_view(self, name: str, end: float) -> MovieView:
        """Return the view of a movie to time ``end`` whose fluid is coloured by ``name``."""
        return movie_view(self, name, end)


def bodies_in(snapshot: Snapshot) -> Bodies:
    """Return the state of the bodies in a snapshot of a scene with bodies."""
    assert snapshot.bodies is not None
    return snapshot.bodies


def farthest(shape: Any) -> float:
    """Return the largest distance of points of a ``shape`` from the centre of its body; 0 for a line."""
    return shape.largest_distance if shape.area else 0.0


def largest_speed(body: Body) -> float:
    """Return an upper bound of the speed of the points of a ``body``."""
    return body.motion.largest_speed(farthest(body.shape))


def open_place(bodies: Sequence[Body], length: float, t: float) -> float | None:
    """Return the middle of the longest part of a period ``length`` along x without ``bodies`` at time ``t``, or None.

    0 where there are no bodies.
    """
    if not bodies:
        return 0.0
    radii = np.array([farthest(body.shape) for body in bodies])
    first = (np.array([body.at(t).centre[0] for body in bodies]) - radii) % length
    order = np.argsort(first)
    first, last = first[order], np.maximum.accumulate((first + 2.0 * radii)[order])
    last = np.maximum(last, last[-1] - length)  # bodies across the end of the cell
    gaps = np.append(first[1:], first[0] + length) - last
    longest = int(np.argmax(gaps))
    return float(last[longest] + 0.5 * gaps[longest]) if gaps[longest] > 0.0 else None


LEAST_JITTER = 0.05
"""Least random displacement of the particles far from walls, in spacings. The flow would stretch a perfect lattice, or
tear it along the diagonals, because repulsive displacements cancel there."""


ABSENT = 1e3
"""Distance, in lengths of the cell, at which a body is ``seen`` that is not in the fluid."""


class BodyScene(Scene):
    """A scene with ``bodies``: fluid around them, and within them where the box is not ``periodic``.

    Scenes with free bodies have ``bodies`` as a field.
    """

    def initial(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the fields of a fluid at rest without stress."""
        return {name: np.zeros(np.shape(x)) for name in ("u", "v", *(STRESSES if self.polymer else ()))}

    @cached_property
    def region(self) -> Region:
        """The fluid's region at t = 0."""
        bodies = tuple(body for body in self.bodies if body.enters <= self.start_time)
        return Region(bodies, self.origin, tuple(np.add(self.origin, self.extent)), self.periodic)

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles."""
        return round(self.region.area / self.spacing**2)

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (particles,) of particles that fill the region; see ``tisph/geometry/packing.py``."""
        x, y = pack(self.region, self.spacing, max(jitter, LEAST_JITTER), seed).T
        return x, y

    def seen(self, snapshot: Snapshot) -> "BodyScene":
        """See ``Scene.seen``; bodies that are not in the fluid are far away."""
        if not self.has_free_bodies:
            return self
        bodies, found = list(self.bodies), bodies_in(snapshot)
        for index, body in enumerate(self.bodies):
            if body.free and np.isnan(found.angle[index]):
                far = ABSENT * (1 + index) * self.extent[0]
                bodies[index] = replace(body, centre=(far, 0.0), motion=REST, enters=math.inf)
            elif body.free:
                velocity, rotation = found.velocity[index], float(found.angular_velocity[index])
                motion = RigidMotion(*(WallMotion(float(part)) for part in (*velocity, rotation)))
                centre = tuple((found.centre[index] - snapshot.t * velocity).tolist())
                angle = float(found.angle[index]) - snapshot.t * rotation
                bodies[index] = replace(body, centre=centre, angle=angle, motion=motion, enters=-math.inf)
        changed: Any = {"bodies": tuple(bodies)}
        scene = replace(self, **changed)
        vars(scene)["region"] = self.region  # only its area is needed, which stays
        return scene

    def contains(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return whether each of the ``points`` (n, 2) is in the fluid at ``time``."""
        return self.distance(points, time) >= 0.0

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Return distances (n,) of ``points`` (n, 2) from the nearest wall at ``time``, negative outside the fluid."""
        return np.min([body.nearest(points, time).distance for body in self.bodies], axis=0)
