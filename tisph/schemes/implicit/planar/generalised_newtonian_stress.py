"""Stress of a generalised Newtonian fluid in planar and axisymmetric flow: 2 nu D, its viscosity nu a function of D.

With L = grad u, D its symmetric part without trace, and q = 2 D:D, the square of the shear rate, the velocities obey

    gamma_0 u - dt nu* L u = u^ - dt G p + dt [div (2 nu D) - nu* div (2 D)],    nu* = d(nu q)/dq,

L u the Laplacian by its own operator, both divergences by the operators of first derivatives. These hardly see
differences between neighbouring particles, which the Laplacian damps; of smooth velocities both parts of nu* cancel to
the order of the operators. It is the stress that is differentiated and not the viscosity, which may change tenfold from
one particle to the next where the stress does not, at the front of a layer or the edge of a plug: with nu lap u + 2 D
grad nu a power law, n = 0.5, came to rest between cylinders in a flow whose torques differed by a factor of 7.

The bracket is first computed from the extrapolated velocities, then from the velocities found with it. A change of the
shear rate meets the viscosity nu + 2 q dnu/dq, one across it nu. Their mean is nu*, so that each outer iteration
reduces errors by (1 - n)/(1 + n) where the viscosity is a power n - 1 of the rate, however much it varies over the
fluid. With the largest viscosity of all as nu* they would remain where the viscosity is low, and extrapolation from
four levels is unstable then.

The pressure also has to balance the divergence of nu* L u, grad nu* . lap u, with lap u = -curl of the vorticity; for a
constant viscosity it is 0. Written as a divergence it would be unstable: errors of the pressure would
return undiminished from one outer iteration to the next.

In axisymmetric flow with swirl the components of 2 D that are odd in r are divided by it, and the component of r and
the direction t around the axis by r^2, so that all are even and the operators of ``coordinates`` hold:

    xx 2 du/dx,   xr/r du/ds + dV/dx,   rr 2 (V + r^2 dV/ds),   tt 2 V,   xt/r dW/dx,   rt/r^2 dW/ds.

A stress T with such components exerts the force, the last two over r,

    dT_xx/dx + 2 T_xr + r^2 dT_xr/ds,   dT_xr/dx + dT_rr/ds + (T_rr - T_tt)/r^2,   dT_xt/dx + 4 T_rt + r^2 dT_rt/ds.
"""

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tisph.rheology import newtonian
from tisph.runtime import real, ti, view
from tisph.schemes._local_newton import SMALL
from tisph.schemes.implicit.planar.parts import ExtraStress, rate_squared
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import TimeLevels, gradients

XX, XR, RR, TT, XT, RT = range(6)
"""Components of revolution."""


