"""What the walls prescribe at a time, as series of the ghosts' values: see ``_ghosts.py``."""

OBEY_MOMENTUM = {"comoving_image": False, "consistent_image": True, "virtual_image": False}
"""Treatments that the implicit scheme serves, and whether their series follow from the momentum equation."""


class WallSeries:
    """Series c0 + c1 d^2 + c2 d^4 of both walls: 2 U, w_2 and w_4/12 by the momentum equation at the wall.

    Without ``obeys_momentum`` only 2 U. ``jumps``: at the start, those of the (bottom, top) wall's velocity, and of its
    acceleration relative to the drive; ``any_jump`` tells whether there is one, then or later. ``walls`` are their
    motions from the last change on.
    """

    def __init__(self, channel, treatment):
        self.channel = channel
        self.motions = (channel.bottom, channel.top)
        self.obeys_momentum = OBEY_MOMENTUM[treatment]
        self.steady = not any(wall.oscillates for wall in self.motions)
        self.jumps = self._jumps()
        self.any_jump = any(any(pair) for pair in self.jumps) or any(wall.changes for wall in self.motions)
        self.enter(channel.start_time)

    def enter(self, time):
        """Go by the motions that the walls have from ``time`` on, to the next change."""
        self.walls = tuple(wall.during(time) for wall in self.motions)

    def jumps_at(self, time):
        """Return ``jumps``, or the like of a later ``time`` at which something changes."""
        return self.jumps if time == self.channel.start_time else self._later_jumps(time)

    def _later_jumps(self, time):
        kinks = [() if wall.driven else wall.kinks for wall in self.motions]
        found = [next((both for when, *both in each if when == time), (0.0, 0.0)) for each in kinks]
        return [list(each) for each in zip(*found, strict=True)]

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
        rates = [0.0 if wall.driven else self._rate_jump(wall, from_rest) - drive for wall in self.motions]
        return list(channel.wall_jumps), rates

    def _rate_jump(self, wall, from_rest):
        """Return by how much the acceleration of a wall jumps at the start."""
        before = 0.0 if from_rest or wall.before is not None else wall.acceleration(0.0)
        return wall.acceleration(0.0) - before
