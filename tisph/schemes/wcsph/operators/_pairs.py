"""The common part of both sets of operators: pair weight, separation and linear artificial viscosity.

The weight is the slope of the kernel over the distance. A root, a division and three powers would be nearly half the
arithmetic of a pair; a table replaces them, which is a piecewise linear function of the squared distance. It is a
kernel as good as the original one, since the consistent operators are normalised by their own moments, for any weights.

Pair loops look one neighbour ahead: separation and weight of the next pair are computed while the present pair is
summed. Otherwise the processor would wait for each weight; a step takes a tenth to a quarter less time. No pair loop
treats two pairs at once: the compiler would pack them into a vector, whose shuffles take longer than that saves.
"""

from typing import Any

import numpy as np

from tisph.runtime import holding, real, scalar, ti, unrolled
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.cells import Particles
from tisph.schemes.wcsph.verlet import VerletLists

INTERVALS = 2048
"""Intervals within the support, a power of two: the weights are within 1e-5 of the largest (tested)."""

ENTRIES = 2 * INTERVALS
"""Table size: zero from the support to sqrt(2) times its radius, farther than any pair of a list can be; 64 kB."""


@ti.data_oriented
class WeightTable:
    """Weights -h^4 W'(r)/r of ``kernel`` for smoothing length ``length``, zero beyond its support.

    Entry k holds intercept and slope of the weight over the squared distance in interval k.
    """

    def __init__(self, kernel: Any, length: float):
        squares = np.arange(INTERVALS + 1) * (kernel.SUPPORT**2 / INTERVALS)
        # the limit at zero distance, where no pair is, need not be exact
        values = np.array([kernel.slope_over_q(q) for q in np.sqrt(np.maximum(squares, 1e-6))])
        slopes = np.diff(values) / np.diff(squares)
        lines = np.zeros((ENTRIES, 2))
        lines[:INTERVALS] = np.stack([values[:-1] - slopes * squares[:-1], slopes / length**2], 1)
        self.entries = holding(ti.Vector.field(2, real(), shape=ENTRIES), lines)
        self.per_square = scalar(INTERVALS / (kernel.SUPPORT * length) ** 2)

    @ti.func
    def at(self, squared):
        """Return the weight of a pair at a squared distance; for any distance, even NaN, the entry exists."""
        line = self.entries[ti.cast(squared * self.per_square[None], ti.i32) & (ENTRIES - 1)]
        return line.x + squared * line.y


@ti.data_oriented
class PairOperators:
    """Access to particles and lists, and the rates that an evaluation returns.

    ``Rates``: ``acceleration``, rate of ``compression``, ``transport``, the velocity of the particle relative to
    the fluid, and where particles carry stress, the rate of ``stress``. ``pair_weight``: factor from the weights of the
    table to V_j (-W'(r)/r), with the volume V = spacing^2 of every particle up to the weak compression. A set of
    operators has ``rates(now, i)``, ``pair_sums(now, i, periodic)`` with its structure ``Sums``, and for the force on
    walls ``pair_pull`` and ``pull_norm``. ``kernel``: a module of ``tisph/schemes/wcsph/kernels``.
    """

    Sums: Any
    """Structure of the sums over neighbours."""

    def __init__(self, lists: VerletLists, fluid: Fluid, kernel: Any, artificial_viscosity: float, shift_speed: float):
        self.particles: Particles = lists.particles
        self.lists = lists
        self.domain = lists.domain
        self.fluid = fluid
        self.has_artificial_viscosity = artificial_viscosity > 0
        if self.has_artificial_viscosity:
            self.artificial_viscosity = scalar(artificial_viscosity)
        self.shift_speed = scalar(shift_speed)
        length = lists.cutoff / kernel.SUPPORT
        self.weights = WeightTable(kernel, length)
        self.smoothing_length = scalar(length)
        self.pair_weight = scalar(lists.spacing**2 / length**4)
        self.vector = ti.types.vector(2, real())
        self.matrix = ti.types.matrix(2, 2, real())
        self.artificial_sums = {"push": self.vector} if self.has_artificial_viscosity else {}
        stress_rate = {"stress": ti.types.vector(3, real())} if fluid.carries_stress else {}
        self.Rates = ti.types.struct(acceleration=self.vector, compression=real(), transport=self.vector, **stress_rate)

    @ti.func
    def sums(self, now, i):
        """Return the ``pair_sums`` of particle ``i``, with minimum images only where a neighbour is across."""
        sums = self.Sums()
        if self.lists.crosses[i] > 0:  # noqa: SIM108 (Taichi has no conditional expression of structs)
            sums = self.pair_sums(now, i, True)
        else:
            sums = self.pair_sums(now, i, False)
        return sums

    @ti.func
    def separation(self, now, i, j, periodic: ti.template()):
        """Return the vector from particle i to particle j."""
        apart = self.particles.mid_position[now, j] - self.particles.mid_position[now, i]
        if ti.static(periodic):
            apart = self.domain.minimum_image(apart)
        return apart

    @ti.func
    def pair(self, now, i, j, periodic: ti.template()):
        """Return the vector from particle i to particle j and the weight of the pair."""
        apart = self.separation(now, i, j, periodic)
        return apart, self.weights.at(apart.dot(apart))

    @ti.func
    def artificial_push(self, weight, apart, approach):
        """Return the term of a pair in Monaghan's linear artificial viscosity, without the factor alpha c h.

        Acceleration sum_j V_j alpha c h (v_ij . r_ij) / r^2 grad W for approaching pairs (Monaghan 1992,
        Annu. Rev. Astron. Astrophys. 30, eq. 4.1, beta = 0) without his 0.01 h^2, since r > 0;
        ``approach`` is the difference of velocities.
        """
        return ti.min(0.0, approach.dot(apart)) / apart.dot(apart) * weight * apart

    @ti.func
    def artificial_strength(self):
        """Return the factor V alpha c h of the sum of ``artificial_push``."""
        return (
            self.artificial_viscosity[None]
            * self.fluid.sound_speed[None]
            * self.smoothing_length[None]
            * self.pair_weight[None]
        )

    @ti.func
    def wall_pull(self, now, i):
        """Return the acceleration of particle ``i`` along x by the wall particles below and above.

        A sum over pairs that straddle a wall is the flux of momentum through it. The term of a pair is ``pair_pull``,
        the factor of the sum ``pull_norm`` of the trace of the second moment.
        """
        trace = 0.0
        pull = ti.Vector([0.0, 0.0])
        push = ti.Vector([0.0, 0.0])
        for k in range(unrolled(self.lists.count[i])):
            j = self.lists.table[i, k]
            apart, weight = self.pair(now, i, j, True)
            trace += weight * apart.dot(apart)
            if j >= self.particles.first_wall:
                above = ti.cast(self.particles.mid_position[now, j].y > 0.0, ti.i32)
                pull[above] += self.pair_pull(now, i, j, weight, apart)
                if ti.static(self.has_artificial_viscosity):
                    faster = self.particles.mid_velocity[now, j] - self.particles.mid_velocity[now, i]
                    push[above] += self.artificial_push(weight, apart, faster).x
        pull = self.pull_norm(trace) * pull
        if ti.static(self.has_artificial_viscosity):
            pull += self.artificial_strength() * push
        return pull
