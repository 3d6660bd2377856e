"""What the scheme has to know of a flow: its box, its liquid, its scales, and the walls in it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class _Flow:
    """Liquid in a box of ``columns`` x ``rows`` spacings, its lowest corner the ``origin``; in any consistent units.

    ``reference_velocity`` is the velocity that errors and steps refer to, as seen from the frame of the mean flow.
    ``acceleration`` is that of the body force; ``walls`` (``_walls.Walls``) are None where there are none, ``corners``
    those (``exact/sliding_corner.py``) where the velocities of two of them differ.
    """

    columns: int
    rows: int
    spacing: float
    density: float
    kinematic_viscosity: float
    reference_velocity: float
    start_time: float = 0.0
    walls: object = None
    origin: tuple[float, float] = (0.0, 0.0)
    acceleration: tuple[float, float] = (0.0, 0.0)
    corners: tuple = ()

    @property
    def length(self):
        """Period along x."""
        return self.columns * self.spacing

    @property
    def gap(self):
        """Period along y."""
        return self.rows * self.spacing


@dataclass(frozen=True, kw_only=True)
class PeriodicFlow(_Flow):
    """A particle in each cell of a box without walls."""

    @property
    def liquid(self):
        """Number of particles of liquid."""
        return self.columns * self.rows

    particles = liquid


@dataclass(frozen=True, kw_only=True)
class BoundedFlow(_Flow):
    """``liquid`` particles between ``walls``.

    Where these bound the liquid the box goes on beyond them by more than operators reach: what lies at one end of it
    has nothing to do with what lies at the other.
    """

    liquid: int

    @property
    def particles(self):
        """Number of points that have operators: particles of liquid, and points on walls."""
        return self.liquid + self.walls.count


def box_around(extent, spacing, periodic, margin):
    """Return the origin, columns and rows of the box of a region with this ``extent`` (2, 2), its corners."""
    low, high = np.asarray(extent, dtype=float)
    ahead = [0.0 if closed else margin for closed in periodic]
    counts = [
        round((top - bottom) / spacing) if closed else int(np.ceil((top - bottom + 2 * margin) / spacing))
        for bottom, top, closed in zip(low, high, periodic, strict=True)
    ]
    return tuple(low - ahead), *counts
