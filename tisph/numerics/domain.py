"""The box as kernels see it: numbers in fields, which are not compiled in."""

from typing import TYPE_CHECKING, Any, Protocol

from tisph.runtime import scalar, ti, view

if TYPE_CHECKING:
    from tisph.scenes._channel import Channel


class Lattice(Protocol):
    """Size of a box in particle spacings: of a scene, or of a ``geometry.region.Box``."""

    @property
    def columns(self) -> int:
        """Number of spacings along x."""

    @property
    def rows(self) -> int:
        """Number of spacings along y."""

    @property
    def spacing(self) -> float:
        """Particle spacing [length]."""


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
    """Box 0 <= x < length, 0 <= y < height, periodic in both directions."""

    periodic_y = True
    has_body_force = False

    def __init__(self, length: float, height: float):
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
        """Return the row of cells, of the rows 1 .. ``rows``, that ``row`` is a periodic copy of."""
        return ti.select(row < 1, row + rows, ti.select(row > rows, row - rows, row))


@ti.data_oriented
class ChannelDomain:
    """Plane channel 0 <= y <= height, periodic in x over ``length``, with walls moving along x.

    ``has_body_force`` and ``oscillates``: whether there are a body acceleration and wall accelerations; without them
    there are no fields of them. ``move_on(time)`` sets velocities and accelerations. ``columns``: number of
    particle spacings in the length; no kernel may read it, since it would be compiled in.
    """

    periodic_y = False

    def __init__(self, channel: "Channel"):
        self.drive = channel.drive
        self.has_body_force = channel.acceleration != 0.0 or self.drive.varies
        bottom: Any = channel.bottom
        top: Any = channel.top
        self.motions = bottom, top
        self.oscillates = any(wall.oscillates and not wall.stress_controlled for wall in self.motions)
        self.columns = channel.columns
        self.height = scalar(channel.gap)
        self.length = scalar(channel.length)
        self.bottom_velocity, self.top_velocity = (
            scalar(0.0 if wall.stress_controlled else wall.velocity(channel.start_time)) for wall in self.motions
        )
        if self.has_body_force:
            self.acceleration = scalar(self.drive.value(channel.start_time))
        if self.oscillates:
            self.bottom_acceleration = scalar(bottom.acceleration(channel.start_time))
            self.top_acceleration = scalar(top.acceleration(channel.start_time))

    def move_on(self, time: float) -> None:
        """Set the wall velocities and accelerations, and the body acceleration, at ``time``."""
        if self.drive.varies:
            view(self.acceleration)[()] = self.drive.value(time)
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
        """Return dU_W/dt - g of a wall: the acceleration that viscous forces cause there."""
        relative = 0.0
        if ti.static(self.oscillates):
            relative += self.top_acceleration[None] if ti.static(top) else self.bottom_acceleration[None]
        if ti.static(self.has_body_force):
            relative -= self.acceleration[None]
        return relative

    @ti.func
    def wall_distance(self, top: ti.template(), y):
        """Return the distance of height ``y`` from a wall, positive inside the channel."""
        return self.height[None] - y if ti.static(top) else y

    @ti.func
    def mirrored(self, top: ti.template(), position):
        """Return the mirror image of ``position`` in a wall."""
        image = position
        image.y = 2.0 * self.height[None] - position.y if ti.static(top) else -position.y
        return image

    @ti.func
    def minimum_image_x(self, dx):
        """Return the difference ``dx`` of two x coordinates to the nearest periodic copy."""
        return minimum_image(dx, self.length[None])

    @ti.func
    def minimum_image(self, apart):
        """Return the vector ``apart`` between two positions to the nearest periodic copy."""
        return ti.Vector([minimum_image(apart.x, self.length[None]), apart.y])

    @ti.func
    def wrap_x(self, x):
        """Return ``x`` moved by whole lengths into [0, length)."""
        return wrapped(x, self.length[None])
