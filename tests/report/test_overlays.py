"""Fields, dye, paths, streamlines, arrows and bodies of a movie frame: where they are, and where none are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from couette import couette
from report_scene import END, Drawn, make_annulus, make_channel, make_snapshot, make_video

from tisph import scenes
from tisph.config.loader import loaded
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.outline import Outline
from tisph.geometry.polygon import Polygon
from tisph.geometry.wanted_spacing import InBox, WantedSpacing
from tisph.report.field import Dye, FieldGrid, GradedGrid
from tisph.report.layout import arrange
from tisph.report.overlays import Solids, Streamlines, Tracks, Vectors
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies, Snapshot

SHAPE = 160, 240
SIZE = 1.5, 1.0
HOLE = 0.7, 0.4, 0.2


def places(rows, seed=0):
    """Disordered particles of a box of ``SIZE``, and their spacing."""
    spacing = 1.0 / rows
    x, y = np.meshgrid((np.arange(round(1.5 * rows)) + 0.5) * spacing, (np.arange(rows) + 0.5) * spacing)
    shift = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, x.size)) * spacing
    return x.ravel() + shift[0], y.ravel() + shift[1], spacing


def pixels():
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    return columns / SHAPE[1] * SIZE[0], (1.0 - rows / SHAPE[0]) * SIZE[1]


def away(x, y):
    return np.hypot(x - HOLE[0], y - HOLE[1])


def test_a_linear_field_is_met_up_to_walls_and_around_a_hole():
    x, y, spacing = places(24)
    wet = away(x, y) > HOLE[2] + 0.3 * spacing
    grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (False, False))
    grid.fit(x[wet], y[wet], 2.0 + 3.0 * x[wet] - 5.0 * y[wet])
    column, row = pixels()
    error = np.abs(grid.image() - (2.0 + 3.0 * column - 5.0 * row))
    # what is added to second moments of about 1/3, less beside a wall, flattens slopes of 6 by some thousandths of a
    # spacing, and float32 is behind that
    assert np.nanmax(error[away(column, row) > HOLE[2]]) < 0.05 * 6.0 * spacing
    assert np.isfinite(error[away(column, row) > HOLE[2]]).all()
    assert np.isnan(grid.image()[away(column, row) < 0.02]).all()  # no particle is near
    x, y = np.array([0.2, 1.3]), np.array([0.01, 0.6])
    assert grid.at(x, y) == pytest.approx(2.0 + 3.0 * x - 5.0 * y, abs=0.02)


@pytest.mark.parametrize("periodic", [False, True])
def test_errors_fall_with_the_square_of_the_spacing(periodic):
    def wave(x, y):
        return np.sin(4.0 * np.pi * x / 3.0) * np.cos(2.0 * np.pi * y)

    errors = []
    for rows in (20, 40):
        x, y, spacing = places(rows)
        grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (periodic, periodic))
        grid.fit(x, y, wave(x, y))
        errors.append(np.sqrt(np.mean((grid.image() - wave(*pixels())) ** 2)))
    assert errors[0] / errors[1] > 3.2  # 4 but for disorder
    assert errors[1] < 3e-3


def rings(step=0.1, first=0.1):
    """Rings around the origin in a box of 2 x 2, ``step`` radii from each other: particles as they grow outwards."""
    ring, turn = np.meshgrid(np.arange(0.0, np.log(1.5 / first), step), np.arange(0.0, 2.0 * np.pi, step))
    radius, noise = first * np.exp(ring.ravel()), np.random.default_rng(0).uniform(-0.2, 0.2, (2, ring.size))
    x, y = radius * (np.array([np.cos(turn.ravel()), np.sin(turn.ravel())]) + step * noise)
    within, flow = np.maximum(np.abs(x), np.abs(y)) < 1.0, {"origin": (-1.0, -1.0), "extent": (2.0, 2.0)}
    x, y, area = x[within], y[within], (step * radius[within]) ** 2
    wanted = WantedSpacing(step, [InBox((0.0, 0.0), (0.0, 0.0), step * first)], step)
    scene = box(**flow, periodic=(False, False), spacing=step, reference_velocity=1.0, wanted_spacing=wanted)
    nothing = np.zeros_like(x)
    return scene, Snapshot(0.0, 0, x, y, nothing, nothing, nothing, nothing, area=area)


def test_a_field_is_as_fine_as_the_particles_at_each_place():
    """A wave of the wavelength of 12 particles at each radius, which a single grid would meet at one radius alone."""

    def wave(x, y):
        return np.cos(2.0 * np.pi * np.log(np.hypot(x, y)) / 1.2)

    scene, snapshot = rings()
    grid = GradedGrid(scene, arrange(scene, 640, 320), (False, False))
    grid.fit(snapshot, wave(snapshot.x, snapshot.y))
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    for radius in (0.15, 0.3, 0.6, 0.9):
        x, y = radius * np.cos(turn), radius * np.sin(turn)
        # at most 0.024 at any radius; a grid with the largest pitch errs by 0.57 at the smallest one
        assert np.abs(grid.at(x, y) - wave(x, y)).max() < 0.04, radius


def test_a_field_goes_on_through_a_periodic_side():
    spacing = 1.0 / 40
    grid = FieldGrid((0, 0), SIZE, SHAPE, spacing, (True, True))
    x, y, _ = places(40)
    grid.fit(x + 0.4, y - 0.7, np.cos(4.0 * np.pi * (x + 0.4) / 3.0))  # some have left the box
    assert grid.image() == pytest.approx(np.cos(4.0 * np.pi * pixels()[0] / 3.0), abs=0.01)


AT_REST = "drive", "acceleration", (0.0, 0.0)


def box(**changes):
    given = {
        "origin": (0.0, 0.0),
        "extent": SIZE,
        "periodic": (True, False),
        "walls": (),
        "bodies": (),
        "start_time": 0.0,
        "spacing": 0.05,
        **changes,
    }
    wanted = WantedSpacing(given["spacing"])
    return SimpleNamespace(**{"flows_through": False, "drive_shown": AT_REST, "wanted_spacing": wanted, **given})


def test_particles_put_in_between_others_have_their_dye():
    x, y, _ = places(20)
    dye, passages = Dye(box(periodic=(False, False)), "stripes"), np.zeros(len(x), dtype=int)
    area = np.ones(len(x))
    dye.of(SimpleNamespace(t=0.0, x=x, y=y, passages=passages, area=area))
    new = passages + (np.arange(len(x)) % 7 == 3)
    shown = dye.of(SimpleNamespace(t=0.1, x=x, y=y, passages=new, area=area))
    middle = np.abs(x * 8 / 1.5 % 1.0 - 0.5) < 0.2
    assert np.array_equal(shown[middle], np.floor(x[middle] * 8 / 1.5) % 2)


@pytest.mark.parametrize("pattern", ["stripes", "checkerboard", "blob"])
def test_dye_stays_with_its_particles(pattern):
    x, y, _ = places(20)
    dye = Dye(box(), pattern)
    first = dye.of(SimpleNamespace(t=0.0, x=x, y=y, passages=None))
    assert set(np.unique(first)) == {0.0, 1.0}
    assert np.array_equal(dye.of(SimpleNamespace(t=0.0, x=y, y=x, passages=None)), first)
    share = {"stripes": 0.5, "checkerboard": 0.5, "blob": np.pi * 0.15**2 / 1.5}[pattern]
    assert first.mean() == pytest.approx(share, abs=0.02)


def test_a_track_follows_its_particle_and_ends_at_a_periodic_side():
    scene = box()
    layout = arrange(scene, 1280, 640)
    tracks, panel = Tracks(scene, layout), np.full((layout.box.height, layout.box.width, 3), 255, dtype=np.uint8)
    for t, x in ((0.0, 1.2), (1.0, 1.4), (2.0, 0.1), (3.0, 0.3)):
        panel[:] = 255
        tracks.paint(panel, SimpleNamespace(t=t, x=np.array([x]), y=np.array([0.5]), passages=None))
    dark = np.flatnonzero(panel[:, :, 0].min(axis=0) < 100) / layout.pixels_per_length
    head = 4.0 * layout.scale / layout.pixels_per_length
    on_track = [(low - head < dark) & (dark < high + head) for low, high in ((1.2, 1.4), (0.1, 0.3))]
    assert np.logical_or(*on_track).all()
    assert all(part.any() for part in on_track)
    rows = np.flatnonzero(panel[:, :, 0].min(axis=1) < 100) / layout.pixels_per_length
    assert abs(rows.mean() - 0.5) < head


ACROSS = 40
BOX = box(extent=(1.0, 1.0), periodic=(True, True), spacing=1 / ACROSS, reference_velocity=1.0)
BOX.axisymmetric, BOX.seen = False, lambda snapshot: BOX


def lines(scene, snapshot):
    """Return the lines in a frame of ``scene``."""
    streams = Streamlines(scene, arrange(scene, 640, 320))
    stream = streams.measured(snapshot)
    return streams.lines(stream) if stream else []


def lines_of(u, v):
    """Return the lines in a periodic box of disordered particles with velocities u(x, y), v(x, y)."""
    place = (np.arange(ACROSS**2) % ACROSS, np.arange(ACROSS**2) // ACROSS)
    jitter = np.random.default_rng(0).uniform(-0.2, 0.2, (2, ACROSS**2))
    x, y = (np.array(place) + 0.5 + jitter) / ACROSS
    nothing = np.zeros(ACROSS**2)
    return lines(BOX, Snapshot(0.0, 0, x, y, u(x, y) + nothing, v(x, y) + nothing, nothing, nothing))


def test_a_stream_function_is_zero_on_walls():
    """A vortex in a box, psi = sin^2(pi x) sin^2(pi y)/pi, has walls at rest; its mean would be 0.25/pi."""
    box = {"scene": "cavity", "geometry": {"width": 1.0, "height": 1.0}, "walls": {"lid": {"velocity": 1.0}}}
    scene = scenes.of(loaded(couette(**box, discretisation={"particles_across": 32}), {}))
    x, y = (np.ravel(each) for each in np.meshgrid(*2 * [(np.arange(32) + 0.5) / 32]))
    sx, sy, sx2, sy2 = np.sin(np.pi * x), np.sin(np.pi * y), np.sin(2 * np.pi * x), np.sin(2 * np.pi * y)
    nothing = np.zeros(x.size)
    snapshot = Snapshot(0.0, 0, x, y, sx**2 * sy2, -sx2 * sy**2, nothing, nothing)
    streams = Streamlines(scene, arrange(scene, 640, 320))
    stream = streams.measured(replace(snapshot, bodies=Bodies.at(0.0, scene.bodies)))
    assert stream.ends == pytest.approx((0.0, 1.0 / np.pi), abs=0.01)  # means of the nearest: second order
    assert streams.levels(stream) == pytest.approx((np.arange(10) + 0.5) * streams.step)


@pytest.fixture(scope="module")
def annulus():
    """The scene, and its particles in the steady flow around the inner cylinder."""
    scene = make_annulus()
    snapshot = start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.0, seed=0)), "f64")
    radius = np.hypot(snapshot.x, snapshot.y)
    speed = (4.0 / radius - radius) / 3.0
    return scene, replace(snapshot, u=-speed * snapshot.y / radius, v=speed * snapshot.x / radius)


def test_lines_between_cylinders_are_circles_and_none_is_within_a_body(annulus):
    scene, snapshot = annulus
    radii = [np.hypot(*line.T) for line in lines(scene, snapshot)]
    assert max(np.ptp(each) for each in radii) < 0.01  # 0.003, with eight particles across: of second order
    flow = np.sort([(4.0 * np.log(each.mean()) - each.mean() ** 2 / 2.0 + 0.5) / 3.0 for each in radii])
    between = (4.0 * np.log(2.0) - 1.5) / 3.0
    # the extremes are those at nodes, up to half a spacing from a wall: a hundredth of the flow
    assert flow / between == pytest.approx((np.arange(10) + 0.5) / 10, abs=0.02)


def test_fluid_at_rest_and_a_run_gone_wrong_have_no_lines():
    channel = make_channel()
    drawn = [Drawn(channel, make_video(overlay=each), "", END) for each in ("none", "streamlines", "vectors")]
    snapshot = make_snapshot(channel, 5.0)

    def boxes():
        return [each.render(snapshot)[each.layout.box.slices].copy() for each in drawn]

    plain, *others = boxes()
    assert not any(np.array_equal(each, plain) for each in others)
    snapshot.u[3] = np.nan
    plain, *others = boxes()
    assert all(np.array_equal(each, plain) for each in others)
    assert lines_of(lambda x, y: 1e-6 * np.sin(9 * x), lambda x, y: 0.0) == []


SCENE = box(extent=(1.0, 1.0), periodic=(True, True), spacing=1 / 40, reference_velocity=2.0)
LAYOUT = arrange(SCENE, 1280, 640)


def paint(u, v, keep=lambda x, y: True):
    """Return which pixels of the box have ink on them, where ``keep`` says that there are particles."""
    x, y = (np.arange(1600) % 40 + 0.5) / 40, (np.arange(1600) // 40 + 0.5) / 40
    kept = np.broadcast_to(keep(x, y), x.shape)
    x, y, nothing = x[kept], y[kept], np.zeros(kept.sum())
    panel = np.full((LAYOUT.box.height, LAYOUT.box.width, 3), 255, dtype=np.uint8)
    Vectors(SCENE, LAYOUT).paint(panel, Snapshot(0.0, 0, x, y, u + nothing, v + nothing, nothing, nothing))
    return (255 - panel[:, :, 0].astype(float)) / 255


def arrow(u, v):
    """Return the ink of one arrow, of those on an even grid, around its middle."""
    ink = paint(u, v)
    count = int(LAYOUT.box.width / (40 * LAYOUT.scale))
    middle, half = (np.array([4.5, 4.5]) / count * LAYOUT.box.width).astype(int), LAYOUT.box.width // count // 2
    return ink[middle[1] - half : middle[1] + half, middle[0] - half : middle[0] + half]


@pytest.mark.parametrize("way", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_arrows_point_where_the_fluid_goes(way):
    ink = arrow(*(1.5 * np.array(way)))
    rows, columns = np.mgrid[: ink.shape[0], : ink.shape[1]] + 0.5
    across, along = (columns, ink.shape[0] - rows) if way[0] == 0 else (ink.shape[0] - rows, columns)
    along = along - ink.shape[0] / 2 if sum(way) > 0 else ink.shape[0] / 2 - along
    across = across - ink.shape[0] / 2
    assert (ink * across**2 * along).sum() > 0.0  # the head, which is wide, is ahead


SIDE = 2.0
ORIGIN = (-1.0, 0.5)
PERIODS = (SIDE, SIDE)


def make_scene(*bodies, periodic):
    return box(bodies=bodies, periodic=(periodic, periodic), origin=ORIGIN, extent=(SIDE, SIDE))


def paint_bodies(scene, time=0.0):
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


def test_the_solid_behind_an_outline_is_drawn():
    corners = ((-1.0, 0.8), (-0.4, 0.8), (-0.4, 1.5), (SIDE - 1.0, 1.5))
    for body in (Body(Outline(corners, 0.2)), Body(Outline(corners[::-1], 0.2))):
        layout, painted, _ = paint_bodies(make_scene(body, periodic=False))
        between = np.abs(positions(layout)[0]) < 0.99  # beyond are the ends of the channel
        assert drawn_as(body, layout, painted, 0.0, between)


def drawn_as(body, layout, painted, time, where=True):
    """Tell whether all that is in ``body``, and nothing outside, is painted, but for a pixel and a half at its wall."""
    points = np.stack(positions(layout), axis=2).reshape(-1, 2)
    distance = body.nearest(points, time).distance.reshape(painted.shape) * layout.pixels_per_length
    return painted[where & (distance < -1.5)].all() and not painted[where & (distance > 1.5)].any()


SQUARE = Polygon(((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)))


@pytest.mark.parametrize("shape", [Circle(0.3), SQUARE], ids=["circle", "square"])
@pytest.mark.parametrize("centre", [(0.1, 1.5), (1.0, 1.5), (-1.0, 0.5), (0.9, 2.4)])
def test_a_body_is_where_it_is_and_through_the_seams(shape, centre):
    motion = RigidMotion(x=WallMotion(3.0), rotation=WallMotion(0.5))
    body = Body(shape, centre, motion=motion, periods=PERIODS)
    scene = make_scene(body, periodic=True)
    for time in (0.0, 1.1):  # by then it has left the box
        layout, painted, _ = paint_bodies(scene, time)
        assert (layout.low, layout.high) == ((-1.0, 0.5), (1.0, 2.5))
        assert drawn_as(body, layout, painted, time)


def test_marks_slide_with_a_straight_wall_and_the_wall_stays():
    lid = Body(Line((1.0, 2.5), (-1.0, 0.0), SIDE), motion=RigidMotion(x=WallMotion(0.8)))
    scene = make_scene(lid, periodic=False)
    still, slid, period = (paint_bodies(scene, time) for time in (0.0, 0.1, 0.625))  # 0.08, and 0.5, a pitch
    layout, painted, _ = still
    assert drawn_as(lid, layout, painted, 0.0)
    assert np.array_equal(painted, slid[1])
    row = int(layout.pixel_positions(0.0, 2.5)[1]) - 2
    marks = [np.flatnonzero(picture[2][row, :, 0] < 150) for picture in (still, slid, period)]
    assert np.array_equal(marks[0], marks[2])
    assert np.mean(marks[1]) - np.mean(marks[0]) == pytest.approx(0.08 * layout.pixels_per_length, abs=1.0)
