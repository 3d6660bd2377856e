"""The operators of the implicit step on particles: least-squares derivatives closed by ghosts, and linear systems.

**Ghosts** are points beyond the walls that complete the neighbourhoods of the particles near a wall. Of a field u that
obeys u_t = nu u_yy + g near a wall with velocity U(t), the Taylor series in the distance d from the wall gives for a
particle F and its mirror image I

    u_I = 2 U - u_F + d^2 w_2 + d^4/12 w_4 + O(d^6),    w_2 = u_yy = (U' - g)/nu,  w_4 = u_yyyy = U''/nu^2

(the odd terms cancel; p_x = 0 at the wall). Treatment ``consistent_image`` uses all terms: it continues
``walls/consistent_image.py`` to the order of the operators. ``comoving_image`` and ``virtual_image`` have no terms in
w. In ``virtual_image`` the ghosts stay on the lattice and u_F is interpolated at their mirror points: by a
least-squares fit of c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 to the fluid particles around it (F. Bierbrauer,
"No-Slip Boundary Conditions in Smoothed Particle Hydrodynamics", slides 4 and 6, second way, whose fit is linear; the
Laplacian of fourth order needs the curvature). At a massless stress-controlled wall the slope of the velocity is known
and the even terms cancel: an even reflection, see ``stress_controlled.py``. The series then has odd powers.

Ghosts are few: except for the values that each iteration of a solver needs, NumPy computes all of them at once.

**Linear systems** are (1 - c A) x = b, and (1 - c A - D t D) x = b with a tangent t. On a lattice, sheared or not, all
particles of a layer have the same neighbourhood: the layers form a small system that is solved directly. For disordered
particles Jacobi iterations grow with the root of the viscous number g nu/spacing^2, and so with the number of particles
across, since steps are as long as accuracy allows. With two levels there are one or two iterations, each as expensive
as four of Jacobi.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.numerics.auxiliary_grid import DirichletGrid, TwoLevel
from tisph.numerics.bicgstab import BiCGStab
from tisph.numerics.least_squares import FEW, LeastSquaresOperators
from tisph.numerics.point_cloud import LANES, PointCloud
from tisph.runtime import holding, real, scalar, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes.implicit.channel.stages import ClosedOperators, Series
from tisph.schemes.implicit.channel.walls import stress_excess

UNKNOWNS = 6
"""Terms of the fit at a mirror point."""

SMALLEST_PIVOT = 1e-8
"""Pivot of the moments, over the sum of the weights, below which an unknown is left out."""

ROUGH = 3.0
"""Viscous number up to which Jacobi suffices: both took as long from 2 to 4."""

SAMPLED = 8
"""Particles of a layer over which its operators are averaged, where they are disordered."""

IDENTICAL = 1e-9
"""Distance from their layers, in spacings, up to which all particles of a layer count as having one neighbourhood."""


@ti.data_oriented
class Ghosts:
    """Base of ghosts, with arrays (ghosts,) in the order of their slots: ``depth`` beyond the wall ``side``.

    ``side``: 0 bottom, 1 top. ``count``: number of ghosts. ``near``: indices of the particles within ``cutoff`` of a
    wall, which have ghosts among their neighbours; ``offset`` (2, near): their distance from each wall. ``listed``: all
    ghosts in the neighbour lists of ``near``, one list after another; ``row``: index in ``near`` of the particle of
    each. ``Reflection`` gives them values.
    """

    mirrors = False
    """Whether the points list the neighbours of mirror points."""

    source: Any
    """Field of the particle that each ghost mirrors; only of mirror images."""

    def __init__(self, points: PointCloud, channel: Channel, cutoff: float) -> None:
        self.points, self.gap, self.cutoff = points, channel.gap, cutoff
        self.count, self.needed = points.ghosts, 0
        self.side, self.depth = np.empty(0, dtype=np.int64), np.empty(0)

    def find(self) -> None:
        """Place the ghosts for the present positions of the particles, before neighbours are listed."""

    def follow(self) -> None:
        """Move the ghosts with particles that have been shifted."""

    def prepare(self) -> None:
        """Find the particles near walls, and prepare the values of ghosts, at their final positions."""
        height = self.heights()
        self.near = np.flatnonzero((height < self.cutoff) | (self.gap - height < self.cutoff))
        below = height[self.near].astype(float)
        self.offset = np.stack([below, self.gap - below])
        entries, listed = self.points.rows_of(self.near)
        table = view(self.points.neighbours)[entries]
        self.row, place = np.nonzero(listed & (table >= self.points.capacity) & (table < self.points.slots))
        self.entry = entries[self.row, place]
        self.listed = table[self.row, place] - self.points.capacity

    def sums(self, rows: Any, differences: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the sums of ``rows`` times ``differences`` by near particle (near,), and by wall (2,).

        ``differences`` (listed,): value of each listed ghost less the value of the particle that lists it.
        """
        shares = view(rows)[self.entry] * differences
        return np.bincount(self.row, shares, self.near.size), np.bincount(self.side[self.listed], shares, 2)

    def heights(self) -> np.ndarray:
        """Return the y of the particles (fluid,), in place."""
        return view(self.points.position)[: self.points.fluid, 1]

    def part(self, values: np.ndarray) -> np.ndarray:
        """Return the part of an array over the slots that belongs to the ghosts, in place."""
        return values[self.points.capacity :][: self.side.size]

    def overflow(self) -> int:
        """Return the number of ghosts if there was no space for them, else 0."""
        return self.needed if self.needed > self.points.ghost_capacity else 0

    def source_values(self, values: np.ndarray) -> np.ndarray:
        """Return the values of the ghosts' sources, of an array over the slots."""
        raise NotImplementedError


