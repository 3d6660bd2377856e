"""The same operators for axisymmetric flow, x being along the axis and y = r the distance from it.

They are d/dx, d/ds = (1/r) d/dr with s = r^2/2, and the Laplacian d2/dx2 + d2/dr2 + (1/r) d/dr, for what does not
change around the axis: none of them is singular on it. In place of r_j - r_i the second coordinate of a neighbour is
one in which solutions are simple:

* where the fluid reaches the axis, (s_j - s_i)/L, L^2 = r_i^2 + support^2, since smooth fields are even in r. Nearer to
  the axis than the support only powers with a + 2 b <= order are in the basis, all those of that order in r: with half
  a disc of neighbours others cannot be told apart, and the Laplacian has growing modes;
* in a gap around an inner cylinder r_i log(r_j/r_i), in which log r and the powers of r are entire functions. Circular
  Couette flow, 16 spacings across with a radius ratio of 0.5, has errors of 3.5e-4 in s, and of 8e-7 in this one.

With the derivatives D by that coordinate d/ds = b D, and the Laplacian's part across the axis is a D^2 + c D.
"""

from tisph.least_squares.operators import BLOCK, D_DY, LAPLACIAN, LeastSquaresOperators, even_powers
from tisph.runtime import scalar, ti

ACROSS = -3
"""Place of the unknown y^2 from the end; that of y is the last."""

NEAR_WALLS = 1.2
"""Distance from the axis, in supports, up to which all functions are taken to be even beside walls, where supports are
wider; elsewhere it is 1. With 1 the equations of the pressure were singular for once at points on a sphere near the
axis, where a polymer moved past it. With 1.2 everywhere errors of pipes that have just started are largest on the axis.
"""

NUMBERS = 4
"""Of each particle: a, b, c and whether it is near the axis."""


@ti.data_oriented
class AxisymmetricOperators(LeastSquaresOperators):
    """``LeastSquaresOperators`` with ``d_dy`` for d/ds, and supports that vary.

    ``lowest_radius``: distance from the axis where y = 0. ``annular``: whether an inner wall keeps the fluid from it.
    """

    axisymmetric = True

    def __init__(self, *arguments, lowest_radius, annular):
        super().__init__(*arguments)
        self.annular, support = annular, arguments[1]
        if not annular:
            self.begins.insert(1, even_powers(arguments[2]))
        self.lowest_radius, self.support = scalar(lowest_radius), scalar(support)
        self.radial = ti.field(self.lane, (self.moments.shape[0], NUMBERS))

    @ti.func
    def radius(self, i):
        """Return the distance of a particle from the axis."""
        return self.points.position[i].y + self.lowest_radius[None]

    @ti.func
    def set_radial(self, i, support, straight):
        """Store a, b and c of particle ``i``, and its second coordinates if ``straight``: without a ``polar_map``."""
        radius = self.radius(i)
        a, b, c = 1.0, 1.0 / radius, 1.0 / radius
        if straight:
            size = ti.sqrt(radius * radius + support * support)
            a, b, c = (radius / size) ** 2, 1.0 / size, 2.0 / size
            if ti.static(self.annular):
                a, b, c = 1.0, 1.0 / radius, 0.0
            for k in range(self.points.count[i]):
                apart = self.d_dy[i, k]
                if ti.static(self.annular):
                    self.d_dy[i, k] = radius / support * ti.log(1.0 + apart * support / radius)
                else:
                    self.d_dy[i, k] = apart * (2.0 * radius + apart * support) * 0.5 / size
        block, lane = i // BLOCK, i % BLOCK
        self.radial[block, 0][lane] = a
        self.radial[block, 1][lane] = b
        self.radial[block, 2][lane] = c * support / self.support[None]  # it is divided by the support twice later on
        self.radial[block, 3][lane] = 0.0
        if ti.static(not self.annular):
            reach = ti.select(support > 1.001 * self.support[None], NEAR_WALLS, 1.0) * support
            self.radial[block, 3][lane] = ti.cast(radius < reach, self.laplacian.dtype)

    @ti.func
    def set_radial_targets(self, worker, block, operator):
        """Let what is asked for of derivatives by the second coordinate be that of each particle."""
        across, along = self.unknowns + ACROSS, self.unknowns - 1
        if operator == LAPLACIAN:
            self.solution[worker, operator, across] *= self.radial[block, 0]
            self.solution[worker, operator, along] = self.radial[block, 2] * self.targets[D_DY, along]
        if operator == D_DY:
            self.solution[worker, operator, along] *= self.radial[block, 1]

    @ti.func
    def hoop(self, values: ti.template(), i):
        """Return what ``laplacian`` lacks for v/r and w/r, all components but the first: twice their d/ds."""
        total = 2.0 * self.apply(self.d_dy, values, i)
        total[0] = 0.0
        return total
