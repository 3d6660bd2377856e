"""Velocity and pressure of a step solved together, which slow flow needs: the Stokes system of least-squares operators.

With sigma = gamma_0/dt, a force f (everything explicit), the Laplacian L, gradient G and divergence D of particles,
velocities u of the fluid and pressures p of all points, fluid and walls (docs/theory/two-dimensional.md, "Slow flow"),

    sigma u - nu L u + G p = f                                       in the fluid,                       (9)
    D u + tau (D G - L) p = 0                                        in the fluid,                      (10)
    n . G p + nu n . curl curl u = n . (f - sigma U)                 on walls,                          (11)
    M sigma X - F(u, p) = load                                       of bodies that the flow carries,   (12)

where U is the velocity of the walls, to which X of the bodies contributes. D G has modes of the pressure that oscillate
from particle to particle, and L has none. With tau = 1/sigma the solution would be the converged one of the splitting
(``equations.py``), and leave a divergence that grows with the step.

GMRES (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856-869), preconditioned from the left, so that
residuals are errors of velocities, by block elimination from X to p to u:

    p = nu phi - sigma L^-1 r,    phi = r in the fluid, nu n . grad phi = r/tau on walls,

r being the residual of (10) and (11) (J. Cahouet, J.-P. Chabard, Int. J. Numer. Meth. Fluids 8 (1988) 869-895), then
u = (sigma - nu L)^-1 (r - G p). Both inverses are one cycle of two levels, an auxiliary grid and Jacobi sweeps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from tisph.runtime import ti, view
from tisph.solvers.auxiliary_grid import WalledGrid
from tisph.solvers.bicgstab import DAMPING

STABILISATION = 0.1
"""tau over spacing^2/nu. Velocities between eccentric cylinders have errors that are the same within 30 % from 0.01 to
10; with 0.03 there are 1.3 times as many iterations, with 1 twice as many."""

SWEEP, WALL_SWEEPS = 0.7, 2
"""Damping of the Jacobi sweeps over velocities, and number of sweeps over the rows of walls."""

FEW_AROUND = 0.3
"""Weight of the particles around a node below which their mean counts less."""

MOST_DIRECTIONS, MOST_STARTS = 60, 5
"""Directions of GMRES before it starts again, and how often it starts."""


@dataclass(frozen=True)
class Unknowns:
    """Further unknowns X (m,): velocities of bodies that the flow carries, or an acceleration along x that drives it.

    * ``motion`` (count * components, m), sparse: velocities of the points on walls by X. ``forces``, of the transposed
      shape: the forces on bodies by the tractions at the points.
    * ``push`` (m,): acceleration of the fluid along x by X. ``pushed`` (m,): load by such an acceleration.
    * ``inertia`` (m,): M sigma. ``section`` (m, points), sparse: weights of the velocities along x in an equation.
      ``load`` (m,): everything that is known.
    * ``guess`` (m,) of X, ``arm`` (m,) by which X become velocities, ``response`` (m,): roughly the derivative of the
      other side of the equation by X.

    An equation is forces * tractions + pushed * acceleration + load = inertia X + section u.
    """

    motion: Any
    forces: Any
    push: np.ndarray
    pushed: np.ndarray
    inertia: np.ndarray
    section: Any
    load: np.ndarray
    guess: np.ndarray
    arm: np.ndarray
    response: np.ndarray

    @classmethod
    def joined(cls, blocks: "Sequence[Unknowns]", walls: int, points: int) -> "Unknowns":
        """Return the unknowns of all ``blocks``: none of them at all where there is no block."""
        from scipy.sparse import csr_matrix, hstack, vstack

        none = np.empty(0)
        nothing = cls(
            csr_matrix((walls, 0)), csr_matrix((0, walls)), none, none, none, csr_matrix((0, points)), *4 * [none]
        )
        parts: dict[str, Any] = {
            each.name: [getattr(block, each.name) for block in (nothing, *blocks)] for each in fields(cls)
        }
        sparse = {"motion": hstack(parts["motion"], "csr"), "forces": vstack(parts["forces"], "csr")}
        sparse["section"] = vstack(parts["section"], "csr")
        return cls(**{name: np.concatenate(values) for name, values in parts.items() if name not in sparse} | sparse)


@dataclass(frozen=True)
class WallRows:
    """Equations at the points on walls: ``normal`` (count, 2) into the fluid and ``weight`` (count,) of a row.

    ``open_walls`` (count,) and ``open_fluid`` (fluid,): parts of the equations that hold where gaps between bodies
    close; 1 elsewhere. ``strain``: function of velocities and their derivatives at the points, 2 D.
    """

    normal: np.ndarray
    weight: np.ndarray
    open_walls: np.ndarray
    open_fluid: np.ndarray
    strain: Any


@ti.data_oriented
class StokesSolver:
    """Solver at the points of least-squares ``operators``: the fluid's come first, those on walls after them.

    ``grid`` of the preconditioner. ``iterations``: number for the last solution.
    """

    def __init__(self, operators: Any, grid: WalledGrid, components: int, spacing: float) -> None:
        self.operators, self.points, self.grid = operators, operators.points, grid
        self.components, self.spacing, self.axisymmetric = components, spacing, operators.axisymmetric
        self.iterations = 0
        # in double precision whatever the particles have: residuals are differences of large numbers
        kinds = [ti.types.vector(numbers, ti.f64) for numbers in (components + 1, 3, components)]
        self.values, self.gradients, self.velocities = (ti.field(kind, self.points.slots + 1) for kind in kinds)
        self.laplacians, self.by_x, self.by_y = (ti.field(kinds[0], self.points.capacity) for _ in range(3))
        self.second_x, self.second_y = (ti.field(kinds[1], self.points.capacity) for _ in range(2))
        self.diffused = ti.field(kinds[2], self.points.capacity)
        self.potential = ti.field(ti.f64, self.points.slots + 1)
        self.of_potential = ti.field(kinds[1], self.points.capacity)

    def assemble(self, rows: WallRows) -> None:
        """Set the matrices of the present operators, with these equations at walls."""
        from scipy.sparse import csr_matrix, diags

        points, self.rows, operators = self.points, rows, self.operators
        self.n, self.fluid = int(view(points.particles)), int(view(points.n_fluid))
        n, fluid, walls = self.n, self.fluid, slice(self.fluid, self.n)
        self.diagonal = view(operators.diagonal)[:n].astype(float)
        table, listed = points.listed_neighbours(walls)
        listed &= table < n
        begins = np.concatenate([[0], np.cumsum(listed.sum(axis=1))])
        entries = view(operators.laplacian)[walls][listed].astype(float), table[listed], begins
        self.at_walls = csr_matrix(entries, (n - fluid, n))
        radius = self.radius = np.ones(n)
        if self.axisymmetric:
            radius = self.radius = view(points.position)[:n, 1] + float(view(operators.lowest_radius))
        x, y = rows.weight * rows.normal.T
        self.along, self.across = (
            np.stack([x, y * radius[fluid:]]),
            np.stack([x * radius[fluid:] ** 2, -y * radius[fluid:]]),
        )
        self.spread = self.grid.interpolation(n)
        self.to_fluid, self.to_nodes = self.spread[:fluid], self.spread.T.tocsr()
        self.around = np.asarray(self.to_fluid.sum(axis=0)).ravel()
        self.means = (diags(1.0 / np.maximum(self.around, FEW_AROUND)) @ self.to_fluid.T).tocsr()

    def set_step(self, sigma: float, viscosity: np.ndarray) -> None:
        """Set the coefficients of a step, with the ``viscosity`` (points,) of its implicit part."""
        fluid, around = self.fluid, self.around
        self.sigma, self.viscosity = sigma, viscosity[:, None]
        self.tau = np.minimum(STABILISATION * self.spacing**2 / viscosity, 1.0 / sigma if sigma else np.inf)
        self.inverse = 1.0 / (sigma - self.viscosity * self.diagonal[:, None])[:fluid]
        mean, sums = viscosity[:fluid].mean(), self.to_fluid.T @ viscosity[:fluid]
        at_nodes = np.divide(sums, around, out=np.full_like(sums, mean), where=around > 0.0)
        self.grid.factorise_velocities(sigma, at_nodes, self.components)
        self.pressure_unit = sigma * self.spacing + mean / self.spacing

    def solve(
        self,
        velocity: np.ndarray,
        pressure: np.ndarray,
        force: np.ndarray,
        divergence: np.ndarray,
        others: Unknowns,
        allowed: float,
    ) -> tuple[bool, np.ndarray]:
        """Solve for ``velocity`` (points, components) and ``pressure`` (points,), in place; return if it was, and X.

        ``velocity`` on walls is known but for the part of ``others``, by their guess. ``force`` f (points, components).
        ``divergence`` (fluid,) that stays in gaps that close. ``allowed``: root mean square error of the velocities.
        """
        fluid, count = self.fluid, self.fluid * self.components
        self.others, self.force, self.divergence = others, force, divergence
        self.given = velocity[fluid:] - (others.motion @ others.guess).reshape(-1, self.components)
        units = np.ones(count), np.full(self.n, 1.0 / self.pressure_unit), others.arm * np.sqrt(fluid)
        self.units = np.concatenate(units)
        unknowns = self.units * np.concatenate([velocity[:fluid].ravel(), pressure, others.guess])
        unknowns, solved = self.iterate(unknowns, allowed * np.sqrt(fluid))
        velocity[...], pressure[...], found = self.parts(unknowns)
        velocity[fluid:] += self.given
        return solved, found

    def parts(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return u (points, components), on walls by X alone, p (points,) and X (m,) of scaled ``unknowns``."""
        unknowns, count = unknowns / self.units, self.fluid * self.components
        velocity, others = np.zeros((self.n, self.components)), unknowns[count + self.n :]
        velocity[: self.fluid] = unknowns[:count].reshape(-1, self.components)
        velocity[self.fluid :] = (self.others.motion @ others).reshape(-1, self.components)
        return velocity, unknowns[count : count + self.n], others

    def residual(self, unknowns: np.ndarray, given: float) -> np.ndarray:
        """Return the residuals of (9) to (12), with the ``given`` part, 0 or 1, of everything that is known."""
        velocity, pressure, others = self.parts(unknowns)
        fluid, components, rows = self.fluid, self.components, self.rows
        velocity[fluid:] += given * self.given
        force = given * self.force
        force[:, 0] += self.others.push @ others
        laplacian, by_x, by_y = self.derivatives(velocity, pressure)
        viscous, gradient = laplacian[:, :components], np.stack([by_x[:, -1], by_y[:, -1]], axis=1)
        if self.axisymmetric:
            viscous[:, 1:] += 2.0 * by_y[:, 1:components]
        momentum = force - self.sigma * velocity + self.viscosity * viscous
        momentum[:, :2] -= gradient
        # a second derivative: of the pressure in the fluid, of the vorticity (over r) at walls
        vorticity = by_x[:, 1] - by_y[:, 0]
        second_x, second_y = self.derivatives_of(gradient[:, 0], gradient[:, 1], vorticity)
        divergence = self.divergence_of(by_x[:, 0], by_y[:, 1], velocity[:, 1])
        pressures = self.divergence_of(second_x[:, 0], second_y[:, 1], gradient[:, 1])
        curl = self.across[0] * second_y[fluid:, 2] + self.across[1] * second_x[fluid:, 2]
        if self.axisymmetric:
            curl += 2.0 * rows.weight * rows.normal[:, 0] * vorticity[fluid:]
        continuity = self.tau * laplacian[:, -1]
        continuity[:fluid] -= rows.open_fluid * (divergence + self.tau[:fluid] * pressures)
        if given and not rows.open_fluid.all():
            force_x, force_y = self.derivatives_of(self.force[:, 0], self.force[:, 1], 0.0)
            forces = self.divergence_of(force_x[:, 0], force_y[:, 1], self.force[:, 1])
            kept = self.tau[:fluid] * (forces - self.sigma * self.divergence)
            continuity[:fluid] -= (1.0 - rows.open_fluid) * kept
        acceleration = force[fluid:] - self.sigma * velocity[fluid:]
        pushed = self.along[0] * acceleration[:, 0] + self.along[1] * acceleration[:, 1]
        wanted = rows.open_walls * (pushed - self.viscosity[fluid:, 0] * curl)
        continuity[fluid:] = self.tau[fluid:] * (wanted - laplacian[fluid:, -1])
        continuity -= continuity.mean()
        rest = self.residual_of_others(velocity, pressure, others, by_x, by_y, given)
        return np.concatenate([momentum[:fluid].ravel(), continuity, rest])

    def divergence_of(self, by_x: np.ndarray, by_y: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Return the divergence (fluid,) by derivatives (points,) of the components along x and ``across`` it."""
        fluid = slice(self.fluid)
        divergence = by_x[fluid] + self.radius[fluid] ** 2 * by_y[fluid]
        return divergence + 2.0 * across[fluid] if self.axisymmetric else divergence

    def residual_of_others(
        self,
        velocity: np.ndarray,
        pressure: np.ndarray,
        others: np.ndarray,
        by_x: np.ndarray,
        by_y: np.ndarray,
        given: float,
    ) -> np.ndarray:
        """Return the residuals (m,) of the equations of the ``Unknowns`` X = ``others``."""
        if not len(others):
            return others
        walls, blocks, normal = slice(self.fluid, None), self.others, self.rows.normal.T
        derivatives = (by[walls, : self.components].T for by in (by_x, by_y))
        stress = self.viscosity[walls, 0] * self.rows.strain(velocity[walls].T, *derivatives)
        rows = (stress[:2], stress[1:3], stress[3:])[: self.components]
        tractions = np.stack([(row * normal).sum(axis=0) for row in rows], axis=1)
        tractions[:, :2] -= (pressure[walls] * normal).T
        found = blocks.forces @ tractions.ravel() - blocks.inertia * others - blocks.section @ velocity[:, 0]
        return given * blocks.load + blocks.pushed * (blocks.push @ others) + found

    def precondition(self, residual: np.ndarray) -> np.ndarray:
        """Return scaled unknowns that remove a ``residual`` approximately."""
        fluid, components, count = self.fluid, self.components, self.fluid * self.components
        correction = np.zeros_like(residual)
        others = slice(count + self.n, None)
        correction[others] = self.units[others] * residual[others] / self.others.response
        momentum, continuity = residual[:count].reshape(-1, components), residual[count : count + self.n]
        pressure = self.pressure_for(continuity)
        momentum = momentum.copy()
        momentum[:, :2] -= self.of_pressure(pressure)[:fluid, 1:]
        correction[:count] = self.velocity_for(momentum).ravel()
        correction[count : count + self.n] = self.units[count] * pressure
        return correction

    def pressure_for(self, continuity: np.ndarray) -> np.ndarray:
        """Return the pressure (points,) that removes the residual (points,) of (10) and (11)."""
        fluid, viscosity = self.fluid, self.viscosity[:, 0]
        phi = np.concatenate([continuity[:fluid], np.zeros(self.n - fluid)])
        wanted = continuity[fluid:] / (self.tau * viscosity)[fluid:]
        for _ in range(1 + WALL_SWEEPS):
            phi[fluid:] += (wanted - self.row_of_walls(phi)) / self.diagonal[fluid:]
        pressure = viscosity * phi
        if self.sigma:
            right = np.concatenate([continuity[:fluid] - continuity[:fluid].mean(), np.zeros(self.n - fluid)])
            smooth = self.spread @ self.grid.invert_pressure(self.to_nodes @ right)
            swept = DAMPING * (right + self.of_pressure(smooth)[:, 0]) / -self.diagonal
            smooth[:fluid] += swept[:fluid]
            smooth[fluid:] -= self.row_of_walls(smooth) / self.diagonal[fluid:]
            pressure += self.sigma * smooth
        return pressure - pressure.mean()

    def velocity_for(self, momentum: np.ndarray) -> np.ndarray:
        """Return velocities (fluid, components), 0 on walls, that remove the residual of (9)."""
        velocity = SWEEP * self.inverse * momentum
        coarse = self.grid.invert_velocities(self.means @ (momentum - self.viscous(velocity)))
        velocity += self.to_fluid @ coarse
        return velocity + SWEEP * self.inverse * (momentum - self.viscous(velocity))

    def viscous(self, velocity: np.ndarray) -> np.ndarray:
        """Return sigma u - nu L u for velocities (fluid, components) that are 0 on walls."""
        view(self.velocities)[: self.fluid] = velocity
        self.diffuse()
        return self.sigma * velocity - self.viscosity[: self.fluid] * view(self.diffused)[: self.fluid]

    def row_of_walls(self, values: np.ndarray) -> np.ndarray:
        """Return the rows (count,) of the Laplacian's matrix at walls times ``values`` (points,)."""
        return self.at_walls @ values + self.diagonal[self.fluid :] * values[self.fluid :]

    def derivatives(self, velocity: np.ndarray, pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return Laplacian and derivatives by x and y (points, components + 1), the last ones those of the pressure."""
        every, values = slice(self.n), view(self.values)
        values[every, : self.components], values[every, self.components] = velocity, pressure
        self.differentiate()
        return view(self.laplacians)[every].copy(), view(self.by_x)[every], view(self.by_y)[every]

    def derivatives_of(self, first: Any, second: Any, third: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives by x and y (points, 3) of three fields (points,)."""
        every, values = slice(self.n), view(self.gradients)
        values[every, 0], values[every, 1], values[every, 2] = first, second, third
        self.differentiate_again()
        return view(self.second_x)[every], view(self.second_y)[every]

    def of_pressure(self, pressure: np.ndarray) -> np.ndarray:
        """Return Laplacian and derivatives (points, 3) of a pressure (points,)."""
        view(self.potential)[: self.n] = pressure
        self.differentiate_potential()
        return view(self.of_potential)[: self.n]

    @ti.kernel
    def differentiate(self):
        """Compute Laplacian and gradient of the ``values``."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own = self.values[i]
            laplacian, by_x, by_y = 0.0 * own, 0.0 * own, 0.0 * own
            for k in range(self.points.count[i]):
                apart = self.values[self.points.neighbours[i, k]] - own
                laplacian += self.operators.laplacian[i, k] * apart
                by_x += self.operators.d_dx[i, k] * apart
                by_y += self.operators.d_dy[i, k] * apart
            self.laplacians[i], self.by_x[i], self.by_y[i] = laplacian, by_x, by_y

    @ti.kernel
    def differentiate_again(self):
        """Compute the gradients of the ``gradients``."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own = self.gradients[i]
            by_x, by_y = 0.0 * own, 0.0 * own
            for k in range(self.points.count[i]):
                apart = self.gradients[self.points.neighbours[i, k]] - own
                by_x += self.operators.d_dx[i, k] * apart
                by_y += self.operators.d_dy[i, k] * apart
            self.second_x[i], self.second_y[i] = by_x, by_y

    @ti.kernel
    def differentiate_potential(self):
        """Compute Laplacian and gradient of the ``potential``."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own = self.potential[i]
            total = ti.Vector([0.0 * own, 0.0 * own, 0.0 * own])
            for k in range(self.points.count[i]):
                apart = self.potential[self.points.neighbours[i, k]] - own
                total[0] += self.operators.laplacian[i, k] * apart
                total[1] += self.operators.d_dx[i, k] * apart
                total[2] += self.operators.d_dy[i, k] * apart
            self.of_potential[i] = total

    @ti.kernel
    def diffuse(self):
        """Compute the Laplacian of the ``velocities``, which are 0 on walls."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            total = self.operators.apply(self.operators.laplacian, self.velocities, i)
            if ti.static(self.axisymmetric):
                total += self.operators.hoop(self.velocities, i)
            self.diffused[i] = total

    def iterate(self, unknowns: np.ndarray, allowed: float) -> tuple[np.ndarray, bool]:
        """Return better ``unknowns``, by GMRES, and whether their error is ``allowed``."""
        self.iterations = 0
        for _ in range(MOST_STARTS):
            residual = self.precondition(self.residual(unknowns, 1.0))
            size = float(np.linalg.norm(residual))
            if not size > allowed:
                return unknowns, size <= allowed
            directions = np.zeros((MOST_DIRECTIONS + 1, len(unknowns)))
            matrix = np.zeros((MOST_DIRECTIONS + 1, MOST_DIRECTIONS))
            directions[0] = residual / size
            for step in range(MOST_DIRECTIONS):
                new, before = -self.precondition(self.residual(directions[step], 0.0)), directions[: step + 1]
                for _ in range(2):  # twice is enough, whatever the rounding
                    parts = before @ new
                    new -= parts @ before
                    matrix[: step + 1, step] += parts
                matrix[step + 1, step] = np.linalg.norm(new)
                self.iterations += 1
                wanted = np.zeros(step + 2)
                wanted[0] = size
                factors, *_ = np.linalg.lstsq(matrix[: step + 2, : step + 1], wanted)
                left = np.linalg.norm(wanted - matrix[: step + 2, : step + 1] @ factors)
                if left <= allowed or not matrix[step + 1, step] > 0.0:
                    break
                directions[step + 1] = new / matrix[step + 1, step]
            unknowns = unknowns + factors @ directions[: step + 1]
            if left <= allowed:
                return unknowns, True
        return unknowns, False
