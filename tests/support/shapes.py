"""Closed curves of every kind, the same ones for all tests of shapes and bodies."""

import numpy as np

from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.polygon import Polygon
from tisph.geometry.spline import Spline

ELL = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0))
"""A polygon with a corner that points inwards."""


def ellipse(a, b, count):
    angle = 2 * np.pi * np.arange(count) / count
    return tuple(zip(a * np.cos(angle), b * np.sin(angle), strict=True))


def wavy(count):
    """A smooth curve with hollows, counterclockwise."""
    angle = 2 * np.pi * np.arange(count) / count
    radius = 1 + 0.2 * np.cos(3 * angle)
    return tuple(zip(radius * np.cos(angle), radius * np.sin(angle), strict=True))


CLOSED = {
    "circle": Circle(0.7),
    "ellipse": Ellipse((1.2, 0.5)),
    "triangle": Polygon(((0.0, 0.0), (2.0, 0.5), (0.5, 1.5))),
    "ell": Polygon(ELL),
    "rounded ell": Polygon(ELL, 0.3),
    "rounded triangle": Polygon(((0.0, 0.0), (2.0, 0.5), (0.5, 1.5)), 0.2),
    "curve": Spline(wavy(24)),
}
