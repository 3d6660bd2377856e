"""The channel as the kernels see it: sizes, wall velocities and drive, as numbers that are not compiled in."""

from tisph.periodic import nearest, wrapped
from tisph.runtime import scalar, ti, view


@ti.data_oriented
class Domain:
    """Plane channel 0 <= y <= gap, periodic in x over ``length``, with walls moving along x.

    ``driven`` and ``oscillates`` tell whether a body acceleration and wall accelerations exist; without them
    their fields do not. Wall velocities are those of the time last given to ``move_on``. ``columns`` is the number of
    spacings in the length, which no kernel may read: it would be compiled in.
    """

    open_across = False

    def __init__(self, channel):
        self.driven = channel.acceleration != 0.0
        self.oscillates = any(wall.oscillates and not wall.driven for wall in (channel.bottom, channel.top))
        self.motions = (channel.bottom, channel.top)
        self.columns = channel.columns
        self.gap = scalar(channel.gap)
        self.length = scalar(channel.length)
        self.bottom_velocity, self.top_velocity = (
            scalar(0.0 if wall.driven else wall.velocity(channel.start_time)) for wall in self.motions
        )
        if self.driven:
            self.acceleration = scalar(channel.acceleration)
        if self.oscillates:
            self.bottom_acceleration = scalar(channel.bottom.acceleration(channel.start_time))
            self.top_acceleration = scalar(channel.top.acceleration(channel.start_time))

    def move_on(self, time):
        """Take up the wall velocities at ``time``."""
        if self.oscillates:
            bottom, top = self.motions
            view(self.bottom_velocity)[()] = bottom.velocity(time)
            view(self.top_velocity)[()] = top.velocity(time)
            view(self.bottom_acceleration)[()] = bottom.acceleration(time)
            view(self.top_acceleration)[()] = top.acceleration(time)

    @ti.func
    def wall_velocity(self, top: ti.template()):
        """Return the velocity of the bottom (``top`` 0) or top wall (1)."""
        return self.top_velocity[None] if ti.static(top) else self.bottom_velocity[None]

    @ti.func
    def relative_acceleration(self, top: ti.template()):
        """Return the acceleration of a wall less that of the body force: what viscous forces have to give there."""
        relative = 0.0
        if ti.static(self.oscillates):
            relative += self.top_acceleration[None] if ti.static(top) else self.bottom_acceleration[None]
        if ti.static(self.driven):
            relative -= self.acceleration[None]
        return relative

    @ti.func
    def inside(self, top: ti.template(), y):
        """Return the distance of height ``y`` from a wall, positive inside the channel."""
        return self.gap[None] - y if ti.static(top) else y

    @ti.func
    def mirrored(self, top: ti.template(), position):
        """Return the mirror image of ``position`` in a wall."""
        place = position
        place.y = 2.0 * self.gap[None] - position.y if ti.static(top) else -position.y
        return place

    @ti.func
    def nearest(self, dx):
        """Return the difference ``dx`` of two x coordinates to the nearest periodic copy."""
        return nearest(dx, self.length[None])

    @ti.func
    def shortest(self, apart):
        """Return the vector ``apart`` between two places to the nearest periodic copy."""
        return ti.Vector([nearest(apart.x, self.length[None]), apart.y])

    @ti.func
    def wrapped(self, x):
        """Return ``x`` moved by whole lengths into [0, length)."""
        return wrapped(x, self.length[None])
