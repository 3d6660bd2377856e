"""Stages of a step between walls of which a stress drives one that has no mass; see ``_plate.py``."""

from tisph.schemes.implicit._elastic_stages import ElasticStages


class PlateStages(ElasticStages):
    """Advances a ``Flow`` between ``PlateWalls``."""

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
            self.plate.finish(self.plate.at_wall(self.fit, found[0], *self.plate.stages[-1][2:4]))
        return found, missed

    def kick(self, flow, velocity_jumps, acceleration_jumps):
        """Let walls that start at once give their impulse, and the stress; see ``ElasticStages.kick``."""
        gains = super().kick(flow, velocity_jumps, acceleration_jumps)
        return [gain + more for gain, more in zip(gains, self.turn(flow, 0.0), strict=True)]

    def turn(self, flow, time):
        """Let the stress jump at ``time``; return the velocities gained, summed over the particles, by wall.

        What the layer that the particles cannot resolve yet takes up is as in ``_kick.py``: a shear rate that jumps by
        J has e' = J delta(t) and e'' = J delta'(t), in the series -d^3/3 e'/nu - d^5/60 e''/nu^2.
        """
        plate, operators, gains = self.walls.plate, self.operators, [0.0, 0.0]
        jump = plate.towards * plate.jump(time, self.walls.first[plate.side])

        def spread(*series):
            both = [[0.0] * 3, [0.0] * 3]
            both[plate.side] = series
            return operators.given("laplacian", both)

        gained = spread(0.0, -jump / 3.0, 0.0) + operators.laplacian(spread(0.0, 0.0, -jump / 60.0))
        flow.velocity += gained
        gains[plate.side] = float(gained.sum(dtype=float))
        return gains
