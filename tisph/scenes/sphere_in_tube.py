"""Sphere or spheroid in a tube: on its axis, held in a flow, moved along the axis, turned around it, or falling.

The flow is periodic along the tube, and the body in the middle at first. With the closure ``no_flux`` a pressure
gradient maintains the mean velocity over each cross-section, which is 0 in a tube that is closed far away. With
``periodic_pressure`` the only mean pressure gradient is the given acceleration. The fluid is at rest at first. Forces
are on the whole body, and include the force of the mean pressure gradient.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from tisph.bodies import _clearance, circle
from tisph.config.base import Model, NonNegative, Positive, Problem, Signed, refusals
from tisph.config.motion import SlipLength, Spacing, slip_length_of
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.motion import FreeMotion, Inertia, RigidMotion, WallMotion
from tisph.geometry.shape import POINTS, volume_of_revolution
from tisph.measures.flow import Size
from tisph.scenes import _axisymmetric
from tisph.scenes._axisymmetric import AxisymmetricScene, cylinder, wall_speed
from tisph.scenes._initial import RestInitial, still_problem
from tisph.scenes._scene import Reference, bodies_in
from tisph.scenes._spacing import with_sources
from tisph.scenes._views import Profile, TimeSeries
from tisph.scenes.pipe import Cylinder
from tisph.snapshot import Snapshot

FREE_KEYS = ("density", "force")

LARGEST_RATIO = 0.6
"""Largest ratio of the radii of ball and tube."""


def wall_factor(ratio: float) -> float:
    """Return Bohlin's factor K of a sphere whose radius is ``ratio`` times the radius of the tube."""
    powers = {1: -2.10443, 3: 2.08877, 5: -0.94813, 6: -1.372, 8: 3.87, 10: -4.19}
    return 1.0 / (1.0 + sum(factor * ratio**power for power, factor in powers.items()))


class Geometry(Model):
    """Radii of tube and sphere, and period along the axis [length].

    ``half_length``: half of the axis of a spheroid along the tube; a sphere where left out.
    """

    unset_keys = ("half_length",)

    tube_radius: Positive
    sphere_radius: Positive
    length: Positive
    half_length: Positive | None = None


class Sphere(Model):
    """Motion of the body from t = 0 on: constant ``velocity`` along the axis, or ``free``; and its rotation.

    ``angular_velocity`` around the axis [1/time]. A free body has a ``density`` [mass/length^3], by default the density
    of the fluid, and an external ``force`` along the axis [mass length/time^2], such as its weight minus its buoyancy.
    ``slip_length`` and ``spacing``: see ``config/motion.py``.
    """

    unset_keys = ("velocity", *FREE_KEYS, "slip_length", "spacing")

    velocity: Signed | None = None
    free: bool = False
    density: NonNegative | None = None
    force: Signed | None = None
    angular_velocity: Signed = 0.0
    slip_length: SlipLength | None = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _check_free(self) -> "Sphere":
        wrong = ("velocity",) if self.free else FREE_KEYS
        text = f"is only for a sphere that is {'not ' if self.free else ''}free"
        found = [((key,), text, getattr(self, key)) for key in wrong if getattr(self, key) is not None]
        if found:
            raise refusals(found)
        return self


class Walls(Model):
    """The tube."""

    tube: Cylinder = Cylinder()


class Drive(Model):
    """Acceleration along the axis [length/time^2], or the mean velocity that closure ``no_flux`` maintains."""

    acceleration: Signed = 0.0
    mean_velocity: Signed = 0.0


SLOW = 0.1
"""Reynolds number U a/nu below which the drag of a sphere has no inertia to 2 %."""

APART = 1.0
"""Least distance of neighbouring spheres in the periodic tube, over its radius: the slowest mode of Stokes flow in a
closed tube decays as exp(-4.47 x/radius), so that neighbours change the drag by about a hundredth."""

FRONT = 1.95
"""Depth of the layer in front of the body, in sqrt(nu/a), where the velocity is 99 % of the outer one; a = (3/2) U/R is
the strain rate there (stagnation flow, F. Homann, Z. angew. Math. Mech. 16 (1936) 153-164)."""


