"""Polymer stress where the flow turns: it lives on the particles and follows its own equation along their paths.

Backward differences of the deviation C of the conformation tensor from rest, of the same order and for the same steps h
as those of the velocities,

    g C = sum_j a_j C^(n+1-j) + h F(C, L),    L = grad u, F as in ``rheology/_polymer.py``,

are solved particle by particle for given L. Of a small change of L the stress S then takes 2 nu* D, D = (L + L^T)/2,

    nu* = sum over the modes of (nu_p/lambda) h / (g + h/lambda).

So the momentum equation is solved with the viscosity nu_s + nu*, by the same rows and solvers as without polymer, and
pushed by div (S - 2 nu* D), in which that part of S has cancelled. S is first that of the velocities expected at the
end of the step, and then that of the velocities found with it: what is left to these two turns is how the flow carries
and stretches the stress that there is. Points on walls are of the liquid, and carry a stress like any other; there L is
a shear along the wall, by what is known of the velocity. With L as measured, stress grew at them (12 spacings between
cylinders, Wi = 2.7 at the inner one, a solvent fraction of 0.1: by e in two relaxation times).

Sources: R. Guenette and M. Fortin, J. Non-Newtonian Fluid Mech. 60 (1995) 27-52 (a viscosity on both sides).
"""

import numpy as np

from tisph.errors import DivergedError
from tisph.runtime import real, ti, view
from tisph.schemes._pointwise import Modes, solve
from tisph.schemes._splitting._history import change, slopes
from tisph.schemes._splitting._series import ORDER


