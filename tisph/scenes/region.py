"""Flow in a region of any shape: fluid inside a closed wall, or between two planes, around bodies.

With ``walls: {around: SHAPE}`` the fluid is inside a circle, an ellipse, a polygon or a closed curve, which may turn
about its centre. Otherwise it is in the cell 0 <= x <= length, 0 <= y <= height of the ``geometry``, which is periodic
along x between the walls ``bottom`` and ``top``. Bodies of any number and shape are in the fluid, which is at rest at
first. An acceleration along x drives a periodic region. There is no exact solution: ``tisph run --estimate-error``
estimates the errors.

With ``coordinates: axisymmetric`` walls and bodies are surfaces of revolution about the axis y = 0; the fluid is in the
half-plane above it. A curve on both sides of the axis must be symmetric about it. A side of a polygon on the axis is
not a wall. Each side of a convex polygon around the fluid, with sharp corners of 50 degrees and more, is a wall of its
own; any other outline is one wall.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, Literal, cast

import numpy as np
from pydantic import Field, model_validator

from tisph.bodies._clearance import LEAST_GAP
from tisph.config import schema
from tisph.config.base import Model, NonNegative, Positive, Problem, refusals
from tisph.config.ends import Ends
from tisph.config.fields import Bodies, Member, nearest
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.polygon import Polygon
from tisph.scenes import annulus
from tisph.scenes._cell import Cell, Surroundings, bodies_of, cell_problems, planes, walls_along
from tisph.scenes._ends import end_lines, stream_problems
from tisph.scenes._initial import Contact, Drive, RestInitial, incommensurate_periods
from tisph.scenes._region_of_revolution import RegionOfRevolution, StreamOfRevolution
from tisph.scenes._scene import farthest
from tisph.scenes.annulus import turning_of
from tisph.scenes.channel import Wall, outlined_wall_problems

LEAST_ANGLE = np.radians(49.9)
"""Least angle of sharp corners, on the axis, too: flow in a cone of 45 degrees diverged with 16 particles across."""


def bodies_and_walls(config: "Config") -> tuple[dict[str, Body], dict[str, Body]]:
    """Return bodies in the fluid and walls around it by name, of a ``config``, with the rotation in its ``turning``."""
    bodies = {}
    if isinstance(config.bodies, tuple):
        periods, given = (config.extent[0] if config.periodic[0] else math.inf, math.inf), Surroundings.of(config)
        bodies = {f"body_{i}": body_of_revolution(each.body(periods, given)) for i, each in enumerate(config.bodies)}
    walls = walls_along(config) if config.geometry else _around(config.walls.around)
    for name in (*bodies, *walls):
        spins = [turning_of(each) for each in config.turning if each.turns(name)]
        group = bodies if name in bodies else walls
        group[name] = replace(group[name], spin=spins[-1]) if spins else group[name]
    return bodies, walls


def body_of_revolution(body: Body) -> Body:
    """Return the ``body``; a polygon with a side on the axis is completed by its mirror image."""
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
    """Return the walls of the shape ``given`` by name: ``around``, or ``around_0`` for the side from its first corner
    and so on. A side on the axis has a number, but no wall.
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
            slip = body.slip_length
            lines = {name: Line(a, b - a, float(np.hypot(*(b - a)))) for name, (a, b) in sides.items()}
            return {name: Body(line, slip_length=slip) for name, line in lines.items()}
    whole = body_of_revolution(body)
    return {"around": replace(whole, shape=replace(cast(Any, whole.shape), fluid_side="inside"))}


def outline_problems(key: str, body: Body, spacing: float) -> Iterator[Problem]:
    """Yield errors of a closed ``body`` as a surface of revolution, and of its motion."""
    points = body.boundary_points(body.shape.length / 1000).point
    asymmetric = np.abs(body.nearest(points * [1.0, -1.0]).distance).max() > 1e-6 * body.shape.length
    if asymmetric and points[:, 1].min() < LEAST_GAP * spacing:
        text = f"must be {LEAST_GAP:g} spacings away from the axis, {LEAST_GAP * spacing:.4g}, or symmetric about it"
        yield key, f"{text}, or a polygon with one side on it"
    if not body.free and (body.motion.y.largest_speed or body.motion.rotation.largest_speed):
        yield (
            f"{key}.motion",
            "must be along the axis, [u, 0], in axisymmetric flow; give rotation in turning",
        )


class Geometry(Model):
    """Period along x and distance of the walls [length]; ``inner_radius``: height of the lower one above an axis."""

    length: Positive
    height: Positive
    inner_radius: NonNegative = 0.0


