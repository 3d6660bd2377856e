"""The viscous step of a liquid that is not Newtonian, on particles.

The step itself is ``_elastic_stages.py``; what it starts from and leads to is kept here, for motion, output between
steps, shifting and checkpoints.
"""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import view
from tisph.schemes.implicit._dense import hermite
from tisph.schemes.implicit._driven import slides_freely, stages
from tisph.schemes.implicit._elastic_solver import ElasticSolver
from tisph.schemes.implicit._elastic_stages import Flow
from tisph.schemes.implicit._elastic_wall_force import ElasticWallForce
from tisph.schemes.implicit._instant import material
from tisph.schemes.implicit._viscous import ViscousStep


class Carried:
    """What particles carry beside velocities, arrays of the states C (components, fluid); a checkpoint keeps them.

    ``state`` at the start of a step, ``end`` after it, and before an earlier one: ``start``; ``start_rate``,
    ``end_rate``: their time derivatives; ``slope``: dC/dy; ``shear_rate`` (fluid): du/dy at the start.
    """

    def __init__(self, components, fluid):
        self.state, self.end, self.start, self.start_rate, self.end_rate, self.slope = np.zeros((6, components, fluid))
        self.shear_rate, self.end_shear_rate = np.zeros((2, fluid))


class ViscoelasticStep(ViscousStep):
    """``ViscousStep`` with what is ``carried``, advanced by ``stages`` (``ElasticStages``)."""

    def __init__(self, stages, channel):
        super().__init__(stages.operators, channel, stages.walls)
        self.stages, self.walls, self.memory = stages, stages.walls, stages.memory
        self.carried = Carried(self.memory.components, self.points.fluid)

    def begin_with(self, heights):
        """Take up the states of particles at ``heights`` (fluid,) at the start, and the slopes at the walls."""
        self.carried.state[...] = self.memory.start(self.channel, heights)
        self.carried.shear_rate[...] = 0.0
        self.walls.forget()
        self.stages.settle(self.channel)

    def turn(self, time):
        """Let walls that change at once give their impulse to velocities and states; see ``ViscousStep``."""
        flow = self.flow()
        gains = self.stages.turn(flow, time)
        active(self.velocity)[0], self.carried.state[...] = flow.velocity, flow.state
        return gains

    def flow(self):
        """Return copies of the velocities along the channel, states and shear rates, in double precision."""
        return Flow(active(self.velocity)[0].astype(float), self.carried.state.copy(), self.carried.shear_rate.copy())

    def advance(self, component, time, length, tolerance):
        """Compute the ends of one component, and with the first those of C; return the estimated error."""
        if component == 1:
            return super().advance(component, time, length, tolerance)
        start, carried = self.flow(), self.carried
        self.solver.assemble()
        end, error = self.stages.advance(start, time, length, tolerance)
        if end is not None:
            active(self.end)[0], active(self.end_rate)[0] = end.velocity, end.velocity_rate
            active(self.start_rate)[0] = start.velocity_rate
            carried.end[...], carried.end_rate[...], carried.end_shear_rate[...] = (
                end.state,
                end.state_rate,
                end.shear_rate,
            )
            carried.start_rate[...] = start.state_rate
            view(self.mean)[: self.points.fluid] = self.stages.mean_velocity
        return error

    def accept(self):
        """Take up the end of the step as the start of the next, on the particles and at the walls."""
        super().accept()
        carried = self.carried
        carried.start[...] = carried.state
        carried.state[...], carried.shear_rate[...] = carried.end, carried.end_shear_rate
        self.walls.conclude()
        for component, (slope, state) in enumerate(zip(carried.slope, carried.state, strict=True)):
            walls = [self.solver.images(side, *self.walls.of_states(side, component)) for side in range(2)]
            slope[...] = self.solver.slopes(state, 1.0) + sum(walls)

    def lost(self):
        """Return the particles whose conformation is not positive definite at the end of the step."""
        return self.memory.lost(self.carried.end)

    def follow(self, moved, across):
        """Let the states follow, by their slopes across the channel."""
        self.carried.state[:, moved] += self.carried.slope[:, moved] * across

    def stress(self):
        """Return S_xx, S_xy, S_yy over the density, (3, fluid)."""
        return self.memory.stress(self.carried.state)

    def stress_at(self, part, length):
        """Return ``stress`` at a ``part`` of the last step, of ``length``: cubic in the states."""
        carried = self.carried
        ends = carried.start, carried.state, carried.start_rate, carried.end_rate
        return self.memory.stress(hermite(part, length, *ends))

    def wall_force(self):
        """Return what measures the impulses of the walls."""
        return ElasticWallForce(self, self.channel)

    def parts(self):
        """Return by name what a checkpoint keeps beside the fields here."""
        return {"carried": self.carried}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {"walls": self.walls.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.walls.restore_host_state(state["walls"])


def step(config, channel, rows, ghosts):
    """Return the step of a liquid that is not Newtonian, or that a stress drives."""
    memory = material(config.fluid.rheology, channel)
    solver, kind = ElasticSolver, ViscoelasticStep
    if channel.driven_side is not None:
        from tisph.schemes.implicit._plate_step import DrivenStep, PlateSolver  # of no use to most runs

        kind = DrivenStep
        if slides_freely(channel, channel.driven_side):
            solver = PlateSolver
    return kind(stages(solver(rows, ghosts, channel), channel, config.walls.treatment.type, memory), channel)
