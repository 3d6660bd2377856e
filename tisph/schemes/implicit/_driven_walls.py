"""Walls one of which a stress drives: what there is of them whether that one has a mass or not."""

from tisph.schemes.implicit._elastic_stages import weighted
from tisph.schemes.implicit._elastic_walls import ElasticWalls
from tisph.schemes.implicit._esdirk import WEIGHTS


class DrivenWalls(ElasticWalls):
    """``ElasticWalls`` one of which is the ``plate``, a ``DrivenWall``."""

    def __init__(self, channel, treatment, memory, plate):
        self.plate = plate
        super().__init__(channel, treatment, memory)

    def conclude(self):
        """Take up the state at the end of the step."""
        super().conclude()
        self.plate.conclude()

    def host_state(self):
        """Return the numbers that a resumed run needs."""
        return {**super().host_state(), "plate": self.plate.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        super().restore_host_state(state)
        self.plate.restore_host_state(state["plate"])


class DrivenWall:
    """The driven wall over a step; everything over the density.

    ``velocity`` and ``displacement`` at the start of the step; ``velocities`` of the wall, and ``stresses`` of the
    liquid there, at the stages that are done. ``kept`` are the names of the numbers that a resumed run needs.
    """

    kept = "velocity", "displacement"

    def __init__(self, channel, memory):
        self.side, self.memory = channel.driven_side, memory
        self.towards = 1.0 if self.side == 0 else -1.0
        self.wall = (channel.bottom, channel.top)[self.side].over(channel.density)
        self.viscosity = channel.solvent_viscosity
        self.forget()

    def forget(self):
        """Go back to before the first step."""
        self.velocity = self.displacement = 0.0
        self.stages = []

    @property
    def mean_stress(self):
        """Integral of the shear stress of the liquid at the wall over the last step, over its length."""
        return weighted(WEIGHTS, self.stresses)

    def conclude(self):
        """Take up the state at the end of the step."""
        self.displacement += self.length * weighted(WEIGHTS, self.velocities)
        self.velocity = self.velocities[-1]

    def host_state(self):
        """Return the numbers that a resumed run needs."""
        return {name: float(getattr(self, name)) for name in self.kept}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in self.kept:
            setattr(self, name, state[name])
