"""Polymer stress in two-dimensional flow: particles carry the conformation, which obeys an ODE along their paths.

Backward differences of the logarithm P of the conformation tensor, of the same order and for the same steps dt as those
of the velocities,

    gamma_0 P = sum_q alpha_q P^(n+1-q) + dt F(P, L),    L = grad u, F as in ``log_conformation.py``,

are solved particle by particle for given L. At rest a small change of L changes the stress S by 2 nu* D, with
D = (L + L^T)/2 and

    nu* = sum over the modes of (nu_p/lambda) dt / (gamma_0 + dt/lambda).

So the momentum equation is solved with the viscosity nu_s + nu*, by the same operators and solvers as without polymer,
and with the force div S - 2 nu* div D, in which that part of S has cancelled. A stretched polymer responds more along
its longest axis, by the largest eigenvalue of A, and less across. Where velocities and pressure are solved for
together, nu* of each point is the mean of both responses, nu* at rest times tr A/2: an outer iteration then reduces the
error of the one before, whatever A and dt are. Gradients of S are gradients of P times
dS/dP: near walls S rises by orders of magnitude within a few spacings, and P does not. S is first computed from the
extrapolated velocities, and then from the velocities found with it: these two outer iterations have to resolve the
advection and the stretching of the present stress. Points on walls belong to the fluid, and carry a stress like any
other; there L is a shear along the wall, since the velocity along it is known. With L as measured, stress grew at them
(12 spacings between cylinders, Wi = 2.7 at the inner one, a solvent fraction of 0.1: by e in two relaxation times).

In axisymmetric flow without swirl the conformation has xx, xr, rr and tt, t being around the axis, and the velocity
gradient L_xx, L_xr, L_rx, L_rr and L_tt = v/r. Differentiated is the logarithm P of the conformation with P_xr/r in
place of P_xr, which is odd in r; the force of a stress T is

    dT_xx/dx + dT_xr/dr + T_xr/r,   dT_xr/dx + dT_rr/dr + (T_rr - T_tt)/r.

T_rr and T_tt are equal on the axis: their logarithms change by L_rr and L_tt, which differ by r^2 times d(v/r)/ds.

With swirl it has all six components, xx, xr, rr, tt, xt and rt. From the velocity gradient the rotation w/r of the axes
r and t along the path of a particle is subtracted: it also has L_tx = dw/dx and L_tr = dw/dr - w/r, and L_xt and L_rt
are 0. Differentiated are P_xt/r and P_rt/r^2; a stress T exerts the force dT_xt/dx + dT_rt/dr + 2 T_rt/r around the
axis.

Sources: R. Guenette and M. Fortin, J. Non-Newtonian Fluid Mech. 60 (1995) 27-52 (a viscosity on both sides).
"""

import math
from collections.abc import Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from tisph.errors import DivergedError
from tisph.runtime import real, ti, view
from tisph.schemes._local_newton import SMALL, Modes, matrix, solve
from tisph.schemes.implicit.planar import log_conformation, log_conformation_with_swirl
from tisph.schemes.implicit.planar.log_conformation_with_swirl import ModesWithSwirl, change_of_logarithm
from tisph.schemes.implicit.planar.parts import ExtraStress
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import ORDER, TimeLevels, TimeWeights, gradients, transfer
from tisph.schemes.implicit.planar.wall_points import WallPoints, WallsOfRevolution

MAX_LOG_JUMP = 5.0
"""Change of P within a spacing above which a run stops: A changes 150-fold from one particle to the next."""

XR, XT, RT = 1, 4, 5
"""Indices of components that are odd in the radius, or of second order in it."""


class Components(NamedTuple):
    """Components of the tensors of one kind of flow.

    ``gradient``: number of components of the velocity gradient: xx, xy, yx, yy, then tt, then tx and ty. ``stress``:
    number of components of the stress: xx, xy, yy, then tt, then xt and yt. ``powers``: indices of components of P, and
    the powers of the radius by which these are divided where they are differentiated. ``algebra``: module with the
    functions of P; ``modes``: class of the modes.
    """

    gradient: int
    stress: int
    powers: tuple[tuple[int, int], ...]
    algebra: ModuleType
    modes: type[Modes]


