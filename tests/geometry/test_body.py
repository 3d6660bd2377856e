"""Bodies: placed, turned, moving, in periodic cells, and how close they come."""

import math
from dataclasses import replace

import numpy as np
import pytest
from shapes import CLOSED

from tisph.geometry.body import Body, gap, smallest_gap
from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.polygon import Polygon

RANDOM = np.random.default_rng(4)
PLACES = RANDOM.uniform(-2.0, 2.0, (200, 2))
ROUNDING = 1e-12
TIMES = np.array([-0.3, 0.0, 0.4, 1.7])

MOTIONS = {
    "constant": RigidMotion(WallMotion(0.3), WallMotion(-0.2), WallMotion(0.7)),
    "oscillating": RigidMotion(WallMotion(0.3, -0.1, 2.0), WallMotion(0.0, 0.4, 0.5), WallMotion(0.6, 0.5, 3.0)),
    "turning": RigidMotion(rotation=WallMotion(1.3)),
    "hardly oscillating": RigidMotion(WallMotion(0.3, 0.2, 1e-9)),
}

closed_shapes = pytest.mark.parametrize("shape", CLOSED.values(), ids=CLOSED)
motions = pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)


@closed_shapes
def test_nearest_goes_with_the_body(shape):
    """A body moved and turned sees places that are moved and turned with it as before."""
    angle, way = 0.7, np.array([0.3, -1.1])
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    before = Body(shape).nearest(PLACES)
    after = Body(shape, tuple(way), angle).nearest(PLACES @ turned.T + way)
    assert np.abs(after.distance - before.distance).max() < ROUNDING
    assert np.abs(after.point - before.point @ turned.T - way).max() < 1e-9
    assert np.abs(after.normal - before.normal @ turned.T).max() < 1e-8  # rounding over the distance
    assert np.abs(after.curvature - before.curvature).max() < 1e-6


@motions
def test_points_keep_to_the_body_and_velocities_are_their_derivatives(motion):
    """The same point at all times, whose central differences are its velocity and acceleration to their order."""
    body = Body(CLOSED["ell"], (0.2, 0.4), 0.3, motion)
    step = 1e-4
    for time in (0.0, 0.4, 1.7):
        before, here, after = (body.boundary_points(0.2, time + k * step).point for k in (-1, 0, 1))
        assert np.abs((after - before) / (2 * step) - body.velocity(here, time)).max() < 1e-6  # step^2 w^2 and rounding
        difference = (after - 2 * here + before) / step**2
        assert np.abs(difference - body.acceleration(here, time)).max() < 1e-5
        assert np.abs(body.nearest(here, time).distance).max() < ROUNDING


def test_a_body_that_starts_from_rest_is_where_it_starts_before():
    wall = WallMotion(0.3, 0.1, 2.0, before=0.0)
    assert wall.velocity(TIMES).tolist()[0] == 0.0
    assert wall.velocity(0.0) == 0.3
    assert (wall.displacement(TIMES)[0], wall.acceleration(-1.0), wall.jerk(-1.0)) == (0.0, 0.0, 0.0)
    body = Body(Circle(1.0), motion=RigidMotion(x=wall, rotation=wall))
    assert body.at(-1.0).centre.tolist() == [0.0, 0.0]
    assert not body.velocity(PLACES, -1.0).any()
    stopped = WallMotion(0.0, before=0.5)
    assert stopped.displacement(TIMES).tolist() == [-0.15, 0.0, 0.0, 0.0]


@closed_shapes
def test_in_a_periodic_cell_a_body_is_all_its_copies(shape):
    """Nearest of the copies by brute force, also where the body has left the cell."""
    periods = (5.0, 6.0)
    body = Body(shape, (14.0, 1.0), 0.4, MOTIONS["constant"], periods)
    foot, time = body.nearest(PLACES, 0.7), 0.7
    copies = [
        Body(shape, (14.0 + 5.0 * i, 1.0 + 6.0 * j), 0.4, MOTIONS["constant"]).nearest(PLACES, time)
        for i in range(-5, 0)
        for j in range(-2, 3)
    ]
    least = np.argmin([copy.distance for copy in copies], axis=0)
    for name in ("distance", "point", "curvature"):
        expected = np.array([getattr(copies[k], name)[row] for row, k in enumerate(least)])
        assert np.abs(getattr(foot, name) - expected).max() < 1e-9
    shifted = body.velocity(PLACES + np.array([10.0, -6.0]), time)
    assert np.abs(shifted - body.velocity(PLACES, time)).max() < ROUNDING


