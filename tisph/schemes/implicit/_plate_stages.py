"""Stages of a step between walls of which a stress drives one that has no mass; see ``_plate.py``."""

from tisph.schemes.implicit._driven_stages import DrivenStages


class PlateStages(DrivenStages):
    """Advances a ``Flow`` between ``PlateWalls``."""

    def at_plate(self, velocity):
        """Return the velocity of the wall."""
        return self.plate.at_wall(self.fit, velocity, *self.plate.stages[-1][2:4])

    def turn(self, flow, time):
        """Let walls that change at once give their impulse, and the stress; see ``ElasticStages.turn``."""
        gains = super().turn(flow, time)
        return [gain + more for gain, more in zip(gains, self.let_go(flow, time), strict=True)]

    def let_go(self, flow, time):
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
