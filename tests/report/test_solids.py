"""Bodies in a movie frame: where they are, how they are turned, and through the seams of a periodic cell."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import Drawn, make_annulus, make_video

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.polygon import Polygon
from tisph.report import style
from tisph.report.layout import arrange
from tisph.report.overlays import Solids
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies

SIDE = 2.0
ORIGIN = (-1.0, 0.5)
PERIODS = (SIDE, SIDE)


def make_scene(*bodies, periodic):
    return SimpleNamespace(
        bodies=bodies, periodic=(periodic, periodic), walls=(), origin=ORIGIN, extent=(SIDE, SIDE), acceleration=0.0
    )


def paint(scene, time=0.0):
    """Return the layout, which pixels of a white box are painted, and the picture."""
    layout = arrange(scene, 640, 320)
    panel = np.full((layout.box.height, layout.box.width, 3), 255, dtype=np.uint8)
    bodies = Bodies.at(time, scene.bodies, np.zeros((2, len(scene.bodies), 4)))
    Solids(scene, layout).paint(panel, SimpleNamespace(bodies=bodies))
    return layout, np.any(panel < 255, axis=2), panel


def positions(layout):
    """Return x and y of the middles of all pixels."""
    rows, columns = np.mgrid[: layout.box.height, : layout.box.width] + 0.5
    return layout.low[0] + columns / layout.pixels_per_length, layout.high[1] - rows / layout.pixels_per_length


def drawn_as(body, layout, painted, time):
    """Tell whether all that is in ``body``, and nothing outside, is painted, but for a pixel and a half at its wall."""
    points = np.stack(positions(layout), axis=2).reshape(-1, 2)
    distance = body.nearest(points, time).distance.reshape(painted.shape) * layout.pixels_per_length
    return painted[distance < -1.5].all() and not painted[distance > 1.5].any()


SQUARE = Polygon(((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)))


@pytest.mark.parametrize("shape", [Circle(0.3), SQUARE], ids=["circle", "square"])
@pytest.mark.parametrize("centre", [(0.1, 1.5), (1.0, 1.5), (-1.0, 0.5), (0.9, 2.4)])
def test_a_body_is_where_it_is_and_through_the_seams(shape, centre):
    motion = RigidMotion(x=WallMotion(3.0), rotation=WallMotion(0.5))
    body = Body(shape, centre, motion=motion, periods=PERIODS)
    scene = make_scene(body, periodic=True)
    for time in (0.0, 1.1):  # by then it has left the box
        layout, painted, _ = paint(scene, time)
        assert (layout.low, layout.high) == ((-1.0, 0.5), (1.0, 2.5))
        assert drawn_as(body, layout, painted, time)


def test_a_cylinder_around_the_fluid_is_all_that_is_not_inside():
    body = Body(Circle(1.0, fluid_side="inside"), (0.0, 1.5))
    layout, painted, panel = paint(make_scene(body, periodic=False))
    assert layout.low[0] < -1.0 < 1.0 < layout.high[0]  # a rim is in sight
    assert drawn_as(body, layout, painted, 0.0)
    assert np.all(panel[0, 0] == style.rgb(style.LIGHT.solid))


def spoke_angle(body, time, nearest, farthest):
    """Return the mean direction from the centre of the dark pixels between two distances from it."""
    layout, _, panel = paint(make_scene(body, periodic=False), time)
    x, y = positions(layout)
    x, y = x - body.at(time).centre[0], y - body.at(time).centre[1]
    away = np.hypot(x, y)
    dark = (panel[:, :, 0] < 150) & (away > nearest) & (away < farthest)
    assert dark.any()
    return np.angle(np.sum((x + 1j * y)[dark]))


@pytest.mark.parametrize("time", [0.0, 1.0, 2.5])
def test_spoke_and_mark_turn_with_the_body(time):
    rotation = RigidMotion(rotation=WallMotion(1.3))
    inside = Body(Circle(0.7), (0.0, 1.5), motion=rotation)
    outside = Body(Circle(0.9, fluid_side="inside"), (0.0, 1.5), motion=rotation)
    first = math.pi / round(2 * math.pi * 0.9 / 0.004)  # points begin half a spacing from angle 0
    for body, nearest, farthest in ((inside, 0.1, 0.6), (outside, 0.92, 1.0)):
        turned = spoke_angle(body, time, nearest, farthest)
        assert abs(np.exp(1j * turned) - np.exp(1.3j * time)) < 0.02 + first  # a pixel over these distances


def test_marks_slide_with_a_straight_wall_and_the_wall_stays():
    lid = Body(Line((1.0, 2.5), (-1.0, 0.0), SIDE), motion=RigidMotion(x=WallMotion(0.8)))
    scene = make_scene(lid, periodic=False)
    still, slid, period = (paint(scene, time) for time in (0.0, 0.1, 0.625))  # 0.08, and 0.5, a pitch
    layout, painted, _ = still
    assert drawn_as(lid, layout, painted, 0.0)
    assert np.array_equal(painted, slid[1])
    row = int(layout.pixel_positions(0.0, 2.5)[1]) - 2
    marks = [np.flatnonzero(picture[2][row, :, 0] < 150) for picture in (still, slid, period)]
    assert np.array_equal(marks[0], marks[2])
    assert np.mean(marks[1]) - np.mean(marks[0]) == pytest.approx(0.08 * layout.pixels_per_length, abs=1.0)


@pytest.fixture(scope="module")
def annulus():
    return make_annulus(centre=(3.0, -1.0), outer=WallMotion(-0.5), initial_state="developed")


def test_frames_of_the_annulus_have_fluid_between_the_cylinders(annulus):
    initial = SimpleNamespace(seed=0, jitter=0.2)
    snapshot = start_snapshot(annulus, start_values(annulus, initial), "f64")
    for name in ("speed", "vorticity"):
        renderer = Drawn(annulus, make_video(640, 320, name), "annulus", 10.0)
        box = renderer.render(snapshot)[renderer.layout.box.slices]
        x, y = positions(renderer.layout)
        radius = np.hypot(x - 3.0, y + 1.0)
        solid = np.all(box == style.rgb(style.LIGHT.solid), axis=2)
        wide = 3 / renderer.layout.pixels_per_length
        assert not solid[(radius > 1.0 + wide) & (radius < 2.0 - wide)].any()
        assert solid[radius > 2.2].all()  # the corners, beyond any mark
        assert 0.9 < solid[radius < 1.0 - wide].mean() < 1.0  # all but the spoke


def test_exact_vorticity_of_the_annulus_is_the_curl_of_its_velocity(annulus):
    x, y, t, small = np.array([4.3, 2.0, 3.1]), np.array([-1.2, -0.1, 0.7]), 0.0, 1e-5
    slopes = [
        (annulus.exact(field, x + dx, y + dy, t) - annulus.exact(field, x - dx, y - dy, t)) / (2 * small)
        for field, dx, dy in (("v", small, 0.0), ("u", 0.0, small))
    ]
    assert annulus.exact_vorticity(x, y, t) == pytest.approx(slopes[0] - slopes[1], abs=1e-8)
    assert annulus.movie_view("vorticity", 1.0).ends == pytest.approx([-2.0, -2.0])  # twice a of u = a r + b / r
