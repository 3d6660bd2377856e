"""What the implicit step starts from and leads to, on particles: for motion, output, shifting and checkpoints."""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real
from tisph.schemes._stages.impulse import apply_impulse
from tisph.schemes._stages.stages import FlowState, ViscousStages, stages_of
from tisph.schemes.implicit._dense import hermite


class PolymerState:
    """What particles carry of an extra stress, arrays of the states C (components, fluid); a checkpoint keeps them.

    ``state`` at the start of a step, ``end`` after it, and before an earlier one: ``start``; ``start_rate``,
    ``end_rate``: their time derivatives; ``slope``: dC/dy; ``shear_rate`` (fluid): du/dy at the start.
    """

    def __init__(self, components, fluid):
        self.state, self.end, self.start, self.start_rate, self.end_rate, self.slope = np.zeros((6, components, fluid))
        self.shear_rate, self.end_shear_rate = np.zeros((2, fluid))


class ImplicitStep:
    """Advances the velocities, and with a ``model`` of an extra stress what particles carry of it, ``polymer``.

    ``velocity`` and ``end`` (2, fluid): at the start and at the end of the step, along and across the channel;
    ``start_rate``, ``end_rate`` their time derivatives there.
    """

    def __init__(self, operators, channel, walls):
        self.closed_operators, self.operators = operators, operators.operators
        self.channel, self.walls, self.model = channel, walls, walls.model
        self.points, self.ghosts = operators.points, operators.ghosts
        self.stages = stages_of(operators, channel, walls)
        self.transverse_stages = ViscousStages(operators, channel, None)
        self.velocity, self.end, self.start_rate, self.end_rate = (self.points.field(real(), 2) for _ in range(4))
        fluid = self.points.fluid
        self.polymer = None if self.model is None else PolymerState(self.model.components, fluid)
        self.transverse_state = np.empty((0, fluid))

    def begin_with(self, heights):
        """Take up what else particles at ``heights`` (fluid,) carry when a run starts."""
        self.walls.reset()
        if self.polymer:
            self.polymer.state[...] = self.model.initial(self.channel, heights)
            self.polymer.shear_rate[...] = 0.0
            self.stages.initialise()

    def apply_impulse(self, time):
        """Let walls that change at once at ``time`` do so.

        Returns the velocity gained from the (bottom, top) wall, summed over the particles.
        """
        flow = self.flow()
        gains = apply_impulse(self.stages, flow, time)
        active(self.velocity)[0] = flow.velocity
        if self.polymer:
            self.polymer.state[...] = flow.state
        return gains

    def flow(self, component=0):
        """Return copies of one component's velocities and of what belongs to them, in double precision."""
        velocity = active(self.velocity)[component].astype(float)
        if component == 1 or not self.polymer:
            return FlowState(velocity, self.transverse_state)
        return FlowState(velocity, self.polymer.state.copy(), self.polymer.shear_rate.copy())

    def set_force(self, force):
        """Let a ``force`` (2, fluid) per unit mass act on the particles in the steps to come."""
        self.stages.force, self.transverse_stages.force = force

    def advance(self, transverse, time, dt, tolerance):
        """Compute the end of a step; return its estimated error. ``transverse``: whether v is not 0 everywhere."""
        self.closed_operators.assemble()
        errors = [self.advance_component(component, time, dt, tolerance) for component in range(1 + transverse)]
        return math.hypot(*errors)

    def advance_component(self, component, time, dt, tolerance):
        """Compute the end of one component, and with the first that of C; return the estimated error."""
        start = self.flow(component)
        end, error = (self.transverse_stages if component else self.stages).advance(start, time, dt, tolerance)
        if end is None:
            return error
        active(self.end)[component], active(self.end_rate)[component] = end.velocity, end.velocity_rate
        active(self.start_rate)[component] = start.velocity_rate
        if self.polymer and component == 0:
            polymer = self.polymer
            polymer.end[...], polymer.end_rate[...] = end.state, end.state_rate
            polymer.end_shear_rate[...], polymer.start_rate[...] = end.shear_rate, start.state_rate
        return error

    def accept(self):
        """Take up the end of the step as the start of the next, on the particles and at the walls."""
        active(self.velocity)[...] = active(self.end)
        self.walls.conclude()
        if not self.polymer:
            return
        polymer, operators = self.polymer, self.closed_operators
        polymer.start[...] = polymer.state
        polymer.state[...], polymer.shear_rate[...] = polymer.end, polymer.end_shear_rate
        for component, (slope, state) in enumerate(zip(polymer.slope, polymer.state, strict=True)):
            images = [operators.boundary_stress(wall.side, *wall.state_excess(component)) for wall in self.walls]
            slope[...] = operators.gradient(state, 1.0) + sum(images)

    def shift_fields(self, moved, across):
        """Let what else particles carry follow those that were ``moved`` by ``across``."""
        if self.polymer:
            self.polymer.state[:, moved] += self.polymer.slope[:, moved] * across

    def indefinite(self):
        """Return the particles with an indefinite conformation tensor at the end of the step."""
        return self.model.indefinite(self.polymer.end) if self.polymer else np.zeros(0, dtype=int)

    def stress(self):
        """Return the stresses S_xx, S_xy, S_yy per unit density that particles carry, (3, fluid), or none, ()."""
        return self.model.stress(self.polymer.state) if self.polymer else ()

    def stress_at(self, theta, dt):
        """Return ``stress`` at the part ``theta`` of the last step, of ``dt``: cubic in the states."""
        if not self.polymer:
            return ()
        polymer = self.polymer
        ends = polymer.start, polymer.state, polymer.start_rate, polymer.end_rate
        return self.model.stress(hermite(theta, dt, *ends))

    def parts(self):
        """Return by name what a checkpoint keeps beside the fields here."""
        return {"polymer": self.polymer} if self.polymer else {}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {"walls": self.walls.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.walls.restore_host_state(state["walls"])
