"""Polymer stress in axisymmetric flow: without swirl the conformation has xx, xr, rr and tt, t being around the axis.

As in planar flow, with the velocity gradient L_xx, L_xr, L_rx, L_rr and L_tt = v/r. Differentiated are the logarithm P
of the conformation with P_xr/r in place of P_xr, which is odd in r; the force of a stress T is

    dT_xx/dx + dT_xr/dr + T_xr/r,   dT_xr/dx + dT_rr/dr + (T_rr - T_tt)/r.

T_rr and T_tt are equal on the axis: their logarithms change by L_rr and L_tt, which differ by r^2 times d(v/r)/ds.

With swirl it has all six components, xx, xr, rr, tt, xt and rt. The velocity gradient is that less the rotation w/r of
the axes r and t along the path of a particle: it also has L_tx = dw/dx and L_tr = dw/dr - w/r, and nothing in place of
xt and rt. Differentiated are P_xt/r and P_rt/r^2; a stress T exerts the force dT_xt/dx + dT_rt/dr + 2 T_rt/r around the
axis.
"""

import numpy as np

from tisph.runtime import ti, view
from tisph.schemes._local_newton import SMALL, Modes
from tisph.schemes._splitting._log_conformation_with_swirl import ModesWithSwirl, conformation_excess, logarithm, rate
from tisph.schemes._splitting._time_levels import gradients
from tisph.schemes._splitting._viscoelastic_stress import ViscoelasticStress

XR, XT, RT = 1, 4, 5


@ti.data_oriented
class ViscoelasticStressOfRevolution(ViscoelasticStress):
    """As ``ViscoelasticStress``, all modes with four components; ``tensors`` have P_xr/r in place of P_xr."""

    velocities, gradient_numbers, stress_numbers = 3, 5, 4
    kind, powers, swirls = Modes, ((XR, 1),), False

    def modes_of(self, problem):
        """Return the modes in three dimensions."""
        fluid = problem.rheology, problem.kinematic_viscosity
        modes = self.kind(*fluid, self.conformation_excess, self.stress_numbers)
        for law in modes.laws:
            law.in_three_dimensions()
        return modes

    @property
    def radius(self):
        """Distances (points,) from the axis at the end of the step."""
        return view(self.points.position)[: self.points.fluid, 1].astype(float) + self.origin[1]

    @property
    def ratio(self):
        """Distances before the step over those after it, 1 of points on walls."""
        ratio, fluid = np.ones(self.points.fluid), slice(self.n_fluid)
        ratio[fluid] = (view(self.levels.position)[fluid, 1] + self.origin[1]) / self.radius[fluid]
        return ratio

    def logarithms(self, modes):
        """Return the P that a start with these C of the modes has, as ``tensors`` have it."""
        return super().logarithms([[*mode, *(self.stress_numbers - len(mode)) * [0.0 * mode[0]]] for mode in modes])

    def solenoidal(self, gradient):
        """Take the divergence, an error, off a velocity gradient (5, points)."""
        gradient[0] -= gradient[0] + gradient[3] + gradient[4]

    def implicit(self):
        """Return 2 nu* D with its component xr over r."""
        xx, xr, rx, rr, tt = self.gradients[:5]
        return self.viscosity * np.stack([2.0 * xx, (xr + rx) / self.radius, 2.0 * rr, 2.0 * tt])

    def force_of_stress(self, d_dx, d_ds):
        """Return the force (3, points), over r but for the first, of derivatives (numbers, points) by x and s."""
        radius, numbers = self.radius, self.stress_numbers
        along, across = self.times_radius(d_dx, radius), radius * self.times_radius(d_ds, radius)
        for component, power in self.powers:
            across[component::numbers] += power * self.state[component::numbers] / radius
        stress = self.modes.stress(self.state, numbers)
        by_x, by_r = (
            np.imag(self.modes.stress(self.state + 1j * SMALL * change, numbers)) / SMALL for change in (along, across)
        )
        first = by_x[0] + by_r[1] + stress[1] / radius
        second = (by_x[1] + by_r[2] + (stress[2] - stress[3]) / radius) / radius
        return np.stack([first, second, self.force_around(stress, by_x, by_r)])

    def force_around(self, stress, by_x, by_r):
        """Return the force (points,) around the axis over r of a ``stress`` and its derivatives by x and r."""
        return np.zeros_like(self.radius)

    def traction_rows(self, stress):
        """Return the components (5, count) of a stress that tractions are made of: xx, xr, rr, none around the axis."""
        return np.concatenate([stress[:3], np.zeros((2, stress.shape[1]))])

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points: xx, xr, rx, rr, tt, and with swirl tx, tr."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, velocity, i)
            radius, across = self.levels.coordinates.radius(i), velocity[i].y
            radial = across + radius * radius * d_dy.y
            plane = ti.Vector([d_dx.x, radius * d_dy.x, radius * d_dx.y, radial, across])
            for number in ti.static(range(5)):
                self.gradient[i][number] = plane[number]
            if ti.static(self.swirls):
                self.gradient[i][5] = radius * d_dx.z
                self.gradient[i][6] = radius * radius * d_dy.z


@ti.data_oriented
class ViscoelasticStressWithSwirl(ViscoelasticStressOfRevolution):
    """As ``ViscoelasticStressOfRevolution``, with six components."""

    gradient_numbers, stress_numbers = 7, 6
    kind, powers, swirls = ModesWithSwirl, ((XR, 1), (XT, 1), (RT, 2)), True
    conformation_excess, logarithm = staticmethod(conformation_excess), staticmethod(logarithm)
    rate = staticmethod(rate)

    def implicit(self):
        """Return 2 nu* D with its components xr and xt over r, and rt over r^2."""
        around = np.stack([self.gradients[5] / self.radius, self.gradients[6] / self.radius**2])
        return np.concatenate([super().implicit(), self.viscosity * around])

    def take_known(self, gradient):
        """Let a velocity gradient (7, count) at the points on walls be what is known of it there."""
        super().take_known(gradient)
        gradient[5:] = self.walls.gradient_around(gradient[5:])

    def force_around(self, stress, by_x, by_r):
        """Return the force (points,) around the axis over r of a ``stress`` and its derivatives by x and r."""
        return (by_x[XT] + by_r[RT] + 2.0 * stress[RT] / self.radius) / self.radius

    def traction_rows(self, stress):
        """Return the components (5, count) of a stress that tractions are made of."""
        return stress[[0, 1, 2, XT, RT]]
