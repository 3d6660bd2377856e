"""Periodic axes as the kernels see them: nearest copies, and places brought back into the box."""

from tisph.runtime import scalar, ti


@ti.func
def nearest(difference, period):
    """Return the ``difference`` of two coordinates to the nearest periodic copy."""
    forth = ti.select(difference > 0.5 * period, difference - period, difference)
    return ti.select(forth < -0.5 * period, forth + period, forth)


@ti.func
def wrapped(coordinate, period):
    """Return a coordinate moved by whole periods into [0, period)."""
    inside = coordinate - ti.floor(coordinate / period) * period
    return ti.select(inside < period, inside, 0.0)


@ti.data_oriented
class PeriodicBox:
    """Box 0 <= x < length, 0 <= y < gap without walls, periodic in both directions; sizes are not compiled in."""

    open_across = True
    driven = False

    def __init__(self, length, gap):
        self.length, self.gap = scalar(length), scalar(gap)

    @ti.func
    def wrapped(self, x):
        """Return ``x`` moved by whole lengths into [0, length)."""
        return wrapped(x, self.length[None])

    @ti.func
    def inside(self, place):
        """Return a place moved by whole periods into the box."""
        return ti.Vector([wrapped(place.x, self.length[None]), wrapped(place.y, self.gap[None])])

    @ti.func
    def shortest(self, apart):
        """Return the vector ``apart`` between two places to the nearest periodic copy."""
        return ti.Vector([nearest(apart.x, self.length[None]), nearest(apart.y, self.gap[None])])

    @ti.func
    def row_inside(self, row, rows):
        """Return which of the rows 1 .. ``rows`` of cells stands for ``row``, which is less than that beyond them."""
        return ti.select(row < 1, row + rows, ti.select(row > rows, row - rows, row))
