"""What all axisymmetric scenes are: a half-plane y >= 0 above the axis, with walls of revolution."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.region import Region
from tisph.geometry.shape import POINTS, volume_of_revolution
from tisph.scenes._axisymmetric.views import NAMES
from tisph.scenes._body_scene import BodyScene
from tisph.snapshot import STRESSES_AROUND


@dataclass(frozen=True, kw_only=True)
class AxisymmetricScene(BodyScene):
    """Fluid from ``inner_radius`` to ``outer_radius`` around a ``length`` of the axis; all in the config's units.

    ``names`` are those of ``bodies``, which are walls of revolution; the fluid reaches the axis where ``inner_radius``
    is 0. Forces are those on whole bodies of revolution, one period long. ``left`` is where the length begins along the
    axis, ``periodic`` as of ``Scene``.
    """

    length: float
    inner_radius: float
    outer_radius: float
    names: tuple[str, ...]
    bodies: tuple[Body, ...]
    start_time: float = 0.0
    left: float = 0.0
    periodic: tuple[bool, bool] = (True, False)

    axisymmetric = True
    time_formula = "νt/H²"

    @property
    def origin(self):
        """Lowest corner of the half-plane that holds fluid."""
        return self.left, self.inner_radius

    @property
    def extent(self):
        """Length, and difference of the radii."""
        return self.length, self.outer_radius - self.inner_radius

    @cached_property
    def region(self):
        """The fluid's region at t = 0, with the axis as a wall where the fluid reaches it."""
        high, bodies = (self.left + self.length, self.outer_radius), self.bodies
        if self.inner_radius == 0.0:
            bodies = (axis(self.length), *bodies)
        return Region(bodies, self.origin, high, self.periodic, axisymmetric=True)

    @cached_property
    def volumes(self):
        """Volumes of the closed ones of the ``bodies``, as what is turned around the axis; 0 of the others."""
        return [
            volume_of_revolution(body.boundary_points(body.shape.length / POINTS)) if body.shape.area else 0.0
            for body in self.bodies
        ]

    @property
    def reference_length(self):
        """Difference of the radii."""
        return self.extent[1]

    @property
    def fastest_wall(self):
        """Speed of the fastest wall or body, as the config gives it."""
        return max(map(wall_speed, self.bodies))

    @property
    def velocity_scale(self):
        """``fastest_wall``."""
        return self.fastest_wall

    @property
    def time_scale(self):
        """Viscous time of the difference of the radii."""
        return self.viscous_time

    @property
    def swirls(self):
        """Whether a wall turns around the axis."""
        return any(body.spin.largest_speed for body in self.bodies)

    @property
    def jump_times(self):
        """Times above 0 at which the angular velocity of a wall, or its slope, jumps."""
        return tuple(sorted({time for body in self.bodies for time in body.spin.jump_times}))

    def narrowest(self, t):
        """Radius of the inner wall, and gap between the walls.

        Where that wall turns the shear rate falls as r^(-2/n), n the index of a power law: as that of a Newtonian fluid
        does at n times the radius.
        """
        index = min(1.0, getattr(self.rheology, "index", 1.0)) if self.swirls else 1.0
        what = "the radius of the inner wall" + (f" times the fluid's index {index:g}" if index < 1.0 else "")
        return (index * self.inner_radius or np.inf, what), (self.extent[1], "the gap between the walls")

    def open_section(self, t):
        """Place along the axis of a cross-section with no body in it."""
        return 0.0

    def initial(self, x, y):
        """Rest, without stress."""
        around = STRESSES_AROUND[: None if self.swirls else 1] if self.polymer else ()
        return {**super().initial(x, y), **dict.fromkeys(("w", *around), np.zeros(np.shape(x)))}

    def movie_profiles(self):
        """See ``Scene.movie_profiles``; the velocity around the axis is called as its colour is."""
        found = super().movie_profiles()
        around = found.get(NAMES["w"])
        return found | {"swirl": replace(around, name="swirl")} if around else found

    def movie_fields(self, name):
        """See ``Scene.movie_fields``; the trace has the stress around the axis, too."""
        return *super().movie_fields(name), *STRESSES_AROUND[: name == "conformation_trace"]

    def description(self):
        """Radii and length."""
        return {"inner_radius": self.inner_radius, "outer_radius": self.outer_radius, "length": self.length}


def axis(length):
    """The axis as a wall, for the arrangement of particles."""
    return Body(Line((0.0, 0.0), (1.0, 0.0), length))


def cylinder(radius, length, outer, **motion):
    """The wall of a cylinder, with the fluid inside it where it is the ``outer`` one; ``motion`` as of ``Body``."""
    line = Line((length, radius), (-1.0, 0.0), length) if outer else Line((0.0, radius), (1.0, 0.0), length)
    return Body(line, **motion)


def layer_at_plates(scene):
    """Depth sqrt(nu/Omega) of layers at walls across the axis (von Karman 1921), Omega of the fastest, and a name."""
    fastest = max(body.spin.largest_speed for body in scene.bodies)
    return np.sqrt(scene.kinematic_viscosity / fastest) if fastest else np.inf, "the layer at walls that turn"


def wall_speed(body):
    """Largest speed of a wall, along the axis and around it."""
    turning = body.spin.largest_speed * (body.centre[1] + body.shape.extent[1, 1]) if body.spin.largest_speed else 0.0
    return float(np.hypot(body.motion.x.largest_speed, turning))
