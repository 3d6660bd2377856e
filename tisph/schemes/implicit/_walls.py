"""What the walls prescribe at a time, as series of the ghosts' values: see ``_ghosts.py``."""

OBEY_MOMENTUM = {"comoving_image": False, "consistent_image": True, "virtual_image": False}
"""Treatments that the implicit scheme serves, and whether their series follow from the momentum equation."""


class WallSeries:
    """Series c0 + c1 d^2 + c2 d^4 of both walls: 2 U, w_2 and w_4/12 by the momentum equation at the wall.

    Without ``obeys_momentum`` only 2 U. ``jumps``: at the start, those of the (bottom, top) wall's velocity, and of its
    acceleration relative to the drive; ``any_jump`` tells whether there is one.
    """

    def __init__(self, channel, treatment):
        self.channel = channel
        self.walls = (channel.bottom, channel.top)
        self.obeys_momentum = OBEY_MOMENTUM[treatment]
        self.steady = not any(wall.oscillates for wall in self.walls)
        self.jumps = self._jumps()
        self.any_jump = any(any(pair) for pair in self.jumps)

    def __call__(self, time):
        """Return the series of the (bottom, top) wall at ``time``."""
        return [self._series(wall, time) for wall in self.walls]

    def _series(self, wall, time):
        if not self.obeys_momentum:
            return [2.0 * wall.velocity(time), 0.0, 0.0]
        nu = self.channel.kinematic_viscosity
        second = (wall.acceleration(time) - self.channel.acceleration) / nu
        fourth = wall.jerk(time) / nu**2
        return [2.0 * wall.velocity(time), second, fourth / 12.0]

    def _jumps(self):
        channel = self.channel
        from_rest = channel.start_time == 0.0 and not channel.settled
        if channel.start_time > 0.0:
            return [0.0, 0.0], [0.0, 0.0]
        drive = channel.acceleration if from_rest else 0.0
        rates = [0.0 if wall.driven else self._rate_jump(wall, from_rest) - drive for wall in self.walls]
        return list(channel.wall_jumps), rates

    def _rate_jump(self, wall, from_rest):
        """Return by how much the acceleration of a wall jumps at the start."""
        before = 0.0 if from_rest or wall.before is not None else wall.acceleration(0.0)
        return wall.acceleration(0.0) - before
