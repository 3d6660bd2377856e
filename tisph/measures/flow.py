"""A flow in its box: fluid, bodies, walls, start, drive, scales and reference, as measures and schemes see it.

All quantities are in the units of the config. Places ``x``, ``y`` and times ``t`` are arrays or numbers that broadcast
against each other. The defaults describe a fluid at rest in a periodic box. A scene (``scenes/_scene.py``) is such a
flow with its views.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from tisph.exact._fluids import Rheology, derivative, fluid_of
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import Drive
from tisph.geometry.outline import EndToEnd
from tisph.geometry.wanted_spacing import GROWTH, Source, WantedSpacing
from tisph.measures.substance import TEMPERATURE, Substance
from tisph.snapshot import Snapshot

Kind = TypeVar("Kind", bound="FlowInBox")

Size = tuple[float, str] | tuple[float, str, float]
"""Size [length] of a layer, radius or gap, its name, and the spacing there, else ``wall_spacing``."""

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


class FlowDefaults:
    """Members of a flow with their values for a fluid at rest in a periodic box."""

    start_time: float = 0.0
    """Time at which the run's clock starts."""

    elastic_speed: float = 0.0
    """Speed of shear waves in the polymer [length/time]."""

    acceleration: float = 0.0
    """Body acceleration along x; of a drive that varies its constant part."""

    pulsation: Any = None
    """Part of the body acceleration along x that oscillates or is given at times (``geometry.motion``), or None."""

    kept_mean_velocity: float | None = None
    """Mean velocity along x that a pressure gradient maintains; None where the acceleration is given."""

    body_force: Callable | None = None
    """Function of places x, y and a time that returns the components of an acceleration; None without one."""

    kinematics: Callable | None = None
    """Function of places x, y and a time that returns the velocity components at all times; None where it is found."""

    kinematics_gradient: Callable | None = None
    """The same for the gradient of that velocity: du/dx, du/dy, dv/dx, dv/dy; None where particles measure it."""

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

    frame_velocity: float = 0.0
    """Velocity along x of the flow's own frame, to which speeds and errors refer."""