class Reflection:
    """Values of a field at the ``ghosts``: a sign times the value of the source, and a ``Series`` in the depth.

    ``even``: whether the (bottom, top) wall reflects the field evenly, else oddly.
    """

    def __init__(self, ghosts: Ghosts, even: Sequence[bool]) -> None:
        self.ghosts, self.even = ghosts, tuple(even)

    def sign(self) -> np.ndarray:
        """Return 1 for each ghost, -1 beyond a wall with even reflection."""
        return np.where(np.array(self.even)[self.ghosts.side], -1.0, 1.0)

    def boundary_values(self, series: Any) -> np.ndarray:
        """Return the value at each ghost of its wall's ``series`` (2, 3)."""
        constant, second, fourth = np.asarray(series)[self.ghosts.side].T
        square = self.ghosts.depth * self.ghosts.depth
        values = constant + square * (second + square * fourth)
        return np.where(self.sign() < 0.0, self.ghosts.depth * values, values) if any(self.even) else values

    def series_slope(self, series: Any) -> np.ndarray:
        """Return the derivative across the channel of the ``series`` at each ghost."""
        constant, second, fourth = np.asarray(series)[self.ghosts.side].T
        depth = self.ghosts.depth
        square = depth * depth
        outwards = 2.0 * depth * (second + 2.0 * square * fourth)
        if any(self.even):
            odd = constant + square * (3.0 * second + 5.0 * square * fourth)
            outwards = np.where(self.sign() < 0.0, odd, outwards)
        return np.where(self.ghosts.side == 1, outwards, -outwards)


