"""A function of the user as an observer."""

from tisph.observers.protocol import StateObserver
from tisph.simulation.state import State


class Callback(StateObserver):
    """Calls ``function`` with each state that is due; ``call`` does it, once the step is done with all its files.

    So an interrupt, which may come while the function runs, finds the simulation between two steps.
    """

    def __init__(self, schedule, function, scene):
        self.schedule, self.function, self.scene = schedule, function, scene
        self.waiting = []

    def observe(self, snapshot):
        """Keep a state until ``call``."""
        self.waiting.append(State(snapshot, self.scene))

    def call(self):
        """Call the function; a state that it fails with does not come again."""
        while self.waiting:
            self.function(self.waiting.pop(0))
