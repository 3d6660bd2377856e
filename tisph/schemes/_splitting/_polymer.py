"""Polymer stress where the flow turns: it lives on the particles and follows its own equation along their paths.

Backward differences of the logarithm P of the conformation tensor, of the same order and for the same steps h as those
of the velocities,

    g P = sum_j a_j P^(n+1-j) + h F(P, L),    L = grad u, F as in ``_logarithm.py``,

are solved particle by particle for given L. At rest the stress S takes 2 nu* D of a small change of L, D = (L + L^T)/2,

    nu* = sum over the modes of (nu_p/lambda) h / (g + h/lambda).

So the momentum equation is solved with the viscosity nu_s + nu*, by the same rows and solvers as without polymer, and
pushed by div (S - 2 nu* D), in which that part of S has cancelled; slopes of S are those of P times dS/dP: near walls
S rises by orders of magnitude within a few spacings, and P does not. S is first that of the velocities expected at the
end of the step, and then that of the velocities found with it: what is left to these two turns is how the flow carries
and stretches the stress that there is. Points on walls are of the liquid, and carry a stress like any other; there L is
a shear along the wall, by what is known of the velocity. With L as measured, stress grew at them (12 spacings between
cylinders, Wi = 2.7 at the inner one, a solvent fraction of 0.1: by e in two relaxation times).

Sources: R. Guenette and M. Fortin, J. Non-Newtonian Fluid Mech. 60 (1995) 27-52 (a viscosity on both sides).
"""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.runtime import real, ti, view
from tisph.schemes._local_newton import SMALL, Modes, solve
from tisph.schemes._splitting._history import change, slopes
from tisph.schemes._splitting._logarithm import deviation, logarithm, rate
from tisph.schemes._splitting._series import ORDER

HOPELESS = 5.0
"""Change of P within a spacing from which on there is nothing to compute: A changes 150-fold from one particle to
the next."""


