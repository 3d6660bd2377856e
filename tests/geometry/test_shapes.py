"""Walls as curves: what all shapes have in common, and each against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe
from shapes import CLOSED, ELL, ellipse, wavy

from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.polygon import Polygon
from tisph.geometry.spline import Spline

RANDOM = np.random.default_rng(3)
PLACES = RANDOM.uniform(-1.5, 3.5, (400, 2))
ROUNDING = 1e-12  # some thousand roundings of numbers of size 1

closed_shapes = pytest.mark.parametrize("shape", CLOSED.values(), ids=CLOSED)
smooth_shapes = pytest.mark.parametrize("name", ["circle", "ellipse", "rounded ell", "rounded triangle", "curve"])


@closed_shapes
def test_a_point_is_its_closest_point_and_the_distance_along_the_normal(shape):
    foot = shape.nearest(PLACES)
    assert np.abs(np.linalg.norm(foot.normal, axis=1) - 1).max() < ROUNDING
    assert np.abs(foot.point + foot.distance[:, None] * foot.normal - PLACES).max() < 1e-9  # sharp corners: by rounding
    again = shape.nearest(foot.point)
    assert np.abs(again.distance).max() < ROUNDING


@closed_shapes
def test_nearest_is_nearest_by_brute_force(shape):
    """Of points closely along the wall none is nearer, and the nearest is as near but for their spacing."""
    fine = shape.boundary_points(shape.length / 4000)
    foot = shape.nearest(PLACES)
    brute = np.linalg.norm(PLACES[:, None] - fine.point, axis=2).min(axis=1)
    spacing = fine.length.max()
    assert (np.abs(foot.distance) <= brute + ROUNDING).all()
    # the nearest of the points is half a spacing or less along the wall from the foot, which may be a corner
    assert (brute <= np.abs(foot.distance) + 0.5 * spacing + ROUNDING).all()


@closed_shapes
def test_the_sign_of_the_distance_tells_in_from_out(shape):
    """By the angle that the wall, run through once, is seen under: 2 pi from within, 0 from without."""
    fine = shape.boundary_points(shape.length / 2000).point
    foot = shape.nearest(PLACES)
    clear = np.abs(foot.distance) > 0.01  # nearer by, the polygon of the points is not the curve
    away = (fine - PLACES[clear, None]) @ np.array([1.0, 1j])
    turns = np.angle(np.roll(away, -1, axis=1) / away).sum(axis=1) / (2 * np.pi)
    assert np.array_equal(np.round(turns) == 1, foot.distance[clear] < 0)
    assert (foot.distance[clear] < 0).any()


@closed_shapes
def test_fluid_inside_changes_all_signs(shape):
    other = replace(shape, fluid_side="inside")
    for one, turned in (
        (shape.nearest(PLACES), other.nearest(PLACES)),
        (shape.boundary_points(0.1), other.boundary_points(0.1)),
    ):
        assert np.array_equal(one.point, turned.point)
        assert np.array_equal(one.normal, -turned.normal)
        assert np.array_equal(one.curvature, -turned.curvature)
    assert np.array_equal(shape.nearest(PLACES).distance, -other.nearest(PLACES).distance)
    assert (shape.length, shape.area) == (other.length, other.area)


@closed_shapes
def test_wall_points_represent_the_whole_wall(shape):
    points = shape.boundary_points(0.037)
    assert points.length.sum() == pytest.approx(shape.length, rel=1e-13)
    assert np.abs(points.length - 0.037).max() < 0.002  # a whole number of them on sides of length 1 and more
    foot = shape.nearest(points.point)
    assert np.abs(foot.distance).max() < ROUNDING
    assert np.abs(foot.normal - points.normal).max() < 1e-9  # as the rounding of a place over the radius
    assert np.abs(foot.curvature - points.curvature).max() < 1e-7


@closed_shapes
def test_the_normals_of_a_closed_wall_cancel(shape):
    """And with the place they give the area; both as well as the points integrate (Gauss)."""
    points = shape.boundary_points(0.02)
    force = points.length @ points.normal
    area = 0.5 * np.sum(points.length * np.sum(points.point * points.normal, axis=1))
    # sides and circles to rounding; where the curvature jumps by 1/R, the sum is off by spacing^2/(12 R) at most (Euler
    # and Maclaurin), which happens twice a corner; the curve by its own error at such points, below
    rough = isinstance(shape, Polygon) and shape.smallest_radius
    allowed = 0.02**2 / (12 * shape.smallest_radius) * 2 * len(shape.corners) if rough else 1e-9
    assert np.abs(force).max() < allowed
    assert area == pytest.approx(shape.area, rel=ROUNDING, abs=2 * allowed)  # places are up to 3 from the origin


def test_points_on_a_smooth_curve_integrate_with_the_accuracy_of_fourier_series():
    """They fall faster than any order would have it, down to what jumps in the curve's fifth derivative."""
    curve = Spline(wavy(60))
    fine = curve.boundary_points(curve.length / 2000)
    whole = np.sum(fine.length * np.exp(fine.point[:, 0]))
    errors = []
    for count in (20, 40, 80):
        points = curve.boundary_points(curve.length / count)
        assert len(points.length) == count
        errors.append(abs(np.sum(points.length * np.exp(points.point[:, 0])) - whole))
    assert errors[1] < errors[0] / 2**8
    assert errors[2] < 1e-7


