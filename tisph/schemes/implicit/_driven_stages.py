"""Stages of a step between walls one of which a stress drives, with a mass or without one."""

from abc import abstractmethod

from tisph.schemes.implicit._elastic_stages import ElasticStages


class DrivenStages(ElasticStages):
    """Advances a ``Flow`` between ``DrivenWalls``."""

    def advance(self, start, time, length, tolerance):
        """Advance by a step; see ``ElasticStages.advance``."""
        self.plate, self.number = self.walls.plate, 0
        self.fit = self.operators.even_fit(self.plate.side)
        return super().advance(start, time, length, tolerance)

    def solved(self, known, known_state, guess, state, moment, implicit, tolerance):
        """Solve a stage; see ``ElasticStages.solved``."""
        self.number += 1
        self.plate.open(self.number, self.walls.moments[self.number])
        found, missed = super().solved(known, known_state, guess, state, moment, implicit, tolerance)
        if found is not None:
            self.plate.finish(self.at_plate(found[0]))
        return found, missed

    @abstractmethod
    def at_plate(self, velocity):
        """Return what a stage that ends with the liquid's ``velocity`` has found at the driven wall."""
