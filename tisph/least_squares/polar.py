"""Vectors in polar coordinates around the centre of curvature of a wall.

With z = x + i y and the centre at z = -1/b, seen from a particle, they are log(1 + b z)/b: differences of the logarithm
of the radius, and of the angle. A flow around a circle is smooth in these, and has powers of (distance over radius) in
x and y. The map is analytic with the derivative 1 at the particle, so that gradient and Laplacian there are those in x
and y; so is its Pade approximant, which is used, z (6 + 3 b z)/(6 + 6 b z + b^2 z^2).
"""

from tisph.runtime import ti


@ti.func
def to_polar(vector, bend):
    """Return a ``vector`` in polar coordinates around the point at -1/``polar_map``, both as complex numbers."""
    x = ti.Vector([bend.x * vector.x - bend.y * vector.y, bend.x * vector.y + bend.y * vector.x])
    squared = ti.Vector([x.x * x.x - x.y * x.y, 2.0 * x.x * x.y])
    upper = ti.Vector([6.0 + 3.0 * x.x, 3.0 * x.y])
    lower = ti.Vector([6.0, 0.0]) + 6.0 * x + squared
    share = ti.Vector([upper.dot(lower), upper.y * lower.x - upper.x * lower.y]) / lower.dot(lower)
    return ti.Vector([share.x * vector.x - share.y * vector.y, share.x * vector.y + share.y * vector.x])