@ti.data_oriented
class GeneralisedNewtonianStress(ExtraStress):
    """Of a fluid whose ``law`` gives a viscosity (``tisph/rheology``), per unit density as all else.

    ``operators`` are those that the velocities are solved with, the Laplacian of each particle times its nu* over the
    ``viscosity``. ``derived``: numbers that are differentiated, 2 nu D and, from ``strain`` on, 2 D (xx, xy, yy
    each), vorticity and nu*; ``implicit_divergence``: dt grad nu* . lap u. ``added_force``: nu* (lap u - div (2 D)) at
    the end of a step, 0 but for the errors of the operators.
    """

    nonlinear, resolution_name = True, "added_power"

    def __init__(self, levels: TimeLevels, problem: Problem) -> None:
        self.axisymmetric, self.lowest_radius = problem.axisymmetric, problem.origin[1]
        self.strain = 6 if self.axisymmetric else 3
        self.numbers = 2 * self.strain + 2
        self.levels, self.points = levels, levels.points
        self.fields: tuple[Any, ...] = ()
        self.parts: Mapping[str, Any] = {}
        self.viscosity = problem.kinematic_viscosity
        rheology = problem.rheology or newtonian.Parameters()
        self.law, self.factor = rheology.law(self.viscosity, problem.density), 1.0
        self.unweighted, self.operators = levels.operators, copy.copy(levels.operators)
        self.operators.laplacian = ti.field(real(), levels.operators.laplacian.shape)
        self.derived = ti.field(ti.types.vector(self.numbers, real()), self.points.slots + 1)
        vector = ti.types.vector(levels.components, real())
        self.d_dx, self.d_dy, self.added_force = (ti.field(vector, self.points.capacity) for _ in range(3))
        self.implicit_divergence, self.operators.diagonal = (ti.field(real(), self.points.capacity) for _ in range(2))
        if self.axisymmetric:
            self.operators.d_dy = ti.field(real(), levels.operators.d_dy.shape)

    @property
    def radius(self) -> Any:
        """Distances (points,) from the axis; 1 in planar flow."""
        if not self.axisymmetric:
            return 1.0
        return view(self.points.position)[: self.points.fluid, 1].astype(float) + self.lowest_radius

    def begin(self, values: Sequence[np.ndarray] = ()) -> None:
        """Find the stress of the newest velocities, whose gradients are measured."""
        self.find(self.levels.fields, self.levels.d_dx, self.levels.d_dy)

    def add_stress(self, velocity: Any, forcing: Any, dt: float) -> None:
        """Add dt times the divergence of the stress of a ``velocity`` to the ``forcing``; weigh the operators."""
        self.measure(velocity)
        self.find(velocity, self.d_dx, self.d_dy)
        self.add_force(forcing, dt, self.viscosity)

    def find(self, velocity: Any, d_dx: Any, d_dy: Any) -> None:
        """Find stress and viscosities for a velocity: it and its gradients are the first numbers of these fields.

        In axisymmetric flow 2 D has nothing of the divergence, which is an error.
        """
        fluid, components = slice(self.points.fluid), self.levels.components
        by_x, by_y = (view(field)[fluid, :components].T.astype(float) for field in (d_dx, d_dy))
        if not self.axisymmetric:
            along, shear = by_x[0] - by_y[1], by_x[1] + by_y[0]
            self.derive(np.stack([along, shear, -along], axis=1), along**2 + shear**2, by_x[1] - by_y[0])
            return
        (_, v_x, w_x), (u_s, v_s, w_s) = by_x, by_y
        across, square = view(velocity)[fluid, 1].astype(float), self.radius**2
        radial = across + square * v_s
        strain = np.stack([-2.0 * (across + radial), u_s + v_x, 2.0 * radial, 2.0 * across, w_x, w_s], axis=1)
        diagonal = 0.5 * (strain[:, XX] ** 2 + strain[:, RR] ** 2 + strain[:, TT] ** 2)
        shear = square * (strain[:, XR] ** 2 + strain[:, XT] ** 2 + square * strain[:, RT] ** 2)
        self.derive(strain, diagonal + shear, v_x - u_s)

    def derive(self, strain: np.ndarray, squared: np.ndarray, vorticity: np.ndarray) -> None:
        """Take up 2 D (points, numbers), q and the vorticity (points,), and find the viscosities."""
        with np.errstate(all="ignore"):  # numbers that are not finite have no velocities, and stop the run
            viscosity = self.local_law(squared + 1j * SMALL)
        implicit = viscosity.real + squared * viscosity.imag / SMALL
        numbers = viscosity.real[:, None] * strain, strain, np.stack([vorticity, implicit], axis=1)
        view(self.derived)[: self.points.fluid] = np.concatenate(numbers, axis=1)
        self.dissipation = viscosity.real * squared

    def local_law(self, squared: Any) -> Any:
        """Return the viscosity (points,) at the square of the shear rate: a nu(a^2 q), a being the ``factor``."""
        return self.factor * self.law.viscosity(self.factor**2 * squared)

    def set_factor(self, factor: Any) -> None:
        """Take the ``factor`` a (points,) of viscosity and times of the law that the temperature has."""
        self.factor = factor

    def power(self, strain: np.ndarray, viscosity: float) -> np.ndarray:
        """Return the power (points,) of the stress per mass for 2 D = ``strain``; see ``ExtraStress.power``."""
        squared = rate_squared(strain)
        return self.local_law(squared) * squared

    def store(self, velocity: Any, step: int) -> float | None:
        """Find the stress at the end of a ``step``; return the power of ``added_force`` over the dissipation nu q.

        The sums are over the fluid, by areas, and the velocity u along x is relative to the mean one of the walls, or
        without walls of the fluid. The dissipation is None at rest.
        """
        self.begin()
        self.find_added_force(velocity)
        fluid, areas = slice(self.points.in_fluid), self.points.areas if self.points.graded else None
        radius = np.broadcast_to(self.radius, self.points.fluid)[fluid]
        speed, at_walls = (view(velocity)[part].astype(float) for part in (fluid, self.points.on_walls))
        speed[:, 0] -= at_walls[:, 0].mean() if len(at_walls) else np.average(speed[:, 0], weights=areas)
        power = speed * view(self.added_force)[fluid]
        power[:, 1:] *= radius[:, None] ** 2
        weight = radius if areas is None else areas * radius
        dissipation = weight @ self.dissipation[fluid]
        return abs(float((weight @ power).sum() / dissipation)) if dissipation > 0.0 else None

    def wall_stress(self) -> np.ndarray:
        """Return the stress (numbers, count) at the points on walls: xx, xy, yy, in axisymmetric flow xt and yt."""
        return self._at_walls(0)

    def implicit_wall_stress(self, strain: np.ndarray) -> np.ndarray:
        """Return the stress at the points on walls in a step in which 2 D is ``strain`` (numbers, count) there."""
        implicit = view(self.derived)[self.points.on_walls, self.numbers - 1].astype(float)
        return self._at_walls(0) + implicit * (strain - self._at_walls(self.strain))

    def _at_walls(self, first: Any) -> np.ndarray:
        points = self.points.on_walls
        found = view(self.derived)[points, first : first + self.strain].T.astype(float)
        if not self.axisymmetric:
            return found
        radius = self.radius[points]
        return np.stack([found[XX], radius * found[XR], found[RR], radius * found[XT], radius**2 * found[RT]])

    @ti.func
    def implicit_viscosity(self, i):
        """Return nu* at a point."""
        return self.derived[i][self.numbers - 1]

    @ti.func
    def local_viscosity(self, i, viscosity):
        """Return nu* at a point, in place of the constant ``viscosity`` of a step."""
        return self.implicit_viscosity(i)

    def local_viscosities(self, viscosity: float, points: int) -> np.ndarray:
        """Return nu* (points,), in place of the constant ``viscosity`` of a step."""
        return view(self.derived)[:points, self.numbers - 1].astype(float)

    @ti.func
    def with_viscous_divergence(self, i, divergence):
        """Return a ``divergence`` plus the divergence of the implicit viscous term, dt grad nu* . lap u."""
        return divergence + self.implicit_divergence[i]

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.particles[None]):
            self.d_dx[i], self.d_dy[i] = gradients(self.unweighted, velocity, i)

    @ti.kernel
    def add_force(self, forcing: ti.template(), dt: float, viscosity: float):
        """Add dt [div (2 nu D) - nu* div (2 D)]; weigh the operators."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.unweighted, self.derived, i)
            implicit, square = self.implicit_viscosity(i), self.levels.coordinates.radius(i) ** 2
            strain = self.levels.coordinates.divergence(i, self.derived, self.strain, d_dx, d_dy)
            force = self.levels.coordinates.divergence(i, self.derived, 0, d_dx, d_dy) - implicit * strain
            last = ti.static(self.numbers - 1)
            vortex = self.levels.coordinates.hoop(self.derived[i][last - 1]) + square * d_dy[last - 1]
            self.implicit_divergence[i] = dt * (square * d_dy[last] * d_dx[last - 1] - d_dx[last] * vortex)
            forcing[i] += dt * force
            self.weigh(i, implicit / viscosity)

    @ti.kernel
    def find_added_force(self, velocity: ti.template()):
        """Find the ``added_force`` of a velocity whose ``derived`` numbers are known."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.n_fluid[None]):
            d_dx, d_dy = gradients(self.unweighted, self.derived, i)
            force = self.unweighted.apply(self.unweighted.laplacian, velocity, i)
            if ti.static(self.levels.coordinates.axisymmetric):
                force += self.unweighted.hoop(velocity, i)
            force -= self.levels.coordinates.divergence(i, self.derived, self.strain, d_dx, d_dy)
            self.added_force[i] = self.implicit_viscosity(i) * force

    @ti.func
    def weigh(self, i, factor):
        """Let the operators of a particle be ``factor`` times those without a viscosity."""
        self.operators.diagonal[i] = factor * self.unweighted.diagonal[i]
        for k in range(self.points.begin[i], self.points.end[i]):
            self.operators.laplacian[k] = factor * self.unweighted.laplacian[k]
            if ti.static(self.levels.coordinates.axisymmetric):
                self.operators.d_dy[k] = factor * self.unweighted.d_dy[k]