@ti.data_oriented
class Polymer:
    """``tensors`` (fluid): C of all modes at the ends of the last steps, newest first."""

    def __init__(self, history, flow):
        self.history, self.rows, self.points = history, history.rows, history.points
        self.walls, self.liquid, self.origin = flow.walls, flow.liquid, flow.origin
        self.modes = Modes(flow.rheology, flow.kinematic_viscosity)
        self.size = self.modes.components
        kept = ti.types.vector(ORDER * self.size, real())
        self.tensors, self.along, self.across = (ti.field(kept, self.points.slots + 1) for _ in range(3))
        self.tensors.used = slice(self.points.fluid)
        self.along.used = self.across.used = slice(flow.liquid, self.points.fluid)  # what walls slide past
        self.gradient = ti.field(ti.types.vector(4, real()), self.points.most)
        self.excess = ti.field(ti.types.vector(3, real()), self.points.slots + 1)
        self.force = ti.field(ti.types.vector(2, real()), self.points.most)
        for field in (self.gradient, self.excess, self.force):
            field.used = None

    @property
    def states(self):
        """C (ages, numbers of all modes, particles) in place."""
        values = view(self.tensors)[: self.points.fluid]
        return values.reshape(len(values), ORDER, self.size).transpose(1, 2, 0)

    def begin(self):
        """Start from rest, without stress."""
        view(self.tensors)[...] = 0.0

    def prepare(self, times, length, time):
        """Take up a step of this ``length`` that ends at ``time``."""
        leading, back = times.backwards()
        self.time, self.duration = time, length / leading
        self.known = np.einsum("a,acn->cn", back[:ORDER], self.states.astype(float)) / leading
        self.known[:, self.liquid :] -= self.duration * self.slid(times)
        self.found = self.states[0].astype(float)
        self.viscosity = sum(
            law.modulus * self.duration / (1.0 + self.duration / law.relaxation_time) for law in self.modes.laws
        )
        view(self.force)[...] = 0.0

    def slid(self, times):
        """Return U . grad C on points that walls slide past with U, expected at the end of a step."""
        sliding, ahead = self.walls.sliding(self.time).T, times.ahead(ORDER)
        slopes = [view(field)[self.liquid : self.points.fluid].astype(float) for field in (self.along, self.across)]
        kept = (slope.reshape(-1, ORDER, self.size) for slope in slopes)
        return sum(speed * np.einsum("a,nac->cn", ahead, slope) for speed, slope in zip(sliding, kept, strict=True))

    def act(self, velocity, known, length):
        """Let the stress of a ``velocity``, a field, push what is ``known`` of a step of this ``length``."""
        self.find(velocity)
        xx, xy, yx, yy = self.gradients
        strained = self.viscosity * np.stack([2.0 * xx, xy + yx, 2.0 * yy])
        view(self.excess)[: self.points.fluid] = (self.modes.stress(self.found) - strained).T
        self.push(known, length)

    def find(self, velocity):
        """Find C at the end of a step for a ``velocity`` there."""
        self.measure(velocity)
        gradient = self.gradients = view(self.gradient)[: self.points.fluid].T.astype(float)
        gradient[[0, 3]] -= 0.5 * (gradient[0] + gradient[3])  # what divergence there is, is an error
        points = gradient[:, self.liquid :]
        points[...] = self.walls.gradients(points.reshape(2, 2, -1), self.time).reshape(4, -1)
        for law, part in self.modes:
            rate = lambda c, law=law: law.deformed(c, gradient)  # noqa: E731
            self.found[part], _ = solve(rate, self.known[part], self.duration, self.found[part])

    def take_up(self, velocity, step):
        """Let the particles carry the C of the ``velocity`` at the end of a ``step``, and its slopes.

        Raises DivergedError where A is not positive definite.
        """
        self.find(velocity)
        states = self.states
        states[1:] = states[:-1].copy()
        states[0] = self.found
        lost = np.flatnonzero(np.any([_lost(self.found[part]) for _, part in self.modes], axis=0))
        if len(lost):
            x, y = view(self.points.place)[lost[0]] + self.origin
            text = f"the conformation tensor is not positive definite at ({x:.4g}, {y:.4g}), step {step}"
            cure = "more particles across, or a smaller relaxation time"
            raise DivergedError(f"stress: {text}, t = {self.time:.6g}; {cure}")
        self.slope()

    def wall_stress(self):
        """Return the stress (3, count) at the points on walls."""
        return self.modes.stress(self.states[0][:, self.liquid :].astype(float))

    def at(self, times, age, tensors):
        """Return the stresses (3, n) ``age`` before the end of the last step, of ``tensors`` (n, ages and numbers)."""
        kept = tensors.reshape(len(tensors), ORDER, self.size)
        return self.modes.stress(np.einsum("a,nac->cn", times.at(age, ORDER), kept) if age else kept[:, 0].T)

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points: du/dx, du/dy, dv/dx, dv/dy."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.points.particles[None]):
            along, across = slopes(self.rows, velocity, i)
            self.gradient[i] = [along.x, across.x, along.y, across.y]

    @ti.kernel
    def push(self, known: ti.template(), length: float):
        """Divergence of the stress beyond that of the implicit viscosity, in place of the one of the last turn."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.points.particles[None]):
            along, across = slopes(self.rows, self.excess, i)
            force = ti.Vector([along[0] + across[1], along[1] + across[2]])
            known[i] += length * (force - self.force[i])
            self.force[i] = force

    @ti.kernel
    def slope(self):
        """Slopes of all that is carried."""
        ti.loop_config(serialize=self.rows.serial)
        for i in range(self.points.particles[None]):
            self.along[i], self.across[i] = slopes(self.rows, self.tensors, i)

    @ti.kernel
    def settle(self):
        """Let all that is carried follow a shift."""
        ti.loop_config(serialize=self.rows.serial)
        for i in range(self.points.particles[None]):
            self.tensors[i] += change(self.rows, self.along, self.across, i, self.history.shift.moved[i])


def _lost(state):
    """Where conformation tensors of one mode are not positive definite."""
    xx, xy, yy = 1.0 + state[0], state[1], 1.0 + state[2]
    return ~((yy > 0.0) & (xx * yy > xy * xy) & np.all(state[3:] > -1.0, axis=0))
