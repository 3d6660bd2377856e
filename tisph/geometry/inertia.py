"""Centroid and polar second moment of the area that a closed wall encloses, by integrals along the wall (Green).

The integral of x over an area is that of x^2 n_x/2 along its edge, and the integral of r^2 that of r^2 (r . n)/4, with
the normal n outwards. They are taken around the middle of the shape, so that shapes far from the origin lose nothing.
"""

import numpy as np

POINTS = 20_000
"""Along the wall. On circles, and on ellipses with axes of up to 30 to 1, sums over them are exact but for round-off.

On polygons, whose curvature jumps, they have an error of the second order: of 1e-7 of the polar moment at most for
corners rounded by 1/100 of the perimeter, of 4e-7 by 1/250.
"""


def centroid(shape):
    """Centroid (2,) [length] of the area within a closed ``shape``, in the frame of its body."""
    points, normals, lengths, middle = _outline(shape)
    return middle + _first_moment(points, normals, lengths) / shape.area


def polar_moment(shape):
    """Integral [length^4] of x^2 + y^2 over the area within a closed ``shape``, around the origin of its frame."""
    points, normals, lengths, middle = _outline(shape)
    square = np.sum(points**2, axis=1)
    around_middle = 0.25 * np.sum(lengths * square * np.sum(points * normals, axis=1))
    shifted = 2 * middle @ _first_moment(points, normals, lengths) + middle @ middle * shape.area
    return float(around_middle + shifted)


def volume_of_revolution(wall):
    """Volume [length^3] of what is within a closed ``wall``, a ``Boundary``, and above y = 0, turned around that axis.

    By Gauss: the integral of pi y^2 n_y along the wall, with normals outwards.
    """
    return float(np.pi * np.sum(wall.length * np.maximum(wall.point[:, 1], 0.0) ** 2 * wall.normal[:, 1]))


def _first_moment(points, normals, lengths):
    """Return the integral (2,) of the place over the area."""
    return 0.5 * lengths @ (points**2 * normals)


def _outline(shape):
    """Return points (m, 2) seen from the middle of the shape, normals outwards, lengths (m,), and the middle (2,)."""
    wall = shape.boundary_points(shape.length / POINTS)
    middle = 0.5 * shape.extent.sum(axis=0)
    outwards = 1.0 if shape.fluid_side == "outside" else -1.0
    return wall.point - middle, outwards * wall.normal, wall.length, middle
