"""The spacing that is wanted near bodies, in boxes and at points."""

import numpy as np
import pytest

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ellipse import Ellipse
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.wanted_spacing import InBox, InGaps, NearBody, WantedSpacing, arc_lengths, graded_boundary


def test_spacing_grows_with_the_distance_from_a_circle():
    """Near a circle of radius 0.2 it is 0.01 up to 0.1 from the wall, then grows by a fifth of the distance."""
    circle = NearBody(Body(Circle(0.2), (0.5, 0.5)), 0.01, within=0.1)
    wanted = WantedSpacing(0.05, [circle], growth=0.2)
    places = np.stack([0.5 + np.array([0.2, 0.3, 0.35, 0.45, 1.0]), np.full(5, 0.5)], axis=1)
    # exact but for the rounding of places, 1e-16 times the growth
    np.testing.assert_allclose(wanted.at(places), [0.01, 0.01, 0.02, 0.04, 0.05], atol=1e-15)
    assert wanted.varies
    assert wanted.smallest == 0.01


def test_spacing_follows_a_body_that_moves():
    """A time t after the start it is that at rest, moved by the velocity times t."""
    moving = Body(Circle(0.1), (0.2, 0.5), motion=RigidMotion(WallMotion(0.5), WallMotion(0.0), WallMotion(0.0)))
    places = np.random.default_rng(0).uniform(size=(50, 2))
    now, later = (
        WantedSpacing(0.05, [NearBody(moving, 0.01)]).at(at, t)
        for at, t in ((places, 0.0), (places + np.array([0.1, 0.0]), 0.2))
    )
    np.testing.assert_allclose(now, later, atol=1e-15)


@pytest.mark.parametrize(("place", "expected"), [((0.98, 0.5), 0.01), ((0.9, 0.5), 0.018), ((0.5, 0.5), 0.03)])
def test_a_box_across_the_end_of_a_period_is_one(place, expected):
    """A box from -0.1 to 0.1 in a period of 1, and its copies, have the same distances."""
    wanted = WantedSpacing(0.03, [InBox((-0.02, 0.0), (0.02, 1.0), 0.01, periods=(1.0, 0.0))])
    assert wanted.at(np.array([place]))[0] == pytest.approx(expected, abs=1e-15)


def test_without_sources_there_is_one_spacing():
    """Everywhere it is the spacing of the flow, to the bit."""
    wanted = WantedSpacing(0.1)
    assert not wanted.varies
    assert (wanted.at(np.zeros((3, 2))) == 0.1).all()


WALLS = {
    "circle": Body(Circle(1.0), (0.3, 0.1)),
    "ellipse": Body(Ellipse((1.0, 0.5)), (0.3, 0.1), 0.2),
    "wall": Body(Line((0.0, 0.0), (1.0, 0.0), 4.0)),
}


def beside(size):
    """A spacing that is a quarter of ``size`` at a place, and grows to it over a distance of 0.75."""
    return WantedSpacing(size, [InBox((1.3, 0.1), (1.3, 0.1), size / 4, 0.3)], growth=size)


@pytest.mark.parametrize("name", WALLS)
def test_points_on_walls_have_the_wanted_distances_and_sums_of_fourth_order(name):
    """Distances to 3 %, as their number is whole; integrals against 200 000 points: 3.9 to 4.1 was measured."""
    body = WALLS[name]

    def integral(wall):
        return np.sum(wall.length * (np.exp(wall.point[:, 0]) + np.cos(2 * wall.point[:, 1]) * wall.normal[:, 0]))

    exact, errors = integral(body.boundary_points(body.shape.length / 200_000)), []
    for size in (0.1, 0.05):
        wanted = beside(size)
        wall = body.placed(graded_boundary(body, wanted))
        sizes, apart = wanted.at(wall.point), np.linalg.norm(np.diff(wall.point, axis=0), axis=1)
        np.testing.assert_allclose(apart, 0.5 * (sizes[1:] + sizes[:-1]), rtol=0.03)
        assert sizes.min() == size / 4
        assert np.abs(body.nearest(wall.point).distance).max() < 1e-15
        assert wall.length.sum() == pytest.approx(body.shape.length, rel=1e-13)
        errors.append(abs(integral(wall) - exact))
    assert np.log2(errors[0] / errors[1]) > 3.7


def test_points_above_an_axis_begin_and_end_half_a_spacing_from_it():
    """The first and last point of a half circle; the sum of their lengths is half the circumference."""
    body = Body(Circle(1.0), (0.3, 0.0))
    wanted = WantedSpacing(0.1, [InBox((1.3, 0.0), (1.3, 0.0), 0.025)])
    wall = body.placed(graded_boundary(body, wanted, above_axis=True))
    assert wall.length.sum() == pytest.approx(np.pi, rel=1e-13)
    heights = wall.point[[0, -1], 1]
    np.testing.assert_allclose(heights, 0.5 * wanted.at(wall.point[[0, -1]]), rtol=0.05)


@pytest.mark.parametrize("name", WALLS)
def test_lengths_along_a_wall(name):
    """Of evenly spaced points, whose distances along the wall are known: to 1e-5 of a radius, as stated."""
    shape = WALLS[name].shape
    points = shape.boundary_points(0.1)
    expected = points.length[0] * (np.arange(len(points.length)) + 0.5)
    np.testing.assert_allclose(arc_lengths(shape, points.point), expected, atol=1e-5)


def test_a_gap_has_a_quarter_of_its_width():
    """Two circles 0.2 and 0.01 apart, on the line of centres; a third one far away does not count."""
    circles = [Body(Circle(0.3), (x, 0.0)) for x in (0.0, 0.8, 1.41)]
    wanted = WantedSpacing(1.0, [InGaps(circles, 0.01, 0.1)], growth=0.1)
    np.testing.assert_allclose(wanted.at(np.array([[0.35, 0.0], [0.4, 0.0], [1.105, 0.0]])), [0.05, 0.05, 0.01])
