"""Periodic axes as the kernels see them: minimum images, and positions wrapped back into the box."""

from tisph.runtime import scalar, ti


@ti.func
def minimum_image(difference, period):
    """Return the ``difference`` of two coordinates to the nearest periodic copy."""
    forth = ti.select(difference > 0.5 * period, difference - period, difference)
    return ti.select(forth < -0.5 * period, forth + period, forth)


@ti.func
def wrapped(coordinate, period):
    """Return a coordinate moved by whole periods into [0, period)."""
    inside = coordinate - ti.floor(coordinate / period) * period
    return ti.select(inside < period, inside, 0.0)


@ti.data_oriented
class PeriodicDomain:
    """Box 0 <= x < length, 0 <= y < height, periodic in both directions; sizes are not compiled in."""

    periodic_y = True
    has_body_force = False

    def __init__(self, length, height):
        self.length, self.height = scalar(length), scalar(height)

    @ti.func
    def wrap_x(self, x):
        """Return ``x`` moved by whole lengths into [0, length)."""
        return wrapped(x, self.length[None])

    @ti.func
    def wrap(self, position):
        """Return a position moved by whole periods into the box."""
        return ti.Vector([wrapped(position.x, self.length[None]), wrapped(position.y, self.height[None])])

    @ti.func
    def minimum_image(self, apart):
        """Return the vector ``apart`` between two positions to the nearest periodic copy."""
        return ti.Vector([minimum_image(apart.x, self.length[None]), minimum_image(apart.y, self.height[None])])

    @ti.func
    def wrap_row(self, row, rows):
        """Return which of the rows 1 .. ``rows`` of cells stands for ``row``, which is less than that beyond them."""
        return ti.select(row < 1, row + rows, ti.select(row > rows, row - rows, row))
