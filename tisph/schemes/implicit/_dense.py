"""The state within the last step: cubic in the velocities, so that output does not shorten the steps."""

from tisph.neighbours.points import used


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

    def at(self, time):
        """Return positions (fluid, 2) and velocities (2, fluid) at ``time``, and the ``others`` (fluid) as they are."""
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position, *others = self.state
        h = self.length
        part = (time - self.began) / h
        late = part * part * (3.0 - 2.0 * part)
        velocity = (1.0 - late) * start + late * end
        velocity += h * part * (1.0 - part) * ((1.0 - part) * start_rate - part * end_rate)
        gone = part * start + 0.5 * part**2 * (end - start)
        return position + h * gone.T, velocity, *others

    def _read(self):
        viscous, motion = self.viscous, self.motion
        fields = (motion.start_velocity, viscous.end, viscous.start_rate, viscous.end_rate)
        return [used(field).astype(float) for field in (*fields, motion.start_position, *self.others)]
