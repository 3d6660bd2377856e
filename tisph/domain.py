"""The channel as the kernels see it: sizes and wall velocities, as numbers that are not compiled in."""

from tisph.runtime import scalar, ti


@ti.data_oriented
class Domain:
    """Plane channel 0 <= y <= gap, periodic in x over ``length``, with walls moving along x."""

    def __init__(self, channel):
        self.gap = scalar(channel.gap)
        self.length = scalar(channel.length)
        self.bottom_velocity = scalar(channel.bottom_velocity)
        self.top_velocity = scalar(channel.top_velocity)

    @ti.func
    def nearest(self, dx):
        """Return the difference ``dx`` of two x coordinates to the nearest periodic copy."""
        length = self.length[None]
        forth = ti.select(dx > 0.5 * length, dx - length, dx)
        return ti.select(forth < -0.5 * length, forth + length, forth)

    @ti.func
    def wrapped(self, x):
        """Return ``x`` moved by whole lengths into [0, length)."""
        length = self.length[None]
        inside = x - ti.floor(x / length) * length
        return ti.select(inside < length, inside, 0.0)
