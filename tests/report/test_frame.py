import warnings

import matplotlib
import numpy as np
import pytest
from report_scene import END, Drawn, make_channel, make_snapshot, make_video, particles

from tisph.geometry.motion import WallMotion
from tisph.measures.metrics import relative_error
from tisph.report import style
from tisph.report.labels import error_label

WIDTH, HEIGHT = 960, 480
VIDEO = make_video(WIDTH, HEIGHT)
LINEAR = {"initial_state": "developed"}


@pytest.fixture(scope="module")
def renderer():
    return Drawn(make_channel(**LINEAR), VIDEO, "test", END)


def pixel(renderer, x, y):
    """Row and column in the frame of a place in the channel."""
    rect, scale = renderer.layout.box, renderer.layout.pixels_per_length
    return rect.top + int((renderer.scene.gap - y) * scale), rect.left + int(x * scale)


def test_frame_has_the_size_asked_for_in_bytes(renderer):
    frame = renderer.render(make_snapshot(renderer.scene, 1.0))
    assert frame.shape == (HEIGHT, WIDTH, 3)
    assert frame.dtype == np.uint8


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.7, 1.0, 1.5])
def test_disc_has_the_colour_of_its_speed(renderer, fraction):
    channel = renderer.scene
    speed = fraction * channel.reference_velocity
    frame = renderer.render(particles(channel, 1.0, [0.004], [0.006], [-speed]))
    expected = 255 * np.array(matplotlib.colormaps["viridis"](min(fraction, 1.0))[:3])
    # The look-up table has 256 speeds and 256 coverages: neighbours differ by at most 2 levels, and are whole ones.
    assert np.abs(frame[pixel(renderer, 0.004, 0.006)] - expected).max() <= 2.5


def test_a_disc_is_at_its_particle_and_the_rest_is_white(renderer):
    x, y = 0.0137, 0.0031
    frame = renderer.render(particles(renderer.scene, 1.0, [x], [y], [0.0]))
    ink = 255.0 - frame[renderer.layout.box.slices][:, :, 0]
    rows, columns = np.mgrid[: ink.shape[0], : ink.shape[1]] + 0.5
    scale = renderer.layout.pixels_per_length
    # Rim sampling as in the raster tests, and bytes: a twentieth of a pixel.
    assert (ink * columns).sum() / ink.sum() == pytest.approx(x * scale, abs=0.05)
    assert (ink * rows).sum() / ink.sum() == pytest.approx((renderer.scene.gap - y) * scale, abs=0.05)
    assert np.count_nonzero(ink) < 4 * (2 * renderer.disc_radius + 2) ** 2


def test_two_snapshots_differ_only_where_something_moves(renderer):
    channel, layout = renderer.scene, renderer.layout
    early, late = make_snapshot(channel, 1.0), make_snapshot(channel, 20.0, slip=0.1)
    changed = np.any(renderer.render(early).copy() != renderer.render(late), axis=2)
    for part in (layout.box, layout.profile, layout.series, layout.time_label, layout.error_label):
        assert changed[part.slices].any()
        changed[part.slices] = False
    assert not changed.any()


def test_same_snapshot_gives_the_same_frame(renderer):
    snapshot = make_snapshot(renderer.scene, 1.0)
    first = renderer.render(snapshot).copy()
    renderer.render(make_snapshot(renderer.scene, 5.0, slip=0.2))
    assert np.array_equal(first, renderer.render(snapshot))


def test_exact_curve_and_dots_stand_at_their_velocity(renderer):
    channel, rect = renderer.scene, renderer.layout.profile
    lowest, highest = renderer.quantity.profile_range
    shift = 0.5
    frame = renderer.render(make_snapshot(channel, 1.0, slip=shift)).astype(float)
    red = 255 * np.array(matplotlib.colors.to_rgb(style.EXACT))
    blue = 255 * np.array(matplotlib.colors.to_rgb(style.PARTICLES))
    row = rect.top + int((1 - 3.5 / channel.rows) * rect.height)  # through the fourth row of particles
    u = channel.exact_velocity(channel.gap * 3.5 / channel.rows, 1.0)
    for colour, velocity in ((red, u), (blue, u + shift * channel.reference_velocity)):
        distance = np.abs(frame[row, rect.left + 1 : rect.right - 1] - colour).max(axis=1)
        columns = np.flatnonzero(distance < 40)  # the core of line or dot, not its soft rim
        expected = (velocity - lowest) / (highest - lowest) * rect.width
        assert columns.mean() + 1.5 == pytest.approx(expected, abs=1.0)  # a pixel


def test_a_periodic_edge_shows_both_parts_of_a_disc(renderer):
    frame = renderer.render(particles(renderer.scene, 1.0, [0.0], [0.005], [0.0]))
    panel = frame[renderer.layout.box.slices]
    middle = panel.shape[0] // 2
    assert panel[middle, 0, 0] < 100
    assert panel[middle, -1, 0] < 100
    long = Drawn(make_channel(length=0.1), VIDEO, "test", END)
    panel = long.render(particles(long.scene, 1.0, [0.0], [0.005], [0.0]))[long.layout.box.slices]
    assert panel[panel.shape[0] // 2, 0, 0] < 100
    assert panel[panel.shape[0] // 2, -1, 0] == 255


@pytest.mark.parametrize("velocity", [0.005, -0.005])
def test_arrows_show_the_motion_of_walls(velocity):
    renderer = Drawn(make_channel(top=WallMotion(velocity)), VIDEO, "test", END)
    frame = renderer.render(make_snapshot(renderer.scene, 1.0))
    layout, rect = renderer.layout, renderer.layout.box
    wall = frame[rect.top - layout.wall_thickness + 2 : rect.top - 2, rect.left : rect.left + rect.width // 3, 0]
    white = (wall > 200).sum(axis=0)
    arrows = np.flatnonzero(white)
    first = arrows[: np.flatnonzero(np.diff(np.append(arrows, arrows[-1] + 9)) > 1)[0] + 1]
    head = np.argmax(white[first])  # the head is wider than the shaft
    assert (head > len(first) / 2) == (velocity > 0)
    resting = frame[rect.bottom + 2 : rect.bottom + layout.wall_thickness - 2, rect.left : rect.right]
    assert resting.mean() > 180  # hatched and light: no dark bar, so no arrows


def test_particles_gone_wrong_do_not_stop_the_picture(renderer):
    channel = renderer.scene
    wrong = particles(channel, 1.0, [0.001, np.nan, 0.003, 0.007], [0.005, 0.005, np.inf, 0.005], [0, 0, 0, np.nan])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frame = renderer.render(wrong)
    assert frame[pixel(renderer, 0.001, 0.005)][0] < 100


def test_user_settings_of_matplotlib_do_not_reach_the_picture(renderer):
    with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "black", "figure.facecolor": "black"}):
        other = Drawn(renderer.scene, VIDEO, "test", END)
    snapshot = make_snapshot(renderer.scene, 1.0)
    assert np.array_equal(other.render(snapshot), renderer.render(snapshot))


def test_error_is_relative_to_the_exact_profile():
    channel = make_channel(**LINEAR)
    x, y = channel.lattice()
    exact = channel.exact_velocity(y, 1.0)
    assert relative_error(channel, particles(channel, 1.0, x, y, 1.01 * exact)) == pytest.approx(0.01)
    at_rest = make_channel()
    assert relative_error(at_rest, particles(at_rest, 0.0, x, y, 0 * x)) is None
    assert error_label(at_rest)(particles(at_rest, 0.0, x, y, 0 * x)) == "unresolved: 0.0 spacings"
