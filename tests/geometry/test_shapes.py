"""Walls as curves: what all shapes have in common, each against closed forms, and areas within walls."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe, ellipeinc
from shapes import CLOSED, ELL, ellipse, wavy

from tisph.geometry import spline
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.outline import Outline, SmoothOutline
from tisph.geometry.polygon import Polygon
from tisph.geometry.shape import centroid, polar_moment
from tisph.geometry.spline import Spline

RANDOM = np.random.default_rng(3)
PLACES = RANDOM.uniform(-1.5, 3.5, (400, 2))
ROUNDING = 1e-12  # some thousand roundings of numbers of size 1

STEP = Outline(((0.0, 0.5), (1.0, 0.5), (1.0, 0.0), (3.0, 0.0)), 0.2)
HALF_AXES = [(1.2, 0.5), (0.3, 1.0), (1.0, 0.05), (1.0, 1.0 - 1e-9), (1e-4, 1.0)]
NEARBY = {
    **{name: (shape, PLACES) for name, shape in CLOSED.items()},
    "outline": (STEP, RANDOM.uniform((0.0, -0.2), (3.0, 1.0), (300, 2))),
    **{f"ellipse {axes}": (Ellipse(axes), 0.6 * PLACES) for axes in HALF_AXES},
}

closed_shapes = pytest.mark.parametrize("shape", CLOSED.values(), ids=CLOSED)
half_axes = pytest.mark.parametrize("half_axes", HALF_AXES)
smooth_shapes = pytest.mark.parametrize("name", ["circle", "ellipse", "rounded ell", "rounded triangle", "curve"])


@closed_shapes
def test_a_point_is_its_closest_point_and_the_distance_along_the_normal(shape):
    foot = shape.nearest(PLACES)
    assert np.abs(np.linalg.norm(foot.normal, axis=1) - 1).max() < ROUNDING
    assert np.abs(foot.point + foot.distance[:, None] * foot.normal - PLACES).max() < 1e-9  # sharp corners: by rounding
    again = shape.nearest(foot.point)
    assert np.abs(again.distance).max() < ROUNDING


@pytest.mark.parametrize(("shape", "places"), NEARBY.values(), ids=NEARBY)
def test_nearest_is_nearest_by_brute_force(shape, places):
    """Of points closely along the wall none is nearer, and the nearest is as near but for their spacing."""
    fine = shape.boundary_points(shape.length / 4000)
    foot = shape.nearest(places)
    brute = np.linalg.norm(places[:, None] - fine.point, axis=2).min(axis=1)
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
    assert np.array_equal(centroid(shape), centroid(other))
    assert polar_moment(shape) == polar_moment(other)


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


def test_a_step_is_straight_parts_and_two_quarter_circles():
    assert STEP.length == pytest.approx(3.5 + 0.2 * (np.pi - 4), rel=1e-12)
    assert (STEP.area, STEP.smallest_radius, STEP.convex_radius) == (0.0, 0.2, 0.2)
    assert np.allclose(STEP.extent, [[0.0, 0.0], [3.0, 0.5]], rtol=0, atol=1e-12)
    # above each straight part, on the diagonals of both arcs, and in the solid; beyond the ends the wall goes on
    away = math.sqrt(0.5) * np.array([1.0, 1.0])
    places = np.array(
        [[0.5, 0.6], [2.0, 0.3], (0.8, 0.3) + 0.3 * away, (1.2, 0.2) - 0.1 * away, [0.4, 0.2], [-0.1, 0.6]]
    )
    foot = STEP.nearest(places)
    assert np.allclose(foot.distance, [0.1, 0.3, 0.1, 0.1, -0.3, 0.1], rtol=0, atol=ROUNDING)
    assert np.allclose(foot.normal, [[0, 1], [0, 1], away, away, [0, 1], [0, 1]], rtol=0, atol=ROUNDING)
    assert np.allclose(foot.curvature, [0.0, 0.0, 5.0, -5.0, 0.0, 0.0], rtol=1e-12)


@pytest.mark.parametrize("shape", [STEP, Outline(((3.0, 0.2), (2.0, 0.2), (0.0, 1.0)), 0.3)])
def test_points_of_an_outline_are_even_from_its_first_corner(shape):
    points, (first, last) = shape.boundary_points(0.03), np.array(shape.corners)[[0, -1]]
    part = points.length[0]
    apart = np.linalg.norm(np.diff(points.point, axis=0), axis=1)
    assert points.length.sum() == pytest.approx(shape.length, rel=1e-12)
    assert np.linalg.norm(points.point[0] - first) == pytest.approx(0.5 * part, rel=1e-9)
    assert np.linalg.norm(points.point[-1] - last) == pytest.approx(0.5 * part, rel=1e-9)
    assert (apart < part * (1 + 1e-9)).all()
    assert (apart > part * (1 - (part / shape.corner_radius) ** 2 / 24 - 1e-9)).all()  # chords of arcs
    tangent = np.diff(points.point, axis=0) / apart[:, None]
    left = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    assert (np.sum(left * points.normal[:-1], axis=1) > 0.9).all()  # the fluid is on the left


def test_an_outline_without_corners_is_a_line():
    box = RANDOM.uniform((0.0, -0.2), (3.0, 1.0), (300, 2))
    wall, line = Outline(((0.0, 0.2), (3.0, 0.5)), 0.1), Line((0.0, 0.2), (3.0, 0.3), math.hypot(3.0, 0.3))
    assert wall.smallest_radius == wall.convex_radius == math.inf
    one, other = wall.nearest(box), line.nearest(box)
    assert np.abs(one.point - other.point).max() < ROUNDING
    assert np.abs(one.distance - other.distance).max() < ROUNDING


def cosine(count, ahead=0.0, places=None):
    """Places on a wave of the period 2, ``count`` a period."""
    x = np.linspace(0.0, 2.0, count + 1)[:places]
    return np.stack([x, 1.0 + 0.2 * np.cos(np.pi * (x + ahead))], axis=1)


def wave_error(wall):
    places = wall.boundary_points(0.01).point
    return np.abs(places[:, 1] - 1.0 - 0.2 * np.cos(np.pi * places[:, 0])).max()


def test_a_smooth_wall_meets_a_wave_with_sixth_order():
    """Periodic, and half of it between open ends, at which it is level."""
    for half in (False, True):
        errors = [wave_error(SmoothOutline(cosine(n, places=n // 2 + 1 if half else None), periodic=not half))
                  for n in (12, 24, 48)]  # fmt: skip
        assert errors[1] < errors[0] / 2**6
        assert errors[2] < errors[1] / 2**6
    wall = SmoothOutline(cosine(48), periodic=True)
    assert wall.convex_radius == pytest.approx(1.0 / (0.2 * np.pi**2), rel=1e-4)


def test_places_beside_a_smooth_wall_find_it_in_few_iterations(monkeypatch):
    """Beside its ends and its points as well, where round-off says on which side of them the closest point is."""
    monkeypatch.setattr(spline, "NEWTON_STEPS", 8)
    wall = SmoothOutline(cosine(48, places=25))
    foot = wall.boundary_points(0.01)
    foot = wall.nearest(np.concatenate([foot.point, cosine(48, places=25), wall.ends]))
    height = 0.4 * RANDOM.uniform(0.0, 1.0, (len(foot.point), 1))  # the fluid's smallest radius of curvature is 0.5
    found = wall.nearest(foot.point + height * foot.normal)
    assert np.abs(found.point - foot.point).max() < ROUNDING
    assert np.abs(found.distance - height[:, 0]).max() < ROUNDING


PERIODIC = {
    "smooth": [Body(SmoothOutline(cosine(48, ahead), periodic=True), periods=(2.0, math.inf)) for ahead in (0.0, 0.7)],
    "corners": [
        Body(Outline(corners, 0.2, periodic=True), periods=(2.0, math.inf))
        for corners in (((0.0, 0.6), (1.0, 0.0), (2.0, 0.6)), ((0.0, 0.18), (0.3, 0.0), (1.3, 0.6), (2.0, 0.18)))
    ],
}


@pytest.mark.parametrize("walls", PERIODIC.values(), ids=PERIODIC)
def test_a_periodic_wall_does_not_depend_on_where_its_period_begins(walls):
    """It is the same beside its ends, of a corner that it begins in, too; mirror images have opposite normals."""
    places = RANDOM.uniform((0.0, -0.2), (2.0, 2.0), (300, 2))
    one, other = walls[0].nearest(places), walls[1].nearest(places - [0.7, 0.0])
    assert (one.distance < 0).any()
    assert np.abs(one.distance - other.distance).max() < 1e-7  # the smooth ones are splines through other places
    assert walls[0].shape.length == pytest.approx(walls[1].shape.length, rel=1e-8)
    assert np.allclose(one.normal, -turned_over(walls[0]).nearest(places).normal, rtol=0, atol=1e-9)


def turned_over(body):
    """The same wall with the fluid on its other side."""
    shape = body.shape
    name = "points" if isinstance(shape, SmoothOutline) else "corners"
    return replace(body, shape=replace(shape, **{name: getattr(shape, name)[::-1]}))


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
            [abs(curve.length - perimeter), abs(curve.area - area), np.abs(curvature - [a / b**2, b / a**2]).max()]
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
    "no axis": (lambda: Ellipse((1.0, -1.0)), "an ellipse needs two half axes above 0"),
    "no number": (lambda: Ellipse((1.0, math.nan)), "an ellipse needs two half axes above 0"),
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
    "backwards": (lambda: Outline(((0, 0), (2, 0), (2, 1), (1, 1))), "between the ends of the wall, x = 0 and 1"),
    "upright": (lambda: Outline(((0, 0), (0, 1))), "between the ends of the wall"),
    "arc beyond an end": (lambda: Outline(((0, 0), (0.1, 0), (0.1, 1), (1, 1)), 0.2), "do not fit: at most 0.1"),
    "step too low": (lambda: Outline(((0, 0), (1, 0), (1, 0.3), (2, 0.3)), 0.2), "do not fit: at most 0.15"),
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


DRAW = np.random.default_rng(5)
CLOSE_PLACES = DRAW.uniform(-1.5, 1.5, (500, 2))
ROUND_OFF = 1e-14  # some tens of roundings of numbers of size 1


@half_axes
def test_a_place_is_on_the_normal_of_its_foot(half_axes):
    """Everywhere, also on the axes, next to them, and at and next to the centres of curvature of all ends."""
    ellipse, (a, b) = Ellipse(half_axes), half_axes
    special = np.array([[0, 0], [a, 0], [0, -b], [0.4 * a, 0], [0, 0.4 * b], [a - b**2 / a, 0], [0, a**2 / b - b]])
    near = [special[:, None] + size * CLOSE_PLACES[:20] for size in (0.0, 1e-3, 1e-9, 1e-16, 1e-120)]
    places = np.concatenate([CLOSE_PLACES, *(each.reshape(-1, 2) for each in near)])
    foot = ellipse.nearest(places)
    scale = np.maximum(1.0, np.linalg.norm(places, axis=1))
    assert np.abs(np.hypot(*(foot.point / half_axes).T) - 1).max() < ROUND_OFF
    across = np.linalg.norm(foot.point + foot.distance[:, None] * foot.normal - places, axis=1)
    assert (across / scale).max() < ROUND_OFF
    outside = np.hypot(*(places / half_axes).T) - 1
    clear = np.abs(outside) > 1e-9  # nearer, the quotients of slender ellipses lose digits
    assert np.array_equal(foot.distance[clear] > 0, outside[clear] > 0)


def test_the_centre_and_the_longer_axis_in_closed_form():
    """Up to the centre of curvature of an end, x = (a^2 - b^2)/a, the foot is at a^2 x/(a^2 - b^2); then at the end."""
    a, b = 1.25, 0.75
    x = np.array([0.0, 0.4, -0.4, 0.8, 1.0, -2.0])
    foot = Ellipse((a, b)).nearest(np.stack([x, np.zeros(6)], axis=1))
    along = np.clip(a**2 * x / (a**2 - b**2), -a, a)
    across = b * np.sqrt(1 - (along / a) ** 2)
    distance = [-0.75, *2 * [-b * math.sqrt(1 - 0.16)], -0.45, -0.25, 0.75]
    assert np.abs(foot.point - np.stack([along, across], axis=1)).max() < ROUND_OFF
    assert np.abs(foot.distance - distance).max() < ROUND_OFF
    assert np.abs(foot.curvature[[0, 4]] - [b / a**2, a / b**2]).max() < ROUND_OFF


def test_an_ellipse_of_equal_axes_is_the_circle():
    ellipse, circle = Ellipse((0.7, 0.7)), Circle(0.7)
    places = np.concatenate([CLOSE_PLACES, [[0.0, 0.0], [0.7, 0.0], [0.0, -0.1]]])
    pairs = (
        (ellipse.nearest(places), circle.nearest(places)),
        (ellipse.boundary_points(0.1), circle.boundary_points(0.1)),
    )
    for one, other in pairs:
        assert vars(one).keys() == vars(other).keys()
        for name, values in vars(one).items():
            assert np.abs(values - vars(other)[name]).max() < ROUND_OFF
    for name in ("length", "area", "smallest_radius", "convex_radius", "extent"):
        assert getattr(ellipse, name) == pytest.approx(getattr(circle, name), rel=1e-15)


@half_axes
@pytest.mark.parametrize("count", [7, 200])
def test_points_are_evenly_spaced_in_arc_length(half_axes, count):
    """By the incomplete elliptic integral of their eccentric angles."""
    ellipse, (a, b) = Ellipse(half_axes), half_axes
    wall = ellipse.boundary_points(ellipse.length / count)
    angle = np.unwrap(np.arctan2(wall.point[:, 1] / b, wall.point[:, 0] / a))
    arc = b * ellipeinc(angle, 1 - (a / b) ** 2)  # from (a, 0)
    assert np.abs(arc - (np.arange(count) + 0.5) * ellipse.length / count).max() < ROUND_OFF * ellipse.length
    assert wall.length == pytest.approx(ellipse.length / count, rel=1e-15)
    assert np.abs(wall.point[::-1] * [1, -1] - wall.point).max() < ROUND_OFF
    assert np.abs(ellipse.nearest(wall.point).distance).max() < ROUND_OFF


def test_length_area_and_radii_in_closed_form():
    ellipse = Ellipse((0.5, 2.0))
    # Gauss and Kummer: 2 pi A (1 + h/4 + h^2/64 + ...) with A = (a + b)/2, h = ((a - b)/(a + b))^2 = 0.36
    series = sum(math.prod((0.5 - j) / (j + 1) for j in range(k)) ** 2 * 0.36**k for k in range(40))
    assert ellipse.length == pytest.approx(math.pi * 2.5 * series, rel=1e-14)
    assert ellipse.area == pytest.approx(math.pi, rel=1e-15)
    assert (ellipse.smallest_radius, ellipse.convex_radius) == (0.125, 0.125)
    assert Ellipse((2.0, 0.5), "inside").smallest_radius == 0.125
    assert Ellipse((2.0, 0.5), "inside").convex_radius == math.inf
    assert ellipse.extent.tolist() == [[-0.5, -2.0], [0.5, 2.0]]


EVEN = 1e-12  # sums over even points of an analytic closed curve are exact but for round-off
SECOND_ORDER = 1e-7  # where the curvature jumps, of corners rounded by 1/100 of the perimeter (geometry/shape.py)


@pytest.mark.parametrize(
    ("shape", "half_axes", "bound"),
    [
        (Circle(0.7), (0.7, 0.7), EVEN),
        (Ellipse((1.2, 0.5)), (1.2, 0.5), EVEN),
        (Ellipse((0.1, 2.0)), (0.1, 2.0), EVEN),
        (Spline(ellipse(1.0, 0.6, 96)), (1.0, 0.6), 1e-8),  # off by the sixth power of the points' distance, 1/15
    ],
)
def test_centroids_and_moments_of_ellipses_in_closed_form(shape, half_axes, bound):
    a, b = half_axes
    assert np.abs(centroid(shape)).max() < bound
    assert polar_moment(shape) == pytest.approx(math.pi / 4 * a * b * (a**2 + b**2), rel=bound)


def test_centroids_and_moments_of_sharp_polygons_in_closed_form():
    triangle = ((0.0, 0.0), (2.0, 0.5), (0.5, 1.5))
    assert centroid(Polygon(triangle)) == pytest.approx(np.mean(triangle, axis=0), rel=SECOND_ORDER)
    # around its corner (0, 0), from which c and d go: area/6 (c.c + c.d + d.d)
    assert polar_moment(Polygon(triangle)) == pytest.approx(1.375 / 6 * (4.25 + 1.75 + 2.5), rel=SECOND_ORDER)
    # of two rectangles, 2 x 1 and 1 x 2, the first around its corner: w h (w^2 + h^2)/3
    assert centroid(Polygon(ELL)) == pytest.approx([0.75, 1.25], rel=SECOND_ORDER)
    upper = 2 * (1 + 4) / 12 + 2 * (0.5**2 + 2.0**2)
    assert polar_moment(Polygon(ELL)) == pytest.approx(2 * (4 + 1) / 3 + upper, rel=SECOND_ORDER)


@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_moments_far_from_the_origin_follow_from_steiner(radius):
    """J = J_c + A |c|^2: the moment around the centroid is that of the shape at the origin."""
    far = np.array([30.0, -20.0])
    near, moved = Polygon(ELL, radius), Polygon(tuple(map(tuple, np.array(ELL) + far)), radius)
    centre = centroid(near)
    assert np.abs(centroid(moved) - far - centre).max() < EVEN
    own = polar_moment(near) - near.area * centre @ centre
    assert polar_moment(moved) == pytest.approx(own + moved.area * (far + centre) @ (far + centre), rel=EVEN)
