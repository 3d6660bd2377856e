"""Walls, bodies and a drive put together at will: fluid inside a closed wall, or between two planes, around bodies.

With ``walls: {around: SHAPE}`` the fluid is inside a circle, an ellipse, a polygon or a closed curve, which may turn
about its centre. Otherwise it is in the cell 0 <= x <= length, 0 <= y <= height of the ``geometry``, which is periodic
along x between the walls ``bottom`` and ``top``. Bodies of any number and shape are in the fluid, which is at rest at
first. An acceleration along x drives it where it is periodic. No solution is known: ``tisph run --estimate-error``
tells the errors.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import model_validator

from tisph.config import resolution, schema
from tisph.config.base import Model, Positive, Problem, refusals
from tisph.config.fields import Bodies, Member
from tisph.scenes._cell.scene import Cell
from tisph.scenes._cell.sections import bodies_of, cell_problems, incommensurate_periods
from tisph.scenes._cell.walls import farthest, plane_walls, planes
from tisph.scenes._initial import Contact, Drive, RestInitial
from tisph.scenes.channel import Wall


class Geometry(Model):
    """Period along x and distance of the walls [length]."""

    length: Positive
    height: Positive


class Walls(Model):
    """One closed wall ``around`` the fluid, a shape as bodies have them; or those at y = 0 and y = height."""

    unset_keys = ("around", "bottom", "top")

    around: Annotated[Model, Member("bodies", usual="circle")] | None = None
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
            text = "is not allowed beside walls.around, which is all round the fluid"
            raise refusals([((name,), text, getattr(self, name)) for name in given])
        return self


class Config(schema.Config):
    """A whole run in the region."""

    geometry: Geometry | None = None
    walls: Walls = Walls.model_validate({})
    bodies: Bodies = ()
    drive: Drive = Drive()
    contact: Contact | None = None
    initial: RestInitial = RestInitial()

    unset_keys = ("geometry", "bodies", "contact")
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
            text = "is not allowed beside walls.around, whose size is that of the region"
            raise refusals([(("geometry",), text, data["geometry"])])
        return data

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the box is periodic in x and y."""
        return self.walls.around is None, False

    @property
    def box(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box."""
        if self.walls.around is None:
            return np.array([[0.0, 0.0], [self.geometry.length, self.geometry.height]])
        body = self.walls.around.body()
        if body.motion.rotation.largest_speed:
            return body.centre + farthest(body.shape) * np.array([[-1.0, -1.0], [1.0, 1.0]])
        points = body.boundary_points(body.shape.length / 1000).point if body.angle else body.shape.extent + body.centre
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def origin(self) -> tuple[float, float]:
        """Lowest corner of the box."""
        return tuple(self.box[0].tolist())

    @property
    def across(self) -> float:
        """The height of the box."""
        return self.extent[1]

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the box."""
        return tuple(np.ptp(self.box, axis=0).tolist())

    @property
    def aspect(self) -> float:
        """Length over height where the length is a period; else nothing has to be divided by the spacing."""
        return self.extent[0] / self.extent[1] if self.periodic[0] else 1.0

    def problems(self) -> Iterator[Problem]:
        """What the scene has against the config."""
        around = self.walls.around
        if around is not None and self.drive.acceleration:
            yield "drive.acceleration", "drives nothing inside a closed wall: the pressure takes it up"
        if around is not None and (around.body().motion.x.largest_speed or around.body().motion.y.largest_speed):
            yield "walls.around.motion", "may only turn: give fixed, angular_velocity or angular_amplitude"
        walls = {f"walls.{name}": wall for name, wall in _walls(self).items()}
        yield from cell_problems(self, bodies_of(self, walls, self.origin), walls)

    def incommensurate(self) -> Iterator[Problem]:
        """A length that the spacing does not divide, or that is too short."""
        if self.periodic[0]:
            yield from resolution.incommensurate_columns(self) or incommensurate_periods(self)


class Scene:
    """Makes the scene."""

    @staticmethod
    def from_config(config):
        """The scene that a validated config describes."""
        walls = _walls(config)
        own = {"origin": config.origin} if "around" in walls else {"planes": planes(walls)}
        return Cell.around(config, bodies_of(config, walls, config.origin), walls, **own)


def _walls(config):
    """Bodies around the fluid by name."""
    if config.walls.around is None:
        return plane_walls(config.geometry.length, config.geometry.height, config.walls)
    body = config.walls.around.body()
    return {"around": replace(body, shape=replace(body.shape, fluid_side="inside"))}
