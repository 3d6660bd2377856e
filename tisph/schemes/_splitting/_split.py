"""One step of the velocities: what they were, then the pressure, then the viscous forces.

G. E. Karniadakis, M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, along the paths of the particles, where
nothing is convected: with backward differences g u - sum_j a_j u^(n+1-j) of steps of any length,

    u^ = sum_j a_j u^(n+1-j),    L p = (D u^ - k g d^n) / h,    (g - h nu L) u^(n+1) = u^ - h G p,

all operators being those of the arrangement at the end of the step. L p is the Laplacian itself, not D G p, which on
particles has spurious modes; so the divergence d of the velocities is not quite 0, and where steps are short asking for
0 anew in each would let pressures grow like 1/h. Hence k: divergence decays at a rate of its own instead.
"""

import math

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._splitting._series import PRESSURES, VELOCITIES
from tisph.solvers.bicgstab import BiCGStab
from tisph.solvers.two_level import TwoLevel

ROUGH = 1.0
"""Viscous number h nu/(g spacing^2) up to which the diagonal is preconditioner enough."""

FIRST = 1e-4, 1e-8
"""Tolerances at which the first of two turns is exact enough: all that is left of it is a curl at walls."""


@ti.data_oriented
class Split:
    """Computes ``end`` and ``pressure`` of a step from what the particles carry, with weights set beforehand.

    ``back``: the a_j; ``ahead``, ``ahead_pressure``: of the values expected at the end, where solvers begin and what
    the error is estimated from.
    """

    def __init__(self, history, grid, flow, closure=None, polymer=None):
        self.history, self.operators, self.points = history, history.operators, history.points
        vector = ti.types.vector(2, real())
        self.spacing, self.closure, self.bounded = flow.spacing, closure, closure is not None
        self.polymer = polymer
        self.driven = any(flow.acceleration)
        self.acceleration = holding(ti.field(vector, ()), flow.acceleration)
        self.pressure = BiCGStab(self.operators, pure_neumann=True)
        self.velocity = BiCGStab(self.operators, width=2)
        self.for_pressure, self.for_velocity = (TwoLevel(solver, grid) for solver in (self.pressure, self.velocity))
        self.known, self.expected = (ti.field(vector, self.points.slots + 1) for _ in range(2))
        self.back, self.ahead = (holding(ti.field(real(), VELOCITIES), 0.0) for _ in range(2))
        self.ahead_pressure = holding(ti.field(real(), PRESSURES), 0.0)
        self.defect = scalar(0.0)

    def solve(self, leading, length, viscosity, kept, tolerances):
        """Solve for pressure and velocities; return whether both could be.

        ``leading`` is g, ``kept`` k g, ``tolerances`` those of the pressure and of the velocities.
        """
        sound, self.iterations = True, [0.0, 0.0]
        turns = 2 if self.bounded or self.polymer else 1
        for turn in range(turns):
            if self.polymer:
                self.polymer.act(self.velocity.x, self.known, length)
            if self.polymer or turn == 0:
                self.divide(length, kept)
            if self.bounded:
                if turn == 1:
                    self.closure.spin(self.velocity.x)
                self.bound(length, leading, viscosity)
            asked = tolerances if turn == turns - 1 else np.maximum(tolerances, FIRST)
            sound = self.solve_pressure(asked[0]) and sound
            self.push(length)
            diffusion = length * viscosity
            rough = diffusion <= ROUGH * leading * self.spacing**2
            preconditioner = None if rough else self.for_velocity
            sound = self.velocity.solve(diffusion, asked[1], leading, preconditioner) and sound
            self.iterations[0] += self.pressure.iterations
            self.iterations[1] += self.velocity.iterations
        self.compare()
        return sound

    def solve_pressure(self, tolerance):
        """Solve -L p = b; return whether it could be."""
        return self.pressure.solve(1.0, tolerance, sigma=0.0, preconditioner=self.for_pressure)

    def error(self):
        """Return the root mean square of what the new velocities differ by from those expected."""
        return math.sqrt(float(view(self.defect)) / int(view(self.points.n_fluid)))

    def begin(self, viscosity, tolerance):
        """Solve L p = - grad u : grad u for the pressure of the velocities that there are; return whether it could be.

        It is carried from then on.
        """
        self.twist()
        if self.bounded:
            self.bound(1.0, 0.0, viscosity)
        sound = self.solve_pressure(tolerance)
        self.lay()
        return sound

    def kick(self, tolerance):
        """Let walls that start to move push liquid at rest away at once; return whether it could be.

        u - grad phi, with L phi = 0 and n . grad phi = -n . U: the impulse of a pressure, over the density.
        """
        self.jolt()
        sound = self.solve_pressure(tolerance)
        self.yield_way()
        return sound

    @ti.kernel
    def jolt(self):
        """Right side of the equation for the impulse."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            self.pressure.x[i] = 0.0
            self.pressure.b[i] = 0.0
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            self.pressure.b[i] = self.closure.right_side(i, -self.velocity.x[i], 0.0)

    @ti.kernel
    def yield_way(self):
        """Let the impulse change the velocities that the particles carry."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            slope = self.slope(i)
            self.history.carried[i][0] -= slope.x
            self.history.carried[i][1] -= slope.y

    @ti.func
    def slope(self, i):
        """Return the slope of the pressure, or of the impulse, at a particle."""
        own, slope = self.pressure.x[i], ti.Vector([0.0, 0.0])
        for k in range(self.points.count[i]):
            difference = self.pressure.x[self.points.neighbours[i, k]] - own
            slope += difference * ti.Vector([self.operators.d_dx[i, k], self.operators.d_dy[i, k]])
        return slope

    @ti.kernel
    def twist(self):
        """Right side of the pressure's equation at the start."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            along, across = self.history.along[i], self.history.across[i]
            self.pressure.b[i] = along[0] ** 2 + 2.0 * across[0] * along[1] + across[1] ** 2
            self.pressure.x[i] = 0.0

    @ti.kernel
    def lay(self):
        """Let the particles carry the pressure."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.history.carried[i][2 * VELOCITIES] = self.pressure.x[i]

    @ti.kernel
    def look_back(self):
        """Sum the velocities that were."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            known, expected = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
            for age in ti.static(range(VELOCITIES)):
                velocity = self.history.velocity(age, i)
                known += self.back[age] * velocity
                expected += self.ahead[age] * velocity
            self.known[i], self.expected[i] = known, expected
            self.velocity.x[i] = expected
            pressure = 0.0
            for age in ti.static(range(PRESSURES)):
                pressure += self.ahead_pressure[age] * self.history.carried[i][2 * VELOCITIES + age]
            self.pressure.x[i] = pressure

    @ti.kernel
    def divide(self, length: float, kept: float):
        """Right side of the pressure's equation."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            own, divergence = self.known[i], 0.0
            for k in range(self.points.count[i]):
                difference = self.known[self.points.neighbours[i, k]] - own
                divergence += self.operators.d_dx[i, k] * difference.x + self.operators.d_dy[i, k] * difference.y
            self.pressure.b[i] = (kept * self.history.divergence[i] - divergence) / length

    @ti.kernel
    def bound(self, length: float, leading: float, viscosity: float):
        """Right side of the pressure's equation at walls, where the velocities at the end are known."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            push = (self.known[i] - leading * self.velocity.x[i]) / length + self.acceleration[None]
            self.pressure.b[i] = self.closure.right_side(i, push, viscosity)

    @ti.kernel
    def push(self, length: float):
        """Right side of the velocities' equation."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            slope = self.slope(i)
            if ti.static(self.driven):
                slope -= self.acceleration[None]
            self.velocity.b[i] = self.known[i] - length * slope

    @ti.kernel
    def compare(self):
        """Sum the squares of the differences from the expected velocities, in a fixed order."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = 0.0
            for i in range(self.points.n_fluid[None]):
                difference = self.velocity.x[i] - self.expected[i]
                total += difference.dot(difference)
            self.defect[None] = total

    @ti.kernel
    def take_up(self):
        """Let the particles carry what was found."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.history.renew(i, self.velocity.x[i], self.pressure.x[i])
