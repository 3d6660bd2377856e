"""Two cylinders, one within the other: geometry, what turns, fluid."""

import math
from dataclasses import dataclass
from functools import cached_property

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.motion import RigidMotion, Schedule, WallMotion
from tisph.scenes._body_scene import BodyScene
from tisph.scenes._layers import age, depth, spreading_viscosity


@dataclass(frozen=True, kw_only=True)
class Cylinders(BodyScene):
    """Two cylinders that turn as ``inner`` and ``outer`` say; every number in the config's units.

    The axis of the outer one is at ``centre``, that of the inner one by ``offset`` farther along x. ``initial_state``
    is ``rest``, ``developed`` or ``exact`` (the flow that began at t = 0, at ``start_time``).
    """

    inner_radius: float
    outer_radius: float
    centre: tuple[float, float]
    inner: WallMotion | Schedule
    outer: WallMotion | Schedule
    initial_state: str
    start_time: float
    offset: float = 0.0

    periodic = (False, False)
    time_formula = "νt/H²"

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
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
        )

    @property
    def origin(self):
        """Lowest corner of the box around the outer cylinder."""
        return tuple(place - self.outer_radius for place in self.centre)

    @property
    def extent(self):
        """Diameter of the outer cylinder, twice."""
        return 2 * self.outer_radius, 2 * self.outer_radius

    @cached_property
    def bodies(self):
        """The two cylinders."""
        shapes = Circle(self.inner_radius), Circle(self.outer_radius, fluid_side="inside")
        axis = self.centre[0] + self.offset, self.centre[1]
        turning = RigidMotion(rotation=self.inner), RigidMotion(rotation=self.outer)
        return Body(shapes[0], axis, motion=turning[0]), Body(shapes[1], self.centre, motion=turning[1])

    @property
    def jump_times(self):
        """Times above 0 at which the angular velocity of a cylinder, or its slope, jumps."""
        return tuple(sorted({*self.inner.jump_times, *self.outer.jump_times}))

    @property
    def reference_length(self):
        """The gap, that between cylinders with one axis."""
        return self.outer_radius - self.inner_radius

    @property
    def velocity_scale(self):
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
            started = self.before(wall) != wall.velocity(0.0) and not self.stays_steady
            since = age(wall, t) if started or wall.jump_times else math.inf
            if since < math.inf:
                layers.append((depth(self, since), f"the layer at the {name} cylinder"))
            if wall.oscillates:
                still = self.kinematic_viscosity
                if self.rheology and not self.polymer and wall.angular_frequency:
                    still = spreading_viscosity(self, 1 / wall.angular_frequency)
                moved = 0.5 * wall.penetration_depth(still)
                layers.append((moved, f"the layer at the oscillating {name} cylinder"))
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

    def description(self):
        """Radii and centre."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "centre": list(self.centre)}


def turning_of(wall):
    """The motion of a cylinder of a config."""
    if wall.angular_velocities:
        return Schedule(wall.times, wall.angular_velocities)
    return WallMotion.from_config(wall)
