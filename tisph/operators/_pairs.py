"""What both sets of operators share: the pair weight, the separation and linear artificial viscosity."""

from tisph.operators._weights import WeightTable
from tisph.runtime import real, scalar, ti


@ti.data_oriented
class PairOperators:
    """Access to particles and lists, and the rates that an evaluation returns.

    ``Rates``: ``acceleration``, rate of ``compression``, and ``transport``, the velocity of the particle
    relative to the liquid. ``pair_weight`` turns kernel slopes into V_j (-W'(r)/r) with the volume
    V = spacing^2 that every particle keeps to within the weak compression.
    """

    def __init__(self, particles, lists, liquid, kernel, artificial_viscosity):
        self.particles = particles
        self.lists = lists
        self.domain = lists.domain
        self.liquid = liquid
        self.has_artificial_viscosity = artificial_viscosity > 0
        self.artificial_viscosity = scalar(artificial_viscosity)
        length = lists.cutoff / kernel.SUPPORT
        self.weights = WeightTable(kernel, length)
        self.smoothing_length = scalar(length)
        self.pair_weight = scalar(lists.spacing**2 / length**4)
        self.vector = ti.types.vector(2, real())
        self.matrix = ti.types.matrix(2, 2, real())
        self.Rates = ti.types.struct(acceleration=self.vector, compression=real(), transport=self.vector)

    @ti.func
    def sums(self, now, i):
        """Return the ``pair_sums`` of particle ``i``, wrapping distances only where a neighbour is across."""
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
            apart.x = self.domain.nearest(apart.x)
        return apart

    @ti.func
    def artificial_push(self, weight, apart, approach):
        """Return a pair's share of Monaghan's linear artificial viscosity, without the factor alpha c h.

        Acceleration sum_j V_j alpha c h (v_ij . r_ij) / r^2 grad W for approaching pairs (Monaghan 1992,
        Annu. Rev. Astron. Astrophys. 30, eq. 4.1, beta = 0) without his 0.01 h^2, since r > 0;
        ``approach`` is the difference of velocities.
        """
        return ti.min(0.0, approach.dot(apart)) / apart.dot(apart) * weight * apart
