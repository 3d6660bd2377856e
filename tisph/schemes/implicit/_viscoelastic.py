"""The viscous step of a liquid with memory: the particles' velocities and states in Taichi fields.

The step itself is ``_elastic_stages.py``; what it starts from and leads to is kept here, for motion, output between
steps, shifting and checkpoints.
"""

import numpy as np

from tisph.neighbours.points import used
from tisph.runtime import real, view
from tisph.schemes.implicit._dense import hermite
from tisph.schemes.implicit._elastic_kick import kick
from tisph.schemes.implicit._elastic_solver import ElasticSolver
from tisph.schemes.implicit._elastic_stages import ElasticStages, Flow
from tisph.schemes.implicit._elastic_wall_force import ElasticWallForce
from tisph.schemes.implicit._elastic_walls import ElasticWalls
from tisph.schemes.implicit._memory import Memory
from tisph.schemes.implicit._viscous import ViscousStep


class ViscoelasticStep(ViscousStep):
    """``ViscousStep`` with the ``state`` C of the ``memory`` (components, fluid), and its rates at both ends of a step.

    ``shear_rate`` (fluid): du/dy at the start; ``state_slope``: dC/dy there.
    """

    def __init__(self, solver, channel, walls, memory):
        super().__init__(solver, channel, walls)
        self.channel, self.walls, self.memory = channel, walls, memory
        self.stages = ElasticStages(solver, channel, walls, memory)
        self.state, self.state_start, self.state_end, self.state_rate, self.state_end_rate, self.state_slope = (
            self.points.field(real(), memory.components) for _ in range(6)
        )
        self.shear_rate = self.points.field(real())

    def begin_with(self, stress):
        """Take up the stress (3, fluid) at the start, and the slopes at the walls."""
        used(self.state)[...] = self.memory.state_of(stress)
        used(self.shear_rate)[...] = 0.0
        self.walls.forget()
        self.stages.settle(self.channel)

    def kick(self, velocity_jumps, acceleration_jumps):
        """Let walls that start at once give their impulse to velocities and states; see ``ViscousStep``."""
        flow = self.flow()
        gains = kick(self.stages, flow, velocity_jumps, acceleration_jumps)
        used(self.velocity)[0], used(self.state)[...] = flow.velocity, flow.state
        return gains

    def flow(self):
        """Return copies of the velocities along the channel, states and shear rates, in double precision."""
        fields = used(self.velocity)[0], used(self.state), used(self.shear_rate)
        return Flow(*(np.array(values, dtype=float) for values in fields))

    def advance(self, component, time, length, tolerance):
        """Compute the ends of one component, and with the first those of C; return the estimated error."""
        if component == 1:
            return super().advance(component, time, length, tolerance)
        start = self.flow()
        end, error = self.stages.advance(start, time, length, tolerance)
        if end is not None:
            used(self.end)[0], used(self.end_rate)[0] = end.velocity, end.velocity_rate
            used(self.state_end)[...], used(self.state_end_rate)[...] = end.state, end.state_rate
            used(self.start_rate)[0], used(self.state_rate)[...] = start.velocity_rate, start.state_rate
            self.end_shear_rate = end.shear_rate
            view(self.mean)[: self.points.fluid] = self.stages.mean_velocity
        return error

    def accept(self):
        """Take up the end of the step as the start of the next, on the particles and at the walls."""
        super().accept()
        used(self.state_start)[...] = used(self.state)
        used(self.state)[...], used(self.shear_rate)[...] = used(self.state_end), self.end_shear_rate
        self.walls.conclude()
        for component, (slope, state) in enumerate(zip(used(self.state_slope), used(self.state), strict=True)):
            walls = [self.solver.images(side, self.walls.first[side, component], 0.0) for side in range(2)]
            slope[...] = self.solver.slopes(state, 1.0) + sum(walls)

    def lost(self):
        """Return the particles whose conformation is not positive definite at the end of the step."""
        return self.memory.lost(used(self.state_end))

    def follow(self, moved, across):
        """Let the states follow, by their slopes across the channel."""
        used(self.state)[:, moved] += used(self.state_slope)[:, moved] * across

    def stress(self):
        """Return S_xx, S_xy, S_yy over the density, (3, fluid)."""
        return self.memory.stress(used(self.state).astype(float))

    def stress_at(self, part, length):
        """Return ``stress`` at a ``part`` of the last step, of ``length``: cubic in the states."""
        fields = self.state_start, self.state, self.state_rate, self.state_end_rate
        return self.memory.stress(hermite(part, length, *(used(field).astype(float) for field in fields)))

    def wall_force(self):
        """Return what measures the impulses of the walls."""
        return ElasticWallForce(self, self.channel)

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return self.walls.host_state()

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.walls.restore_host_state(state)


def step(config, channel, rows, ghosts):
    """Return the step of a liquid whose rheology carries a stress."""
    memory = Memory(config.fluid.rheology, channel.kinematic_viscosity)
    walls = ElasticWalls(channel, config.walls.treatment.type, memory)
    return ViscoelasticStep(ElasticSolver(rows, ghosts), channel, walls, memory)