@ti.data_oriented
class Polymer:
    """``tensors`` (fluid): P of all modes at the ends of the last steps, newest first."""

    def __init__(self, history, flow):
        self.history, self.operators, self.points = history, history.operators, history.points
        self.walls, self.n_fluid, self.origin, self.spacing = flow.walls, flow.n_fluid, flow.origin, flow.spacing
        self.initial_deviations = flow.initial_deviations
        self.modes = Modes(flow.rheology, flow.kinematic_viscosity, deviation)
        self.size = self.modes.components
        self.tensors, self.along, self.across = self._three(ORDER * self.size)
        self.now, self.now_along, self.now_across = self._three(self.size)
        self.tensors.used = slice(self.points.fluid)
        self.along.used = self.across.used = None
        self.gradient = ti.field(ti.types.vector(4, real()), self.points.capacity)
        self.strained = ti.field(ti.types.vector(3, real()), self.points.slots + 1)
        self.force, self.pull = (ti.field(ti.types.vector(2, real()), self.points.capacity) for _ in range(2))
        for field in (self.gradient, self.strained, self.force, self.pull, self.now, self.now_along, self.now_across):
            field.used = None

    def _three(self, numbers):
        """A field with these ``numbers`` of each point, and two for its slopes."""
        kind = ti.types.vector(numbers, real())
        return [ti.field(kind, self.points.slots + 1) for _ in range(3)]

    @property
    def states(self):
        """P (ages, numbers of all modes, particles) in place."""
        values = view(self.tensors)[: self.points.fluid]
        return values.reshape(len(values), ORDER, self.size).transpose(1, 2, 0)

    def begin(self):
        """Start from rest, without stress, or from what the flow says."""
        view(self.tensors)[...] = 0.0
        if self.initial_deviations:
            places = view(self.points.position)[: self.points.fluid].astype(float) + self.origin
            modes = self.initial_deviations(*places.T)
            self.states[0] = np.concatenate([logarithm(deviations) for deviations in modes])

    def prepare(self, times, length, time):
        """Take up a step of this ``length`` that ends at ``time``."""
        leading, back = times.backwards()
        self.time, self.duration = time, length / leading
        states, elapsed = self.states.astype(float), (times.unit * times.ages)[:ORDER]
        if self.walls:
            states[..., self.n_fluid :] = self.walls.carried(states[..., self.n_fluid :], elapsed, self.time)
        self.known = np.einsum("a,acn->cn", back[:ORDER], states) / leading
        self.found, self.slopes = states[0], [None for _ in self.modes.laws]
        self.viscosity = sum(
            law.modulus * self.duration / (1.0 + self.duration / law.relaxation_time) for law in self.modes.laws
        )
        view(self.force)[...] = 0.0

    def act(self, velocity, known, length):
        """Let the stress of a ``velocity``, a field, push what is ``known`` of a step of this ``length``."""
        self.find(velocity)
        xx, xy, yx, yy = self.gradients
        used = slice(self.points.fluid)
        view(self.strained)[used] = (self.viscosity * np.stack([2.0 * xx, xy + yx, 2.0 * yy])).T
        view(self.now)[used] = self.found.T
        self.incline()
        ways = [view(field)[used].T.astype(float) for field in (self.now_along, self.now_across)]
        along, across = (np.imag(self.modes.stress(self.found + 1j * SMALL * way)) / SMALL for way in ways)
        view(self.pull)[used] = np.stack([along[0] + across[1], along[1] + across[2]], axis=1)
        self.push(known, length)

    def find(self, velocity):
        """Find P at the end of a step for a ``velocity`` there."""
        self.measure(velocity)
        gradient = self.gradients = view(self.gradient)[: self.points.fluid].T.astype(float)
        gradient[[0, 3]] -= 0.5 * (gradient[0] + gradient[3])  # what divergence there is, is an error
        if self.walls:
            points = gradient[:, self.n_fluid :]
            points[...] = self.walls.gradients(points.reshape(2, 2, -1), self.time).reshape(4, -1)
        for mode, (law, part) in enumerate(self.modes):
            way = lambda p, law=law: rate(law, p, gradient)  # noqa: E731
            known, guess = self.known[part], self.found[part]
            with np.errstate(all="ignore"):  # what is not finite has no pressure, and is refused
                self.found[part], self.slopes[mode] = solve(way, known, self.duration, guess, self.slopes[mode])

    def take_up(self, velocity, step):
        """Let the particles carry the P of the ``velocity`` at the end of a ``step``.

        Returns the largest change of P within a spacing, and x and y where it is. Raises DivergedError where that is
        beyond all use.
        """
        self.find(velocity)
        states = self.states
        states[1:] = states[:-1].copy()
        states[0] = self.found
        self.slope()
        change, x, y = self.steepest()
        if not change < HOPELESS:
            text = f"stress: it changes more than {math.exp(HOPELESS):.0f}-fold within a particle spacing at"
            cure = "more particles across, or a smaller relaxation time"
            raise DivergedError(f"{text} ({x:.4g}, {y:.4g}), step {step}, t = {self.time:.6g}; {cure}")
        return change, x, y

    def steepest(self):
        """Return the largest change of a P within a spacing, its Frobenius norm, and x and y where it is."""
        used, weights = slice(self.points.fluid), np.array([1.0, 2.0, 1.0, 1.0])
        slopes = [view(field)[used, : self.size].astype(float) for field in (self.along, self.across)]
        squares = sum(slope**2 for slope in slopes)
        sums = [squares[:, part] @ weights[: part.stop - part.start] for part in self.modes.parts]
        worst = np.max(sums, axis=0)
        place = int(np.argmax(np.where(np.isnan(worst), np.inf, worst)))
        where = view(self.points.position)[place] + self.origin
        return self.spacing * math.sqrt(worst[place]), *where.tolist()

    def wall_stress(self):
        """Return the stress (3, count) at the points on walls."""
        return self.modes.stress(self.states[0][:, self.n_fluid :].astype(float))

    def at(self, times, age, tensors):
        """Return the stresses (3, n) ``age`` before the end of the last step, of ``tensors`` (n, ages and numbers)."""
        kept = tensors.reshape(len(tensors), ORDER, self.size)
        return self.modes.stress(np.einsum("a,nac->cn", times.at(age, ORDER), kept) if age else kept[:, 0].T)

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points: du/dx, du/dy, dv/dx, dv/dy."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            along, across = slopes(self.operators, velocity, i)
            self.gradient[i] = [along.x, across.x, along.y, across.y]

    @ti.kernel
    def incline(self):
        """Slopes of P at the end of a step."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            self.now_along[i], self.now_across[i] = slopes(self.operators, self.now, i)

    @ti.kernel
    def push(self, known: ti.template(), length: float):
        """Divergence of the stress beyond that of the implicit viscosity, in place of the one of the last turn."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            along, across = slopes(self.operators, self.strained, i)
            force = self.pull[i] - ti.Vector([along[0] + across[1], along[1] + across[2]])
            known[i] += length * (force - self.force[i])
            self.force[i] = force

    @ti.kernel
    def slope(self):
        """Slopes of all that is carried."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            self.along[i], self.across[i] = slopes(self.operators, self.tensors, i)

    @ti.kernel
    def settle(self):
        """Let all that is carried follow a shift."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            self.tensors[i] += change(self.operators, self.along, self.across, i, self.history.shift.moved[i])
