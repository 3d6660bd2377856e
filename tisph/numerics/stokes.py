"""Velocity and pressure of a step solved together, which slow flow needs: the Stokes system of least-squares operators.

With sigma = gamma_0/dt, a force f (everything explicit), the Laplacian L, gradient G and divergence D of particles,
velocities u of the fluid and pressures p of all points, fluid and walls (docs/theory/two-dimensional.md, "Slow flow"),

    sigma u - nu L u + G p = f                                       in the fluid,                       (9)
    D u + tau (D G - L) p = 0                                        in the fluid,                      (10)
    n . G p + nu n . curl curl u = n . (f - sigma U)                 on walls,                          (11)
    M sigma X - F(u, p) = load                                       of bodies that the flow carries,   (12)
    n . G u = -n_x D_y v,   n . G v = 0,   p = -nu D_y v + S_yy      at an outlet,                      (13)

with -D_y v - v/r, and the pressure of ``OpenEnds.outlet_pressure``, around an axis,

where U is the velocity of the walls, to which X of the bodies contributes. At an outlet, an end along y, (13) gives the
velocities and pressures there, which are no unknowns, by those of the other points. D G has modes of the pressure that
oscillate from particle to particle, and L has none. With tau = 1/sigma the solution would be the converged one of the
splitting (``equations.py``), and leave a divergence that grows with the step.

GMRES (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856-869), preconditioned from the left, so that
residuals are errors of velocities, by block elimination from p to u to X:

    p = nu phi - sigma L^-1 r,    phi = r in the fluid, nu n . grad phi = r/tau on walls,

r being the residual of (10) and (11) (J. Cahouet, J.-P. Chabard, Int. J. Numer. Meth. Fluids 8 (1988) 869-895), then
u = (sigma - nu L)^-1 (r - G p), and X by the forces of p and u: without these the residuals of X miss the error that p
causes, and velocities of bodies scatter by 30 times the tolerance (an ellipse in shear, 50 across; with them by 4).
Both inverses are one cycle of two levels, an auxiliary grid and Jacobi sweeps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from tisph.numerics.auxiliary_grid import DAMPING, WalledGrid
from tisph.runtime import view

STABILISATION = 0.1
"""tau over spacing^2/nu. Velocities between eccentric cylinders have errors that are the same within 30 % from 0.01 to
10; with 0.03 there are 1.3 times as many iterations, with 1 twice as many."""

SWEEP, WALL_SWEEPS = 0.7, 2
"""Damping of the Jacobi sweeps over velocities, and number of sweeps over the rows of walls."""

FEW_AROUND = 0.3
"""Weight of the particles around a node below which their mean counts less."""

MOST_DIRECTIONS, MOST_STARTS = 200, 3
"""Directions of GMRES before it starts again, and how often it starts. The first flow of ten free circles takes 88
directions; starting again after every 60 takes more than 480."""


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
    close; 1 elsewhere. ``strain``: function of velocities and their derivatives at the points, 2 D. ``outlet``: of
    the last points, at an open end, the factors of du/dx in their rows of the Laplacian; it may be empty.
    """

    normal: np.ndarray
    weight: np.ndarray
    open_walls: np.ndarray
    open_fluid: np.ndarray
    strain: Any
    outlet: np.ndarray = field(default_factory=lambda: np.zeros(0))


class SparseRows:
    """Layout, as sparse matrices, of the rows ``low`` to ``high`` of least-squares operators of ``points``."""

    def __init__(self, points: Any, low: int, high: int) -> None:
        self.shape = high - low, points.fluid
        self.row, self.listed = points.rows_of(slice(low, high))
        table = view(points.neighbours)[self.row]
        self.listed &= table < points.fluid
        ends = np.cumsum(1 + self.listed.sum(axis=1))
        self.begins = np.concatenate([[0], ends])
        self.first = self.begins[:-1]
        self.others = np.ones(ends[-1] if len(ends) else 0, dtype=bool)
        self.others[self.first] = False
        self.columns = np.empty(len(self.others), dtype=np.int32)
        self.columns[self.first], self.columns[self.others] = np.arange(low, high), table[self.listed]

    def matrix(self, operator: Any) -> Any:
        """Return the matrix (rows, points) of an ``operator``, a field; the entry of the point itself comes first."""
        from scipy.sparse import csr_matrix

        entries = np.zeros(len(self.others))
        entries[self.others] = view(operator)[self.row[self.listed]]
        entries[self.first] = -np.add.reduceat(entries, self.first) if len(self.first) else 0.0
        return csr_matrix((entries, self.columns, self.begins), self.shape)


