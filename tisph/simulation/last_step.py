"""The last step of a simulation as observers see it: sound states, each computed once."""

from collections import Counter

import numpy as np

from tisph.simulation.start import seen_from_config


class LastStep:
    """What ``observers/protocol.py`` calls the last step; ``due`` has the times that each observer waits for.

    ``start`` is the state at the start of the run, where no step has been taken yet, else None.
    """

    def __init__(self, scheme, scene, guard, due=(), start=None):
        self.scheme, self.scene, self.guard = scheme, scene, guard
        self.time, self.steps = scheme.time, scheme.steps
        counts = Counter(time for times in due for time in set(times))
        self.latest = max(counts, default=self.time)
        self.kept_times = {time for time, count in counts.items() if count > 1} | {self.latest}
        self.kept = {} if start is None else {self.latest: start}
        self.sound = False

    def at(self, time):
        """Return the state at ``time``; DivergedError where the guard finds that the latest one is not sound.

        Those before it lie between that one and a state that was sound.
        """
        self.check()
        return self._state(time)

    def check(self):
        """Let the guard see the latest state that is asked for, once."""
        if not self.sound:
            self.guard.check(self._state(self.latest))
            self.sound = True

    def around(self, times, x, half_width):
        """Return the particles within ``half_width`` of the place ``x`` at ``times``: which time, x, y and u of each.

        The guard looks first where they are within a step, as such steps are long and few. Where they are the ends of
        short steps it looks at one in ``guard.INTERVAL``: whole states cost much more than what is asked for here.
        """
        if any(time != self.time for time in times):
            self.check()
        velocity = self.scene.frame_velocity
        travelled = velocity * (np.array(times) - self.scene.start_time)
        when, places, y, u = self.scheme.around(times, x - travelled, half_width)
        return when, places + travelled[when], y, u + velocity

    def _state(self, time):
        if time not in self.kept:
            state = seen_from_config(self.scheme.snapshot(time), self.scene)
            if time not in self.kept_times:
                return state
            self.kept[time] = state
        return self.kept[time]
