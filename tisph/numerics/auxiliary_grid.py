"""Auxiliary grids, on which sigma + c (-Laplacian) is inverted.

The residual of a linear system after a few Jacobi sweeps is smooth. Bilinear weights transfer it from the particles to
the nodes of the grid, the system is solved there, and the same weights transfer the solution back. With this
preconditioner the number of iterations does not depend on the number of particles. Each node gathers from the particles
in the four cells around it, in the order of their numbers: bitwise the same for any number of threads. Without walls,
and between the plane walls of a channel, the solution is by fast Fourier transforms and the symbol of the five-point
Laplacian. They run on one thread: a second thread of SciPy's costs more than it saves up to 1e5 nodes, and saves a
quarter of the time at 1e6. Between any other walls the grid is a ``WalledGrid``.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from tisph.numerics.bicgstab import BiCGStab
from tisph.numerics.counting_sort import counting_sort
from tisph.numerics.point_cloud import PointCloud
from tisph.runtime import integer, real, scalar, ti, view
from tisph.size_class import size_class

DAMPING = 0.8
"""Damping factor of the Jacobi sweep."""


@ti.data_oriented
class AuxiliaryGrid:
    """Grid of ``shape`` (rows, columns) nodes in a box of the length of a ``flow`` and this ``height``.

    All points are in the box. ``members``: particles cell by cell, in cell c from ``begin[c + 1]`` to
    ``begin[c + 2]``. ``offset``: position of a particle in its ``cell``, from 0 to 1 along each axis. ``share``:
    factor of the sums over particles at the nodes.
    """

    def __init__(self, points: PointCloud, flow: Any, height: float, shape: tuple[int, int], share: float):
        self.points, self.shape = points, shape
        rows, columns = shape
        self.columns, self.rows = integer(columns), integer(rows)
        self.per_x, self.per_y = scalar(columns / flow.length), scalar(rows / height)
        self.share = scalar(share)
        nodes = size_class(rows * columns + 2)
        self.begin = ti.field(ti.i32, nodes)
        self.cell, self.members = (ti.field(ti.i32, points.capacity) for _ in range(2))
        self.offset = ti.field(ti.types.vector(2, real()), points.capacity)

    def nodes(self, kind: Any) -> Any:
        """Return a field of this ``kind`` for each node."""
        return ti.field(kind, self.begin.shape)

    outlet: Any = None
    """Field with the first slot of the points at an open end at which the pressure is known; None without any."""

    def invert(self, field: Any, sigma: float, coefficient: float) -> None:
        """Replace the values f at the nodes, in ``field``, by (``sigma`` - ``coefficient`` Laplacian)^-1 f."""
        raise NotImplementedError

    @ti.kernel
    def sort(self):
        """Sort the points by cell at their present positions."""
        particles = self.points.particles[None]
        columns, rows = self.columns[None], self.rows[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            position = self.points.position[i]
            x, y = self.points.domain.wrap_x(position.x) * self.per_x[None], position.y * self.per_y[None]
            column = ti.max(0, ti.min(columns - 1, ti.cast(x, ti.i32)))
            row = ti.max(0, ti.min(rows - 1, ti.cast(y, ti.i32)))
            self.offset[i] = [x - column, y - row]
            self.cell[i] = row * columns + column
        ti.loop_config(serialize=True)
        for _ in range(1):
            counting_sort(self.cell, self.begin, self.members, rows * columns, particles, ti.Vector([0, 0]))

    @ti.func
    def deposit(self, values: ti.template(), node):
        """Return the weighted sum of the particles' values at node number ``node``."""
        columns, rows = self.columns[None], self.rows[None]
        column, row = node % columns, node // columns
        left, below = ti.select(column == 0, columns, column) - 1, ti.select(row == 0, rows, row) - 1
        total = 0.0 * values[0]
        for upper in ti.static(range(2)):
            for right in ti.static(range(2)):
                cell = (row if ti.static(upper) else below) * columns + (column if ti.static(right) else left)
                for s in range(self.begin[cell + 1], self.begin[cell + 2]):
                    i = self.members[s]
                    offset = self.offset[i]
                    weight_x = 1.0 - offset.x if ti.static(right) else offset.x
                    weight_y = 1.0 - offset.y if ti.static(upper) else offset.y
                    total += weight_x * weight_y * values[i]
        return self.share[None] * total

    @ti.func
    def interpolate(self, values: ti.template(), i):
        """Return the values of the nodes interpolated to particle ``i``."""
        columns, rows = self.columns[None], self.rows[None]
        cell, offset = self.cell[i], self.offset[i]
        column, row = cell % columns, cell // columns
        right, above = ti.select(column == columns - 1, 0, column + 1), ti.select(row == rows - 1, 0, row + 1)
        lower = (1.0 - offset.x) * values[row * columns + column] + offset.x * values[row * columns + right]
        upper = (1.0 - offset.x) * values[above * columns + column] + offset.x * values[above * columns + right]
        return (1.0 - offset.y) * lower + offset.y * upper