class StokesSolver:
    """Solver at the points of least-squares ``operators``: the fluid's come first, those on walls after them.

    ``grid`` of the preconditioner. Where the spacing varies rows of (10) are weighted by ``scale``, the areas of
    particles over tau: so they add up to 0 with those of walls. ``iterations``: number for the last solution.
    Velocities inside are (components, points). Matrices are scipy's: a product takes a third of the time that the rows
    of the tables of the operators do.
    """

    def __init__(self, operators: Any, grid: WalledGrid, components: int, spacing: float) -> None:
        self.operators, self.points, self.grid = operators, operators.points, grid
        self.components, self.spacing, self.axisymmetric = components, spacing, operators.axisymmetric
        self.iterations = 0

    def assemble(self, rows: WallRows) -> None:
        """Set the matrices of the present operators, with these equations at walls."""
        from scipy.sparse import diags

        points, operators, self.rows = self.points, self.operators, rows
        n, fluid = self.n, self.fluid = points.fluid, points.in_fluid
        layout = SparseRows(points, 0, n)

        def matrix(field: Any) -> tuple[Any, Any, Any]:
            """Return the matrices of all rows, of the rows of the fluid and of the rows of the walls."""
            whole = layout.matrix(field)
            return whole, whole[:fluid], whole[fluid:]

        self.laplacian, self.fluid_laplacian, self.wall_laplacian = matrix(operators.laplacian)
        self.d_dx, self.fluid_x, self.wall_x = matrix(operators.d_dx)
        self.d_dy, self.fluid_y, self.wall_y = matrix(operators.d_dy)
        self.diagonal = self.laplacian.data[layout.first]
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
        if len(rows.outlet):
            self.set_outlet()

    def set_outlet(self) -> None:
        """Set the matrices by which velocities and pressures at the outlet follow from the others."""
        from scipy.sparse.linalg import splu

        self.last = self.n - len(self.rows.outlet)
        rows = self.wall_laplacian[self.last - self.fluid :]
        self.others_row, self.outlet_y = rows[:, : self.last], self.d_dy[self.last :]
        self.outlet_row = splu(rows[:, self.last :].tocsc())

    def complete(self, velocity: np.ndarray) -> np.ndarray:
        """Set a ``velocity`` (components, points) at the outlet by (13), in place; return du/dx (count,) there."""
        u, v = velocity[0], velocity[1]
        for each in velocity[1:]:
            each[self.last :] = self.outlet_row.solve(-(self.others_row @ each[: self.last]))
        change = -(self.outlet_y @ v)
        if self.axisymmetric:
            change = self.radius[self.last :] ** 2 * change - 2.0 * v[self.last :]
        u[self.last :] = self.outlet_row.solve(self.rows.outlet * change - self.others_row @ u[: self.last])
        return change

    def set_step(self, sigma: float, viscosity: np.ndarray) -> None:
        """Set the coefficients of a step, with the ``viscosity`` (points,) of its implicit part."""
        fluid, around = self.fluid, self.around
        self.sigma, self.viscosity = sigma, viscosity
        areas = np.ones(self.n)
        areas[:fluid] = self.points.areas
        if self.points.graded:
            areas[fluid:] = view(self.points.relative_spacing)[fluid : self.n].astype(float) ** 2
        self.tau = np.minimum(STABILISATION * self.spacing**2 * areas / viscosity, 1.0 / sigma if sigma else np.inf)
        self.area, self.scale = areas[:fluid], np.ones(self.n)
        if self.points.graded:
            self.scale = self.tau.max() / self.tau
            self.scale[:fluid] *= self.area
        self.inverse = 1.0 / (sigma - viscosity * self.diagonal)[:fluid]
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
        outlet_pressure: np.ndarray,
    ) -> tuple[bool, np.ndarray]:
        """Solve for ``velocity`` (points, components) and ``pressure`` (points,), in place; return if it was, and X.

        ``velocity`` on walls is known but for the part of ``others``, by their guess. ``force`` f (points, components).
        ``divergence`` (fluid,) that stays in gaps that close. ``allowed``: root mean square error of the velocities.
        ``outlet_pressure``: p - nu du/dx at outlets.
        """
        self.outlet_pressure = outlet_pressure
        fluid, count = self.fluid, self.fluid * self.components
        self.others, self.force, self.divergence = others, np.ascontiguousarray(force.T), divergence
        self.given = velocity[fluid:].T - self.of_walls(others.guess)
        units = np.ones(count), np.full(self.n, 1.0 / self.pressure_unit), others.arm * np.sqrt(fluid)
        self.units = np.concatenate(units)
        unknowns = self.units * np.concatenate([velocity[:fluid].T.ravel(), pressure, others.guess])
        unknowns, solved = self.iterate(unknowns, allowed * np.sqrt(fluid))
        found, pressure[...], of_others = self.parts(unknowns, 1.0)
        velocity[...] = found.T
        return solved, of_others

    def of_walls(self, others: np.ndarray) -> np.ndarray:
        """Return the velocities (components, count) of the points on walls by ``others`` X."""
        return (self.others.motion @ others).reshape(-1, self.components).T

    def parts(self, unknowns: np.ndarray, given: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return u (components, points), p (points,) and X (m,) of scaled ``unknowns``.

        On walls u is by X and the ``given`` part, 0 or 1, of the prescribed velocities.
        """
        unknowns, count = unknowns / self.units, self.fluid * self.components
        velocity, others = np.empty((self.components, self.n)), unknowns[count + self.n :]
        velocity[:, : self.fluid] = unknowns[:count].reshape(self.components, -1)
        velocity[:, self.fluid :] = self.of_walls(others) + given * self.given
        pressure = unknowns[count : count + self.n]
        if len(self.rows.outlet):
            change = self.complete(velocity)
            pressure[self.last :] = self.viscosity[self.last :] * change + given * self.outlet_pressure
        return velocity, pressure, others

    def residual(self, unknowns: np.ndarray, given: float) -> np.ndarray:
        """Return the residuals of (9) to (12), with the ``given`` part, 0 or 1, of everything that is known."""
        velocity, pressure, others = self.parts(unknowns, given)
        fluid, rows = self.fluid, self.rows
        force = given * self.force
        force[0] += self.others.push @ others
        by_x, by_y = ([matrix @ each for each in velocity] for matrix in (self.d_dx, self.d_dy))
        gradient = self.d_dx @ pressure, self.d_dy @ pressure
        momentum = force[:, :fluid] - self.viscous(velocity, by_y)
        momentum[0] -= gradient[0][:fluid]
        momentum[1] -= gradient[1][:fluid]
        # a second derivative: of the pressure in the fluid, of the vorticity (over r) at walls
        vorticity = by_x[1] - by_y[0]
        divergence = self.divergence_of(by_x[0][:fluid], by_y[1][:fluid], velocity[1])
        pressures = self.divergence_of(self.fluid_x @ gradient[0], self.fluid_y @ gradient[1], gradient[1])
        curl = self.across[0] * (self.wall_y @ vorticity) + self.across[1] * (self.wall_x @ vorticity)
        if self.axisymmetric:
            curl += 2.0 * rows.weight * rows.normal[:, 0] * vorticity[fluid:]
        continuity = self.tau * (self.laplacian @ pressure)
        continuity[:fluid] -= rows.open_fluid * (divergence + self.tau[:fluid] * pressures)
        if given and not rows.open_fluid.all():
            forces = self.divergence_of(self.fluid_x @ self.force[0], self.fluid_y @ self.force[1], self.force[1])
            kept = self.tau[:fluid] * (forces - self.sigma * self.divergence)
            continuity[:fluid] -= (1.0 - rows.open_fluid) * kept
        acceleration = (force - self.sigma * velocity)[:, fluid:]
        pushed = self.along[0] * acceleration[0] + self.along[1] * acceleration[1]
        wanted = rows.open_walls * (pushed - self.viscosity[fluid:] * curl)
        continuity[fluid:] = self.tau[fluid:] * wanted - continuity[fluid:]
        if len(rows.outlet):
            at_outlet = slice(self.fluid * self.components + self.last, self.fluid * self.components + self.n)
            continuity[self.last :] = pressure[self.last :] - (unknowns / self.units)[at_outlet]
        else:
            continuity *= self.scale
            continuity -= continuity.mean()
        rest, blocks = others, self.others
        if len(others):
            forces = self.forces_on_others(velocity, pressure)
            rest = forces - blocks.inertia * others - blocks.section @ velocity[0]
            rest = given * blocks.load + blocks.pushed * (blocks.push @ others) + rest
        return np.concatenate([momentum.ravel(), continuity, rest])

    def viscous(self, velocity: np.ndarray, by_y: Sequence[np.ndarray]) -> np.ndarray:
        """Return sigma u - nu L u (components, fluid) for a ``velocity`` (components, points), and its d/dy."""
        fluid = self.fluid
        result = np.stack([self.fluid_laplacian @ each for each in velocity])
        if self.axisymmetric:
            for component in range(1, self.components):
                result[component] += 2.0 * by_y[component][:fluid]
        return self.sigma * velocity[:, :fluid] - self.viscosity[:fluid] * result

    def divergence_of(self, by_x: np.ndarray, by_y: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Return the divergence (fluid,) by derivatives (fluid,) of the components along x and ``across`` it."""
        if not self.axisymmetric:
            return by_x + by_y
        return by_x + self.radius[: self.fluid] ** 2 * by_y + 2.0 * across[: self.fluid]

    def forces_on_others(self, velocity: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """Return the forces (m,) of a ``velocity`` (components, points) and ``pressure`` (points,) on X."""
        normal = self.rows.normal.T
        derivatives = (np.stack([matrix @ each for each in velocity]) for matrix in (self.wall_x, self.wall_y))
        walls = slice(self.fluid, None)
        stress = self.viscosity[walls] * self.rows.strain(velocity[:, walls], *derivatives)
        rows = (stress[:2], stress[1:3], stress[3:])[: self.components]
        tractions = np.stack([(row * normal).sum(axis=0) for row in rows], axis=1)
        tractions[:, :2] -= (pressure[walls] * normal).T
        return self.others.forces @ tractions.ravel()

    def precondition(self, residual: np.ndarray) -> np.ndarray:
        """Return scaled unknowns that remove a ``residual`` approximately."""
        count, others = self.fluid * self.components, residual[self.fluid * self.components + self.n :]
        momentum, continuity = residual[:count].reshape(self.components, -1), residual[count : count + self.n]
        pressure = self.pressure_for(continuity)
        momentum = momentum.copy()
        momentum[0] -= self.fluid_x @ pressure
        momentum[1] -= self.fluid_y @ pressure
        velocity = self.velocity_for(momentum)
        if len(others):
            whole = np.concatenate([velocity, np.zeros((self.components, self.n - self.fluid))], axis=1)
            others = (others + self.forces_on_others(whole, pressure)) / self.others.response
        return self.units * np.concatenate([velocity.ravel(), pressure, others])

    def pressure_for(self, continuity: np.ndarray) -> np.ndarray:
        """Return the pressure (points,) that removes the residual (points,) of (10) and (11)."""
        fluid = self.fluid
        if not len(self.rows.outlet):
            continuity = continuity / self.scale
        phi = np.concatenate([continuity[:fluid], np.zeros(self.n - fluid)])
        wanted = continuity[fluid:] / (self.tau * self.viscosity)[fluid:]
        walls = slice(fluid, self.n - len(self.rows.outlet))
        number = walls.stop - fluid
        for _ in range(1 + WALL_SWEEPS):
            phi[walls] += (wanted - self.wall_laplacian @ phi)[:number] / self.diagonal[walls]
        pressure = self.viscosity * phi
        if self.sigma:
            mean = 0.0 if len(self.rows.outlet) else continuity[:fluid].mean()
            right = np.concatenate([continuity[:fluid] - mean, np.zeros(self.n - fluid)])
            right[:fluid] *= self.area
            smooth = self.spread @ self.grid.invert_pressure(self.to_nodes @ right)
            right[:fluid] /= self.area
            smooth[walls.stop :] = 0.0
            smooth[:fluid] -= DAMPING * (right[:fluid] + self.fluid_laplacian @ smooth) / self.diagonal[:fluid]
            smooth[walls] -= (self.wall_laplacian @ smooth)[:number] / self.diagonal[walls]
            pressure += self.sigma * smooth
        if not len(self.rows.outlet):
            return pressure - pressure.mean()
        pressure[walls.stop :] = continuity[walls.stop :]
        return pressure

    def velocity_for(self, momentum: np.ndarray) -> np.ndarray:
        """Return velocities (components, fluid), 0 on walls, that remove the residual of (9)."""
        velocity = SWEEP * self.inverse * momentum
        coarse = self.grid.invert_velocities(self.means @ self.left(velocity, momentum).T)
        velocity += (self.to_fluid @ coarse).T
        return velocity + SWEEP * self.inverse * self.left(velocity, momentum)

    def left(self, velocity: np.ndarray, momentum: np.ndarray) -> np.ndarray:
        """Return the residual of (9) with velocities (components, fluid) that are 0 on walls."""
        whole = np.zeros((self.components, self.n))
        whole[:, : self.fluid] = velocity
        if len(self.rows.outlet):
            self.complete(whole)
        by_y = [self.fluid_y @ each for each in whole] if self.axisymmetric else []
        return momentum - self.viscous(whole, by_y)

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
