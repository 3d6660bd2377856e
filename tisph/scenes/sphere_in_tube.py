"""A sphere, or a spheroid, on the axis of a tube: held in a flow, moved along the axis, turned around it, or falling.

The flow is periodic along the tube, and the body in the middle at first. With the closure ``no_flux`` a pressure
gradient keeps the mean velocity over each cross-section, 0 in a tube that is closed far away; with
``periodic_pressure`` there is none but that of the acceleration. The fluid is at rest at first. Forces are those on the
whole body, with the part of the mean pressure gradient.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from pydantic import model_validator

from tisph.bodies import _clearance, circle
from tisph.config.base import Model, NonNegative, Positive, Problem, Signed, refusals
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.motion import FreeMotion, Inertia, RigidMotion, WallMotion
from tisph.geometry.shape import POINTS, volume_of_revolution
from tisph.scenes import _axisymmetric
from tisph.scenes._axisymmetric import AxisymmetricScene, cylinder, wall_speed
from tisph.scenes._initial import RestInitial, still_problem
from tisph.scenes._layers import depth
from tisph.scenes._views import TimeSeries
from tisph.scenes.pipe import Cylinder

FREE_KEYS = ("density", "force")


class Geometry(Model):
    """Radii of tube and sphere, and period along the axis [length].

    ``half_length``: of a spheroid, half of its axis along the tube; that of a sphere where left out.
    """

    unset_keys = ("half_length",)

    tube_radius: Positive
    sphere_radius: Positive
    length: Positive
    half_length: Positive | None = None


class Sphere(Model):
    """What the body does from t = 0 on: constant ``velocity`` along the axis, or ``free``; and what turns it.

    ``angular_velocity`` around the axis [1/time]. A free body has a ``density`` [mass/length^3], that of the fluid
    where left out, and a ``force`` along the axis from outside [mass length/time^2], as its weight less its buoyancy.
    """

    unset_keys = ("velocity", *FREE_KEYS)

    velocity: Signed | None = None
    free: bool = False
    density: NonNegative | None = None
    force: Signed | None = None
    angular_velocity: Signed = 0.0

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
    """Acceleration along the axis [length/time^2], or the mean velocity that closure ``no_flux`` keeps."""

    acceleration: Signed = 0.0
    mean_velocity: Signed = 0.0


FRONT = 1.95
"""Depth of the layer in front of the body, in sqrt(nu/a), a = (3/2) U/R being the strain rate there: the velocity is
99 % of that outside (stagnation flow, F. Homann, Z. angew. Math. Mech. 16 (1936) 153-164)."""


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
    def outer_radius(self) -> float:
        """Radius of the tube [length]."""
        return self.geometry.tube_radius

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        yield from super().problems()
        closed = self.closure == "no_flux"
        if closed and self.drive.acceleration:
            yield "drive.acceleration", "is only for the closure periodic_pressure; give a mean_velocity"
        if not closed and self.drive.mean_velocity:
            yield "drive.mean_velocity", "is only for the closure no_flux; give an acceleration"
        if not Scene.from_config(self).velocity_scale:
            remedy = "give a velocity or an angular_velocity, or let it be free under a force"
            yield from still_problem(self, "sphere", remedy)
        yield from self._sizes()

    def _sizes(self) -> Iterator[Problem]:
        """A body that is too small, or too large."""
        body, tube = Scene.from_config(self).bodies
        for _, text in _clearance.size_problems([("", circle.Parameters, body)], self.spacing, self.across):
            yield "geometry.sphere_radius", text
        for _, text in _clearance.problems([body], {"walls.tube": tube}, self.spacing):
            yield "geometry.sphere_radius", text


@dataclass(frozen=True, kw_only=True)
class Scene(AxisymmetricScene):
    """A sphere in a tube, its ``bodies``. ``acceleration`` along the axis; None where a mean velocity is kept."""

    acceleration: float
    kept_mean_velocity: float | None

    flow_quantities = ("drag", "drag_ratio", "velocity")
    time_formula = "tU/a"

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        geometry, kept = config.geometry, config.closure == "no_flux"
        tube = {"motion": RigidMotion(x=WallMotion(config.walls.tube.velocity))}
        tube["spin"] = WallMotion(config.walls.tube.angular_velocity)
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
    def sphere(self):
        """The body."""
        return self.bodies[0]

    @cached_property
    def reference_length(self):
        """Radius of the body across the axis."""
        return float(self.sphere.shape.extent[1, 1])

    @cached_property
    def velocity_scale(self):
        """Speed of the body or of the tube, by the load of one that is free, or of the driven fluid, roughly."""
        body, radius = self.sphere, self.reference_length
        speeds = [abs(self.kept_mean_velocity or 0.0), wall_speed(self.bodies[1])]
        speeds.append(abs(self.acceleration) * (self.outer_radius - radius) ** 2 / (4.0 * self.kinematic_viscosity))
        speeds.append(radius * body.spin.largest_speed)
        if body.free:
            load = abs(body.motion.inertia.load[0])
            slow = load / (6.0 * math.pi * self.dynamic_viscosity * radius)
            speeds.append(min(slow, math.sqrt(load / (self.density * radius**2))))
        else:
            speeds.append(body.motion.x.largest_speed)
        return max(speeds)

    @property
    def peak_velocity(self):
        """What may become of it beside the body, roughly."""
        return 2.0 * super().peak_velocity

    @property
    def time_scale(self):
        """Time in which the fluid or the body goes its radius."""
        return self.reference_length / self.reference_velocity

    @property
    def contact(self):
        """See ``Scene.contact``: nothing touches on the axis."""
        return (self.spacing, 0.0) if self.has_free_bodies else None

    def narrowest(self, t):
        """Radius of curvature of the body, and gap between it and the tube."""
        radius = self.sphere.shape.convex_radius
        gap = self.outer_radius - self.reference_length
        return (radius, "the smallest radius of the sphere"), (gap, "the gap between sphere and tube")

    def thinnest_layer(self, t):
        """Depth of the layer at the body that started at t = 0, or of that in front of it; and where it is."""
        strain_rate = 0.75 * self.peak_velocity / self.sphere.shape.convex_radius
        front = FRONT * math.sqrt(self.kinematic_viscosity / strain_rate) if strain_rate else math.inf
        return min((depth(self, t), "the layer at the sphere"), (front, "the layer in front of the sphere"))

    def open_section(self, t):
        """Place along the axis that is farthest from the body at time ``t``."""
        return float(self.sphere.at(t).centre[0]) + 0.5 * self.length

    def diagnostics(self, snapshot, series):
        """Force and torque on sphere and tube, ``drag`` and where the sphere is.

        ``drag``: minus the force on the sphere along its velocity relative to the tube, or plus that along a mean flow
        past one at rest; ``drag_ratio``: over 6 pi mu a U, U being the larger of these speeds and a the radius across
        the axis; None of a fluid at rest. ``mean_velocity``: over a cross-section; ``acceleration``
        along the axis, that of the mean pressure gradient.
        """
        found = _axisymmetric.loads(self, snapshot)
        force = found["force_sphere"]
        velocity = snapshot.bodies.velocity[0, 0] - snapshot.bodies.velocity[1, 0]
        drag = -force * np.sign(velocity) if velocity else abs(force)
        speed = abs(velocity) or abs(self.kept_mean_velocity or 0.0)
        scale = 6.0 * np.pi * self.dynamic_viscosity * self.reference_length * speed
        return {
            "drag": drag,
            "drag_ratio": drag / scale if scale else None,
            "place": snapshot.bodies.centre[0, 0],
            "velocity": snapshot.bodies.velocity[0, 0],
            **found,
            "acceleration": _axisymmetric.acceleration(self, snapshot),
            "mean_velocity": _axisymmetric.mean_velocity(self, snapshot),
            **_axisymmetric.spread(self, snapshot),
        }

    def parameters(self):
        """Numbers of the flow."""
        ratio = self.reference_length / self.outer_radius
        kept = self.reference_velocity == abs(self.kept_mean_velocity or 0.0)
        lines = super().parameters("the radius of the sphere, across the axis", "the mean velocity" if kept else None)
        return [*lines, ("sphere over tube", f"{ratio:.6g}, the ratio of the radii")]

    def profiles(self):
        """Velocities over the radius at the place of the sphere at first."""
        line = _axisymmetric.across(self, 0.5 * self.length)
        return [_axisymmetric.velocity(self, name, line) for name in ("u", "v")]

    def time_series(self):
        """Force on the sphere along the axis, torque around it, and its velocity."""
        radius, speed = self.reference_length, self.reference_velocity
        force = 6.0 * np.pi * self.dynamic_viscosity * radius * speed
        return TimeSeries(
            content="force and torque of the fluid on the sphere, its place and velocity along the axis",
            name="force",
            unit="whole_force",
            scale=force,
            columns=["force_sphere", "torque_sphere", "place", "velocity"],
            labels=[("force", None), ("torque", None), ("place", None), ("velocity", None)],
            exact_columns=[],
            measure=self._followed,
            exact=lambda times: None,
            sizes=[force, force * radius, radius, speed],
            panels=[
                ("force", "whole_force"),
                ("torque", "moment") if self.sphere.spin.largest_speed else None,
                ("place", "length") if self.sphere.free else None,
                ("velocity", "velocity") if self.sphere.free else None,
            ],
            drifting=["place"],
        )

    def _followed(self, snapshot):
        bodies = snapshot.bodies
        return np.array(
            [
                _axisymmetric.loads(self, snapshot)["force_sphere"],
                bodies.torque[0],
                bodies.centre[0, 0],
                bodies.velocity[0, 0],
            ]
        )

    def movie_series(self):
        """The force on the sphere, or the velocity of one that is free."""
        velocity = self.sphere.free
        kind = ("velocity", "velocity") if velocity else ("force", "whole_force")
        return self.time_series().only("velocity" if velocity else "force", *kind)


def _body(config):
    """The sphere of a config, or the spheroid."""
    geometry, given = config.geometry, config.sphere
    radius, half = geometry.sphere_radius, geometry.half_length
    shape = Circle(radius) if half in (None, radius) else Ellipse((half, radius))
    motion = RigidMotion(x=WallMotion(given.velocity or 0.0))
    if given.free:
        motion = FreeMotion(_inertia(config, volume_of_revolution(shape.boundary_points(shape.length / POINTS))))
    centre, spin = (0.5 * geometry.length, 0.0), WallMotion(given.angular_velocity)
    return Body(shape, centre, motion=motion, periods=(geometry.length, math.inf), spin=spin)


def _inertia(config, volume):
    fluid, given = config.fluid.density, config.sphere
    mass = volume * (fluid if given.density is None else given.density)
    load = (given.force or 0.0) + fluid * volume * config.drive.acceleration
    return Inertia((mass, mass, 1.0), (load, 0.0, 0.0), held=(False, True, True), displaced=volume)