@dataclass(frozen=True, kw_only=True)
class FlowInBox(FlowDefaults):
    """A fluid in the box 0 <= x <= width, 0 <= y <= height; all quantities in the config's units."""

    density: float
    """Density of the fluid."""

    kinematic_viscosity: float
    """Kinematic viscosity, of solvent and polymer together."""

    spacing: float
    """Distance between neighbouring particles at the start, the largest one where it varies."""

    units: Any
    """``config.sections.Units``: labels of the units for plots and tables."""

    rheology: Rheology | None = None
    """Parameters of a non-Newtonian fluid, else None."""

    inertia: bool = True
    """Whether fluid and bodies have inertia; without it the flow is Stokes flow at every time."""

    given_velocity: float | None = None
    """Reference velocity from the config; None where ``velocity_scale`` is used."""

    substances: tuple[Substance, ...] = ()
    """Temperature and dissolved substances; the temperature is the first one where there is one."""

    columns: int = 0
    """Particles along x at the start, in a box without ``bodies``."""

    rows: int = 0
    """Particles along y at the start, in a box without ``bodies``."""

    spacing_sources: tuple[Source, ...] = ()
    """Places near which particles are closer to one another."""

    growth: float = GROWTH
    """Growth of the spacing over the distance from these."""

    @cached_property
    def wanted_spacing(self) -> WantedSpacing:
        """The particle spacing that is wanted at each place."""
        return WantedSpacing(self.spacing, self.spacing_sources, self.growth)

    @property
    def drive(self) -> Drive:
        """The body acceleration along x."""
        return Drive(self.acceleration, self.pulsation)

    def pulsating_velocity(self, square: float, inviscid: float = 1.0) -> float:
        """Return the largest velocity that the part g of the drive that varies may cause; 0 without one.

        It is g times ``square`` [length^2] over the viscosity in slow flow, and at most ``inviscid`` g / angular
        frequency where g oscillates.
        """
        if self.pulsation is None:
            return 0.0
        strength, frequency = self.pulsation.largest_speed, self.pulsation.angular_frequency
        slow = strength * square / self.kinematic_viscosity
        return float(min(slow, inviscid * strength / frequency) if frequency else slow)

    @property
    def polymer(self) -> PolymerParameters | None:
        """Relaxation time and solvent fraction of a polymer solution, which set its time scales; else None."""
        return PolymerParameters.of(self.rheology)

    @property
    def temperature(self) -> Substance | None:
        """The temperature among the substances; None without one."""
        return next((each for each in self.substances if each.name == TEMPERATURE), None)

    @property
    def isothermal(self) -> bool:
        """Whether the temperature has no effect on the flow, or there is none."""
        found = self.temperature
        return found is None or not (found.law or found.expansion)

    @property
    def comparable(self) -> bool:
        """Whether references of the flow hold: they are of flow at one temperature."""
        return self.isothermal

    @property
    def linear(self) -> bool:
        """Whether flows of the fluid in a channel add up: it is Newtonian or an Oldroyd-B fluid."""
        return self.rheology is None or self.rheology.type == "oldroyd_b"

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
    def fluid_area(self) -> float:
        """Area of the fluid."""
        width, height = self.extent
        return width * height

    def mean(self, snapshot: Snapshot, values: np.ndarray) -> float:
        """Return the mean of ``values`` (particles,) over the area of the fluid."""
        raise NotImplementedError

    @property
    def has_free_bodies(self) -> bool:
        """Whether the flow carries any of the ``bodies``."""
        return any(body.free for body in self.bodies)

    @property
    def flows_through(self) -> bool:
        """Whether fluid flows in and out."""
        return not all(body.solid for body in self.bodies)

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

    @property
    def peak_velocity(self) -> float:
        """Upper bound of the speed in the flow."""
        return max(self.reference_velocity, self.velocity_scale)

    @property
    def time_scale(self) -> float:
        """Time scale of the dimensionless time t* = t / time_scale."""
        return self.reference_length / self.reference_velocity

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
    def driven_periodically(self) -> bool:
        """Whether a wall, a body or an inlet oscillates, or the drive."""
        moving: list[Any] = [self.pulsation, *(wall for _, wall in self.walls)]
        for body in self.bodies:
            motion = getattr(body, "motion", None)
            moving += [getattr(motion, part, None) for part in ("x", "y", "rotation")]
            moving += [getattr(body, "spin", None), getattr(getattr(body, "course", None), "wave", None)]
        return any(getattr(part, "angular_frequency", 0.0) and part.amplitude for part in moving)

    @property
    def diffusion_time(self) -> float:
        """Decay time [time] of the slowest flow between walls at rest, depth^2/(pi^2 nu) between two of them.

        In a closed box it is an upper bound: decay rates over nu are at least the second eigenvalue of the Laplacian
        in plane flow (L. E. Payne 1955), the first one around an axis. A box without walls has its longer side as
        depth.
        """
        (width, height), closed = self.extent, not any(self.periodic) and not self.flows_through
        if closed and not self.axisymmetric:
            total = 4.0 / max(width, height) ** 2 + 1.0 / min(width, height) ** 2
        else:
            depth = max(width, height) if all(self.periodic) else height
            on_axis = self.axisymmetric and self.origin[1] == 0.0  # a square around the pipe
            total = 2.0 / (2.0 * height) ** 2 if on_axis else 1.0 / depth**2
            total += 1.0 / width**2 if closed else 0.0
        return 1.0 / (math.pi**2 * self.kinematic_viscosity * total)

    @property
    def slow_times(self) -> dict[str, float]:
        """Times [time] in which the flow forgets its past, by their names."""
        found = {}
        if self.rheology and self.rheology.carries_stress:
            laws = self.rheology.laws(self.kinematic_viscosity)
            found["longest relaxation time"] = max(law.relaxation_time for law in laws)
        if self.inertia:
            found["time of viscous decay"] = self.diffusion_time
        if self.reference_velocity and self.changes_shape:
            found["convective time of moving bodies"] = self.reference_length / self.reference_velocity
        return found

    @property
    def changes_shape(self) -> bool:
        """Whether the region of the fluid has another shape later."""
        return any(map(_changes_places, self.bodies))

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

    @cached_property
    def wall_spacings(self) -> list[float]:
        """Largest spacing along each of the ``bodies`` at the start."""
        wanted, t = self.wanted_spacing, self.start_time
        if not wanted.varies:
            return [self.spacing] * len(self.bodies)
        return [float(wanted.at(body.boundary_points(wanted.smallest, t).point, t).max()) for body in self.bodies]

    @property
    def wall_spacing(self) -> float:
        """Largest spacing along walls and bodies at the start; the largest one without any."""
        walls = zip(self.wall_spacings, self.bodies, strict=True)
        return max((spacing for spacing, body in walls if body.solid), default=self.spacing)

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """Return the smallest radius of a wall that bulges into the fluid, and the smallest gap at time ``t``.

        Where the spacing varies, they are those that are the smallest in spacings; infinite if there is none.
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

    def seen(self: Kind, snapshot: Snapshot) -> Kind:
        """Return this flow with free bodies at their places in ``snapshot``, moving on with their velocities there."""
        return self

    def in_flow_frame(self: Kind) -> Kind:
        """Return this flow in a frame that moves with ``frame_velocity``."""
        return self

    def thinnest_layer(self, t: float) -> Size:
        """Return the depth of the thinnest layer in the flow at time ``t``, infinite if none.

        Where the spacing varies, it is the layer that is the thinnest in spacings.
        """
        return math.inf, ""

    def open_section(self, t: float) -> float | None:
        """Return the place along x of a cross-section without bodies at time ``t``; None without one."""
        return 0.0

    def unresolved_ends(self, snapshot: Snapshot) -> tuple[str, str] | None:
        """Return a short text and the reason if the flow through ends is not resolved, else None."""
        return None

    @property
    def named_loads(self) -> dict[str, tuple[int, int]]:
        """Loads of bodies that are judged by their scatter: name of the number in a sample -> (body, component).

        The components are 0 and 1, forces along x and y, and 2, the torque.
        """
        return {}

    def drift(self, snapshot: Snapshot) -> float:
        """Return the velocity error common to all fluid and bodies, over the bodies' velocity relative to the fluid.

        0 where walls fix the velocity.
        """
        return 0.0

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

    def contains(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return whether each of the ``points`` (n, 2) is in the fluid at ``time``."""
        return self.distance(points, time) >= 0.0

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Return distances (n,) of ``points`` (n, 2) from the nearest wall at ``time``, negative outside the fluid."""
        return np.min([body.nearest(points, time).distance for body in self.bodies], axis=0)


def _changes_places(body: Body) -> bool:
    """Return whether the fluid around a ``body`` has another shape later: a circle may turn in its place."""
    motion = body.motion
    along, around = bool(motion.x.largest_speed or motion.y.largest_speed), bool(motion.rotation.largest_speed)
    return body.in_fluid and (body.free or along or (around and not isinstance(body.shape, Circle)))
