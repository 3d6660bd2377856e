"""An auxiliary grid whose nodes are as close to one another as particles where the spacing varies.

Cells of a regular grid are divided into four until they are as large as two spacings wanted at their middle, up to a
factor of the square root of 2; as one, where velocities are solved with the pressure. The nodes are the middles of
those in the fluid. Nodes less than half a cell from a wall are moved onto it, those farther beyond it left out. Linear
finite elements on the triangles of B. Delaunay (1934) between them have, for a triangle of area A with the edges e_1,
e_2, e_3 against its corners, the stiffness matrix e_i . e_j/(4 A). Unlike the particles the nodes rest, so the matrices
are factorised when walls have moved.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from tisph.numerics.auxiliary_grid import COARSENING, FLOATING
from tisph.numerics.point_cloud import PointCloud
from tisph.runtime import integer, ti, view

COARSENING_TOGETHER = 1.0
"""The same where velocities and pressures are solved together. Errors that the grid does not see are left in velocities
and cut steps: with 2 in place of 1 a free circle without inertia takes 1.2 times the time for a step, and a third of
the step."""

COPIED = 4.0
"""Width of the strip beside a border of a periodic box, in largest cells, whose nodes have copies beyond the other."""

THIN = 0.02
"""Area of a triangle, over the square of its longest edge, below which it is left out: corners on a straight wall."""

ON_WALL = 1e-3
"""Distance from a wall, in largest spacings, up to which a node is on it: moved there, it misses it by round-off."""

SYMMETRIC: Any = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
"""Options of the factors of a matrix with a symmetric pattern: a third of the entries of others."""

Distance = Callable[[np.ndarray], np.ndarray]


def no_walls(places: np.ndarray) -> np.ndarray:
    """Return the distances (n,) of ``places`` (n, 2) from walls that are not there."""
    return np.full(len(places), np.inf)


@ti.data_oriented
class GradedGrid:
    """Grid of the ``points`` in a ``box``, with the functions of an ``AuxiliaryGrid``.

    To kernels its nodes are the points; ``invert`` transfers to the nodes of the triangles and back. ``spread``:
    sparse matrix (points, nodes) that interpolates to the points. ``volume``: of the nodes over the square of the
    largest spacing, by the power of the radius. ``velocities``: whether the grid serves them as well. ``outlet``: see
    ``AuxiliaryGrid``.
    """

    outlet: Any = None

    def __init__(self, points: PointCloud, box: Any, velocities: bool) -> None:
        self.points, self.box = points, box
        self.coarsening = COARSENING_TOGETHER if velocities else COARSENING
        self.rows, self.columns = points.particles, integer(1)
        self.factors: Any = None

    def nodes(self, kind: Any) -> Any:
        """Return a field of this ``kind`` for each point."""
        return ti.field(kind, self.points.slots + 1)

    def set_walls(self, distance: Distance, outlet: Distance | None = None, time: float = 0.0) -> None:
        """Place the nodes for the walls and the spacing at ``time``, and factorise the matrix of the pressure.

        ``distance``, ``outlet``: see ``WalledGrid.set_walls``.
        """
        from scipy.sparse import diags, identity
        from scipy.sparse.linalg import splu

        ends = outlet or no_walls
        self.place = place = self.placed(distance, ends, time)
        self.triangulate(lambda places: np.minimum(distance(places), ends(places)))
        used, least = self.volume[0] > 0.0, ON_WALL * self.box.spacing
        self.free = np.flatnonzero(used & (distance(place) > least))
        self.active = np.flatnonzero(used & (ends(place) > least))
        self.closed = outlet is None
        power = 1 if self.box.axisymmetric else 0
        rows = diags(self.volume[0] / np.maximum(self.volume[power], 1e-300))
        matrix = (rows @ self.stiffness(power)).tocsc()[self.active][:, self.active]
        floating = FLOATING * matrix.diagonal().max() * identity(len(self.active), format="csc")
        self.factors = splu(matrix + floating, **SYMMETRIC)

    def placed(self, distance: Distance, ends: Distance, time: float) -> np.ndarray:
        """Return the places (nodes, 2), in the box, where distances from walls and ``ends`` are these."""
        box, most = self.box, self.coarsening * self.box.spacing
        shape = [max(1, round(length / most)) for length in (box.length, box.height)]
        size = np.array([box.length, box.height]) / shape
        self.largest_cell = size.max()
        cells = np.stack(np.meshgrid(*(np.arange(number) + 0.5 for number in shape)), axis=-1).reshape(-1, 2) * size
        found = []
        while len(cells):
            away = np.minimum(distance(cells), ends(cells))
            cells, away = cells[away > -size.max()], away[away > -size.max()]
            wanted = self.coarsening * box.wanted_spacing.at(cells + box.origin, time)
            whole = wanted**2 > 0.5 * size.prod()
            found.append(self.onto_walls(cells[whole], away[whole], 0.5 * size.max(), distance, ends))
            quarters = 0.25 * size * [(1, 1), (1, -1), (-1, 1), (-1, -1)]
            cells, size = (cells[~whole, None] + quarters).reshape(-1, 2), 0.5 * size
        return np.concatenate(found)

    def onto_walls(
        self, cells: np.ndarray, away: np.ndarray, near: float, distance: Distance, ends: Distance
    ) -> np.ndarray:
        """Return ``cells`` (n, 2), moved onto walls that are ``near``; cells farther beyond them are left out."""
        cells, away = cells[away > -near], away[away > -near]
        moved = np.flatnonzero(away < near)
        for walls in (distance, ends):
            beside, step = cells[moved], 1e-4 * near
            now = walls(beside)
            close = np.isfinite(now) & (np.abs(now) < near)
            moved_here, now, beside = moved[close], now[close], beside[close]
            slope = np.stack([(walls(beside + each) - now) / step for each in step * np.eye(2)], axis=1)
            cells[moved_here] -= now[:, None] * slope
        return cells

    def triangulate(self, distance: Distance) -> None:
        """Make the triangles (n, 3) between the nodes; ``distance`` from walls or ends."""
        from scipy.spatial import Delaunay, cKDTree

        box, place, owner = self.box, self.place, np.arange(len(self.place))
        strip = COPIED * self.largest_cell
        for axis, period in enumerate((box.length, box.height)):
            low, high = place[:, axis] < strip, place[:, axis] > period - strip
            shift = period * np.eye(2)[axis]
            place = np.concatenate([place, place[low] + shift, place[high] - shift])
            owner = np.concatenate([owner, owner[low], owner[high]])
        if box.reaches_axis:
            near = np.abs(place[:, 1] + box.origin[1]) < strip
            mirrored = place[near] * [1.0, -1.0] - [0.0, 2.0 * box.origin[1]]
            place, owner = np.concatenate([place, mirrored]), np.concatenate([owner, owner[near]])
        self.owner, self.nearest, self.triangles = owner, cKDTree(place), Delaunay(place)
        corners = self.triangles.simplices
        x, y = np.moveaxis(place[corners], 2, 0)
        middle = np.stack([x.mean(axis=1), y.mean(axis=1)], axis=1)
        edges = np.stack([np.roll(each, -1, 1) - np.roll(each, -2, 1) for each in (x, y)], axis=2)
        area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
        self.sound = area > THIN * (edges**2).sum(axis=2).max(axis=1)
        here = (middle >= 0.0).all(axis=1) & (middle < (box.length, box.height)).all(axis=1) & self.sound
        if box.reaches_axis:
            here &= middle[:, 1] + box.origin[1] > 0.0
        here[here] = distance(middle[here]) > 0.0
        corners, edges, area = owner[corners[here]], edges[here], area[here]
        self.corners, self.area = corners, area
        self.radius = middle[here, 1] + box.origin[1]
        self.entries = np.einsum("tia,tja->tij", edges, edges) / (4.0 * area * box.spacing**2)[:, None, None]
        powers = (0, 1, 3) if box.axisymmetric else (0,)
        third = area / (3.0 * box.spacing**2)
        self.volume = {power: self.sums(third * self.radius**power) for power in powers}

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Return the sums (nodes,) of ``values`` (triangles,) around each node."""
        return np.bincount(self.corners.ravel(), np.repeat(values, 3), len(self.place))

    def stiffness(self, power: int, factor: np.ndarray | None = None) -> Any:
        """Return the matrix (nodes, nodes) of minus div(r^``power`` ``factor`` (nodes,) grad), over spacing squared."""
        from scipy.sparse import coo_matrix

        weight = self.radius**power
        if factor is not None:
            weight = weight * factor[self.corners].mean(axis=1)
        entries = self.entries * weight[:, None, None]
        here, there = np.broadcast_arrays(self.corners[:, :, None], self.corners[:, None, :])
        return coo_matrix((entries.ravel(), (here.ravel(), there.ravel())), 2 * (len(self.place),)).tocsc()

    def sort(self) -> None:
        """Find the triangles of the points at their present positions."""
        from scipy.sparse import csr_matrix

        if self.factors is None:
            self.set_walls(no_walls)
        place = view(self.points.position)[: self.points.fluid].astype(float)
        found = self.triangles.find_simplex(place)
        transform = self.triangles.transform[found]
        two = np.einsum("pij,pj->pi", transform[:, :2], place - transform[:, 2])
        weights, nodes = np.concatenate([two, 1.0 - two.sum(axis=1, keepdims=True)], axis=1), self.triangles.simplices
        nodes = nodes[found]
        lost = (found < 0) | ~self.sound[found]
        weights[lost] = [1.0, 0.0, 0.0]
        nodes[lost] = self.nearest.query(place[lost])[1][:, None]
        begins = 3 * np.arange(len(place) + 1)
        self.spread = csr_matrix((weights.ravel(), self.owner[nodes].ravel(), begins), (len(place), len(self.place)))
        self.gather = self.spread.T.tocsr()

    def interpolation(self, points: int) -> Any:
        """Return the sparse matrix (points, nodes) that interpolates to the points."""
        return self.spread

    @ti.func
    def deposit(self, values: ti.template(), node):
        """Return the value of the point that is node number ``node``."""
        return values[node]

    @ti.func
    def interpolate(self, values: ti.template(), i):
        """Return the value of the node that is point ``i``."""
        return values[i]

    def invert(self, field: Any, sigma: float, coefficient: float) -> None:
        """Replace f at the points by (- ``coefficient`` Laplacian)^-1 f; ``sigma`` is 0."""
        values = view(field)[: self.points.fluid]
        values[...] = self.spread @ self.invert_pressure(self.gather @ (values.astype(float) / coefficient))

    def invert_pressure(self, values: np.ndarray) -> np.ndarray:
        """Return (-Laplacian)^-1 of ``values`` (nodes,), of mean 0 where no pressure is known."""
        result, right = np.zeros_like(values), values[self.active]
        found = self.factors.solve(right - right.mean() if self.closed else right)
        result[self.active] = found - found.mean() if self.closed else found
        return result

    def factorise_velocities(self, sigma: float, viscosity: np.ndarray, components: int) -> None:
        """Factorise ``sigma`` - ``viscosity`` (nodes,) Laplacian for fields that are 0 on walls.

        In axisymmetric flow all components but the first are over r, as in ``WalledGrid.factorise_velocities``.
        """
        from scipy.sparse import diags
        from scipy.sparse.linalg import splu

        self.powers = [1, 3, 3][:components] if self.box.axisymmetric else [0] * components
        self.velocity_factors = {}
        for power in set(self.powers):
            matrix = (diags(sigma * self.volume[power]) + self.stiffness(power, viscosity)).tocsc()
            self.velocity_factors[power] = splu(matrix[self.free][:, self.free], **SYMMETRIC)

    def invert_velocities(self, values: np.ndarray) -> np.ndarray:
        """Return the solutions for ``values`` (nodes, components)."""
        result = np.zeros_like(values)
        for component, power in enumerate(self.powers):
            right = self.volume[power][self.free] * values[self.free, component]
            result[self.free, component] = self.velocity_factors[power].solve(right)
        return result
