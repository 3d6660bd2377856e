"""The region of the fluid between bodies and walls of a cell, and the box in which neighbours are searched.

The cell may be periodic in either direction; the box is whole spacings wide and high, and always periodic.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line


@dataclass(frozen=True, kw_only=True)
class Box:
    """``columns`` x ``rows`` spacings from the lowest corner, the ``origin``."""

    columns: int
    rows: int
    spacing: float
    origin: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def length(self) -> float:
        """Period along x."""
        return self.columns * self.spacing

    @cached_property
    def height(self) -> float:
        """Period along y."""
        return self.rows * self.spacing

    def places(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and y (n,) of ``position`` (n, 2), measured from the lowest corner and wrapped, in the box."""
        x, y = wrapped(position[:, 0], self.length), wrapped(position[:, 1], self.height)
        return x + self.origin[0], y + self.origin[1]


def box_around(
    corners: Sequence[Sequence[float] | np.ndarray] | np.ndarray,
    spacing: float,
    periodic: Sequence[bool],
    margin: float,
    axisymmetric: bool = False,
) -> Box:
    """Return the box of a region from the lowest to the highest of its ``corners`` (2, 2), ``periodic`` (2,) or not.

    Along an axis without a period the box extends beyond the region by the ``margin`` or a little more, so that its
    two ends do not interact. In ``axisymmetric`` flow y is the distance from an axis, and the box does not extend below
    the axis; it extends by as much more above.
    """
    low, high = np.asarray(corners, dtype=float)
    ahead = [0.0 if closed else margin for closed in periodic]
    origin = low - ahead
    if axisymmetric:
        origin[1] = max(origin[1], 0.0)
    columns, rows = (
        round((top - bottom) / spacing) if closed else int(np.ceil((top - bottom + 2 * margin) / spacing))
        for bottom, top, closed in zip(low, high, periodic, strict=True)
    )
    return Box(columns=columns, rows=rows, spacing=spacing, origin=tuple(origin.tolist()))


def nearest_image(difference: np.ndarray, period: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the ``difference`` to the nearest periodic copy; ``period`` [length] is 0 along axes without one."""
    period = np.asarray(period)
    return difference - period * np.round(difference / np.where(period > 0, period, math.inf))


def wrapped(values: np.ndarray, period: float) -> np.ndarray:
    """Return ``values`` (n,) modulo ``period``; few are outside of it, and the others cost next to nothing."""
    outside = ~((values >= 0.0) & (values < period))
    if outside.any():
        values = values.copy()
        values[outside] %= period
        values[values >= period] = 0.0  # -1e-20 modulo the period is the period after rounding
    return values


PIECES = 10_000
"""Pieces of a wall with corners over which integrals along it are sums; arcs then have errors below 1e-6."""

PUSHES = 4
"""Most rounds in which places are moved off walls: in a corner one wall may push towards the other."""


@dataclass(frozen=True)
class Region:
    """The fluid between ``bodies`` in the cell from ``low`` to ``high`` (2,), ``periodic`` (2,) along x and y or not.

    Where it is not periodic walls must bound it: lines, each one period long, and outlines, or a closed curve with the
    fluid inside.
    All bodies are at their places at t = 0. In ``axisymmetric`` flow the region is in the half-plane above y = 0. The
    axis is among the ``bodies`` where the fluid reaches it; half of a closed curve on both sides of it counts.
    ValueError where a body in the fluid does not have the periods of the cell.
    """

    bodies: tuple[Body, ...]
    low: tuple[float, float]
    high: tuple[float, float]
    periodic: tuple[bool, bool] = (False, False)
    axisymmetric: bool = False

    def __post_init__(self) -> None:
        periods = tuple(np.where(self.periodic, self.size, math.inf).tolist())
        for body in self.bodies:
            if body.in_fluid and tuple(body.periods) != periods:
                raise ValueError(f"a body in a cell of periods {periods} needs the same ones, not {body.periods}")

    @property
    def size(self) -> np.ndarray:
        """Width and height (2,) of the cell."""
        return np.subtract(self.high, self.low)

    @property
    def periods(self) -> np.ndarray:
        """Periods (2,) of the cell, 0 along axes that are not periodic."""
        return np.where(self.periodic, self.size, 0.0)

    @property
    def area(self) -> float:
        """Area of the fluid."""
        if all(self.periodic):
            area = float(np.prod(self.size))
        else:
            # by Gauss: the integral over walls with ends is the area for each coordinate without a period
            area = sum(_enclosed(body, self.periodic) for body in self.bodies if not body.shape.area)
            area /= 2 - sum(self.periodic)
        closed = [0.5 if self.axisymmetric and body.crosses_axis else 1.0 for body in self.bodies]
        signs = [1 if body.shape.fluid_side == "inside" else -1 for body in self.bodies]
        return area + sum(c * body.shape.area * s for c, body, s in zip(closed, self.bodies, signs, strict=True))

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Return distances (n,) of ``points`` (n, 2) from the nearest wall, negative outside the fluid."""
        none = np.full(len(points), math.inf)
        return np.min([none, *(body.nearest(points).distance for body in self.bodies)], axis=0)

    def images(self, points: np.ndarray, cutoff: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mirror images (k, 2) behind the walls of ``points`` (n, 2) near them, and indices (k,) of the points.

        Points within ``cutoff`` of a wall have images.
        """
        found = [(np.empty((0, 2)), np.empty(0, dtype=int)), *(body.images(points, cutoff) for body in self.bodies)]
        images, source = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return images, source

    def wrapped(self, points: np.ndarray) -> np.ndarray:
        """Return ``points`` (n, 2) moved by whole periods into the cell."""
        cells = np.floor((points - self.low) / self.size)
        return points - np.where(self.periodic, cells * self.size, 0.0)

    def off_walls(self, points: np.ndarray, least: float | np.ndarray) -> np.ndarray:
        """Return ``points`` (n, 2), moved along normals of walls to distances of at least ``least``, one or (n,)."""
        points, which = points.copy(), np.arange(len(points))
        least = np.broadcast_to(least, len(points))
        for _ in range(PUSHES):
            moved = []
            for body in self.bodies:
                foot = body.nearest(points[which])
                near = foot.distance < least[which]
                points[which[near]] = foot.point[near] + least[which[near], None] * foot.normal[near]
                moved.append(which[near])
            which = np.unique(np.concatenate(moved)) if moved else which[:0]
        return points


def _enclosed(wall: Body, periodic: tuple[bool, bool]) -> float:
    """Return the integral along a ``wall`` with ends of -x n_x - y n_y, without coordinates that are ``periodic``."""
    if isinstance(wall.shape, Line):
        return wall.shape.length * float(wall.nearest(np.zeros((1, 2))).distance[0])
    points = wall.boundary_points(wall.shape.length / PIECES)
    return -float(points.length @ (points.point * points.normal)[:, ~np.array(periodic)].sum(axis=1))
