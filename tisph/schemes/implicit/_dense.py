"""The state within the last step: cubic in the velocities, so that output does not shorten the steps."""

import numpy as np

from tisph.neighbours.point_cloud import active

TOGETHER = 2**20
"""Positions of particles at various times that are looked at together."""


class DenseOutput:
    """Positions and velocities at any time of the step that was taken last (Hermite interpolation).

    What is read from the fields is kept until the next step: many outputs may fall into one.
    """

    def __init__(self, step, motion, others):
        self.step, self.motion, self.others = step, motion, others
        self.began = self.dt = 0.0
        self.state = None

    def keep(self, time, dt):
        """Take note of a step that has been taken, from ``time`` on."""
        self.began, self.dt = time, dt
        self.state = None

    def within(self, time):
        """Return the part theta of the last step up to ``time``, and its dt."""
        return (time - self.began) / self.dt, self.dt

    def at(self, time):
        """Return positions (fluid, 2) and velocities (2, fluid) at ``time``, and the ``others`` (fluid) as they are."""
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position, *others = self.state
        theta = self.within(time)[0]
        velocity = self._velocity(theta, start, end, start_rate, end_rate)
        return position + self._displacement(theta, start, end).T, velocity, *others

    def around(self, times, x, half_width, period):
        """Return what is within ``half_width`` of ``x`` (times,), of this ``period``, at each of the ``times``.

        Flat arrays: which time (ascending), and x, y and velocity along the channel of a particle.
        """
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position = self.state[:5]
        thetas = (np.asarray(times) - self.began)[:, None] / self.dt
        found = []
        for some in np.split(np.arange(len(times)), range(0, len(times), max(1, TOGETHER // position.shape[0]))[1:]):
            apart = position[:, 0] + self._displacement(thetas[some], start[0], end[0]) - x[some, None]
            apart -= period * np.round(apart / period)
            when, particle = np.nonzero(np.abs(apart) < half_width)
            theta, when = thetas[some[when], 0], some[when]
            y = position[particle, 1] + self._displacement(theta, start[1, particle], end[1, particle])
            u = self._velocity(theta, *(values[0, particle] for values in (start, end, start_rate, end_rate)))
            found.append((when, x[when] + apart[np.searchsorted(some, when), particle], y, u))
        return [np.concatenate(column) for column in zip(*found, strict=True)]

    def _velocity(self, theta, *ends):
        return hermite(theta, self.dt, *ends)

    def _displacement(self, theta, start, end):
        return self.dt * (theta * start + 0.5 * theta**2 * (end - start))

    def _read(self):
        step, motion = self.step, self.motion
        fields = (motion.start_velocity, step.end, step.start_rate, step.end_rate)
        return [active(field).astype(float) for field in (*fields, motion.start_position, *self.others)]


def hermite(theta, dt, start, end, start_rate, end_rate):
    """Return at the part ``theta`` of a step of ``dt`` the cubic with these values and time derivatives at its ends."""
    late = theta * theta * (3.0 - 2.0 * theta)
    change = dt * theta * (1.0 - theta) * ((1.0 - theta) * start_rate - theta * end_rate)
    return (1.0 - late) * start + late * end + change
