"""A region of axisymmetric flow: walls and bodies of revolution put together at will, and what is looked at in it.

They are turned around the axis y = 0. A curve on both sides of it must be symmetric about it: half of it counts. Of a
polygon with a side on the axis that side is no wall. The sides of a convex polygon around the fluid, with sharp corners
of 50 degrees and more, are straight walls, each of its own; another outline is one wall.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.bodies._clearance import LEAST_GAP
from tisph.config.base import Problem
from tisph.geometry.body import Body, gap
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.polygon import Polygon
from tisph.scenes._annulus.cylinders import turning_of
from tisph.scenes._axisymmetric import measures, views
from tisph.scenes._axisymmetric.scene import AxisymmetricScene, cylinder, layer_at_plates
from tisph.scenes._cell.sections import surroundings
from tisph.scenes._layers import depth

LEAST_ANGLE = np.radians(49.9)
"""Of sharp corners, those on the axis among them: with 45 degrees there, 16 across, fluid in a cone diverged."""

POINTS = 100
"""Points on each wall from which gaps are taken."""


def bodies_and_walls(config: Any) -> tuple[dict[str, Body], dict[str, Body]]:
    """Bodies in the fluid and walls around it by name, of a ``config``; they turn as its ``turning`` says."""
    box, bodies = config.geometry, {}
    if isinstance(config.bodies, tuple):
        periods, given = (box.length if box else math.inf, math.inf), surroundings(config)
        bodies = {f"body_{i}": body_of_revolution(each.body(periods, given)) for i, each in enumerate(config.bodies)}
    walls = _around(config.walls.around) if box is None else {}
    for name, height in (("bottom", 0.0), ("top", box.height)) if box else ():
        if box.inner_radius + height:
            motion = RigidMotion(WallMotion.from_config(getattr(config.walls, name)))
            walls[name] = cylinder(box.inner_radius + height, box.length, name == "top", motion=motion)
    for name in (*bodies, *walls):
        spins = [turning_of(each) for each in config.turning if each.turns(name)]
        group = bodies if name in bodies else walls
        group[name] = replace(group[name], spin=spins[-1]) if spins else group[name]
    return bodies, walls


def body_of_revolution(body: Body) -> Body:
    """The ``body``, as it is on both sides of the axis if it is a polygon with a side there."""
    if not isinstance(body.shape, Polygon):
        return body
    corners = body.at().to_lab_frame(np.array(body.shape.corners))
    corners = np.where(np.abs(corners) < 1e-12 * body.shape.length, 0.0, corners)
    on_axis = corners[:, 1] == 0.0
    right = np.flatnonzero(on_axis & np.roll(on_axis, 1))  # counterclockwise the side on the axis ends there
    if on_axis.sum() != 2 or len(right) != 1 or (corners[:, 1] < 0.0).any():
        return body
    corners, centre = np.roll(corners, -right[0], axis=0), np.array([body.centre[0], 0.0])
    whole = np.concatenate([corners, corners[-2:0:-1] * [1.0, -1.0]]) - centre
    return replace(body, shape=replace(body.shape, corners=whole.tolist()), centre=tuple(centre.tolist()), angle=0.0)


def _around(given: Any) -> dict[str, Body]:
    """Walls by name of the shape ``given``: ``around``, or ``around_0`` for the side from its first corner, and so on.

    A side on the axis has a number and no wall.
    """
    body = given.body()
    if isinstance(body.shape, Polygon) and not body.shape.corner_radius:
        corners = body.at().to_lab_frame(np.array(given.corners))
        ends = np.roll(corners, -1, axis=0)
        (x, y), (next_x, next_y) = (ends - corners).T, np.roll(ends - corners, -1, axis=0).T
        turns = np.arctan2(x * next_y - y * next_x, x * next_x + y * next_y)
        convex = abs(np.sign(turns).sum()) == len(turns) and np.abs(turns).max() < np.pi - LEAST_ANGLE
        if convex and (corners[:, 1] >= 0.0).all():
            pairs = zip(corners, ends, strict=True) if turns[0] > 0.0 else zip(ends, corners, strict=True)
            sides = {f"around_{i}": pair for i, pair in enumerate(pairs) if pair[0][1] or pair[1][1]}
            return {name: Body(Line(a, b - a, float(np.hypot(*(b - a))))) for name, (a, b) in sides.items()}
    whole = body_of_revolution(body)
    return {"around": replace(whole, shape=replace(whole.shape, fluid_side="inside"))}


def outline_problems(key: str, body: Body, spacing: float) -> Iterator[Problem]:
    """What speaks against a closed ``body`` as a surface of revolution, and against its motion."""
    points = body.boundary_points(body.shape.length / 1000).point
    asymmetric = np.abs(body.nearest(points * [1.0, -1.0]).distance).max() > 1e-6 * body.shape.length
    if asymmetric and points[:, 1].min() < LEAST_GAP * spacing:
        text = f"must be {LEAST_GAP:g} spacings away from the axis, {LEAST_GAP * spacing:.4g}, or symmetric about it"
        yield key, f"{text}, or a polygon with one side on it"
    if not body.free and (body.motion.y.largest_speed or body.motion.rotation.largest_speed):
        yield f"{key}.motion", "must be along the axis, [u, 0], in axisymmetric flow; what turns around it says turning"


@dataclass(frozen=True, kw_only=True)
class RegionOfRevolution(AxisymmetricScene):
    """The first ``count`` of the ``bodies`` are in the fluid, the others around it; at rest at first.

    ``singular``: whether walls meet that turn differently.
    """

    count: int
    acceleration: float
    singular: bool

    parameters = views.parameters

    @classmethod
    def from_config(cls, config):
        """The scene that a validated config describes."""
        bodies, walls = bodies_and_walls(config)
        (left, low), (right, high) = config.box.tolist()
        return cls(
            **cls.fluid_of(config),
            length=right - left,
            left=left,
            inner_radius=low,
            outer_radius=high,
            periodic=config.periodic,
            names=(*bodies, *walls),
            bodies=(*bodies.values(), *walls.values()),
            count=len(bodies),
            acceleration=config.drive.acceleration,
            singular=config.singular,
        )

    @property
    def velocity_scale(self):
        """Speed of the fastest wall or body, or of the fluid that the acceleration drives, roughly."""
        drive, width = abs(self.acceleration), self.reference_length
        driven = min(drive * width**2 / (4.0 * self.kinematic_viscosity), math.sqrt(drive * width))
        return max(super().velocity_scale, driven)

    @property
    def flow_quantities(self):
        """Loads on bodies and walls; no torques where walls meet that turn differently: they have no limit."""
        return tuple(name for name in self._columns if not (self.singular and name.startswith("torque")))

    def narrowest(self, t):
        """Smallest radius of a wall that bulges into the fluid, and smallest gap at a body."""
        radius = min(body.shape.convex_radius for body in self.bodies)
        pairs = ((body, other) for i, body in enumerate(self.bodies[: self.count]) for other in self.bodies[i + 1 :])
        least = min((gap(*pair, t, POINTS) for pair in pairs), default=math.inf)
        return (radius, "the smallest radius"), (least, "the gap at a body")

    def thinnest_layer(self, t):
        """Depth of the layer at walls that started at t = 0, or turn, and where it is."""
        started = depth(self, t), "the layer at walls"
        return min(started, layer_at_plates(self)) if self.count or not self.periodic[0] else started

    def diagnostics(self, snapshot, series):
        """Forces along the axis and torques around it on bodies and walls, and kinetic energies."""
        energies = zip(measures.ENERGIES, measures.kinetic_energies(snapshot), strict=True)
        return {**measures.loads(self, snapshot), **dict(energies), **measures.spread(self, snapshot)}

    def profiles(self):
        """Velocities over the radius in the middle of the length."""
        line = views.across(self, self.left + 0.5 * self.length)
        return [views.velocity(self, name, line) for name in "w" * self.swirls + "uv"]

    @property
    def _columns(self):
        kinds = ("torque", "force") if self.swirls else ("force",)
        return tuple(f"{kind}_{name}" for kind in kinds for name in self.names)

    def time_series(self):
        """Forces along the axis and, where something turns, torques around it."""
        return views.loads_series(self, self._columns)

    def movie_series(self):
        """Torques, or forces where nothing turns."""
        return views.only_first(self.time_series())