def test_gaps_of_circles_in_closed_form():
    one, other = Body(Circle(1.0), (0.1, 0.2)), Body(Circle(0.5), (1.7, 0.9))
    apart = math.hypot(1.6, 0.7) - 1.5
    assert gap(one, other) == pytest.approx(apart, abs=1e-6)
    assert gap(other, one) == pytest.approx(apart, abs=1e-6)
    outer = Body(Circle(3.0, "inside"))
    assert gap(one, outer) == pytest.approx(3.0 - 1.0 - math.hypot(0.1, 0.2), abs=1e-6)
    assert gap(replace(one, centre=(1.5, 0.9)), other) == pytest.approx(-0.7, abs=1e-6)  # the deepest point
    wall = Body(Line((0.0, -2.0), length=8.0))
    assert gap(one, wall) == pytest.approx(1.2, abs=1e-6)
    assert smallest_gap([one, wall, other])[1] == (0, 2)
    square, circle = Polygon(((0, 0), (1, 0), (1, 1), (0, 1))), Body(Circle(0.3), (0.0, 2.0))
    assert gap(Body(square, angle=math.pi / 4), circle) == pytest.approx(1.7 - math.sqrt(2), abs=1e-5)  # at a corner
    moving = replace(other, motion=RigidMotion(x=WallMotion(1.0)))
    assert gap(one, moving, 2.0) == pytest.approx(math.hypot(3.6, 0.7) - 1.5, abs=1e-6)


def test_gaps_across_a_periodic_cell():
    periods = (4.0, math.inf)
    one, other = (Body(Circle(0.5), (x, 0.0), periods=periods) for x in (0.2, 3.5))
    assert gap(one, other) == pytest.approx(4.0 - 3.3 - 1.0, abs=1e-6)
    assert smallest_gap([replace(one, shape=Circle(1.8))]) == (pytest.approx(0.4, abs=1e-6), (0, 0))
    assert smallest_gap([Body(Circle(1.0))]) == (math.inf, None)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("points", [100, 1000])
def test_smallest_gap_is_that_of_all_pairs(seed, points):
    """Exactly, though most pairs are left out: far ones, overlapping ones, walls, and copies in a periodic cell."""
    draw = np.random.default_rng(seed)
    periods = [(math.inf, math.inf), (6.0, math.inf), (6.0, 5.0)][seed % 3]
    shapes = [*CLOSED.values(), *(Circle(radius) for radius in draw.uniform(0.1, 0.3, 6))]
    places = draw.uniform(0.0, 12.0 if seed < 3 else 5.0, (len(shapes), 2)).tolist()
    bodies = [
        Body(shape, tuple(place), angle=0.3, motion=MOTIONS["constant"], periods=periods)
        for shape, place in zip(shapes, places, strict=True)
    ]
    if periods[1] == math.inf:
        bodies += [Body(Line((0.0, -3.0), length=6.0)), Body(Circle(20.0, "inside"), (1.0, 1.0))]
    pairs = [(i, j) for i in range(len(bodies)) for j in range(i + 1, len(bodies))]
    found = [(gap(bodies[i], bodies[j], 0.3, points), (i, j)) for i, j in pairs]
    found += [(*smallest_gap([body], 0.3, points)[:1], (i, i)) for i, body in enumerate(bodies)]
    assert smallest_gap(bodies, 0.3, points) == min(found)


def test_what_bodies_cannot_do_is_refused():
    with pytest.raises(ValueError, match="cannot turn"):
        Body(Line(), motion=MOTIONS["turning"])
    with pytest.raises(ValueError, match="periods are above 0"):
        Body(Circle(1.0), periods=(0.0, 1.0))
    with pytest.raises(ValueError, match="give them a length"):
        gap(Body(Line()), Body(Line((0.0, 1.0), (-1.0, 0.0))))
