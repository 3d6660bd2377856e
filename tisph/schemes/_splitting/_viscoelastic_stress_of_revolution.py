"""Polymer stress in axisymmetric flow without swirl: the conformation has xx, xr, rr and tt, t being around the axis.

As in planar flow, with the velocity gradient L_xx, L_xr, L_rx, L_rr and L_tt = v/r. Differentiated are the logarithm P
of the conformation with P_xr/r in place of P_xr, which is odd in r; the force of a stress T is

    dT_xx/dx + dT_xr/dr + T_xr/r,   dT_xr/dx + dT_rr/dr + (T_rr - T_tt)/r.

T_rr and T_tt are equal on the axis: their logarithms change by L_rr and L_tt, which differ by r^2 times d(v/r)/ds.
"""

import numpy as np

from tisph.runtime import ti, view
from tisph.schemes._local_newton import SMALL, Modes
from tisph.schemes._splitting._bdf import ORDER
from tisph.schemes._splitting._log_conformation import conformation_excess, logarithm
from tisph.schemes._splitting._time_levels import gradients, transfer
from tisph.schemes._splitting._viscoelastic_stress import ViscoelasticStress

XR = 1


@ti.data_oriented
class ViscoelasticStressOfRevolution(ViscoelasticStress):
    """As ``ViscoelasticStress``, all modes with four components; ``tensors`` have P_xr/r in place of P_xr.

    ``powers`` of r that components of P are divided by, in pairs with their indices.
    """

    velocities, gradient_numbers, stress_numbers = 3, 5, 4
    kind, powers, swirls = Modes, ((XR, 1),), False
    conformation_excess, logarithm = staticmethod(conformation_excess), staticmethod(logarithm)

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

    def times_radius(self, values, radius):
        """Return ``values`` (..., numbers of all modes, n) times the ``powers`` of a ``radius`` (n,)."""
        result = np.array(values)
        for component, power in self.powers:
            result[..., component :: self.stress_numbers, :] *= radius**power
        return result

    def logarithms(self, modes):
        """Return the P that a start with these C of the modes has, as ``tensors`` have it."""
        padded = [[*mode, *(self.stress_numbers - len(mode)) * [0.0 * mode[0]]] for mode in modes]
        return self.times_radius(np.concatenate([self.logarithm(mode) for mode in padded]), 1.0 / self.radius)

    def on_paths(self):
        """Return P (levels, numbers, points) of the particles at the last time levels."""
        return self.times_radius(self.states.astype(float), self.radius * self.ratio)

    def store(self):
        """Store P at the end of a step as the newest level."""
        earlier = self.times_radius(self.states[:-1], self.ratio)
        self.states[1:] = earlier
        self.states[0] = self.times_radius(self.state, 1.0 / self.radius)

    def solenoidal(self, gradient):
        """Take the divergence, an error, off a velocity gradient (5, points)."""
        gradient[0] -= gradient[0] + gradient[3] + gradient[4]

    def implicit(self):
        """Return 2 nu* D with its component xr over r."""
        xx, xr, rx, rr, tt = self.gradients[:5]
        return self.viscosity * np.stack([2.0 * xx, (xr + rx) / self.radius, 2.0 * rr, 2.0 * tt])

    def differentiated(self):
        """Return P as it is differentiated."""
        return self.times_radius(self.state, 1.0 / self.radius)

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

    def spatial_derivatives(self, d_dx, d_ds):
        """Return the derivatives of P by x and r, but for those of the ``powers``, of those of ``tensors``."""
        radius = self.radius
        return self.times_radius(d_dx.T, radius).T, (radius * self.times_radius(d_ds.T, radius)).T

    def wall_stress(self):
        """Return the stress (5, count) at the points on walls: xx, xr, rr, and none around the axis."""
        state = self.times_radius(self.states[0].astype(float), self.radius)[:, self.n_fluid :]
        return self.traction_rows(self.modes.stress(state, self.stress_numbers))

    def implicit_wall_stress(self, strain):
        """Return the stress (5, count) at the points on walls in a step in which 2 D is ``strain`` there."""
        walls = slice(self.n_fluid, self.points.fluid)
        implicit = self.times_radius(view(self.implicit_stress)[: self.points.fluid].T.astype(float), self.radius)
        stress = self.modes.stress(self.state[:, walls], self.stress_numbers) - implicit[:, walls]
        return self.traction_rows(stress) + self.viscosity * strain

    def traction_rows(self, stress):
        """Return the components (5, count) of a stress that tractions are made of."""
        return np.concatenate([stress[:3], np.zeros((2, stress.shape[1]))])

    def at(self, times, offset, tensors, radius):
        """Return the stresses xx, xr, rr and tt a time ``offset`` before the end of the last step, of ``tensors``."""
        levels = tensors.reshape(len(tensors), ORDER, self.size)
        weights = times.interpolation(offset, ORDER)
        state = np.einsum("a,nac->cn", weights, levels) if offset else levels[:, 0].T
        return self.modes.stress(self.times_radius(state, radius), self.stress_numbers)

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

    @ti.kernel
    def add_stress_force(self, known: ti.template(), dt: float):
        """Divergence of the stress less that of the implicit viscosity, instead of the one before."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, self.implicit_stress, i)
            own, square = self.implicit_stress[i], self.levels.coordinates.radius(i) ** 2
            implicit = ti.Vector([d_dx[0] + 2.0 * own[1] + square * d_dy[1], 0.0, 0.0])
            implicit[1] = d_dx[1] + d_dy[2] + (own[2] - own[3]) / square
            if ti.static(self.swirls):
                implicit[2] = d_dx[4] + 4.0 * own[5] + square * d_dy[5]
            force = self.stress_divergence[i] - implicit
            known[i] += dt * (force - self.force[i])
            self.force[i] = force

    @ti.kernel
    def remap(self):
        """Transfer all levels with a shift."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            moved = self.levels.coordinates.shifted(i, self.levels.shift.moved[i])
            self.tensors[i] += transfer(self.operators, self.d_dx, self.d_dy, i, moved)