class Config(_axisymmetric.Config):
    """A whole run of a sphere in a tube."""

    geometry: Geometry
    sphere: Sphere = Sphere()
    closure: Literal["no_flux", "periodic_pressure"] = "no_flux"
    walls: Walls = Walls()
    drive: Drive = Drive()
    initial: RestInitial = RestInitial()

    across_name = "the radius of the tube"
    inner_radius: ClassVar[float] = 0.0

    @property
    def flow(self) -> str:
        """See ``schema.Config.flow``."""
        sphere = self.geometry.half_length in (None, self.geometry.sphere_radius)
        return f"{'Free ' * self.sphere.free}{'sphere' if sphere else 'spheroid'} in a tube".capitalize()

    @property
    def outer_radius(self) -> float:
        """Radius of the tube [length]."""
        return self.geometry.tube_radius

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        yield from super().problems()
        closed = self.closure == "no_flux"
        if closed and self.drive.acceleration:
            yield "drive.acceleration", "is only for the closure periodic_pressure; give a mean_velocity"
        if not closed and self.drive.mean_velocity:
            yield "drive.mean_velocity", "is only for the closure no_flux; give an acceleration"
        if not Scene.from_config(self).velocity_scale:
            remedy = "give a velocity or an angular_velocity, or let it be free under a force"
            yield from still_problem(self, "sphere", remedy)
        flow = with_sources(Scene.from_config(self), self)
        body, tube = flow.bodies
        for problem in _clearance.size_problems([("", circle.Parameters, body)], flow.wanted_spacing, self.across):
            yield "geometry.sphere_radius", problem[1]
        for problem in _clearance.problems([body], {"walls.tube": tube}, flow.wanted_spacing):
            yield "geometry.sphere_radius", problem[1]


