"""The box in which particles are looked for: whole spacings wide and high, and periodic whatever is in it."""

from dataclasses import dataclass

import numpy as np


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
