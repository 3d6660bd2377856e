"""Free bodies and the solvers of the fluid around them: loads of the one, velocities of the others, in turn."""

import math

import numpy as np

from tisph.runtime import view
from tisph.schemes._two_dimensional.free_bodies import MOST_ITERATIONS


class Coupling:
    """``bodies`` (``FreeBodies``) on the ``boundary`` (``WallBoundary``) of the fluid that ``splitting`` solves for.

    ``precision``: rounding error of what is computed, relative.
    """

    def __init__(self, boundary, splitting, precision):
        self.bodies, self.boundary, self.splitting, self.precision = boundary.free, boundary, splitting, precision
        self.least = 0.0

    def prepare(self, times, dt, time):
        """Take up a step ``dt`` that ends at ``time``."""
        self.time = time
        self.bodies.prepare(times, dt, time)
        walls, fastest = self.boundary.walls, float(np.abs(self.bodies.arm * self.bodies.velocities).max())
        self.splitting.rounding = self.precision * fastest * math.sqrt(walls.count) / (dt * walls.spacing)
        self.curl_scale = self.bodies.viscosity * dt / self.bodies.gamma0 / math.sqrt(self.boundary.walls.count)

    def correct(self):
        """Change the velocities of the bodies by what the fluid does to them; return whether there is no need to."""
        self.splitting.wall_gradients()
        loads = self._loads(self.boundary.strain(), self.splitting.extra_stress)
        boundary, scale = self.boundary.pressure_boundary, self.curl_scale
        given = scale * boundary.normal_curls.astype(float)
        self.splitting.find_normal_curls()
        found = scale * boundary.normal_curls.astype(float)
        if self.bodies.correct(self.bodies.step_residual(loads), self.least, given, found):
            return True
        boundary.normal_curls[...] = given / scale
        self.bodies.attempt()
        self.boundary.velocity = self.boundary.walls.velocities(self.time)
        self.boundary.impose_velocities(self.splitting)
        return False

    def error(self):
        """Return that of the step by the bodies: infinite where no velocities have been found for them."""
        return self.bodies.difference() if self.bodies.converged <= self.least else math.inf

    def _loads(self, strain, extra_stress):
        """Return force and torque (n, 3) of pressure and strain at the walls, per unit density."""
        boundary = self.boundary
        extra = extra_stress.implicit_wall_stress(strain) if extra_stress else 0.0
        tractions = boundary.tractions(view(self.splitting.pressure.x)[boundary.slots].astype(float), strain, extra)
        return boundary.walls.sums(tractions, self.time)[0, self.bodies.index, :3]

    def begin(self, tolerance):
        """Find the velocities after the start, of bodies and a fluid that move against each other before.

        Pressure acts on both for no time; what it does to the one it does to the other. Return whether the impulse
        could be solved for.
        """
        bodies, boundary = self.bodies, self.boundary
        self.time = boundary.problem.start_time
        self._take_rotations()
        before = bodies.newest
        bodies.begin(before, bodies.mass + bodies.added_mass(0.0))
        for _ in range(MOST_ITERATIONS):
            solved = boundary.find_impulse(self.splitting, tolerance)
            impulse = -view(self.splitting.pressure.x)[boundary.slots].astype(float)[:, None] * boundary.normal
            loads = boundary.walls.sums(impulse[None], self.time)[0, bodies.index, :3]
            residual = bodies.mass * (bodies.velocities - before) - loads
            if bodies.correct(residual, tolerance * np.abs(boundary.velocity - boundary.fluid_velocity).max()):
                break
            self._start(bodies.velocities)
        self.splitting.apply_impulse()
        bodies.begin_start(self.boundary.problem.acceleration)
        self._take_accelerations()
        return solved

    def _take_rotations(self):
        """Let bodies without a moment of inertia turn as the fluid at their surface does.

        Else the layer that begins there, as thin as it is strong, would turn them with a torque that nothing resists.
        """
        bodies, boundary = self.bodies, self.boundary
        slip = np.stack([boundary.fluid_velocity, boundary.walls.velocities(self.time)])
        around = boundary.walls.sums(slip, self.time)[:, bodies.index, 2]
        rate = (around[0] - around[1]) / boundary.walls.moments(self.time)[bodies.index]
        turned = bodies.newest
        turned[:, 2] += np.where(bodies.massless_rotation, rate, 0.0)
        self._start(turned)

    def _start(self, velocities):
        for motion, velocity in zip(self.bodies.motions, velocities, strict=True):
            motion.start(self.time, velocity)
        self.boundary.velocity = self.boundary.walls.velocities(self.time)

    def _take_accelerations(self):
        for motion, acceleration in zip(self.bodies.motions, self.bodies.velocities, strict=True):
            motion.change = acceleration

    def correct_start(self, tolerance):
        """Change the first accelerations of the bodies by what the first pressure does; return whether it need not.

        Loads of a pressure that was solved to a ``tolerance`` tell no more: where it changes no longer, extrapolating
        from its changes would lead anywhere.
        """
        bodies, boundary = self.bodies, self.boundary
        loads = self._loads(boundary.strain(), None)
        residual = bodies.mass * bodies.velocities - loads - bodies.load
        residual[bodies.massless_rotation, 2] = 0.0  # no acceleration of theirs alters a torque
        if bodies.correct(residual, tolerance * np.abs(bodies.arm * bodies.velocities).max()):
            return True
        self._take_accelerations()
        boundary.set_acceleration(self.splitting)
        return False