@ti.data_oriented
class PeriodicGrid(AuxiliaryGrid):
    """Grid of a periodic box, with nodes about as far apart as the particles."""

    def __init__(self, points: PointCloud, flow: Any, height: float):
        from scipy import fft  # only where it is needed: its import takes as long as a small run

        self.fft = fft
        columns, rows = fft.next_fast_len(flow.columns, real=True), fft.next_fast_len(flow.rows)
        super().__init__(points, flow, height, (rows, columns), rows * columns / (flow.rows * flow.columns))
        wave_x = (2.0 * columns / flow.length * np.sin(np.pi * np.arange(columns // 2 + 1) / columns)) ** 2
        self.eigenvalues = self.eigenvalues_y(rows, height)[:, None] + wave_x

    def eigenvalues_y(self, rows: int, height: float) -> np.ndarray:
        """Return the eigenvalues (rows,) of minus the second difference along y."""
        return (2.0 * rows / height * np.sin(np.pi * np.arange(rows) / rows)) ** 2

    def invert(self, field: Any, sigma: float, coefficient: float) -> None:
        """Replace f at the nodes by (``sigma`` - ``coefficient`` Laplacian)^-1 f; of mean 0 where sigma is 0."""
        rows, columns = self.shape
        values = view(field)[: rows * columns].reshape(rows, columns, -1)
        symbol = sigma + coefficient * self.eigenvalues
        if sigma == 0.0:
            symbol[0, 0] = np.inf
        self.divide_by_symbol(values, symbol[:, :, None])

    def divide_by_symbol(self, values: np.ndarray, symbol: np.ndarray) -> None:
        """Divide the transform of ``values`` (rows, columns, width) by ``symbol``, in place."""
        transformed = self.fft.rfft2(values, axes=(0, 1))
        transformed /= symbol
        values[...] = self.fft.irfft2(transformed, s=self.shape, axes=(0, 1), overwrite_x=True)


@ti.data_oriented
class DirichletGrid(PeriodicGrid):
    """Grid of a channel, for fields that are odd about its walls, with a sine transform along y.

    The first row of nodes, at the bottom wall, holds zeros, and stands for the row at the top wall too.
    """

    def eigenvalues_y(self, rows: int, height: float) -> np.ndarray:
        """Return the eigenvalues (rows - 1,) of minus the second difference along y, of sines."""
        return (2.0 * rows / height * np.sin(0.5 * np.pi * np.arange(1, rows) / rows)) ** 2

    def divide_by_symbol(self, values: np.ndarray, symbol: np.ndarray) -> None:
        """Divide the transform of ``values`` (rows, columns, width) by ``symbol``, in place."""
        transformed = self.fft.dst(values[1:], 1, axis=0)
        transformed = self.fft.rfft(transformed, axis=1)
        transformed /= symbol
        transformed = self.fft.irfft(transformed, self.shape[1], axis=1, overwrite_x=True)
        values[1:] = self.fft.idst(transformed, 1, axis=0, overwrite_x=True)
        values[0] = 0.0


COARSENING = 2.0
"""Distance of the nodes in particle spacings. In a cavity and around a cylinder, 25 and 20 across, there are 7 and 5
iterations a step; with 1.5 there are 6.5 and 4, and the grid takes twice as long."""

EMPTY = 1e-3
"""Part of the largest entry on the diagonal below which a node does not count."""

FLOATING = 1e-8
"""Part of the largest entry on the diagonal that is added to it, since a constant is no part of the solution."""

NEAREST = 0.1
"""Least distance of a node from a wall beside it, over the distance of nodes, for the velocities."""

STIFFNESS, MASS = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
"""Matrices of a linear element of length 1; their products along x and y are the matrices of a bilinear element."""


@ti.data_oriented
class WalledGrid(AuxiliaryGrid):
    """Grid between curved walls, for the pressure: bilinear finite elements on the nodes of a ``box`` around the fluid.

    An element is weighted by its part in the fluid, from the distance of its middle to the nearest wall. The stiffness
    matrix obeys the natural boundary condition, a normal derivative of zero, as corrections of the pressure do once the
    rows of the points on walls are satisfied (``TwoLevel``). It is the Galerkin operator of the particles' matrix in
    the limit of many particles: the integral of grad(test) . grad(trial), over the area of a particle. It depends only
    on the positions of the walls: where walls rest, or move along themselves, it is factorised once. In axisymmetric
    flow an element is also weighted by its distance from the axis, and rows are divided by the volume of a node.
    ``set_walls`` comes before the first ``invert``. ``velocities``: whether the grid serves them as well.
    """

    def __init__(self, points: PointCloud, box: Any, velocities: bool = False):
        rows, columns = (max(1, round(number / COARSENING)) for number in (box.rows, box.columns))
        super().__init__(points, box, box.height, (rows, columns), 1.0)
        self.box, self.velocities = box, velocities

    def set_walls(
        self,
        distance: Callable[[np.ndarray], np.ndarray],
        outlet: Callable[[np.ndarray], np.ndarray] | None = None,
        time: float = 0.0,
    ) -> None:
        """Assemble and factorise the matrix.

        ``distance(positions)``: distance (n,) of positions (n, 2) in the box from the nearest wall, positive in the
        fluid [length]. ``outlet``: the same of an open end that is none of these walls; the pressure is 0 behind it.
        """
        from scipy.sparse import coo_matrix, diags, identity
        from scipy.sparse.linalg import splu

        rows, columns = self.shape
        width, height = self.box.length / columns, self.box.height / rows
        row, column = np.divmod(np.arange(rows * columns), columns)
        middle = np.stack([(column + 0.5) * width, (row + 0.5) * height], axis=1)
        part = np.clip(0.5 + distance(middle) / max(width, height), 0.0, 1.0)
        element = height / width * np.kron(MASS, STIFFNESS) + width / height * np.kron(STIFFNESS, MASS)
        ends = [(row + up) % rows * columns + (column + right) % columns for up in (0, 1) for right in (0, 1)]
        corners = np.array(ends)
        here, there = np.broadcast_arrays(corners[:, None], corners[None])
        volumes = part * (middle[:, 1] + self.box.origin[1]) if self.box.axisymmetric else part
        entries = element[:, :, None] * volumes / self.box.spacing**2
        matrix = coo_matrix((entries.ravel(), (here.ravel(), there.ravel())), 2 * (rows * columns,)).tocsc()
        if self.box.axisymmetric:
            area, volume = (np.bincount(corners.ravel(), np.tile(each, 4)) for each in (part, volumes))
            matrix = (diags(np.divide(area, volume, out=np.zeros_like(area), where=volume > 0.0)) @ matrix).tocsc()
        diagonal = matrix.diagonal()
        nodes, used = np.stack([column * width, row * height], axis=1), diagonal > EMPTY * diagonal.max()
        if self.velocities:
            self.node_distance = distance(nodes)
        self.closed = outlet is None
        if outlet:
            used &= outlet(nodes) > 0.0
        self.active = np.flatnonzero(used)
        floating = FLOATING * diagonal.max() * identity(len(self.active), format="csc")
        self.factors = splu(matrix[self.active][:, self.active] + floating)

    def invert(self, field: Any, sigma: float, coefficient: float) -> None:
        """Replace f at the nodes by (- ``coefficient`` Laplacian)^-1 f; ``sigma`` is 0."""
        values = view(field)[: self.shape[0] * self.shape[1]]
        result = self.invert_pressure(values.astype(float) / coefficient)
        if self.closed and values.dtype == np.float32:
            # a constant, amplified by 1 / FLOATING, is up to 1000 times the rest, of which rounding would leave little
            result[self.active] -= result[self.active].mean()
        values[...] = result

    def invert_pressure(self, values: np.ndarray) -> np.ndarray:
        """Return (-Laplacian)^-1 of ``values`` (nodes,)."""
        result = np.zeros_like(values)
        result[self.active] = self.factors.solve(values[self.active])
        return result

    def interpolation(self, points: int) -> Any:
        """Return the sparse matrix (points, nodes) that interpolates to the points, as ``interpolate`` does."""
        from scipy.sparse import csr_matrix

        rows, columns = self.shape
        row, column = np.divmod(view(self.cell)[:points], columns)
        x, y = view(self.offset)[:points].T.astype(float)
        corners = [(up, right) for up in (0, 1) for right in (0, 1)]
        nodes = [(row + up) % rows * columns + (column + right) % columns for up, right in corners]
        weights = [(y if up else 1.0 - y) * (x if right else 1.0 - x) for up, right in corners]
        begins = np.arange(points + 1) * len(corners)
        entries = np.stack(weights, axis=1).ravel(), np.stack(nodes, axis=1).ravel(), begins
        return csr_matrix(entries, (points, rows * columns))

    def factorise_velocities(self, sigma: float, viscosity: np.ndarray, components: int) -> None:
        """Factorise ``sigma`` - ``viscosity`` (nodes,) Laplacian for fields that are 0 on walls.

        It is the Laplacian of the differences between nodes; where a wall is between two of them the difference is to
        it (G. H. Shortley, R. Weller, J. Appl. Phys. 9 (1938) 334-348). In axisymmetric flow all components but the
        first are over r, and have the Laplacian (1/r^3) d(r^3 d/dr)/dr.
        """
        self.powers = [1, 3, 3][:components] if self.box.axisymmetric else [0] * components
        self.in_fluid = np.flatnonzero(self.node_distance > 0.0)
        self.velocity_factors = {power: self.factors_of(sigma, viscosity, power) for power in set(self.powers)}

    def factors_of(self, sigma: float, viscosity: np.ndarray, power: int) -> Any:
        """Return the factors of the matrix with r^``power`` in its Laplacian."""
        from scipy.sparse import coo_matrix, diags
        from scipy.sparse.linalg import splu

        rows, columns = self.shape
        width, height = self.box.length / columns, self.box.height / rows
        inside, number = self.in_fluid, np.full(rows * columns, -1)
        number[inside] = np.arange(len(inside))
        row, column = np.divmod(inside, columns)
        lower, upper = (np.maximum(row * height + self.box.origin[1] + side * height, 0.0) for side in (-0.5, 0.5))
        volume = (upper ** (power + 1) - lower ** (power + 1)) / ((power + 1) * height) if power else np.ones(len(row))
        diagonal, entries = np.full(len(inside), float(sigma)), []
        sides = (
            (0, 1, width, volume),
            (0, -1, width, volume),
            (1, 0, height, upper**power),
            (-1, 0, height, lower**power),
        )
        for up, right, apart, face in sides:
            other = (row + up) % rows * columns + (column + right) % columns
            here, there = self.node_distance[inside], self.node_distance[other]
            part = np.where(there > 0.0, 1.0, np.maximum(here / np.maximum(here - there, 1e-300), NEAREST))
            factor = viscosity[inside] * face / (volume * apart**2 * part)
            diagonal += factor
            linked = np.flatnonzero(there > 0.0)
            entries.append((-factor[linked], linked, number[other[linked]]))
        values, here, there = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return splu((coo_matrix((values, (here, there)), 2 * (len(inside),)) + diags(diagonal)).tocsc())

    def invert_velocities(self, values: np.ndarray) -> np.ndarray:
        """Return the solutions for ``values`` (nodes, components)."""
        result = np.zeros_like(values)
        for component, power in enumerate(self.powers):
            result[self.in_fluid, component] = self.velocity_factors[power].solve(values[self.in_fluid, component])
        return result


@ti.data_oriented
class TwoLevel:
    """Preconditioner of two levels, with which the number of iterations does not depend on the number of particles.

    The solver of the ``grid``, which has sorted the particles, reduces the smooth part of the residual, and a damped
    Jacobi sweep on the particles the rough part and the errors of the transfers. A second sweep before them costs more
    than the iterations that it saves. ``walls``: whether points on walls follow the fluid among the unknowns of the
    ``solver``. Their rows, one-sided derivatives, are not dominated by the diagonal: a further sweep satisfies them for
    the new values of the fluid.
    """

    def __init__(self, solver: BiCGStab, grid: AuxiliaryGrid, walls: bool = False):
        self.solver, self.grid, self.walls, self.points = solver, grid, walls, solver.points
        self.smooth = ti.field(solver.kind, solver.points.slots + 1)
        self.nodes = grid.nodes(solver.kind)

    def forget(self) -> None:
        """Take note that points have other numbers."""
        view(self.smooth)[...] = 0.0

    def apply(self) -> None:
        """Apply one cycle of the preconditioner to the solver's ``input``."""
        self.restrict()
        self.grid.invert(self.nodes, float(view(self.solver.sigma)), float(view(self.solver.coefficient)))
        self.prolong()

    @ti.kernel
    def restrict(self):
        """Transfer the solver's ``input`` to the grid."""
        ti.loop_config(serialize=self.solver.serial)
        for node in range(self.grid.rows[None] * self.grid.columns[None]):
            self.nodes[node] = self.grid.deposit(self.solver.input, node)

    @ti.kernel
    def prolong(self):
        """Interpolate the solution on the grid, sweep once, and multiply the result by the matrix."""
        particles = self.solver.number[None]
        ti.loop_config(serialize=self.solver.serial)
        for i in range(particles):
            self.smooth[i] = self.grid.interpolate(self.nodes, i)
        self.solver.update_ghosts(self.smooth, particles)
        ti.loop_config(serialize=self.solver.serial)
        for i in range(particles):
            damping = DAMPING
            if ti.static(self.walls):
                damping = ti.select(i < self.points.n_fluid[None], DAMPING, 0.0)
            residual = self.solver.input[i] - self.solver.row(self.smooth, i)
            self.solver.correction[i] = self.smooth[i] + damping * self.solver.inverse[i] * residual
        if ti.static(self.walls):
            self.solver.sweep(self.points.n_fluid[None], particles)
        self.solver.multiply(particles)
