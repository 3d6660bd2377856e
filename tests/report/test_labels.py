"""Texts of pictures: numbers, units, error labels, labels of walls and drives, and room for all."""

from pathlib import Path

import numpy as np
import pytest
from report_scene import END, Drawn, make_channel, make_video, particles

from tisph import scenes
from tisph.config import load
from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.labels import axis_exponent, coordinate_name, cut_name, fixed_point, number
from tisph.report.layout import Rect, arrange
from tisph.report.text import DriveLabel, paint_arrow, wall_labels

MINUS, TIMES, NU = "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}", "\N{GREEK SMALL LETTER NU}"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (50.0, "50"),
        (0.005, "0.005"),
        (-0.25, f"{MINUS}0.25"),
        (9999.0, "9999"),
        (9999.9, f"1{TIMES}10⁴"),
        (3e-7, f"3{TIMES}10⁻⁷"),
        (-2.5e-4, f"{MINUS}2.5{TIMES}10⁻⁴"),
        (float("nan"), "nan"),
        (123456.0, f"1.235{TIMES}10⁵"),
    ],
)
def test_numbers_are_plain_in_the_usual_range_and_scientific_beyond(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("largest", "exponent"), [(0.005, -3), (0.01, 0), (1.0, 0), (9000.0, 0), (2e5, 3), (3e-7, -9), (0.0, 0)]
)
def test_axes_take_out_powers_of_a_thousand(largest, exponent):
    assert axis_exponent(largest) == exponent


@pytest.mark.parametrize(
    ("largest", "value", "text"),
    [
        (0.5, 0.25, "0.250"),
        (0.005, -0.00354, f"{MINUS}0.00354"),
        (0.5, -1e-9, "0.000"),
        (1234.0, 7.3, "7"),
        (2e5, -1.5e5, f"{MINUS}150{TIMES}10³"),
        (3e-7, 1.5e-7, f"150{TIMES}10⁻⁹"),
    ],
)
def test_values_that_change_keep_their_decimals(largest, value, text):
    assert fixed_point(largest, 3)(value) == text


BOX = Rect(10, 5, 34, 11)


def ink(share):
    """Coverage of the pixels of a frame with a black arrow, 0 to 1."""
    frame = np.full((30, 60, 3), 255, dtype=np.uint8)
    paint_arrow(frame, BOX, share, "#000000")
    return 1.0 - frame[:, :, 0] / 255.0


VIDEO = make_video(960, 480)
FREQUENCY = np.pi  # radians a second: a period of 2 s
DEVELOPED = {"initial_state": "developed"}


def renderer_of(**changes):
    return Drawn(make_channel(**{"top": WallMotion(0.0), **changes}), VIDEO, "test", END)


def frame_at(renderer, t):
    return renderer.render(particles(renderer.scene, t, [0.0], [0.005], [0.0])).copy()


def arrow_directions(renderer, t):
    """Of each white arrow left of the words on the upper wall: +1 if its head is at the right, -1 at the left."""
    bar, words = renderer.layout.wall("top"), wall_labels(renderer.scene, renderer.layout)[0].box
    height = (frame_at(renderer, t)[bar.top + 2 : bar.bottom - 2, bar.left : words.left, 0] > 200).sum(axis=0)
    columns = np.flatnonzero(height)
    arrows = np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1) if columns.size else []
    return [1 if np.argmax(height[arrow]) > len(arrow) / 2 else -1 for arrow in arrows]


def test_labels_and_arrows_follow_a_wall_that_oscillates():
    renderer = renderer_of(top=WallMotion(0.004, 0.0, FREQUENCY))
    directions = {t: set(arrow_directions(renderer, t)) for t in (0.0, 0.5, 1.0, 1.5, 2.0)}
    assert directions == {0.0: {1}, 0.5: set(), 1.0: {-1}, 1.5: set(), 2.0: {1}}
    label = wall_labels(renderer.scene, renderer.layout)[0]
    assert [label.words(t) for t in (0.0, 0.5, 1.0, 1.25)] == [
        "0.00400 m/s",
        "0.00000 m/s",
        "\N{MINUS SIGN}0.00400 m/s",
        "\N{MINUS SIGN}0.00283 m/s",
    ]