@smooth_shapes
def test_curvature_is_the_rotation_rate_of_the_normal(name):
    shape = CLOSED[name]
    points = shape.boundary_points(shape.length / 5000)
    step = points.length[0]
    change = np.sum((np.roll(points.normal, -1, axis=0) - np.roll(points.normal, 1, axis=0)) ** 2, axis=1) ** 0.5
    smooth = np.abs(np.roll(points.curvature, -2) - np.roll(points.curvature, 2)) < 0.1
    # differences are good to the square of step * curvature, 1e-5
    assert np.abs(change / (2 * step) - np.abs(points.curvature))[smooth].max() < 1e-3
    turned = np.sum(points.length * points.curvature)
    assert turned == pytest.approx(2 * np.pi, rel=1e-3)  # arcs by whole points: one of several hundred
    assert shape.smallest_radius == pytest.approx(1 / np.abs(points.curvature).max(), rel=1e-3)
    for side in ("outside", "inside"):
        seen = replace(shape, fluid_side=side)
        bulge = seen.boundary_points(shape.length / 5000).curvature.max()
        assert seen.convex_radius == pytest.approx(1 / bulge if bulge > 0 else np.inf, rel=1e-3)


def test_circle_in_closed_form():
    circle = Circle(0.7)
    foot = circle.nearest(np.array([[3.0, 4.0], [0.0, 0.1], [0.0, 0.0]]))
    assert np.allclose(foot.distance, [4.3, -0.6, -0.7], rtol=0, atol=1e-15)
    assert np.allclose(foot.normal[:2], [[0.6, 0.8], [0.0, 1.0]], rtol=0, atol=1e-15)
    assert foot.curvature.tolist() == [1 / 0.7] * 3
    assert np.linalg.norm(foot.normal[2]) == 1.0
    assert Circle(2.0, "inside").nearest(np.array([[1.5, 0.0]])).curvature[0] == -0.5
    assert (circle.length, circle.area) == (2 * math.pi * 0.7, math.pi * 0.7**2)


def test_line_in_closed_form():
    line = Line((0.0, 1.0), (-2.0, 0.0), length=3.0)
    foot = line.nearest(np.array([[0.3, 0.75], [5.0, 1.5]]))
    assert foot.distance.tolist() == [0.25, -0.5]
    assert foot.point.tolist() == [[0.3, 1.0], [5.0, 1.0]]
    assert foot.normal.tolist() == [[0.0, -1.0]] * 2
    points = line.boundary_points(0.31)
    assert np.allclose(points.point[:, 0], -0.3 * (np.arange(10) + 0.5), rtol=0, atol=1e-15)
    assert points.length.sum() == pytest.approx(3.0)
    assert line.extent.tolist() == [[-3.0, 1.0], [0.0, 1.0]]


