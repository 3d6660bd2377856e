"""Stress of a generalised Newtonian fluid in axisymmetric flow with swirl.

As in planar flow; the components of 2 D that are odd in r are divided by it, and that of r and the direction t around
the axis by r^2, so that all are even and the operators of ``_coordinates`` hold:

    xx 2 du/dx,   xr/r du/ds + dV/dx,   rr 2 (V + r^2 dV/ds),   tt 2 V,   xt/r dW/dx,   rt/r^2 dW/ds.

A stress T with such components exerts the force, the last two over r,

    dT_xx/dx + 2 T_xr + r^2 dT_xr/ds,   dT_xr/dx + dT_rr/ds + (T_rr - T_tt)/r^2,   dT_xt/dx + 4 T_rt + r^2 dT_rt/ds.
"""

import numpy as np

from tisph.runtime import real, ti, view
from tisph.schemes._splitting._generalised_newtonian_stress import GeneralisedNewtonianStress
from tisph.schemes._splitting._time_levels import gradients

XX, XR, RR, TT, XT, RT = range(6)


@ti.data_oriented
class GeneralisedNewtonianStressOfRevolution(GeneralisedNewtonianStress):
    """As ``GeneralisedNewtonianStress``; the operators that velocities are solved with have a weighted d/ds, too."""

    numbers, components = 14, 3

    def __init__(self, levels, problem):
        super().__init__(levels, problem)
        self.lowest_radius = problem.origin[1]
        self.operators.d_dy = ti.field(real(), levels.operators.d_dy.shape)

    @property
    def radius(self):
        """Distances (points,) from the axis."""
        return view(self.points.position)[: self.points.fluid, 1].astype(float) + self.lowest_radius

    def find(self, velocity, d_dx, d_dy):
        """Find stress and viscosities; of the divergence, which is an error, 2 D has nothing."""
        (_, v_x, w_x), (u_s, v_s, w_s) = (
            view(field)[: self.points.fluid, :3].T.astype(float) for field in (d_dx, d_dy)
        )
        across, square = view(velocity)[: self.points.fluid, 1].astype(float), self.radius**2
        radial = across + square * v_s
        strain = np.stack([-2.0 * (across + radial), u_s + v_x, 2.0 * radial, 2.0 * across, w_x, w_s], axis=1)
        diagonal = 0.5 * (strain[:, XX] ** 2 + strain[:, RR] ** 2 + strain[:, TT] ** 2)
        shear = square * (strain[:, XR] ** 2 + strain[:, XT] ** 2 + square * strain[:, RT] ** 2)
        self.derive(strain, diagonal + shear, v_x - u_s)

    def wall_stress(self):
        """Return the stress (5, count) at the points on walls: xx, xr, rr, and of x and r with t."""
        return self._at_walls(slice(0, 6))

    def implicit_wall_stress(self, strain):
        """Return the stress (5, count) at the points on walls in a step in which 2 D is ``strain`` there."""
        implicit = view(self.derived)[self.n_fluid : self.points.fluid, -1].astype(float)
        return self.wall_stress() + implicit * (strain - self._at_walls(slice(6, 12)))

    def _at_walls(self, part):
        points, radius = slice(self.n_fluid, self.points.fluid), self.radius[self.n_fluid :]
        found = view(self.derived)[points, part].T.astype(float)
        return np.stack([found[XX], radius * found[XR], found[RR], radius * found[XT], radius**2 * found[RT]])

    @ti.func
    def divergence(self, i, first: ti.template(), d_dx, d_dy):
        """Return the force of the stress whose components begin at ``first`` of what is derived."""
        own, square = self.derived[i], self.levels.coordinates.radius(i) ** 2
        hoop = (own[first + RR] - own[first + TT]) / square
        return ti.Vector(
            [
                d_dx[first + XX] + 2.0 * own[first + XR] + square * d_dy[first + XR],
                d_dx[first + XR] + d_dy[first + RR] + hoop,
                d_dx[first + XT] + 4.0 * own[first + RT] + square * d_dy[first + RT],
            ]
        )

    @ti.kernel
    def add_force(self, known: ti.template(), dt: float, viscosity: float):
        """Divergence of the stress less that of the implicit part, in place of the one before; and its operators."""
        ti.loop_config(serialize=self.unweighted.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.unweighted, self.derived, i)
            implicit, square = self.implicit_viscosity(i), self.levels.coordinates.radius(i) ** 2
            force = self.divergence(i, 0, d_dx, d_dy) - implicit * self.divergence(i, 6, d_dx, d_dy)
            vortex = 2.0 * self.derived[i][12] + square * d_dy[12]
            self.implicit_divergence[i] = dt * (square * d_dy[13] * d_dx[12] - d_dx[13] * vortex)
            known[i] += dt * (force - self.force[i])
            self.force[i] = force
            self.weigh(i, implicit / viscosity)
