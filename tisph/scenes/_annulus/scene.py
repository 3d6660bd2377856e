"""The annulus between two cylinders: geometry, what turns, fluid, exact solution."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.schedule import Schedule
from tisph.measures.metrics import field_error, relative_difference
from tisph.scenes import _two_dimensional
from tisph.scenes._annulus import views
from tisph.scenes._annulus.flow import cartesian, polar, reference_flow
from tisph.scenes._body_scene import BodyScene
from tisph.snapshot import STRESSES


@dataclass(frozen=True, kw_only=True)
class Annulus(BodyScene):
    """Two cylinders around ``centre`` that turn as ``inner`` and ``outer`` say; every number in the config's units.

    ``initial_state`` is ``rest``, ``developed`` or ``exact`` (the flow that began at t = 0, at ``start_time``).
    """

    inner_radius: float
    outer_radius: float
    centre: tuple[float, float]
    inner: WallMotion | Schedule
    outer: WallMotion | Schedule
    initial_state: str
    start_time: float

    periodic = (False, False)
    flow_quantities = ("torque_inner", "torque_outer")
    time_formula = "νt/H²"

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        inner, outer = (_turning_of(wall) for wall in (config.walls.inner, config.walls.outer))
        return cls(
            **cls.fluid_of(config),
            inner_radius=config.geometry.inner_radius,
            outer_radius=config.geometry.outer_radius,
            centre=config.geometry.centre,
            inner=inner,
            outer=outer,
            initial_state=config.initial.state,
            start_time=config.start_time,
        )

    @property
    def fields(self):
        """Velocity and pressure, and the stresses of a polymer."""
        return ("u", "v", "pressure", *(STRESSES if self.polymer else ()))

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
        shapes = Circle(self.inner_radius), Circle(self.outer_radius, fluid_side="inside")
        motions = RigidMotion(rotation=self.inner), RigidMotion(rotation=self.outer)
        return tuple(Body(shape, self.centre, motion=way) for shape, way in zip(shapes, motions, strict=True))

    @property
    def jump_times(self):
        """Times above 0 at which the angular velocity of a cylinder, or its slope, jumps."""
        return tuple(sorted({*self.inner.jump_times, *self.outer.jump_times}))

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
    def vanishing_scale(self):
        """Whether the cylinders oscillate, or come to rest."""
        walls = self.inner, self.outer
        return any(wall.oscillates for wall in walls) or not any(wall.cosine for wall in walls)

    def thinnest_layer(self, t):
        """Depth of the thinnest layer at time ``t`` and where it is: that of a wall that started, or oscillates."""
        layers = []
        for name, wall in (("inner", self.inner), ("outer", self.outer)):
            if (self.before(wall) != wall.velocity(0.0) and not self.stays_steady) or wall.jump_times:
                since = t - max((change for change in wall.jump_times if change < t), default=0.0)
                viscosity = self.kinematic_viscosity * (self.polymer.diffusive_fraction(since) if self.polymer else 1.0)
                layers.append((math.sqrt(viscosity * since), f"the layer at the {name} cylinder"))
            if wall.oscillates:
                depth = 0.5 * wall.penetration_depth(self.kinematic_viscosity)
                layers.append((depth, f"the layer at the oscillating {name} cylinder"))
        return min(layers, default=(math.inf, ""))

    def before(self, wall):
        """Angular velocity of a cylinder before t = 0."""
        if wall.before is not None:
            return wall.before
        return wall.velocity(0.0) if self.initial_state == "developed" else 0.0

    @property
    def stays_steady(self):
        """Whether the flow goes on as it was before t = 0."""
        return self.initial_state == "developed" and all(
            wall.before in (None, wall.cosine) for wall in (self.inner, self.outer)
        )

    @property
    def _flow(self):
        return reference_flow(self)

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
        return self._flow.velocity(radius, t)

    def exact_vorticity(self, x, y, t):
        """Exact vorticity dv/dx - du/dy (1/time), the shear rate r d(u/r)/dr and twice u/r."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        return self._flow.shear_rate(radius, t) + 2 * self.exact_around(x, y, t) / radius

    def exact(self, field, x, y, t):
        """Exact value of one of ``fields``; of zero mean for the pressure, at one time."""
        if field == "pressure":
            return self._exact_pressure(x, y, t)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        if field in STRESSES:
            return cartesian(self.exact_polymer_stress(x, y, t), *away)[STRESSES.index(field)]
        part = -away[1] if field == "u" else away[0]
        return part / np.hypot(*away) * self.exact_around(x, y, t)

    def exact_polymer_stress(self, x, y, t):
        """Exact stress of the polymer in polar components, shape (3, ...): around the axis, shear, along the radius."""
        return self.density * self._flow.polymer_stress(self.radii(x, y), t)

    @property
    def initial_conformation_excess(self):
        """``conformation_excess`` when the run starts; None from rest, which has none."""
        return None if self.initial_state == "rest" else self._deviations

    def _deviations(self, x, y):
        """C (components, n) of each mode, xx, xy, yy (and zz), at places ``x``, ``y`` (n,) when the run starts."""
        radius = np.clip(self.radii(x, y), self.inner_radius, self.outer_radius)
        away = np.subtract(x, self.centre[0]), np.subtract(y, self.centre[1])
        modes = self._flow.conformation_excess(radius, self.start_time)
        return [np.concatenate([cartesian(mode[:3], *away), mode[3:]]) for mode in modes]

    def polymer_stress(self, snapshot):
        """Shear stress (particles,) of the polymer, and its N1, the stress around the axis less that along radii."""
        away = snapshot.x - self.centre[0], snapshot.y - self.centre[1]
        return polar([getattr(snapshot, name) for name in STRESSES], *away)

    def _exact_pressure(self, x, y, t):
        def at(time):
            return self._flow.pressure(self.radii(x, y), time, density=self.density)

        times = np.unique(t)
        if len(times) == 1:
            return at(times[0]) + np.zeros(np.shape(t))
        return np.concatenate([np.broadcast_to(at(time), np.shape(x)) for time in times], axis=-1)

    def initial(self, x, y):
        """The exact velocity, and stress of a polymer, when the run starts."""
        names = [name for name in self.fields if name != "pressure"]
        return {name: self.exact(name, x, y, self.start_time) for name in names}

    def exact_torques(self, t):
        """Torques of the fluid on the inner and the outer cylinder, per length of the axis."""
        return self._flow.torque(t, density=self.density)

    @property
    def extra_series(self):
        """First normal stress difference of a polymer at both cylinders, ``n1_inner`` and ``n1_outer``."""
        return views.extra_series(self) if self.polymer else None

    def exact_normal_stress(self, t):
        """Exact N1 (2, times) of the polymer at the inner and the outer cylinder."""
        radii = np.array([[self.inner_radius], [self.outer_radius]])
        around, _, along = self.density * self._flow.polymer_stress(radii, np.asarray(t))
        return around - along

    def diagnostics(self, snapshot, series):
        """Errors of pressure and stresses, torques with their references, and ``_two_dimensional.diagnostics``.

        ``l2_pressure``: sqrt(sum (p-p_exact)^2 / sum p_exact^2), p - p_exact less its mean. ``torque_inner`` and
        ``torque_outer``: of the fluid on the cylinders, per length of the axis, each also ``_exact``. With polymer
        ``shear_stress_l2`` and ``normal_stress_l2``, those of its shear stress and N1 in polar components.
        """
        numbers = {"l2_pressure": field_error(self, snapshot, "pressure"), **self._stress_errors(snapshot)}
        exact = self.exact_torques(snapshot.t)
        for index, name in enumerate(("inner", "outer")):
            numbers[f"torque_{name}"] = snapshot.bodies.torque[index]
            numbers[f"torque_{name}_exact"] = exact[index]
        return {**numbers, **_two_dimensional.diagnostics(self, snapshot)[1]}

    def _stress_errors(self, snapshot):
        if self.polymer is None:
            return {}
        around, exact, along = self.exact_polymer_stress(snapshot.x, snapshot.y, snapshot.t)
        shear, normal = self.polymer_stress(snapshot)
        return {
            "shear_stress_l2": relative_difference(shear, exact),
            "normal_stress_l2": relative_difference(normal, around - along),
        }

    def description(self):
        """Radii and centre."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "centre": list(self.centre)}

    movie_view = views.movie_view
    parameters = views.parameters
    profiles = views.profiles
    time_series = views.time_series

    def movie_fields(self, name):
        """The pressure, or all of the stress, where it is shown."""
        return ("stress_xx", "stress_yy") if name == "shear_stress" else super().movie_fields(name)


def _turning_of(wall):
    """The motion of a cylinder of a config."""
    if wall.angular_velocities:
        return Schedule(wall.times, wall.angular_velocities)
    return WallMotion.from_config(wall)