def test_polygon_in_closed_form():
    ell = Polygon(ELL)
    assert (ell.length, ell.area, ell.smallest_radius) == (10.0, 4.0, 0.0)
    foot = ell.nearest(np.array([[-3.0, -4.0], [1.5, 1.2], [0.5, 0.2], [1.1, 1.1]]))
    assert np.allclose(foot.distance, [5.0, 0.2, -0.2, 0.1], rtol=0, atol=1e-14)
    assert np.allclose(foot.normal[:3], [[-0.6, -0.8], [0.0, 1.0], [0.0, -1.0]], rtol=0, atol=1e-14)
    rounded = Polygon(ELL, 0.3)  # five corners out, one in, each replaces 2 R of sides by a quarter of a circle
    assert rounded.length == pytest.approx(10.0 + 6 * 0.3 * (np.pi / 2 - 2), rel=1e-14)
    assert rounded.area == pytest.approx(4.0 - 4 * 0.3**2 * (1 - np.pi / 4), rel=1e-14)
    foot = rounded.nearest(np.array([[0.3 - 3.0, 0.3 - 4.0], [1.1, 1.1]]))
    assert np.allclose(foot.distance, [4.7, 0.3 - 0.2 * math.sqrt(2)], rtol=0, atol=1e-14)
    assert np.allclose(foot.curvature, [1 / 0.3, -1 / 0.3], rtol=1e-14)
    assert np.allclose(rounded.extent, [[0, 0], [2, 3]])


def test_a_square_with_the_largest_radius_is_a_circle():
    square = Polygon(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)), 1.0)
    circle = Circle(1.0)
    one, other = square.nearest(PLACES), circle.nearest(PLACES)
    assert np.abs(one.distance - other.distance).max() < ROUNDING
    assert (square.length, square.area) == pytest.approx((circle.length, circle.area), rel=1e-14)


def test_corners_and_points_may_run_either_way():
    for shape, turned in ((Polygon(ELL, 0.1), Polygon(ELL[::-1], 0.1)), (Spline(wavy(24)), Spline(wavy(24)[::-1]))):
        assert shape.area == pytest.approx(turned.area, rel=1e-13)
        assert np.abs(shape.nearest(PLACES).distance - turned.nearest(PLACES).distance).max() < ROUNDING


def test_a_curve_through_points_of_an_ellipse_has_its_order():
    """Perimeter by the elliptic integral, area, and curvature at the ends of the axes."""
    a, b = 1.0, 0.6
    perimeter, area = 4 * a * ellipe(1 - (b / a) ** 2), np.pi * a * b
    errors = []
    for count in (24, 48):
        curve = Spline(ellipse(a, b, count))
        curvature = curve.nearest(np.array([[2.0, 0.0], [0.0, 2.0]])).curvature
        errors.append(
            [
                abs(curve.length - perimeter),
                abs(curve.area - area),
                np.abs(curvature - [a / b**2, b / a**2]).max(),
            ]
        )
    order = np.log2(np.divide(*errors))
    assert (order[:2] > 5.5).all()  # a spline of fifth degree: sixth order in place, fourth in the second derivative
    assert order[2] > 3.5
    assert max(errors[1][:2]) < 1e-7


def test_images_across_a_circle_and_into_a_corner():
    circle = Circle(1.0)
    images, whose = circle.images(np.array([[1.5, 0.0], [0.0, 1.1], [0.6, -0.9]]), 0.2)
    assert whose.tolist() == [1, 2]
    assert np.allclose(circle.nearest(images).distance, [-0.1, 1 - math.sqrt(1.17)], rtol=0, atol=1e-15)
    box = Polygon(((0, 0), (1, 0), (1, 1), (0, 1)), fluid_side="inside")
    images, whose = box.images(np.array([[0.1, 0.15], [0.5, 0.9]]), 0.2)
    found = sorted(np.round(np.column_stack([whose, images]), 12).tolist())
    assert found == [[0.0, -0.1, -0.15], [0.0, -0.1, 0.15], [0.0, 0.1, -0.15], [1.0, 0.5, 1.1]]
    ell = Polygon(ELL)  # its hollow corner (1, 1) is the liquid's
    assert len(ell.images(np.array([[1.1, 1.1]]), 0.2)[0]) == 3
    assert len(ell.images(np.array([[2.1, 1.1]]), 0.2)[0]) == 0  # off a corner of the body, which sides fill
    rounded = Polygon(ELL, 0.3).images(np.array([[1.1, 1.1]]), 0.2)[0]
    assert np.allclose(rounded, 1.3 - (0.6 - 0.2 * math.sqrt(2)) / math.sqrt(2), rtol=0, atol=1e-14)