@ti.data_oriented
class MirrorGhosts(Ghosts):
    """Mirror images: ghost k is the image of particle ``source[k]``."""

    def __init__(self, points: PointCloud, channel: Channel, cutoff: float) -> None:
        super().__init__(points, channel, cutoff)
        self.source = ti.field(ti.i32, shape=points.ghost_slots)

    @staticmethod
    def ghost_capacity(channel: Channel, cutoff: float) -> int:
        """Return the number of ghosts for which there must be space: up to 1.5 times as many rows as on a lattice."""
        rows = math.ceil(1.5 * cutoff / channel.spacing) + 1
        return 2 * min(rows, channel.rows) * channel.columns

    def find(self) -> None:
        """Mirror every particle within cutoff of a wall."""
        height = self.heights()
        sources = [np.flatnonzero(height < self.cutoff), np.flatnonzero(self.gap - height < self.cutoff)]
        self.needed = sum(len(each) for each in sources)
        count = min(self.needed, self.points.ghost_slots)
        self.side = np.repeat([0, 1], [len(each) for each in sources])[:count]
        view(self.source)[:count] = np.concatenate(sources)[:count]
        view(self.count)[()] = count
        self.follow()

    def follow(self) -> None:
        """Place the ghosts at the mirror images of their sources."""
        count, first, positions = self.side.size, self.points.capacity, view(self.points.position)
        image = positions[view(self.source)[:count]]
        height, top = image[:, 1].astype(float), self.side == 1
        self.depth = np.where(top, self.gap - height, height)
        image[:, 1] = np.where(top, 2.0 * self.gap - height, -height)
        positions[first : first + count] = image

    def source_values(self, values: np.ndarray) -> np.ndarray:
        """Return the values of the ghosts' sources, of an array over the slots."""
        return values[view(self.source)[: self.side.size]]

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value that ghost ``k`` mirrors."""
        return values[self.source[k]]


@ti.data_oriented
class FixedGhosts(Ghosts):
    """Fixed ghosts; ``share[n]`` is the weight of entry n, a neighbour of the mirror point of a ghost."""

    mirrors = True

    def __init__(self, points: PointCloud, channel: Channel, cutoff: float) -> None:
        super().__init__(points, channel, cutoff)
        self.share = ti.field(real(), shape=points.entries)
        self.radius = scalar(cutoff)
        self.vector, self.matrix = ti.types.vector(UNKNOWNS, real()), ti.types.matrix(UNKNOWNS, UNKNOWNS, real())
        self.place(channel)

    @staticmethod
    def ghost_capacity(channel: Channel, cutoff: float) -> int:
        """Return the number of ghosts: all layers within cutoff."""
        return 2 * min(math.ceil(cutoff / channel.spacing), channel.rows) * channel.columns

    def place(self, channel: Channel) -> None:
        """Place the ghosts on the lattice, where they stay."""
        layers = self.points.ghost_capacity // (2 * channel.columns)
        layer, column = np.divmod(np.arange(layers * channel.columns), channel.columns)
        x, depth = (column + 0.5) * channel.spacing, (layer + 0.5) * channel.spacing
        heights, mirrored = np.concatenate([-depth, channel.gap + depth]), np.concatenate([depth, channel.gap - depth])
        count, first = heights.size, self.points.capacity
        holding(self.points.position, _padded(np.stack([np.tile(x, 2), heights], 1), first, self.points.slots + 1))
        holding(self.points.mirror, _padded(np.stack([np.tile(x, 2), mirrored], 1), 0, self.points.ghost_slots))
        holding(self.count, count)
        self.depth, self.side = np.tile(depth, 2), np.repeat([0, 1], depth.size)

    def prepare(self) -> None:
        """Find the particles near walls, and fit at all mirror points."""
        super().prepare()
        self.fit()

    @ti.kernel
    def fit(self):
        """Compute all shares."""
        ti.loop_config(serialize=self.points.serial)
        for k in range(self.count[None]):
            row = self.points.capacity + k
            moments = self.matrix(0.0)
            for n in range(self.points.begin[row], self.points.end[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[n])
                moments += weight * basis.outer_product(basis)
            coefficients = self.solved(moments)
            for n in range(self.points.begin[row], self.points.end[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[n])
                self.share[n] = weight * coefficients.dot(basis)

    @ti.func
    def weighted_basis(self, k, j):
        """Return basis and weight of point ``j`` around mirror point ``k``; the sentinel has the weight 0."""
        apart = self.points.position[j] - self.points.mirror[k]
        x, y = self.points.domain.minimum_image_x(apart.x) / self.radius[None], apart.y / self.radius[None]
        nearness = ti.max(0.0, 1.0 - x * x - y * y)
        inside = ti.cast(nearness > 0.0, self.share.dtype)
        x, y = x * inside, y * inside
        return self.vector(1.0, x, y, x * x, x * y, y * y), nearness * nearness

    @ti.func
    def solved(self, moments):
        """Return the first row of the inverse of ``moments``, by L D L^T; undetermined unknowns are left out."""
        lower, first = moments, self.vector(0.0)
        first[0] = 1.0
        for k in ti.static(range(UNKNOWNS)):
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            inverse = usable / ti.select(usable > 0.0, lower[k, k], 1.0)
            for i in ti.static(range(k + 1, UNKNOWNS)):
                factor = lower[i, k] * inverse
                for j in ti.static(range(k + 1, UNKNOWNS)):
                    lower[i, j] -= factor * lower[k, j]
                first[i] -= factor * first[k]
        for back in ti.static(range(UNKNOWNS)):
            k = ti.static(UNKNOWNS - 1 - back)
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            for j in ti.static(range(k + 1, UNKNOWNS)):
                first[k] -= lower[k, j] * first[j]
            first[k] *= usable / ti.select(usable > 0.0, lower[k, k], 1.0)
        return first

    def source_values(self, values: np.ndarray) -> np.ndarray:
        """Return the values at the mirror points, of an array over the slots."""
        count = self.side.size
        entries, listed = self.points.rows_of(slice(self.points.capacity, self.points.capacity + count))
        shares = np.where(listed, view(self.share)[entries], 0.0)
        return np.einsum("nk,nk...->n...", shares, values[view(self.points.neighbours)[entries]])

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value at the mirror point of ghost ``k``."""
        row = self.points.capacity + k
        total = 0.0 * values[0]
        for n in range(self.points.begin[row], self.points.end[row]):
            total += self.share[n] * values[self.points.neighbours[n]]
        return total