class Walls(Model):
    """One closed wall ``around`` the fluid, with the shape of a body; or walls at y = 0 and y = height."""

    unset_keys = ("around", "bottom", "top")

    around: Annotated[Any, Member("bodies", usual="circle")] | None = None
    bottom: Wall | None = None
    top: Wall | None = None

    @model_validator(mode="before")
    @classmethod
    def _fill_in_planes(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("around") is not None:
            return data
        return {**data, **{name: data.get(name) or {} for name in ("bottom", "top")}}

    @model_validator(mode="after")
    def _check_forms(self) -> "Walls":
        given = [name for name in ("bottom", "top") if getattr(self, name) is not None]
        if self.around is not None and given:
            text = "is not allowed with walls.around, which encloses the fluid"
            raise refusals([((name,), text, getattr(self, name)) for name in given])
        if self.around is not None and self.around.motion == "free":
            text = "must not be free: a wall is fixed, or turns with an angular_velocity or angular_amplitude"
            raise refusals([(("around", "motion"), text, "free")])
        return self


class Turning(annulus.Turning):
    """Angular velocity around the axis of a ``wall`` or body, by its name in results; the keys are as for a cylinder.

    ``around`` means all sides of the closed wall.
    """

    wall: str

    def turns(self, name: str) -> bool:
        """Return whether this is the rotation of the wall called ``name``."""
        return name == self.wall or (self.wall == "around" and name.startswith("around_"))


class Config(schema.Config):
    """A whole run in the region."""

    coordinates: Literal["planar", "axisymmetric"] = "planar"
    geometry: Geometry | None = None
    walls: Walls = Walls.model_validate({})
    ends: Ends | None = None
    bodies: Bodies = ()
    drive: Drive = Drive()
    turning: Annotated[tuple[Turning, ...], Field(strict=False, max_length=100)] = ()
    contact: Contact | None = None
    initial: RestInitial = RestInitial()

    unset_keys = (*schema.Config.unset_keys, "geometry", "bodies", "contact", "turning", "ends")
    across_name = "the region"

    @model_validator(mode="before")
    @classmethod
    def _check_geometry(cls, data: Any) -> Any:
        walls = data.get("walls") if isinstance(data, dict) else None
        closed = isinstance(walls, dict) and walls.get("around") is not None
        given = isinstance(data, dict) and data.get("geometry") is not None
        if not closed and not given:
            raise refusals([(("geometry",), "is missing: give length and height, or walls.around", {})])
        if closed and given:
            text = "is not allowed with walls.around, which sets the size of the region"
            raise refusals([(("geometry",), text, data["geometry"])])
        if closed and data.get("ends") is not None:
            raise refusals([(("ends",), "is not allowed with walls.around, which encloses the fluid", data["ends"])])
        return data

    @property
    def flow(self) -> str:
        """See ``schema.Config.flow``."""
        if self.ends:
            return f"{self.named_bodies or 'Flow'} in a stream around an axis"
        place = "in a closed vessel" if self.walls.around else "between two walls"
        return f"{self.named_bodies or 'Flow'} {place}"

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the box is periodic in x and y."""
        return self.walls.around is None and self.ends is None, False

    @property
    def axisymmetric(self) -> bool:
        """Whether y is the distance from an axis."""
        return self.coordinates == "axisymmetric"

    @property
    def singular(self) -> bool:
        """Whether walls with different angular velocities around the axis meet, or the inlet's velocity jumps there."""
        if self.ends:
            inlet = self.ends.inlet
            return inlet is not None and inlet.jumps_at_walls(
                on_axis=not (self.geometry and self.geometry.inner_radius)
            )
        sides = [wall.spin for wall in bodies_and_walls(self)[1].values()] if self.axisymmetric else []
        return not self.periodic[0] and any(spin != sides[0] for spin in sides)

    @property
    def box(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box."""
        if self.geometry is not None:
            low = self.geometry.inner_radius
            return np.array([[0.0, low], [self.geometry.length, low + self.geometry.height]])
        around: Any = self.walls.around
        body = around.body()
        if body.motion.rotation.largest_speed:
            return body.centre + farthest(body.shape) * np.array([[-1.0, -1.0], [1.0, 1.0]])
        points = body.boundary_points(body.shape.length / 1000).point if body.angle else body.shape.extent + body.centre
        points = np.maximum(points, [-np.inf, 0.0]) if self.axisymmetric else points
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def origin(self) -> tuple[float, float]:
        """Lowest corner of the box."""
        return tuple(self.box[0].tolist())

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the box."""
        return tuple(np.ptp(self.box, axis=0).tolist())

    @property
    def aspect(self) -> float:
        """Length over height where the length is a period; 1 else, when the spacing need not divide any length."""
        return self.extent[0] / self.extent[1] if self.periodic[0] else 1.0

    def problems(self) -> Iterator[Problem]:
        """Yield the errors that the scene finds in the config."""
        if self.scheme.type == "wcsph" and self.walls.around is None:
            yield "scheme.type", "wcsph has no wall treatment for scene region; take auto or implicit"
            return
        for name in ("bottom", "top"):
            wall = getattr(self.walls, name)
            if wall and (wall.stress_controlled or wall.velocities):
                yield f"walls.{name}", "must have a constant velocity, or an amplitude"
                return
            if wall and wall.velocity_before is not None:
                yield f"walls.{name}.velocity_before", "must be left out: in a region the fluid is at rest at first"
        if self.walls.around is None and (errors := list(outlined_wall_problems(self))):
            yield from errors
            return
        yield from _coordinate_problems(self)
        around = self.walls.around
        if around is not None and self.drive.acceleration:
            yield "drive.acceleration", "must be 0 inside a closed wall, where the pressure balances it"
        if around is not None and (around.body().motion.x.largest_speed or around.body().motion.y.largest_speed):
            yield "walls.around.motion", "may only turn: give fixed, angular_velocity or angular_amplitude"
        bodies, walls = bodies_and_walls(self) if self.axisymmetric else ({}, _walls(self))
        walls = {f"walls.{name}": wall for name, wall in walls.items()}
        placed = list(bodies.values()) if self.axisymmetric else bodies_of(self, walls, self.origin)
        if self.ends and self.axisymmetric:
            yield from stream_problems(self, walls)
            walls |= {f"ends.{side}": Body(line) for side, line in end_lines(self).items()}
        yield from cell_problems(self, placed, walls)

    def incommensurate(self) -> Iterator[Problem]:
        """Yield an error for a length that the spacing does not divide, or that is too short."""
        if self.periodic[0]:
            yield from schema.incommensurate_columns(self) or incommensurate_periods(self)


class Scene:
    """Maker of the scene."""

    @staticmethod
    def from_config(config: "Config") -> Cell | RegionOfRevolution:
        """Return the scene that a validated config describes."""
        if config.axisymmetric:
            return (StreamOfRevolution if config.ends else RegionOfRevolution).around(config, *bodies_and_walls(config))
        walls = _walls(config)
        own = {"origin": config.origin} if "around" in walls else {"walls": planes(walls)}
        return Cell.around(config, bodies_of(config, walls, config.origin), walls, **own)


def _coordinate_problems(config: Config) -> Iterator[Problem]:
    """Yield errors of sections that the coordinates do not allow, or not in this form."""
    if not config.axisymmetric:
        if config.ends:
            yield "ends", "is only for coordinates: axisymmetric; in planar flow take scene channel"
        if config.turning or (config.geometry and config.geometry.inner_radius):
            yield "turning" if config.turning else "geometry.inner_radius", "is only for coordinates: axisymmetric"
        return
    bodies, walls = bodies_and_walls(config)
    names = (*bodies, *walls)
    if config.discretisation.precision == "f32":
        yield "discretisation.precision", "must be f64 in axisymmetric flow"
    if not isinstance(config.bodies, tuple) or config.has_free_bodies:
        yield "bodies", "must be listed, and fixed or moved along the axis, in axisymmetric flow"
    if config.drive.gravity:
        yield "drive.gravity", "moves free bodies alone, in planar flow"
    if config.walls.bottom not in (None, Wall()) and "bottom" not in walls:
        yield "walls.bottom", "must be left out: it is the axis where geometry.inner_radius is 0"
    for index, each in enumerate(config.turning):
        if not any(map(each.turns, names)):
            yield f"turning.{index}.wall", f"must be one of {', '.join(names)}{nearest(each.wall, names)}"
        if each.angular_velocity_before is not None:
            yield f"turning.{index}.angular_velocity_before", "is for scene annulus alone"
    closed = {f"bodies.{index}": body for index, body in enumerate(bodies.values())}
    if config.walls.around is not None:
        closed["walls.around"] = body_of_revolution(config.walls.around.body())
    for key, body in closed.items():
        yield from outline_problems(key, body, config.spacing)


def _walls(config: "Config") -> dict[str, Body]:
    """Return the walls around the fluid by name."""
    if config.walls.around is None:
        return walls_along(config)
    body = config.walls.around.body()
    return {"around": replace(body, shape=replace(body.shape, fluid_side="inside"))}
