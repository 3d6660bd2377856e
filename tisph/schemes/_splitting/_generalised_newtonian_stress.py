"""Stress of a generalised Newtonian fluid in two-dimensional flow: 2 nu D, its viscosity nu a function of D.

With L = grad u, D its symmetric part without trace, and q = 2 D:D, the square of the shear rate, the velocities obey

    gamma_0 u - dt nu* L u = u^ - dt G p + dt [div (2 nu D) - nu* div (2 D)],    nu* = d(nu q)/dq,

L u the Laplacian by its own operator, both divergences by those of first derivatives. These hardly see what changes
from one particle to the next, which the Laplacian damps; of smooth velocities both parts of nu* cancel to the order of
the operators. It is the stress that is differentiated and not the viscosity, which may change tenfold from one particle
to the next where the stress does not, at the front of a layer or the edge of a plug: with nu lap u + 2 D grad nu a
power law, n = 0.5, came to rest between cylinders in a flow whose torques differed by a factor of 7.

The bracket is first that of the extrapolated velocities, then that of the velocities found with it. A change of the
shear rate meets the viscosity nu + 2 q dnu/dq, one across it nu. Their mean is nu*, so that each outer iteration
reduces errors by (1 - n)/(1 + n) where the viscosity is a power n - 1 of the rate, however much it varies over the
fluid. With the largest viscosity of all as nu* they would remain where the viscosity is low, and extrapolation from
four levels is unstable then.

The pressure also has to balance the divergence of nu* L u, grad nu* . lap u, with lap u = -curl of the vorticity, which
is not 0 as that of a constant viscosity. Written as a divergence it would be unstable: errors of the pressure would
return undiminished from one outer iteration to the next.
"""

import copy

import numpy as np

from tisph.runtime import real, ti, view
from tisph.schemes._local_newton import SMALL
from tisph.schemes._splitting._time_levels import gradients


@ti.data_oriented
class GeneralisedNewtonianStress:
    """Of a fluid whose ``law`` gives a viscosity (``tisph/rheology``), per unit density as all else.

    ``operators`` are those that the velocities are solved with, the Laplacian of each particle times its nu* over the
    ``viscosity``. ``derived``: what derivatives are taken of, 2 nu D and 2 D (xx, xy, yy each), vorticity and nu*;
    ``implicit_divergence``: dt grad nu* . lap u.
    """

    varying = True
    numbers, components = 8, 2

    def __init__(self, levels, problem):
        self.levels, self.points, self.n_fluid = levels, levels.points, problem.n_fluid
        self.viscosity = problem.kinematic_viscosity
        self.law = problem.rheology.law(self.viscosity, problem.density)
        self.unweighted, self.operators = levels.operators, copy.copy(levels.operators)
        self.operators.laplacian = ti.field(real(), levels.operators.laplacian.shape)
        self.derived = ti.field(ti.types.vector(self.numbers, real()), self.points.slots + 1)
        vector = ti.types.vector(self.components, real())
        self.d_dx, self.d_dy, self.force = (ti.field(vector, self.points.capacity) for _ in range(3))
        self.implicit_divergence, self.operators.diagonal = (ti.field(real(), self.points.capacity) for _ in range(2))

    def begin(self):
        """Find the stress of the newest velocities, whose gradients are measured."""
        self.find(self.levels.fields, self.levels.d_dx, self.levels.d_dy)

    def prepare(self, times, dt, time):
        """Take up a step."""
        view(self.force)[...] = 0.0

    def add_stress(self, velocity, known, dt):
        """Add the stress of a ``velocity``, a field, to what is ``known`` of a step ``dt``, and weigh the operators."""
        self.measure(velocity)
        self.find(velocity, self.d_dx, self.d_dy)
        self.add_force(known, dt, self.viscosity)

    def find(self, velocity, d_dx, d_dy):
        """Find stress and viscosities for a velocity: it and its gradients are the first numbers of these fields."""
        d_dx, d_dy = (view(field)[: self.points.fluid, :2].astype(float) for field in (d_dx, d_dy))
        along, shear = d_dx[:, 0] - d_dy[:, 1], d_dx[:, 1] + d_dy[:, 0]
        strain, squared = np.stack([along, shear, -along], axis=1), along**2 + shear**2
        self.derive(strain, squared, d_dx[:, 1] - d_dy[:, 0])

    def derive(self, strain, squared, vorticity):
        """Take up 2 D (points, numbers), q and the vorticity (points,), and find the viscosities."""
        with np.errstate(all="ignore"):  # what is not finite has no velocities, and stops the run
            viscosity = self.law.viscosity(squared + 1j * SMALL)
        implicit = viscosity.real + squared * viscosity.imag / SMALL
        numbers = viscosity.real[:, None] * strain, strain, np.stack([vorticity, implicit], axis=1)
        view(self.derived)[: self.points.fluid] = np.concatenate(numbers, axis=1)

    def take_up(self, velocity, step):
        """Find the stress at the end of a ``step``."""
        self.begin()

    def wall_stress(self):
        """Return the stress (3, count) at the points on walls."""
        return view(self.derived)[self.n_fluid : self.points.fluid, :3].T.astype(float)

    def implicit_wall_stress(self, strain):
        """Return the stress (3, count) at the points on walls in a step in which 2 D is ``strain`` there."""
        derived = view(self.derived)[self.n_fluid : self.points.fluid].T.astype(float)
        return derived[:3] + derived[7] * (strain - derived[3:6])

    @ti.func
    def implicit_viscosity(self, i):
        """Return nu* at a point."""
        return self.derived[i][self.numbers - 1]

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.particles[None]):
            self.d_dx[i], self.d_dy[i] = gradients(self.unweighted, velocity, i)

    @ti.kernel
    def add_force(self, known: ti.template(), dt: float, viscosity: float):
        """Divergence of the stress less that of the implicit part, in place of the one before; and its operators."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.unweighted, self.derived, i)
            implicit = self.implicit_viscosity(i)
            strain = ti.Vector([d_dx[3] + d_dy[4], d_dx[4] + d_dy[5]])
            force = ti.Vector([d_dx[0] + d_dy[1], d_dx[1] + d_dy[2]]) - implicit * strain
            self.implicit_divergence[i] = dt * (d_dy[7] * d_dx[6] - d_dx[7] * d_dy[6])
            known[i] += dt * (force - self.force[i])
            self.force[i] = force
            self.weigh(i, implicit / viscosity)

    @ti.func
    def weigh(self, i, factor):
        """Let the operators of a particle be ``factor`` times those without a viscosity."""
        self.operators.diagonal[i] = factor * self.unweighted.diagonal[i]
        for k in range(self.points.count[i]):
            self.operators.laplacian[i, k] = factor * self.unweighted.laplacian[i, k]
            if ti.static(self.levels.coordinates.axisymmetric):
                self.operators.d_dy[i, k] = factor * self.unweighted.d_dy[i, k]
