"""The state within the last step: cubic in the velocities, so that output does not shorten the steps."""

import numpy as np

from tisph.neighbours.point_cloud import active

TOGETHER = 2**20
"""Places of particles at various times that are looked at together."""


class DenseOutput:
    """Positions and velocities at any time of the step that was taken last (Hermite interpolation).

    What is read from the fields is kept until the next step: many outputs may fall into one.
    """

    def __init__(self, viscous, motion, others):
        self.viscous, self.motion, self.others = viscous, motion, others
        self.began = self.length = 0.0
        self.state = None

    def keep(self, time, length):
        """Take note of a step that has been taken, from ``time`` on."""
        self.began, self.length = time, length
        self.state = None

    def within(self, time):
        """Return the part of the last step up to ``time``, and its length."""
        return (time - self.began) / self.length, self.length

    def at(self, time):
        """Return positions (fluid, 2) and velocities (2, fluid) at ``time``, and the ``others`` (fluid) as they are."""
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position, *others = self.state
        part = self.within(time)[0]
        velocity = self._velocity(part, start, end, start_rate, end_rate)
        return position + self._gone(part, start, end).T, velocity, *others

    def around(self, times, x, half_width, length):
        """Return what is within ``half_width`` of ``x`` (times,), of period ``length``, at each of the ``times``.

        Flat arrays: which time (ascending), and place and velocity along the channel of a particle, x, y and u.
        """
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position = self.state[:5]
        parts = (np.asarray(times) - self.began)[:, None] / self.length
        found = []
        for some in np.split(np.arange(len(times)), range(0, len(times), max(1, TOGETHER // position.shape[0]))[1:]):
            apart = position[:, 0] + self._gone(parts[some], start[0], end[0]) - x[some, None]
            apart -= length * np.round(apart / length)
            when, particle = np.nonzero(np.abs(apart) < half_width)
            part, when = parts[some[when], 0], some[when]
            y = position[particle, 1] + self._gone(part, start[1, particle], end[1, particle])
            u = self._velocity(part, *(values[0, particle] for values in (start, end, start_rate, end_rate)))
            found.append((when, x[when] + apart[np.searchsorted(some, when), particle], y, u))
        return [np.concatenate(column) for column in zip(*found, strict=True)]

    def _velocity(self, part, *ends):
        return hermite(part, self.length, *ends)

    def _gone(self, part, start, end):
        return self.length * (part * start + 0.5 * part**2 * (end - start))

    def _read(self):
        viscous, motion = self.viscous, self.motion
        fields = (motion.start_velocity, viscous.end, viscous.start_rate, viscous.end_rate)
        return [active(field).astype(float) for field in (*fields, motion.start_position, *self.others)]


def hermite(part, length, start, end, start_rate, end_rate):
    """Return at a ``part`` of a step of ``length`` the cubic with these values and time derivatives at its ends."""
    late = part * part * (3.0 - 2.0 * part)
    change = length * part * (1.0 - part) * ((1.0 - part) * start_rate - part * end_rate)
    return (1.0 - late) * start + late * end + change
