"""The annulus between two cylinders: its flow, and what is looked at in it."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.exact.circular_couette import CircularCouette
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.scenes import _turning
from tisph.scenes._filled import Filled
from tisph.scenes._views import Followed, Profile, Radius, Shown
from tisph.verification.metrics import field_error


@dataclass(frozen=True, kw_only=True)
class Annulus(Filled):
    """Two cylinders around ``centre`` that turn as ``inner`` and ``outer`` say; every number in the config's units.

    ``initial_state`` is ``rest``, ``developed`` or ``exact`` (the flow that began at t = 0, at ``start_time``).
    """

    inner_radius: float
    outer_radius: float
    centre: tuple[float, float]
    inner: WallMotion
    outer: WallMotion
    density: float
    kinematic_viscosity: float
    spacing: float
    initial_state: str
    start_time: float
    units: Any

    periodic = (False, False)
    fields = ("u", "v", "pressure")
    flow_numbers = ("torque_inner", "torque_outer")
    time_formula = "νt/H²"

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        inner, outer = (WallMotion.from_config(wall) for wall in (config.walls.inner, config.walls.outer))
        return cls(
            inner_radius=config.geometry.inner_radius,
            outer_radius=config.geometry.outer_radius,
            centre=config.geometry.centre,
            inner=inner,
            outer=outer,
            density=config.fluid.density,
            kinematic_viscosity=config.kinematic_viscosity,
            spacing=config.spacing,
            initial_state=config.initial.state,
            start_time=config.start_time,
            units=config.units,
        )

    @property
    def origin(self):
        """Lowest corner of the box around the outer cylinder."""
        return tuple(place - self.outer_radius for place in self.centre)

    @property
    def extent(self):
        """Diameter of the outer cylinder, twice."""
        return 2 * self.outer_radius, 2 * self.outer_radius

    @property
    def gap(self):
        """Distance between the cylinders."""
        return self.outer_radius - self.inner_radius

    @cached_property
    def bodies(self):
        """The two cylinders."""
        shapes = Circle(self.inner_radius), Circle(self.outer_radius, liquid="inside")
        motions = RigidMotion(turning=self.inner), RigidMotion(turning=self.outer)
        return tuple(Body(shape, self.centre, motion=way) for shape, way in zip(shapes, motions, strict=True))

    @property
    def reference_length(self):
        """The gap."""
        return self.gap

    @property
    def reference_velocity(self):
        """Speed of the fastest wall, now or before."""
        return max(self.inner_radius * self.inner.largest_speed, self.outer_radius * self.outer.largest_speed)

    @property
    def time_scale(self):
        """Viscous time of the gap."""
        return self.viscous_time

    @property
    def loses_its_scale(self):
        """Whether the cylinders turn to and fro, or come to rest."""
        walls = self.inner, self.outer
        return any(wall.oscillates for wall in walls) or not any(wall.cosine for wall in walls)

    def thinnest_layer(self, t):
        """Depth of the thinnest layer at time ``t`` and where it is: that of a wall that started, or oscillates."""
        layers = []
        for name, wall in (("inner", self.inner), ("outer", self.outer)):
            before = self._before(wall)
            if before != wall.velocity(0.0) and not self._settled:
                layers.append((math.sqrt(self.kinematic_viscosity * t), f"the layer at the {name} cylinder"))
            if wall.oscillates:
                depth = 0.5 * wall.penetration_depth(self.kinematic_viscosity)
                layers.append((depth, f"the layer at the oscillating {name} cylinder"))
        return min(layers, default=(math.inf, ""))

    def _before(self, wall):
        """Angular velocity of a cylinder before t = 0."""
        if wall.before is not None:
            return wall.before
        return wall.velocity(0.0) if self.initial_state == "developed" else 0.0

    @property
    def _settled(self):
        """Whether the flow goes on as it was before t = 0."""
        return self.initial_state == "developed" and all(
            wall.before in (None, wall.cosine) for wall in (self.inner, self.outer)
        )

    @cached_property
    def _flow(self):
        walls = (replace(wall, before=self._before(wall)) for wall in (self.inner, self.outer))
        return CircularCouette(self.inner_radius, self.outer_radius, self.kinematic_viscosity, *walls)

    def radii(self, x, y):
        """Distance of places from the axis."""
        return np.hypot(np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1]))

    def around(self, snapshot):
        """Velocity around the axis, array (particles,)."""
        x, y = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return (x * snapshot.v - y * snapshot.u) / np.hypot(x, y)

    def exact_around(self, x, y, t):
        """Exact velocity around the axis."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.settled_velocity(radius, t) if self._settled else self._flow.velocity(radius, t)

    def exact_vorticity(self, x, y, t):
        """Exact vorticity dv/dx - du/dy (1/time), the shear rate r d(u/r)/dr and twice u/r."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        shear_rate = self._flow.settled_shear_rate if self._settled else self._flow.shear_rate
        return shear_rate(radius, t) + 2 * self.exact_around(x, y, t) / radius

    def exact(self, field, x, y, t):
        """Exact value of one of ``fields``; of zero mean for the pressure, at one time."""
        if field == "pressure":
            return self._exact_pressure(x, y, t)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        part = -away[1] if field == "u" else away[0]
        return part / np.hypot(*away) * self.exact_around(x, y, t)

    def _exact_pressure(self, x, y, t):
        def at(time):
            return self._flow.pressure(self.radii(x, y), time, density=self.density, settled=self._settled)

        times = np.unique(t)
        if len(times) == 1:
            return at(times[0]) + np.zeros(np.shape(t))
        return np.concatenate([np.broadcast_to(at(time), np.shape(x)) for time in times], axis=-1)

    def initial(self, x, y):
        """The exact velocity when the run starts."""
        return {name: self.exact(name, x, y, self.start_time) for name in ("u", "v")}

    def exact_torques(self, t):
        """Torques of the liquid on the inner and the outer cylinder, per length of the axis."""
        of = self._flow.settled_torque if self._settled else self._flow.torque
        return of(t, density=self.density)

    def measures(self, snapshot, followed):
        """Error of the pressure, torques on the cylinders with their references, and those of ``_turning.measures``.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), p - p_exact less its mean. ``torque_inner`` and
        ``torque_outer``: of the liquid on the cylinders, per length of the axis, each also ``_exact``.
        """
        numbers = {"l2_pressure": field_error(self, snapshot, "pressure")}
        exact = self.exact_torques(snapshot.t)
        for index, name in enumerate(("inner", "outer")):
            numbers[f"torque_{name}"] = snapshot.bodies.torque[index]
            numbers[f"torque_{name}_exact"] = exact[index]
        return {**numbers, **_turning.measures(self, snapshot)[1]}

    def description(self):
        """Radii and centre."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "centre": list(self.centre)}

    def facts(self):
        """Numbers of the flow."""
        length, time = self.units.length, self.units.time
        return [
            ("Reynolds number", f"{self.reynolds:.6g}  (U H / nu, H the gap)"),
            ("fastest wall U", f"{self.reference_velocity:.6g} {length}/{time}"),
            ("kinematic viscosity nu", f"{self.kinematic_viscosity:.6g} {length}^2/{time}"),
            ("radii", f"{self.inner_radius:.6g} and {self.outer_radius:.6g} {length}"),
            ("viscous time", f"{self.viscous_time:.6g} {time}  (H^2 / nu)"),
        ]

    def profiles(self):
        """Velocity around the axis, and pressure, over the radius."""
        return [self._velocity(), _turning.pressure_profile(self, self._radius)]

    def followed(self):
        """Torques on the cylinders."""
        scale = 2 * math.pi * self.inner_radius**2 * self.dynamic_viscosity * self.reference_velocity / self.gap
        return Followed(
            content="torque of the liquid on the cylinders over time t",
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

    def shown(self, name, end):
        """Speed with the velocity around the axis over the radius, or vorticity or pressure over it.

        Where a wall starts, the vorticity is infinite at first: colours and axes are fitted to what is left of it in a
        layer a quarter of the gap deep, or half-way through the run.
        """
        profiles = {"speed": self._velocity, "vorticity": self._vorticity}
        profile = profiles[name]() if name in profiles else _turning.pressure_profile(self, self._radius)
        first = self.start_time
        if name == "vorticity":
            first = max(first, min(self.viscous_time / 16, 0.5 * (first + end)))
        return Shown(
            name=name,
            signed=name != "speed",
            of=profile.of if name != "speed" else _turning.speed,
            profile=profile,
            ends=profile.extremes(first, end),
            otherwise=1.0,
            error=("pressure", "p") if name == "pressure" else None,
        )

    @property
    def _radius(self):
        return Radius(ends=(self.inner_radius, self.outer_radius), place=self.centre)

    def _velocity(self):
        scale = (self.reference_velocity, "speed of the fastest wall")
        return Profile("u_θ", "velocity", self._radius, of=self.around, exact=self.exact_around, scale=scale)

    def _vorticity(self):
        return Profile("vorticity", "rate", self._radius, of=_turning.vorticity(self), exact=self.exact_vorticity)