@dataclass(frozen=True, kw_only=True)
class Scene(AxisymmetricScene):
    """A sphere and a tube, the two ``bodies``; ``acceleration`` along the axis."""

    acceleration: float
    kept_mean_velocity: float | None

    flow_quantities = ("drag", "drag_ratio", "velocity")
    time_formula = "tU/a"

    @classmethod
    def from_config(cls, config: "Config") -> "Scene":
        """Return the scene that a validated config describes."""
        geometry, kept = config.geometry, config.closure == "no_flux"
        given = config.walls.tube
        tube: dict[str, Any] = {"motion": RigidMotion(x=WallMotion(given.velocity))}
        tube |= {"spin": WallMotion(given.angular_velocity), "slip_length": slip_length_of(given)}
        return cls(
            **cls.fluid_of(config),
            length=geometry.length,
            inner_radius=0.0,
            outer_radius=geometry.tube_radius,
            names=("sphere", "tube"),
            bodies=(_body(config), cylinder(geometry.tube_radius, geometry.length, True, **tube)),
            acceleration=0.0 if kept else config.drive.acceleration,
            kept_mean_velocity=config.drive.mean_velocity if kept else None,
        )

    @property
    def sphere(self) -> Body:
        """The body."""
        return self.bodies[0]

    @cached_property
    def reference_length(self) -> float:
        """Radius of the body across the axis."""
        return float(self.sphere.shape.extent[1, 1])

    @cached_property
    def velocity_scale(self) -> float:
        """Largest speed of body, tube and driven fluid; rough estimates for a free body under a load and the fluid."""
        body, radius, motion = self.sphere, self.reference_length, self.sphere.motion
        speeds = [abs(self.kept_mean_velocity or 0.0), wall_speed(self.bodies[1])]
        speeds.append(abs(self.acceleration) * (self.outer_radius - radius) ** 2 / (4.0 * self.kinematic_viscosity))
        speeds.append(radius * body.spin.largest_speed)
        if isinstance(motion, FreeMotion):
            load = abs(motion.inertia.load[0])
            slow = load / (6.0 * math.pi * self.dynamic_viscosity * radius)
            speeds.append(min(slow, math.sqrt(load / (self.density * radius**2))))
        else:
            speeds.append(motion.x.largest_speed)
        return max(speeds)

    @property
    def drive_shown(self) -> tuple[str, str, tuple[float, float]]:
        """See ``Scene.drive_shown``: the force on a free sphere, a mean velocity that is kept, or the acceleration."""
        motion = self.sphere.motion
        if isinstance(motion, FreeMotion) and motion.inertia.load[0] and not self.acceleration:
            return "force on the sphere", "whole_force", (motion.inertia.load[0], 0.0)
        if self.kept_mean_velocity:
            return "mean velocity", "velocity", (self.kept_mean_velocity, 0.0)
        return super().drive_shown

    @property
    def peak_velocity(self) -> float:
        """Rough bound of the speed beside the body."""
        return 2.0 * super().peak_velocity

    @property
    def time_scale(self) -> float:
        """Time in which the fluid or the body moves by the radius."""
        return self.reference_length / self.reference_velocity

    @property
    def contact(self) -> tuple[float, float] | None:
        """See ``Scene.contact``: a pressure of 0, because nothing touches on the axis."""
        return (self.spacing, 0.0) if self.has_free_bodies else None

    def narrowest(self, t: float) -> tuple[Size, Size]:
        """See ``Scene.narrowest``: radius of curvature of the body, and gap between body and tube."""
        radius = self.sphere.shape.convex_radius
        gap = self.outer_radius - self.reference_length
        wanted, (sphere, tube) = self.wanted_spacing, self.bodies
        between = gap, "the gap between sphere and tube", wanted.between(sphere, tube, t)
        return (radius, "the smallest radius of the sphere", wanted.along(sphere)), between

    def thinnest_layer(self, t: float) -> Size:
        """See ``Scene.thinnest_layer``: the layer at the body that started at t = 0, or in front of the body."""
        strain_rate = 0.75 * self.peak_velocity / self.sphere.shape.convex_radius
        front = FRONT * math.sqrt(self.kinematic_viscosity / strain_rate) if strain_rate else math.inf
        layers = (self.layer_depth(t), "the layer at the sphere"), (front, "the layer in front of the sphere")
        return *min(layers), self.wall_spacings[0]

    def open_section(self, t: float) -> float:
        """Return the place along the axis that is farthest from the body at time ``t``."""
        return float(self.sphere.at(t).centre[0]) + 0.5 * self.length

    def diagnostics(self, snapshot: Snapshot, series: Sequence) -> dict[str, Any]:
        """Return force and torque on sphere and tube, drag, place and velocity of the sphere.

        ``drag``: force against the motion of the sphere relative to the tube, or along the flow past a sphere at rest.
        ``drag_ratio``: drag / (6 pi mu a U), a the radius across the axis, U the speed of the sphere relative to the
        tube, or the mean velocity of the flow past a sphere at rest; None if both are 0. ``mean_velocity``: over a
        cross-section; ``acceleration``: along the axis, by the mean pressure gradient.
        """
        found = self.loads(snapshot)
        force = found["force_sphere"]
        bodies = bodies_in(snapshot)
        velocity = bodies.velocity[0, 0] - bodies.velocity[1, 0]
        drag = -force * np.sign(velocity) if velocity else abs(force)
        speed = abs(velocity) or abs(self.kept_mean_velocity or 0.0)
        scale = 6.0 * np.pi * self.dynamic_viscosity * self.reference_length * speed
        return {
            "drag": drag,
            "drag_ratio": drag / scale if scale else None,
            "place": bodies.centre[0, 0],
            "velocity": bodies.velocity[0, 0],
            **found,
            "acceleration": self.axial_acceleration(snapshot),
            "mean_velocity": self.mean_velocity(snapshot),
            **self.spread(snapshot),
        }

    def parameters(self) -> list[tuple[str, str]]:
        """Return pairs (label, text) that describe the flow, independent of particles."""
        ratio = self.reference_length / self.outer_radius
        kept = self.reference_velocity == abs(self.kept_mean_velocity or 0.0)
        lines = super().parameters("the radius of the sphere, across the axis", "the mean velocity" if kept else None)
        known = [("reference", str(self.reference))] if self.sphere.free else []
        return [*lines, ("sphere over tube", f"{ratio:.6g}, the ratio of the radii"), *known]

    def profiles(self) -> list[Profile]:
        """Return the velocities over the radius at the initial place of the sphere."""
        line = self.radial_line(0.5 * self.length)
        return [self.radial_profile(name, line) for name in ("u", "v")]

    @property
    def reference(self) -> Reference:
        """See ``Scene.reference``: the terminal velocity of a free sphere."""
        sphere, tube = self.bodies
        radius, tube_radius = self.reference_length, self.outer_radius
        slow = abs(self._stokes_velocity) * radius < SLOW * self.kinematic_viscosity
        spins = sphere.spin.largest_speed * radius**2, tube.spin.largest_speed * tube_radius**2
        assumptions = {
            "a free sphere": sphere.free and isinstance(sphere.shape, Circle),
            "a Newtonian fluid": self.rheology is None,
            "walls without slip": not (sphere.slip_length or tube.slip_length),
            "a closed tube at rest": self.kept_mean_velocity == 0.0 and not tube.motion.x.largest_speed,
            f"a radius up to {LARGEST_RATIO:g} of the tube's": radius <= LARGEST_RATIO * tube_radius,
            f"spheres {APART:g} radius of the tube apart": self.length - 2.0 * radius >= APART * tube_radius,
        }
        if self.inertia:
            assumptions[f"a Reynolds number U a/nu below {SLOW:g}, or no inertia"] = slow
            still = max(spins) < SLOW * self.kinematic_viscosity
            assumptions["slow rotation, or no inertia"] = still
        return self.reference_for("Stokes flow in this tube (Bohlin)", assumptions)

    @property
    def _stokes_velocity(self) -> float:
        """Velocity under the external force in Stokes flow in a closed tube (Bohlin); NaN if it is not free."""
        radius, motion = self.reference_length, self.sphere.motion
        drag = 6.0 * math.pi * self.dynamic_viscosity * radius * wall_factor(radius / self.outer_radius)
        return float(motion.inertia.load[0]) / drag if isinstance(motion, FreeMotion) else math.nan

    @property
    def terminal_velocity(self) -> float:
        """Velocity of a free sphere at the end of a run; NaN where no ``reference`` applies."""
        return self._stokes_velocity if self.reference.applies else math.nan

    def time_series(self) -> TimeSeries:
        """Return the force on the sphere along the axis, the torque around it, its place and its velocity."""
        radius, speed = self.reference_length, self.reference_velocity
        force = 6.0 * np.pi * self.dynamic_viscosity * radius * speed

        def measure(snapshot: Snapshot) -> np.ndarray:
            bodies, load = bodies_in(snapshot), self.loads(snapshot)["force_sphere"]
            return np.array([load, bodies.torque[0], bodies.centre[0, 0], bodies.velocity[0, 0]])

        return TimeSeries(
            content="force and torque of the fluid on the sphere, its place and velocity along the axis",
            name="force",
            unit="whole_force",
            scale=force,
            columns=["force_sphere", "torque_sphere", "place", "velocity"],
            labels=[("force", None), ("torque", None), ("place", None), ("velocity", None)],
            exact_columns=[],
            measure=measure,
            exact=lambda times: None,
            sizes=[force, force * radius, radius, speed],
            levels=[*3 * [math.nan], self.terminal_velocity],
            level_name="Stokes flow in this tube (Bohlin)",
            panels=[
                ("force", "whole_force"),
                ("torque", "moment") if self.sphere.spin.largest_speed else None,
                ("place", "length") if self.sphere.free else None,
                ("velocity", "velocity") if self.sphere.free else None,
            ],
            drifting=["place"],
        )

    def movie_series(self) -> TimeSeries:
        """Return the force on the sphere, or the velocity of a free sphere."""
        velocity = self.sphere.free
        kind = ("velocity", "velocity") if velocity else ("force", "whole_force")
        return self.time_series().only("velocity" if velocity else "force", *kind)


def _body(config: "Config") -> Body:
    """Return the sphere of a config, or the spheroid."""
    geometry, given = config.geometry, config.sphere
    radius, half = geometry.sphere_radius, geometry.half_length
    shape = Circle(radius) if half in (None, radius) else Ellipse((half, radius))
    motion: RigidMotion | FreeMotion = RigidMotion(x=WallMotion(given.velocity or 0.0))
    if given.free:
        volume, fluid = volume_of_revolution(shape.boundary_points(shape.length / POINTS)), config.fluid.density
        mass = volume * (fluid if given.density is None else given.density)
        load = (given.force or 0.0) + fluid * volume * config.drive.acceleration
        motion = FreeMotion(Inertia((mass, mass, 1.0), (load, 0.0, 0.0), held=(False, True, True), displaced=volume))
    centre, spin = (0.5 * geometry.length, 0.0), WallMotion(given.angular_velocity)
    periods, slip_length = (geometry.length, math.inf), slip_length_of(given)
    return Body(shape, centre, motion=motion, periods=periods, spin=spin, slip_length=slip_length)