def scene_of(name, **changes):
    """The scene of one of the configs, changed."""
    path = Path(__file__).parents[2] / "configs" / f"{name}.yaml"
    return scenes.of(load(path, [f"{key}={value}" for key, value in changes.items()]))


def test_gravity_points_down_and_a_lid_along():
    """An arrow ends in a point, which has less ink than the shaft."""
    disc = scene_of("drafting_kissing_tumbling", **{"drive.gravity": [0.0, -981.0], "drive.acceleration": 0.0})
    name, unit, vector = disc.drive_shown
    assert (name, unit, vector) == ("gravity", "acceleration", (0.0, -981.0))
    layout = arrange(disc, 1280, 640)
    frame = np.full((640, 1280, 3), 255, dtype=np.uint8)
    label = DriveLabel(disc, layout)
    label.paint(frame, 0.0)
    arrow = frame[label.box.slices][:, -layout.pixels(34) :, 0]
    ink = (arrow < 90).sum(axis=1)
    rows = np.flatnonzero(ink)
    assert ink[rows[-1]] < ink[rows[0]] < ink.max()
    assert scene_of("cavity").drive_shown == ("lid", "velocity", (1.0, 0.0))


def inked(label, t):
    """Return the columns of the label that have ink at time ``t``, without its words."""
    frame = np.full((640, 1280, 3), 255, dtype=np.uint8)
    label.paint(frame, t)
    return np.flatnonzero((frame[label.boxes[0].slices][:, -34:, 0] < 90).any(axis=0))


def test_a_drive_that_varies_is_shown_as_at_each_moment():
    pipe = scene_of("womersley")
    largest = pipe.drive_shown[2][0]
    assert largest == pytest.approx(abs(pipe.acceleration) + pipe.pulsation.amplitude)
    for t in (0.0, 0.3, 1.1):
        assert pipe.drive_share(t) * largest == pytest.approx(pipe.drive.value(t))
    assert scene_of("poiseuille").drive_share(0.3) is None


def test_the_arrow_of_a_lid_follows_its_velocity():
    lid = scene_of("cavity_oldroyd_b")
    label = DriveLabel(lid, arrange(lid, 1280, 640))
    lengths = [np.ptp(inked(label, t)) if len(inked(label, t)) else 0 for t in (0.0, 0.5, 1.0)]
    assert label.animated
    assert lengths == pytest.approx([0, 17, 34], abs=2)  # pixels: half the speed at t = 0.5
    assert not DriveLabel(scene_of("cavity"), arrange(scene_of("cavity"), 1280, 640)).animated


def test_names_of_axes_and_places_of_cuts():
    ball, cavity = scene_of("falling_ball"), scene_of("cavity")
    assert [coordinate_name(ball, axis) for axis in "xy"] == ["x", "r"]
    assert [coordinate_name(cavity, axis) for axis in "xy"] == ["x", "y"]
    assert [cut_name(profile, cavity) for profile in cavity.profiles()] == ["u at x = 0.5 m", "v at y = 0.5 m"]
    assert [profile.reference for profile in cavity.profiles()] == 2 * ["Marchi et al. 2009, steady"]


def test_stopped_wall_is_light_without_arrows_and_says_what_it_did():
    renderer = renderer_of(top=WallMotion(0.0, before=0.005), **DEVELOPED)
    label = wall_labels(renderer.scene, renderer.layout)[0]
    assert label.words(0.0) == "stopped (0.005 m/s before t = 0)"
    frame, bar = frame_at(renderer, 0.0), renderer.layout.wall("top")
    assert frame[bar.slices].mean() > 180  # no dark bar
    behind = frame[label.box.slices]
    assert (behind[:, :, 0] < 90).any()  # words on the plain colour of the wall, without hatching
    corner = behind[:3, :3]
    assert np.all(corner == style.rgb(style.LIGHT.wall_resting).astype(np.uint8))
