"""Auxiliary grid between curved walls, for the pressure: bilinear finite elements, factorised once.

Of each element counts the part in the fluid, by the distance of its middle from the nearest wall. The stiffness matrix
obeys the natural boundary condition, a normal derivative of zero, as corrections of the pressure do once the rows
of the points on walls are satisfied (``TwoLevel``). It is the Galerkin operator of the particles' matrix in the limit
of many particles: the integral of grad(test) . grad(trial), over the area of a particle. It depends on where the walls
are, and not on where the particles are: where walls stay, or move along themselves, it is factorised once. In
axisymmetric flow elements count by their distance from the axis, and rows are those of a unit of volume again.
"""

import numpy as np

from tisph.runtime import ti, view
from tisph.solvers.auxiliary_grid import AuxiliaryGrid

COARSENING = 2.0
"""Distance of the nodes in particle spacings. In a cavity and around a cylinder, 25 and 20 across, there are 7 and 5
iterations a step; with 1.5 there are 6.5 and 4, and the grid takes twice as long."""

EMPTY = 1e-3
"""Part of the largest entry on the diagonal below which a node does not count."""

FLOATING = 1e-8
"""Part of the largest entry on the diagonal that is added to it, since a constant is no part of the solution."""

STIFFNESS, MASS = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
"""Of a linear element of length 1: along x and along y they give those of a bilinear one."""


@ti.data_oriented
class WalledGrid(AuxiliaryGrid):
    """Nodes of a ``box`` around the fluid; a solution needs ``set_walls`` first."""

    def __init__(self, points, box):
        shape = tuple(max(1, round(number / COARSENING)) for number in (box.rows, box.columns))
        super().__init__(points, box, box.height, shape, 1.0)
        self.box = box

    def set_walls(self, distance):
        """Assemble and factorise the matrix; ``distance`` of positions (n, 2) in the box is that from walls (n,)."""
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
        self.active = np.flatnonzero(diagonal > EMPTY * diagonal.max())
        floating = FLOATING * diagonal.max() * identity(len(self.active), format="csc")
        self.factors = splu(matrix[self.active][:, self.active] + floating)

    def invert(self, field, sigma, coefficient):
        """Replace the nodes' values f by (- ``coefficient`` Laplacian)^-1 f; ``sigma`` is 0."""
        values = view(field)[: self.shape[0] * self.shape[1]]
        found = self.factors.solve(values[self.active].astype(float) / coefficient)
        values[...] = 0.0
        values[self.active] = found
