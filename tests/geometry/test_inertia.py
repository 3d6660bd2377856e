"""Centroids and polar moments of the areas within walls, against closed forms and the theorem of Steiner."""

import math
from dataclasses import replace

import numpy as np
import pytest
from shapes import CLOSED, ELL, ellipse

from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.polygon import Polygon
from tisph.geometry.shape import centroid, polar_moment
from tisph.geometry.spline import Spline

EVEN = 1e-12  # sums over even points of an analytic closed curve are exact but for round-off
SECOND_ORDER = 1e-7  # where the curvature jumps, of corners rounded by 1/100 of the perimeter (geometry/shape.py)


@pytest.mark.parametrize("shape", [Circle(0.7), Ellipse((1.2, 0.5)), Ellipse((0.1, 2.0))])
def test_circles_and_ellipses_in_closed_form(shape):
    a, b = getattr(shape, "half_axes", (0.7, 0.7))
    assert np.abs(centroid(shape)).max() < EVEN
    assert polar_moment(shape) == pytest.approx(math.pi / 4 * a * b * (a**2 + b**2), rel=EVEN)


def test_sharp_polygons_in_closed_form():
    triangle = ((0.0, 0.0), (2.0, 0.5), (0.5, 1.5))
    assert centroid(Polygon(triangle)) == pytest.approx(np.mean(triangle, axis=0), rel=SECOND_ORDER)
    # around its corner (0, 0), from which c and d go: area/6 (c.c + c.d + d.d)
    assert polar_moment(Polygon(triangle)) == pytest.approx(1.375 / 6 * (4.25 + 1.75 + 2.5), rel=SECOND_ORDER)
    # of two rectangles, 2 x 1 and 1 x 2, the first around its corner: w h (w^2 + h^2)/3
    assert centroid(Polygon(ELL)) == pytest.approx([0.75, 1.25], rel=SECOND_ORDER)
    upper = 2 * (1 + 4) / 12 + 2 * (0.5**2 + 2.0**2)
    assert polar_moment(Polygon(ELL)) == pytest.approx(2 * (4 + 1) / 3 + upper, rel=SECOND_ORDER)


@pytest.mark.parametrize("radius", [0.3, 0.1, 0.05])
def test_a_rounded_rectangle_is_its_parts(radius):
    """Three rectangles, and four quarters of a disc whose centroids are 4 R/(3 pi) from its straight sides."""
    width, height = 2.0, 1.0
    place = np.array([0.3, -0.2])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (width / 2, height / 2) + place
    shape = Polygon(tuple(map(tuple, corners)), radius)
    inner, lower = width - 2 * radius, height - 2 * radius
    around_middle = inner * height * (inner**2 + height**2) / 12
    side = (inner + radius) / 2
    around_middle += 2 * radius * lower * ((radius**2 + lower**2) / 12 + side**2)
    quarter, own = math.pi / 4 * radius**2, 4 * radius / (3 * math.pi)
    away = (inner / 2 + own) ** 2 + (lower / 2 + own) ** 2
    around_middle += 4 * (math.pi / 8 * radius**4 + quarter * (away - 2 * own**2))
    assert centroid(shape) == pytest.approx(place, abs=SECOND_ORDER)
    assert polar_moment(shape) == pytest.approx(around_middle + shape.area * place @ place, rel=SECOND_ORDER)


def test_a_curve_through_points_of_an_ellipse_has_its_moment():
    shape = Spline(ellipse(1.0, 0.6, 96))
    # the spline is off by the sixth power of the points' distance, 1/15
    assert polar_moment(shape) == pytest.approx(math.pi / 4 * 0.6 * 1.36, rel=1e-8)
    assert np.abs(centroid(shape)).max() < 1e-8


@pytest.mark.parametrize("shape", CLOSED.values(), ids=CLOSED)
def test_the_side_of_the_fluid_changes_nothing(shape):
    other = replace(shape, fluid_side="inside")
    assert np.array_equal(centroid(other), centroid(shape))
    assert polar_moment(other) == polar_moment(shape)


@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_moments_far_from_the_origin_follow_from_steiner(radius):
    """J = J_c + A |c|^2: the moment around the centroid is that of the shape at the origin."""
    far = np.array([30.0, -20.0])
    near, moved = Polygon(ELL, radius), Polygon(tuple(map(tuple, np.array(ELL) + far)), radius)
    centre = centroid(near)
    assert np.abs(centroid(moved) - far - centre).max() < EVEN
    own = polar_moment(near) - near.area * centre @ centre
    assert polar_moment(moved) == pytest.approx(own + moved.area * (far + centre) @ (far + centre), rel=EVEN)


def test_a_mirrored_shape_has_the_mirrored_centroid():
    mirrored = Polygon(tuple((-x, y) for x, y in ELL), 0.2)
    # the points on the wall start elsewhere, so that their errors differ
    assert centroid(mirrored) == pytest.approx(centroid(Polygon(ELL, 0.2)) * [-1, 1], rel=SECOND_ORDER)
    assert polar_moment(mirrored) == pytest.approx(polar_moment(Polygon(ELL, 0.2)), rel=SECOND_ORDER)