def test_a_thin_curve_is_told_from_its_other_side():
    """Along normals the foot is where they stand: outside up to where hollows between points are, of radius 0.08."""
    thin = Spline(ellipse(1.0, 0.02, 60))
    points = thin.boundary_points(thin.length / 997)
    height = RANDOM.uniform(0.0, 0.03, len(points.length))
    foot = thin.nearest(points.point + height[:, None] * points.normal)
    assert np.abs(foot.distance - height).max() < ROUNDING
    assert np.abs(foot.point - points.point).max() < 1e-10
    blunt = np.abs(points.point[:, 0]) < 0.9
    foot = thin.nearest((points.point - 0.005 * points.normal)[blunt])
    assert np.abs(foot.distance + 0.005).max() < ROUNDING


REFUSED = {
    "radius": (lambda: Circle(0.0), "a circle needs a radius above 0"),
    "side": (lambda: Circle(1.0, "left"), "the fluid is outside or inside"),
    "two corners": (lambda: Polygon(((0, 0), (1, 0))), "needs three corners"),
    "same corners": (lambda: Polygon(((0, 0), (0, 0), (1, 0), (1, 1))), "must be two places"),
    "bow": (lambda: Polygon(((0, 0), (1, 1), (1, 0), (0, 1))), "meets itself near"),
    "touching": (lambda: Polygon(((0, 0), (2, 0), (2, 2), (1, 0), (0, 2))), "meets itself near"),
    "folded": (lambda: Polygon(((0, 0), (2, 0), (1, 0), (1, 1))), "folds back"),
    "not finite": (lambda: Polygon(((0, 0), (math.inf, 0), (1, 1))), "must be finite"),
    "corner too round": (lambda: Polygon(((0, 0), (1, 0), (1, 2), (0, 2)), 0.6), "do not fit: at most 0.5"),
    "negative corner": (lambda: Polygon(((0, 0), (1, 0), (1, 2)), -0.1), "must be 0 or more"),
    "two points": (lambda: Spline(((0, 0), (1, 0))), "needs three points"),
    "closed twice": (lambda: Spline(((0, 0), (1, 0), (1, 1), (0, 0))), "must be two places"),
    "eight": (lambda: Spline(((0, 0), (1, 1), (2, 0), (1, -0.1), (0, 1), (-1, 0.5))), "meets itself near"),
    "no direction": (lambda: Line((0, 0), (0, 0)), "a tangent with a direction"),
    "no period": (lambda: Line().boundary_points(0.1), "give it a length"),
    "no spacing": (lambda: Circle(1.0).boundary_points(0.0), "a spacing above 0"),
}


@pytest.mark.parametrize(("make", "text"), REFUSED.values(), ids=REFUSED)
def test_impossible_shapes_are_refused_with_what_is_possible(make, text):
    with pytest.raises(ValueError, match=text):
        make()


def test_images_across_a_rounded_corner_are_of_what_is_near():
    """Of what is farther than the reach they would come out on the other side of a small body."""
    body = Polygon(((-0.2, -0.15), (0.2, -0.15), (0.0, 0.2)), 0.1)
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 49), np.linspace(-0.6, 0.6, 49))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    points = points[body.nearest(points).distance > 0]
    images, whose = body.images(points, 0.08)
    assert body.nearest(points[whose]).distance.max() < 0.08
    assert body.nearest(images).distance.max() < 0.0
    assert set(whose) == set(np.flatnonzero(body.nearest(points).distance < 0.08))