@ti.data_oriented
class ClosedParticleOperators(ClosedOperators):
    """``ClosedOperators`` on the particles of a ``channel`` for a field with this ``reflection``; arrays are (fluid,).

    ``coupled``: whether there is an extra stress.
    """

    def __init__(
        self,
        operators: LeastSquaresOperators,
        reflection: Reflection,
        channel: Channel,
        coupled: bool,
        diffusivity: float,
    ) -> None:
        self.operators, self.ghosts, self.points = operators, reflection.ghosts, operators.points
        self.reflection, self.channel, self.diffusivity = reflection, channel, diffusivity
        self.coupled = coupled
        self.round_off = float(np.finfo(view(operators.laplacian).dtype).eps)
        self.solver: Any = (CoupledSolver if coupled else ViscousSolver)(operators, reflection, channel)
        self.values, self.found = ti.field(real(), self.points.slots + 1), self.points.field(real())
        self.both = ti.field(ti.types.vector(2, real()), self.points.capacity)
        self.fluid = slice(self.points.fluid)

    def of_field(self, even: Sequence[bool], diffusivity: float) -> "ClosedParticleOperators":
        """Return the operators of another field; see ``ClosedOperators.of_field``."""
        return ClosedParticleOperators(self.operators, Reflection(self.ghosts, even), self.channel, False, diffusivity)

    def point_heights(self) -> np.ndarray:
        """Return the y of the particles."""
        return self.ghosts.heights().astype(float)

    def prepare(self) -> None:
        """Prepare linear systems with the assembled operators."""
        if self.solver.coarse:
            self.solver.coarse.assemble()

    def derivative(self, operator: str, values: np.ndarray, parity: float) -> np.ndarray:
        """Return an operator of ``values``, see ``ClosedOperators.derivative``."""
        self.close(values, parity * self.reflection.sign())
        self.apply(getattr(self.operators, operator))
        return view(self.found)[self.fluid].astype(float)

    def full_gradient(self, values: np.ndarray, parity: np.ndarray, boundary: Any) -> np.ndarray:
        """Return both derivatives (fluid, 2) of ``values``, in an array that the next call overwrites.

        Ghosts have ``parity`` (ghosts,) times the value of their source in the fluid, plus ``boundary``.
        """
        ghosts = self.close(values, parity)
        ghosts += boundary
        self.apply_both()
        return view(self.both)[self.fluid]

    def derivatives(self, values: np.ndarray, series: Sequence[Series], slope: Any, curvature: Any) -> None:
        """Set ``slope`` (fluid, 2), the gradient of ``values``, and ``curvature`` (fluid, 3): d_xx, d_xy and d_yy."""
        reflection, sign = self.reflection, self.reflection.sign()
        slope[...] = self.full_gradient(values, -sign, reflection.boundary_values(series))
        curvature[:, :2] = self.full_gradient(slope[:, 0], -sign, 0.0)
        curvature[:, 2] = self.full_gradient(slope[:, 1], sign, reflection.series_slope(series))[:, 1]

    def close(self, values: np.ndarray, parity: np.ndarray) -> np.ndarray:
        """Store ``values`` and ``parity`` (ghosts,) times them for the ghosts; return the ghosts' part, in place."""
        everywhere = view(self.values)
        everywhere[self.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.source_values(everywhere)
        return ghosts

    @ti.kernel
    def apply(self, rows: ti.template()):
        """Compute a derivative of ``values``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.found[i] = self.operators.apply(rows, self.values, i)

    @ti.kernel
    def apply_both(self):
        """Compute both first derivatives of ``values``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            along = self.operators.apply(self.operators.d_dx, self.values, i)
            across = self.operators.apply(self.operators.d_dy, self.values, i)
            self.both[i] = [along, across]

    def boundary(self, operator: str, series: Sequence[Series]) -> np.ndarray:
        """Return the part of an operator from the ``series`` of the images beyond both walls."""
        return self.from_images(operator, self.reflection.boundary_values(series))

    def boundary_stress(self, side: int, slope: Any, third: Any) -> np.ndarray:
        """Return the part of d/dy of the stress from its derivatives at a wall, see ``stress_excess``."""
        return self.from_images("d_dy", self.image_stress(side, slope, third))

    def image_stress(self, side: int, slope: float, third: float) -> np.ndarray:
        """Return the ``stress_excess`` of each image beyond the wall ``side``, 0 beyond the other (ghosts,)."""
        excess = stress_excess(self.ghosts.depth, side, self.reflection.even[side], slope, third)
        return np.where(self.ghosts.side == side, excess, 0.0)

    def from_images(self, operator: str, values: np.ndarray) -> np.ndarray:
        """Return the part of an operator from the ``values`` (ghosts,) of the images."""
        sums, rows = np.zeros(self.points.fluid), getattr(self.operators, operator)
        sums[self.ghosts.near] = self.ghosts.sums(rows, values[self.ghosts.listed])[0]
        return sums

    def solve(
        self, gamma_dt: float, tangent: np.ndarray | None, right: np.ndarray, guess: np.ndarray, tolerance: float
    ) -> np.ndarray | None:
        """Solve (1 - g nu_s A - g D T D) x = ``right``, see ``ClosedOperators.solve``."""
        solver, coefficient = self.solver, gamma_dt * self.diffusivity
        view(solver.x)[self.fluid], view(solver.b)[self.fluid] = guess, right
        if tangent is None:
            solved = solver.solve(coefficient, tolerance)
        else:
            solved = solver.solve_coupled(coefficient, gamma_dt * tangent, tolerance)
        return view(solver.x)[self.fluid].astype(float) if solved else None

    def near_wall(self, side: int) -> tuple[np.ndarray, np.ndarray, float]:
        """Return the particles near any wall, their distances from the wall ``side``, and the radius of fits."""
        return self.ghosts.near, self.ghosts.offset[side], self.ghosts.cutoff


@ti.data_oriented
class ReflectingSolver(BiCGStab):
    """A ``BiCGStab`` for a field with a ``reflection`` between the walls of a ``channel``."""

    def __init__(self, operators: LeastSquaresOperators, reflection: Reflection, channel: Channel) -> None:
        super().__init__(operators, reflection.ghosts)
        self.mixed, self.middle = any(reflection.even), scalar(channel.gap / 2.0)
        self.signs = holding(ti.field(real(), 2), [-1.0 if even else 1.0 for even in reflection.even])

    @ti.func
    def sign(self, k):
        """Return 1, or -1 for a ghost beyond a wall with even reflection."""
        sign = ti.cast(1.0, self.signs.dtype)
        if ti.static(self.mixed):
            upper = ti.cast(self.points.position[self.points.capacity + k].y > self.middle[None], ti.i32)
            sign = self.signs[upper]
        return sign

    @ti.func
    def reflect(self, values, k):
        """Set the value of ghost ``k``."""
        values[self.points.capacity + k] = -self.sign(k) * self.ghosts.value(values, k)

    @ti.func
    def update_ghosts(self, values: ti.template(), particles):
        """Reflect ``values``."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)


@ti.data_oriented
class ViscousSolver(ReflectingSolver):
    """Solver of (1 - c A) x = b in a ``channel``.

    ``two_level``: the preconditioner of two levels, made for the first system that needs it. Few particles use Jacobi:
    the kernels of two levels take as long to compile as they save in a whole run.
    """

    def __init__(self, operators: LeastSquaresOperators, reflection: Reflection, channel: Channel) -> None:
        super().__init__(operators, reflection, channel)
        self.channel = channel
        self.two_level: Any = None
        mirrors = reflection.ghosts.mirrors
        self.coarse = None if mirrors else LayerCoarseSpace(operators, reflection, channel, coupled=False)
        self.roughest = ROUGH * channel.spacing**2

    def solve(self, coefficient: float, tolerance: float) -> bool:  # type: ignore[override]
        """Solve (1 - ``coefficient`` A) x = b; return whether the residual is at most ``tolerance`` |b|."""
        if self.coarse and self.coarse.layers_identical:
            fluid = slice(self.points.fluid)
            view(self.x)[fluid] = self.coarse.solution(view(self.b)[fluid], coefficient)
            return super().solve(coefficient, tolerance)
        if coefficient <= self.roughest or self.points.fluid <= FEW:
            return super().solve(coefficient, tolerance)
        if self.two_level is None:
            self.two_level = TwoLevel(self, DirichletGrid(self.points, self.channel, self.channel.gap))
        self.two_level.grid.sort()
        return super().solve(coefficient, tolerance, preconditioner=self.two_level)


@ti.data_oriented
class CoupledSolver(ReflectingSolver):
    """Solver of (1 - c A - D t D) x = b; ``tangent_stress`` (slots + 1) is t D x.

    Both derivatives D use the rows of the same least-squares operators as the stages, so the solver solves the discrete
    equation of the scheme. Images of D x and of the stress are even where images of x are odd, and odd beyond a wall
    with even reflection.
    """

    def __init__(self, operators: LeastSquaresOperators, reflection: Reflection, channel: Channel) -> None:
        super().__init__(operators, reflection, channel)
        mirrors = reflection.ghosts.mirrors
        self.coarse = None if mirrors else LayerCoarseSpace(operators, reflection, channel, coupled=True)
        self.tangent, self.tangent_stress = self.points.field(real()), ti.field(real(), self.points.slots + 1)
        self.fluid = slice(self.points.fluid)

    @ti.func
    def update_ghosts(self, values: ti.template(), particles):
        """Reflect ``values``, and compute their ``tangent_stress`` on particles and images."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.tangent_stress[i] = self.tangent[i] * self.operators.apply(self.operators.d_dy, values, i)
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            image = self.sign(k) * self.ghosts.value(self.tangent_stress, k)
            self.tangent_stress[self.points.capacity + k] = image

    @ti.func
    def row(self, values: ti.template(), i):
        """Return row ``i`` of the system times ``values``, whose ``tangent_stress`` is known."""
        centre, stress, total = values[i], self.tangent_stress[i], 0.0 * values[i]
        for group in range(self.points.begin[i] // LANES, self.points.end[i] // LANES):
            for lane in ti.static(range(LANES)):  # both sums at once: they read the same neighbours
                k = group * LANES + lane
                j = self.points.neighbours[k]
                viscous = self.coefficient[None] * self.operators.laplacian[k] * (values[j] - centre)
                total += viscous + self.operators.d_dy[k] * (self.tangent_stress[j] - stress)
        return self.sigma[None] * centre - total

    def solve_coupled(self, coefficient: float, tangent: np.ndarray, tolerance: float) -> bool:
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = b; return whether the residual is small enough.

        ``tolerance``: largest residual over |b|. ``tangent`` (fluid,).
        """
        view(self.tangent)[self.fluid] = tangent
        if self.coarse:
            view(self.coefficient)[()], view(self.sigma)[()] = coefficient, 1.0
            self.start()
            residual = view(self.residual)[self.fluid].astype(float)
            correction = self.coarse.correction(residual, coefficient, np.broadcast_to(tangent, residual.shape))
            view(self.x)[self.fluid] += correction
        return super().solve(coefficient, tolerance)


class LayerCoarseSpace:
    """A coarse space with one unknown a layer of a ``channel``, linear in between; for mirror images.

    ``layers_identical``: whether all particles of a layer have the same neighbourhood. ``coupled``: whether systems
    have a tangent.
    """

    def __init__(
        self, operators: LeastSquaresOperators, reflection: Reflection, channel: Channel, coupled: bool
    ) -> None:
        self.operators, self.points, self.ghosts = operators, operators.points, reflection.ghosts
        self.reflection, self.coupled = reflection, coupled
        self.spacing, self.number = channel.spacing, channel.rows
        self.layers_identical = False
        self.inverted: float | None = None

    def assemble(self) -> None:
        """Average the operators over each layer, for the present positions of the particles."""
        self.locate()
        if self.coupled or self.layers_identical:
            self.sample(SAMPLED if self.coupled else 1)
            self.laplacian, self.inverted = self.matrix(self.operators.laplacian, self.odd), None
        if self.coupled:
            self.odd_gradient, self.even_gradient = (
                self.matrix(self.operators.d_dy, sign) for sign in (self.odd, self.even)
            )

    def locate(self) -> None:
        """Find the nearest layer of each particle, and the layers on both sides of it."""
        height = self.ghosts.heights().astype(float) / self.spacing - 0.5
        below = np.clip(np.floor(height), 0, self.number - 2).astype(int)
        self.below, self.offset = below, height - below
        self.layer = np.clip(np.rint(height), 0, self.number - 1).astype(int)
        self.counts = np.maximum(np.bincount(self.layer, minlength=self.number), 1)
        self.layers_identical = bool(np.abs(height - self.layer).max() < IDENTICAL)

    def sample(self, most: int) -> None:
        """Choose up to ``most`` particles of each layer, and list their neighbours."""
        order = np.argsort(self.layer, kind="stable")
        rank = np.arange(len(order)) - np.searchsorted(self.layer[order], self.layer[order])
        self.sampled = order[rank < most]
        source = np.arange(self.points.slots + 1)
        ghosts = self.ghosts.part(source)
        ghosts[...] = view(self.ghosts.source)[: ghosts.size]
        source[self.points.capacity + ghosts.size :] = source[self.points.fluid : self.points.capacity] = 0
        self.entries, self.listed = self.points.rows_of(self.sampled)
        table = view(self.points.neighbours)[self.entries]
        signs = np.ones(self.points.slots + 1)
        ghosts = self.ghosts.part(signs)
        ghosts[...] = self.reflection.sign()
        self.others, self.even = source[table], signs[table]
        self.odd = np.where(table >= self.points.capacity, -self.even, self.even)

    def matrix(self, rows: Any, sign: np.ndarray) -> np.ndarray:
        """Return the operator (layers, layers) of the least-squares ``rows``, with the ``sign`` of each neighbour."""
        entries = np.where(self.listed, view(rows)[self.entries], 0.0).astype(float)
        sampled, others = self.sampled, self.others
        first = self.layer[sampled] * self.number
        matrix = np.zeros(self.number**2)
        centre = -entries.sum(axis=1)
        for step in (0, 1):
            share = sign * entries * (self.offset[others] if step else 1.0 - self.offset[others])
            index = (first[:, None] + self.below[others] + step).ravel()
            matrix += np.bincount(index, share.ravel(), self.number**2)
            share = centre * (self.offset[sampled] if step else 1.0 - self.offset[sampled])
            matrix += np.bincount(first + self.below[sampled] + step, share, self.number**2)
        counts = np.bincount(self.layer[sampled], minlength=self.number)
        return matrix.reshape(self.number, self.number) / np.maximum(counts, 1)[:, None]

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means (layers,) of ``values`` (fluid,)."""
        return np.bincount(self.layer, values, self.number) / self.counts

    def solution(self, right: np.ndarray, coefficient: float) -> np.ndarray:
        """Solve (1 - coefficient A) x = ``right`` (fluid,) on identical layers."""
        if coefficient != self.inverted:  # all stages of a step have the same
            self.inverse = np.linalg.inv(np.eye(self.number) - coefficient * self.laplacian)
            self.inverted = coefficient
        return np.einsum("ij,j", self.inverse, self.mean(right))[self.layer]  # BLAS would start threads

    def correction(self, residual: np.ndarray, coefficient: float, tangent: np.ndarray) -> np.ndarray:
        """Return the correction of velocities (fluid,) for a ``residual`` of (1 - coefficient A - D tangent D) x."""
        coupling = np.einsum("ij,jk->ik", self.even_gradient, self.mean(tangent)[:, None] * self.odd_gradient)
        found = np.linalg.solve(np.eye(self.number) - coefficient * self.laplacian - coupling, self.mean(residual))
        return (1.0 - self.offset) * found[self.below] + self.offset * found[self.below + 1]


def _padded(values: np.ndarray, first: int, size: int) -> np.ndarray:
    """Return an array of ``size`` with ``values`` from ``first`` on, else zeros."""
    after = size - first - len(values)
    return np.pad(values, [(first, after)] + [(0, 0)] * (values.ndim - 1))
