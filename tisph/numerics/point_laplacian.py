"""A Laplacian on the points themselves, whose inverse preconditions the linear systems where the spacing varies.

A regular auxiliary grid does not follow such points. The graph of the 8 nearest neighbours does, with the weights

    w_ij = h_i h_j / (2 r_ij^2)

of the pairs, h being the spacings and r_ij the distance: sum_j w_ij (p_j - p_i) is h_i^2 times the Laplacian on a
lattice, where 4 neighbours are at h and 4 at sqrt(2) h. The matrix is symmetric, and singular by constants alone. Its
factors are computed anew when points have moved by ``STALE`` of their spacing, or others are there.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from tisph.geometry.region import nearest_image
from tisph.numerics.auxiliary_grid import FLOATING
from tisph.numerics.point_cloud import PointCloud
from tisph.runtime import integer, ti, view

NEAREST = 8
"""Neighbours of a point in the graph."""

SYMMETRIC: Any = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
"""Options of the factors of a matrix with a symmetric pattern: a third of the entries of others."""

STALE = 0.5
"""Displacement of a point, over its spacing, from which on the factors are computed anew."""


@ti.data_oriented
class PointLaplacian:
    """The Laplacian on the ``points`` in a ``box``, with the functions of an ``AuxiliaryGrid`` whose nodes they are.

    ``outlet``: see ``AuxiliaryGrid``. ``place`` (points, 2), ``spacing`` (points,): what the factors belong to.
    """

    def __init__(self, points: PointCloud, box: Any) -> None:
        self.points, self.box = points, box
        self.rows, self.columns = points.particles, integer(1)
        self.outlet: Any = None
        self.parts = {"laplacian": self}
        self.forget()

    def forget(self) -> None:
        """Forget the factors, and make room for those of the present number of points."""
        self.place, self.spacing = np.full((self.points.fluid, 2), np.nan), np.ones(self.points.fluid)
        self.factors: Any = None

    def nodes(self, kind: Any) -> Any:
        """Return a field of this ``kind`` for each node."""
        return ti.field(kind, self.points.slots + 1)

    def set_walls(self, distance: Callable, outlet: Callable | None = None) -> None:
        """Do nothing: points on walls are nodes."""

    def sort(self) -> None:
        """Compute the factors, if those there are belong to points too far from the present ones."""
        present = view(self.points.position)[: self.points.fluid].astype(float)
        spacing = self.box.spacing * view(self.points.relative_spacing)[: self.points.fluid].astype(float)
        moved = np.hypot(*nearest_image(present - self.place, (self.box.length, self.box.height)).T)
        if not (moved < STALE * spacing).all():
            self.place, self.spacing, self.factors = present, spacing, None
        if self.factors is None:  # a resumed run has those of earlier positions
            self.factorise()

    def factorise(self) -> None:
        """Assemble and factorise the matrix of the points at ``place`` with their ``spacing`` (points,)."""
        from scipy.sparse import identity
        from scipy.sparse.linalg import splu

        self.pairs = self.graph()
        matrix = self.matrix(1 if self.box.axisymmetric else 0)
        self.last = len(self.place) if self.outlet is None else int(view(self.outlet))
        matrix = matrix[: self.last, : self.last]
        floating = FLOATING * matrix.diagonal().max() * identity(self.last, format="csc")
        self.factors = splu(matrix + floating, **SYMMETRIC)

    def matrix(self, power: int) -> Any:
        """Return minus the Laplacian (points, points) with r^``power``, times the areas over the largest one."""
        from scipy.sparse import coo_matrix, diags

        weights, (here, there) = self.pairs
        if power:
            radius = self.place[:, 1] + self.box.origin[1]
            weights = weights * (0.5 * (radius[here] + radius[there]) / radius[here]) ** power
        graph = coo_matrix((weights, (here, there)), 2 * (len(self.place),))
        return (diags(np.asarray(graph.sum(axis=1)).ravel()) - graph).tocsc()

    def graph(self) -> Any:
        """Return the weights of all pairs, over the square of the largest spacing, and the indices of both points."""
        from scipy.spatial import cKDTree

        n, spacing = len(self.place), self.spacing
        distance, nearest = cKDTree(self.place, boxsize=(self.box.length, self.box.height)).query(
            self.place, NEAREST + 1
        )
        here, there, apart = np.repeat(np.arange(n), NEAREST), nearest[:, 1:].ravel(), distance[:, 1:].ravel()
        low, high = np.minimum(here, there), np.maximum(here, there)
        _, chosen = np.unique(low * n + high, return_index=True)
        low, high, apart = low[chosen], high[chosen], apart[chosen]
        weight = 0.5 * spacing[low] * spacing[high] / (apart * self.box.spacing) ** 2
        return np.tile(weight, 2), (np.concatenate([low, high]), np.concatenate([high, low]))

    @ti.func
    def deposit(self, values: ti.template(), node):
        """Return the value of the point that is node number ``node``."""
        return values[node]

    @ti.func
    def interpolate(self, values: ti.template(), i):
        """Return the value of the node that is point ``i``."""
        return values[i]

    def invert(self, field: Any, sigma: float, coefficient: float) -> None:
        """Replace f at the nodes by (- ``coefficient`` Laplacian)^-1 f; ``sigma`` is 0."""
        values = view(field)[: self.points.fluid]
        values[...] = self.invert_pressure(values.astype(float) / coefficient)

    def invert_pressure(self, values: np.ndarray) -> np.ndarray:
        """Return (-Laplacian)^-1 of ``values`` (points,), of mean 0 where no pressure is known."""
        result = np.zeros_like(values)
        known = self.last < len(values)
        right = values[: self.last]
        found = self.factors.solve(right if known else right - right.mean())
        result[: self.last] = found if known else found - found.mean()
        return result

    def interpolation(self, points: int) -> Any:
        """Return the sparse matrix (points, nodes) that interpolates to the points: they are the nodes."""
        from scipy.sparse import identity

        return identity(points, format="csr")

    def factorise_velocities(self, sigma: float, viscosity: np.ndarray, components: int) -> None:
        """Factorise ``sigma`` - ``viscosity`` (nodes,) Laplacian for fields that are 0 on walls.

        In axisymmetric flow all components but the first are over r, as in ``WalledGrid.factorise_velocities``.
        """
        from scipy.sparse import diags
        from scipy.sparse.linalg import splu

        inside = self.points.in_fluid
        self.powers = [1, 3, 3][:components] if self.box.axisymmetric else [0] * components
        mass, viscous = diags(sigma * self.points.areas), diags(viscosity[:inside])
        self.velocity_factors = {
            power: splu((mass + viscous @ self.matrix(power)[:inside, :inside]).tocsc(), **SYMMETRIC)
            for power in set(self.powers)
        }

    def invert_velocities(self, values: np.ndarray) -> np.ndarray:
        """Return the solutions for ``values`` (nodes, components)."""
        result, inside = np.zeros_like(values), self.points.in_fluid
        for component, power in enumerate(self.powers):
            right = self.points.areas * values[:inside, component]
            result[:inside, component] = self.velocity_factors[power].solve(right)
        return result