COMPONENTS = {
    "planar": Components(4, 3, (), log_conformation, Modes),
    "axisymmetric": Components(5, 4, ((XR, 1),), log_conformation, Modes),
    "with swirl": Components(7, 6, ((XR, 1), (XT, 1), (RT, 2)), log_conformation_with_swirl, ModesWithSwirl),
}


@ti.data_oriented
class ViscoelasticStress(ExtraStress):
    """``tensors`` (fluid): P of all modes at the ends of the last steps, newest first.

    In axisymmetric flow components of P are divided by ``powers`` of the radius there, in pairs with their indices.
    ``local``: whether each point has its own nu*, the ``response`` of its polymer; else that is 1, and ``viscosity`` is
    nu* at rest.
    """

    nonlinear, resolution_name = True, "steepest"

    def __init__(self, levels: TimeLevels, problem: Problem, local: bool) -> None:
        self.levels, self.operators, self.points = levels, levels.operators, levels.points
        self.walls = problem.walls
        self.origin, self.spacing = problem.origin, problem.spacing
        self.initial_conformation_excess = problem.initial_conformation_excess
        self.source, self.places = problem.conformation_source, problem.places
        self.given_gradient = problem.kinematics_gradient
        self.axisymmetric, self.swirls = problem.axisymmetric, problem.swirls
        kind = COMPONENTS["with swirl" if self.swirls else "axisymmetric" if self.axisymmetric else "planar"]
        self.powers, self.stress_numbers, self.algebra = kind.powers, kind.stress, kind.algebra
        components = kind.stress if self.axisymmetric else None  # of each mode; in planar flow its law has them
        excess = kind.algebra.conformation_excess
        self.modes = kind.modes(problem.rheology, problem.kinematic_viscosity, excess, components)
        for law in self.modes.laws if self.axisymmetric else ():
            law.in_three_dimensions()
        self.size = self.modes.components
        self.tensors, self.d_dx, self.d_dy = self._three(ORDER * self.size)
        self.current, self.current_d_dx, self.current_d_dy = self._three(self.size)
        self.points.count(self.tensors)
        self.d_dx.used = self.d_dy.used = None
        self.gradient = ti.field(ti.types.vector(kind.gradient, real()), self.points.capacity)
        self.implicit_stress = ti.field(ti.types.vector(self.stress_numbers, real()), self.points.slots + 1)
        self.stress_divergence = ti.field(ti.types.vector(levels.components, real()), self.points.capacity)
        self.fields, self.viscosity, self.parts = (self.tensors,), 0.0, {"polymer": self}
        self.local, self.response = local, ti.field(real(), self.points.capacity)
        self.response.used = None
        view(self.response)[...] = 1.0
        scratch = self.gradient, self.implicit_stress, self.stress_divergence
        for field in (*scratch, self.current, self.current_d_dx, self.current_d_dy):
            field.used = None

    @property
    def all_places(self) -> Any:
        """Places x, y (points,) of all points in the frame of the scene at the end of the step."""
        return self.places(view(self.points.position)[: self.points.fluid].astype(float))

    @property
    def radius(self) -> Any:
        """Distances (points,) from the axis at the end of the step; 1 in planar flow."""
        if not self.axisymmetric:
            return 1.0
        return view(self.points.position)[: self.points.fluid, 1].astype(float) + self.origin[1]

    @property
    def ratio(self) -> Any:
        """Distances from the axis before the step over those after it, 1 in planar flow and at walls without slip."""
        if not self.axisymmetric:
            return 1.0
        ratio, moving = np.ones(self.points.fluid), np.ones(self.points.fluid, dtype=bool)
        if self.walls:
            moving[self.points.in_fluid :] = self.walls.slip_length > 0.0
        ratio[moving] = (view(self.levels.position)[: len(ratio), 1][moving] + self.origin[1]) / self.radius[moving]
        return ratio

    def times_radius(self, values: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return ``values`` (..., numbers of all modes, n) times the ``powers`` of a ``radius`` (n,)."""
        result = np.array(values) if self.powers else values
        for component, power in self.powers:
            result[..., component :: self.stress_numbers, :] *= radius**power
        return result

    def _three(self, numbers: int) -> list[Any]:
        """A field with these ``numbers`` of each point, and two for its gradients."""
        kind = ti.types.vector(numbers, real())
        return [ti.field(kind, self.points.slots + 1) for _ in range(3)]

    @property
    def states(self) -> np.ndarray:
        """P (levels, numbers of all modes, particles) in place."""
        values = view(self.tensors)[: self.points.fluid]
        return values.reshape(len(values), ORDER, self.size).transpose(1, 2, 0)

    def begin(self, values: Sequence[np.ndarray] = ()) -> None:
        """Start from rest, without stress, or from the initial state of the problem, or from ``values`` of P."""
        view(self.tensors)[...] = 0.0
        if values:
            view(self.tensors)[: self.points.fluid] = values[0]
        elif self.initial_conformation_excess:
            positions = view(self.points.position)[: self.points.fluid].astype(float) + self.origin
            modes = self.initial_conformation_excess(*positions.T)
            self.states[0] = self.logarithms(modes)
        self.state = self.times_radius(self.states[0].astype(float), self.radius)

    def logarithms(self, modes: Sequence[Any]) -> np.ndarray:
        """Return the P that a start with these C of the modes has, as ``tensors`` have it."""
        if self.axisymmetric:
            modes = [[*mode, *(self.stress_numbers - len(mode)) * [0.0 * mode[0]]] for mode in modes]
        return self.times_radius(np.concatenate([self.algebra.logarithm(mode) for mode in modes]), 1.0 / self.radius)

    def implicit(self) -> np.ndarray:
        """Return 2 nu* D (numbers, points), its components over the ``powers`` of the radius."""
        (xx, xy, yx, yy, *rest), radius = self.gradients, self.radius
        rows = [2.0 * xx, (xy + yx) / radius, 2.0 * yy, *(2.0 * tt for tt in rest[:1])]
        if self.swirls:
            rows += [rest[1] / radius, rest[2] / radius**2]
        return (1.0 if self.local else self.viscosity) * np.stack(rows)

    def local_viscosities(self, viscosity: float, points: int) -> np.ndarray:
        """Return the ``viscosity`` of the step with the response of the stretched polymer in place of that at rest."""
        if not self.local:
            return super().local_viscosities(viscosity, points)
        return viscosity - self.viscosity + view(self.response)[:points].astype(float)

    def set_response(self) -> None:
        """Set nu* of each point by its conformation: nu* at rest times 1 + (tr A - tr 1)/2."""
        response = 0.0
        for law, part in self.modes:
            excess = self.modes.excess(self.state[part])
            # a polymer that swirl has stretched around the axis responds to no gradient of the velocity along it
            around = excess[3] if self.axisymmetric and not self.swirls else 0.0
            stretch = 0.5 * (excess[0] + excess[2] + around)
            at_rest = law.modulus * self.duration / (1.0 + self.duration / law.relaxation_time)
            response = response + at_rest * (1.0 + np.maximum(stretch, 0.0))
        view(self.response)[: self.points.fluid] = response

    def differentiated(self) -> np.ndarray:
        """Return P as it is differentiated."""
        return self.times_radius(self.state, 1.0 / self.radius)

    def force_of_stress(self, d_dx: np.ndarray, d_dy: np.ndarray) -> np.ndarray:
        """Return the force (components, points) of the stress for the derivatives (numbers, points) of P by x and y.

        In axisymmetric flow the second ones are by s, and forces but the first over r.
        """
        radius, numbers = self.radius, self.stress_numbers
        along, across = self.times_radius(d_dx, radius), radius * self.times_radius(d_dy, radius)
        for component, power in self.powers:
            across[component::numbers] += power * self.state[component::numbers] / radius
        by_x, by_y = (
            np.imag(self.modes.stress(self.state + 1j * SMALL * change, numbers)) / SMALL for change in (along, across)
        )
        first, second = by_x[0] + by_y[1], by_x[1] + by_y[2]
        if not self.axisymmetric:
            return np.stack([first, second])
        stress, around = self.modes.stress(self.state, numbers), np.zeros_like(radius)
        if self.swirls:
            around = (by_x[XT] + by_y[RT] + 2.0 * stress[RT] / radius) / radius
        return np.stack([first + stress[1] / radius, (second + (stress[2] - stress[3]) / radius) / radius, around])

    def prepare(self, weights: TimeWeights, dt: float, time: float) -> None:
        """Begin a step ``dt`` that ends at ``time``: history, guess and implicit viscosity."""
        gamma0, alpha = weights.bdf()
        self.time, self.duration = time, dt / gamma0
        states = self.times_radius(self.states.astype(float), self.radius * self.ratio)
        elapsed = (weights.unit * weights.offsets)[:ORDER]
        if self.walls:
            states[..., self.points.in_fluid :] = self.walls.carried(
                states[..., self.points.in_fluid :], elapsed, self.time
            )
        self.explicit_part = np.einsum("a,acn->cn", alpha[:ORDER], states) / gamma0
        self.state = np.einsum("a,acn->cn", weights.extrapolation(ORDER), states)
        self.jacobians = [None for _ in self.modes.laws]
        self.viscosity = sum(
            law.modulus * self.duration / (1.0 + self.duration / law.relaxation_time) for law in self.modes.laws
        )
        if self.local:
            self.set_response()
        if self.source:
            self.produced = np.stack(self.source(*self.all_places, time))[: len(self.state)]

    def add_stress(self, velocity: Any, forcing: Any, dt: float) -> None:
        """Add dt div (S - 2 nu* D) of a ``velocity`` field to the forcing ``forcing`` of a step ``dt``."""
        self.find(velocity)
        all_points = slice(self.points.fluid)
        view(self.implicit_stress)[all_points] = self.implicit().T
        view(self.current)[all_points] = self.differentiated().T
        self.current_gradients()
        derivatives = [view(field)[all_points].T.astype(float) for field in (self.current_d_dx, self.current_d_dy)]
        view(self.stress_divergence)[all_points] = self.force_of_stress(*derivatives).T
        self.add_stress_force(forcing, dt)

    def find(self, velocity: Any) -> None:
        """Find P at the end of a step for a ``velocity`` there."""
        self.measure(velocity)
        gradient = self.gradients = view(self.gradient)[: self.points.fluid].T.astype(float)
        if self.axisymmetric:  # the divergence is an error
            gradient[0] -= gradient[0] + gradient[3] + gradient[4]
        else:
            gradient[[0, 3]] -= 0.5 * (gradient[0] + gradient[3])
        if self.walls:
            self.take_known(self.walls, gradient[:, self.points.in_fluid :], self.slip(self.walls, velocity))
        if self.given_gradient:
            gradient[...] = np.stack(self.given_gradient(*self.all_places, self.time))
        for mode, (law, part) in enumerate(self.modes):
            change = lambda p, law=law: self._rate(law, p, gradient)  # noqa: E731
            known, guess = self.explicit_part[part], self.state[part]
            with np.errstate(all="ignore"):  # numbers that are not finite have no pressure, and stop the run
                jacobian = self.jacobians[mode] or matrix(change, guess, self.duration)
                self.state[part], self.jacobians[mode] = solve(change, known, self.duration, guess, jacobian)

    def _rate(self, law: Any, state: Any, gradient: np.ndarray) -> Any:
        """Return dP/dt with the ``conformation_source``; slopes by a complex ``state`` leave it out."""
        change = self.algebra.rate(law, state, gradient)
        if self.source:
            change = np.stack(change) + change_of_logarithm(state.real, self.produced)
        return change

    def slip(self, walls: WallPoints, velocity: Any) -> np.ndarray | None:
        """Return the ``velocity`` (2, count) in the plane relative to ``walls`` along which fluid slips; None without.

        It is 0 at other walls.
        """
        if not walls.slip_length.any():
            return None
        points = self.points.on_walls
        relative = view(velocity)[points].astype(float) - walls.velocities(self.time)
        relative[:, 1] *= self.radius[points] if self.axisymmetric else 1.0
        return np.where(walls.slip_length > 0.0, relative[:, :2].T, 0.0)

    def take_known(self, walls: WallPoints, gradient: np.ndarray, slip: np.ndarray | None) -> None:
        """Replace a measured velocity gradient (numbers, count) at ``walls`` by a shear along the wall, in place.

        Fluid that slips with the velocity ``slip`` (2, count) is stretched along the wall as well.
        """
        plane, measured = gradient[:4], gradient[5:].copy()
        plane[...] = walls.gradients(plane.reshape(2, 2, -1), self.time, slip).reshape(4, -1)
        if self.swirls and isinstance(walls, WallsOfRevolution):
            gradient[5:] = walls.gradient_around(measured)
        if slip is not None and self.axisymmetric:
            slips, normal = walls.slip_length > 0.0, walls.at(self.time)[1].T
            across = np.where(slips, gradient[4], 0.0) * normal[:, None] * normal  # for a divergence of 0
            plane -= across.reshape(4, -1)
            gradient[5:, slips] = measured[:, slips]

    def power(self, strain: np.ndarray, viscosity: float) -> np.ndarray:
        """Return the power (points,) of solvent and polymer, S : D, per mass; see ``ExtraStress.power``."""
        stress = self.modes.stress(self.state, self.stress_numbers)
        count, weights = len(stress), np.array([0.5, 1.0, 0.5, 0.5, 1.0, 1.0])
        return super().power(strain, viscosity) + np.einsum("c,cn,cn->n", weights[:count], stress, strain[:count])

    def store(self, velocity: Any, step: int) -> tuple[float, float, float]:
        """Store the P of the ``velocity`` at the end of a ``step`` as the newest level.

        Returns the largest change of P within a spacing, and x and y where it is. Raises DivergedError where that is
        too large.
        """
        self.find(velocity)
        self.states[1:] = self.times_radius(self.states[:-1].copy(), self.ratio)
        self.states[0] = self.differentiated()
        if self.given_gradient:  # P is not differentiated
            return 0.0, 0.0, 0.0
        self.level_gradients()
        change, x, y = self.log_jump()
        if not change < MAX_LOG_JUMP:
            text = f"stress: it changes more than {math.exp(MAX_LOG_JUMP):.0f}-fold within a particle spacing at"
            raise DivergedError(f"{text} ({x:.4g}, {y:.4g}), step {step}, t = {self.time:.6g}")
        return change, x, y

    def log_jump(self) -> tuple[float, float, float]:
        """Return the largest change of a P within a spacing, its Frobenius norm, and x and y where it is.

        The ``powers`` of the radius are left out.
        """
        all_points, weights = slice(self.points.fluid), np.array([1.0, 2.0, 1.0, 1.0, 2.0, 2.0])
        gradients = (view(field)[all_points, : self.size].T.astype(float) for field in (self.d_dx, self.d_dy))
        d_dx, d_dy = (self.times_radius(gradient, self.radius) for gradient in gradients)
        squares = (d_dx**2 + (self.radius * d_dy) ** 2).T
        sums = [squares[:, part] @ weights[: part.stop - part.start] for part in self.modes.parts]
        relative = view(self.points.relative_spacing)[all_points] if self.points.graded else 1.0
        worst = np.max(sums, axis=0) * np.square(relative, dtype=float)
        index = int(np.argmax(np.where(np.isnan(worst), np.inf, worst)))
        where = view(self.points.position)[index] + self.origin
        return self.spacing * math.sqrt(worst[index]), *where.tolist()

    def wall_stress(self) -> np.ndarray:
        """Return the stress (numbers of tractions, count) at the points on walls."""
        state = self.times_radius(self.states[0].astype(float), self.radius)[:, self.points.in_fluid :]
        return self.traction_rows(self.modes.stress(state, self.stress_numbers))

    def present_wall_stress(self) -> np.ndarray:
        """Return the same for the newest iterate of a step."""
        return self.traction_rows(self.modes.stress(self.state[:, self.points.in_fluid :], self.stress_numbers))

    def implicit_wall_stress(self, strain: np.ndarray) -> np.ndarray:
        """Return the same in a step in which 2 D is ``strain`` there.

        As the momentum equation has it: S, with the change of the strain since then times nu*.
        """
        implicit = self.times_radius(view(self.implicit_stress)[: self.points.fluid].T.astype(float), self.radius)
        viscosity = self.local_viscosities(self.viscosity, self.points.fluid)[self.points.in_fluid :]
        factor = viscosity if self.local else 1.0
        stress = self.present_wall_stress() - factor * self.traction_rows(implicit[:, self.points.in_fluid :])
        return stress + viscosity * strain

    def traction_rows(self, stress: np.ndarray) -> np.ndarray:
        """Return the components of a stress that tractions are made of: xx, xy, yy, in axisymmetric flow xt and yt."""
        if not self.axisymmetric:
            return stress
        return np.concatenate([stress[:3], stress[4:] if self.swirls else np.zeros((2, stress.shape[1]))])

    def at(self, weights: TimeWeights, offset: float, levels: Sequence[np.ndarray], radius: np.ndarray) -> np.ndarray:
        """Return the stresses (components, n) a time ``offset`` before the end of the last step, of ``tensors``."""
        tensors = levels[0].reshape(len(radius), ORDER, self.size)
        level_weights = weights.interpolation(offset, ORDER)
        state = np.einsum("a,nac->cn", level_weights, tensors) if offset else tensors[:, 0].T
        return self.modes.stress(self.times_radius(state, radius), self.stress_numbers)

    @ti.kernel
    def measure(self, velocity: ti.template()):
        """Velocity gradients at all points: xx, xy, yx, yy, in axisymmetric flow tt, and with swirl tx and ty."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, velocity, i)
            if ti.static(not self.axisymmetric):
                self.gradient[i] = [d_dx.x, d_dy.x, d_dx.y, d_dy.y]
            else:
                radius, across = self.levels.coordinates.radius(i), velocity[i].y
                radial = across + radius * radius * d_dy.y
                plane = ti.Vector([d_dx.x, radius * d_dy.x, radius * d_dx.y, radial, across])
                for number in ti.static(range(5)):
                    self.gradient[i][number] = plane[number]
                if ti.static(self.swirls):
                    self.gradient[i][5] = radius * d_dx.z
                    self.gradient[i][6] = radius * radius * d_dy.z

    @ti.kernel
    def current_gradients(self):
        """Gradients of P at the end of a step."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            self.current_d_dx[i], self.current_d_dy[i] = gradients(self.operators, self.current, i)

    @ti.kernel
    def add_stress_force(self, forcing: ti.template(), dt: float):
        """Add dt div (S - 2 nu* D)."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, self.implicit_stress, i)
            implicit = self.levels.coordinates.divergence(i, self.implicit_stress, 0, d_dx, d_dy)
            forcing[i] += dt * (self.stress_divergence[i] - self.response[i] * implicit)

    @ti.kernel
    def level_gradients(self):
        """Gradients of all levels."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            self.d_dx[i], self.d_dy[i] = gradients(self.operators, self.tensors, i)

    @ti.kernel
    def remap(self):
        """Transfer all levels with a shift."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            moved = self.levels.coordinates.shifted(i, self.levels.shift.moved[i])
            self.tensors[i] += transfer(self.operators, self.d_dx, self.d_dy, i, moved)
