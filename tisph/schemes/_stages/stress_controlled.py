"""What stress-controlled walls with and without a mass share; all is per unit density."""

from tisph.schemes._stages.esdirk import GAMMA, B, weighted
from tisph.schemes._stages.walls import CoupledWall


class StressControlledWall(CoupledWall):
    """What both kinds share.

    ``velocity`` and ``displacement`` at the start of the step; ``velocities`` of the wall, and ``stresses`` of the
    fluid there, at the stages that are done.
    """

    def __init__(self, channel, side, obeys_momentum, model):
        super().__init__(channel, side, obeys_momentum, model)
        self.control = self.schedule.over(channel.density)

    def forget(self):
        """Go back to before the first step."""
        super().forget()
        self.velocity = self.displacement = 0.0

    def begin(self, time, dt, fluid, operators):
        """Begin a step of ``dt`` at ``time``."""
        self.dt, self.gamma_dt = dt, GAMMA * dt
        self.stress_of = self.control.after(time).stress
        self.near, self.distance, self.weights = operators.even_fit(self.side)
        self.velocities, self.stresses, self.rates = [self.velocity], [], []
        self.series, self.stress_series = [], []

    def acceleration(self, time):
        """Return 0: what the fluid takes of the stress is known."""
        return 0.0

    @property
    def mean_stress(self):
        """Shear stress of the fluid at the wall, the mean over the last step."""
        return weighted(B, self.stresses)

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        self.displacement += self.dt * weighted(B, self.velocities)
        self.velocity = self.velocities[-1]


def one_sided(side, series):
    """Return the series of both walls, of which the other's are 0."""
    both = [[0.0] * 3, [0.0] * 3]
    both[side] = series
    return both
