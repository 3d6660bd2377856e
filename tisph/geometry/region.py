"""The fluid's region, what bodies and walls leave of a cell, and the box in which particles are searched.

The cell may be periodic in either direction; the box is whole spacings wide and high, and periodic whatever is in it.
"""

import math
from dataclasses import dataclass

import numpy as np

from tisph.geometry.body import Body


@dataclass(frozen=True, kw_only=True)
class Box:
    """``columns`` x ``rows`` spacings from the lowest corner, the ``origin``."""

    columns: int
    rows: int
    spacing: float
    origin: tuple[float, float] = (0.0, 0.0)

    @property
    def length(self):
        """Period along x."""
        return self.columns * self.spacing

    @property
    def height(self):
        """Period along y."""
        return self.rows * self.spacing

    def places(self, position):
        """Places x and y (n,) in the box of ``position`` (n, 2), from its lowest corner on."""
        return position[:, 0] % self.length + self.origin[0], position[:, 1] % self.height + self.origin[1]


def box_around(corners, spacing, periodic, margin, axisymmetric=False):
    """Box of a region from the lowest to the highest of its ``corners`` (2, 2), which is ``periodic`` (2,) or not.

    Where it is not, the box goes on beyond it by the ``margin`` or a little more: what lies at one end has then nothing
    to do with what lies at the other. ``axisymmetric``: y is the distance from an axis, and nothing is beyond that; by
    what the box does not go on there, it goes on above.
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


def nearest_image(difference, period):
    """``difference`` of places to the nearest periodic copy; the ``period`` [length] is 0 along axes without one."""
    period = np.asarray(period)
    return difference - period * np.round(difference / np.where(period > 0, period, math.inf))


PUSHES = 4
"""Rounds at most in which places are moved off walls: in a corner one wall may push towards the other."""


@dataclass(frozen=True)
class Region:
    """What ``bodies`` leave of the cell from ``low`` to ``high`` (2,), which goes on where it is ``periodic`` (2,).

    Where it is not periodic walls must bound it: lines, each one period long, or a closed curve with the fluid inside.
    Everything is taken at t = 0. In ``axisymmetric`` flow it is in the half-plane above the axis y = 0, which is among
    the ``bodies`` where the fluid reaches it: of a closed curve on both sides of the axis half is in it. ValueError
    where a body in the fluid has not the periods of the cell.
    """

    bodies: tuple[Body, ...]
    low: tuple[float, float]
    high: tuple[float, float]
    periodic: tuple[bool, bool] = (False, False)
    axisymmetric: bool = False

    def __post_init__(self):
        periods = tuple(np.where(self.periodic, self.size, math.inf).tolist())
        for body in self.bodies:
            if body.shape.area and body.shape.fluid_side == "outside" and tuple(body.periods) != periods:
                raise ValueError(f"a body in a cell of periods {periods} needs the same ones, not {body.periods}")

    @property
    def size(self):
        """Width and height (2,) of the cell."""
        return np.subtract(self.high, self.low)

    @property
    def periods(self):
        """Periods (2,) of the cell, 0 along axes that are not periodic."""
        return np.where(self.periodic, self.size, 0.0)

    @property
    def area(self):
        """Area of the fluid."""
        if all(self.periodic):
            area = float(np.prod(self.size))
        else:
            # by Gauss the sum of length times distance, from any one point, of lines is the area of a strip between
            # two, and twice that of a box between four
            lines = [body for body in self.bodies if not body.shape.area]
            area = sum(body.shape.length * float(body.nearest(np.zeros((1, 2))).distance[0]) for body in lines)
            area /= 2 - sum(self.periodic)
        return area + sum(self._signed_area(body) for body in self.bodies)

    def _signed_area(self, body):
        """Area that a closed wall adds to the fluid's, negative where it takes it away."""
        share = 0.5 if self.axisymmetric and body.crosses_axis else 1.0
        return share * body.shape.area * (1 if body.shape.fluid_side == "inside" else -1)

    def distance(self, points):
        """Distances (n,) of ``points`` (n, 2) from the nearest wall, negative outside the fluid."""
        none = np.full(len(points), math.inf)
        return np.min([none, *(body.nearest(points).distance for body in self.bodies)], axis=0)

    def images(self, points, cutoff):
        """Mirror images (k, 2), behind the walls, of those of ``points`` (n, 2) that are within ``cutoff`` of one."""
        return np.concatenate([np.empty((0, 2)), *(body.images(points, cutoff)[0] for body in self.bodies)])

    def wrapped(self, points):
        """``points`` (n, 2) moved by whole periods into the cell."""
        cells = np.floor((points - self.low) / self.size)
        return points - np.where(self.periodic, cells * self.size, 0.0)

    def off_walls(self, points, least):
        """``points`` (n, 2), those nearer to a wall than ``least`` (n,) or one, moved along its normal that far off."""
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
