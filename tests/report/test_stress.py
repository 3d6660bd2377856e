"""Movies coloured by polymer shear stress, and the error labels of all kinds of flow."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from report_scene import END, Drawn, make_channel, make_polymer_channel, make_snapshot, make_video, particles

from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.labels import error_label

VIDEO = make_video(960, 480, color_by="shear_stress")
LARGEST = 4e-4  # of the exact stress over the run
TIMES = "\N{MULTIPLICATION SIGN}"
DEVELOPED = {"initial_state": "developed"}


@pytest.fixture(scope="module")
def renderer():
    return Drawn(make_polymer_channel(), VIDEO, "test", END)


def with_stress(channel, stress):
    return replace(particles(channel, 5.0, [0.004], [0.006], [0.0]), stress_xy=np.array([stress]))


def colour_under_the_particle(renderer, snapshot):
    rect, scale = renderer.layout.box, renderer.layout.pixels_per_length
    gap = renderer.scene.gap
    row, column = rect.top + int((gap - snapshot.y[0]) * scale), rect.left + int(snapshot.x[0] * scale)
    return renderer.render(snapshot)[row, column].astype(float)


@pytest.mark.parametrize("share", [-1.5, -1.0, -0.3, 0.0, 0.7, 1.0])
def test_disc_has_the_colour_of_its_stress(renderer, share):
    colour = colour_under_the_particle(renderer, with_stress(renderer.scene, share * LARGEST))
    expected = 255 * np.array(matplotlib.colormaps[style.DIVERGING_MAP](0.5 + 0.5 * np.clip(share, -1, 1))[:3])
    # The look-up table has 256 stresses and 256 coverages: neighbouring entries differ by at most 3 levels.
    assert np.abs(colour - expected).max() <= 3


def test_both_signs_and_none_can_be_told_apart_and_from_the_background(renderer):
    minus, none, plus = (
        colour_under_the_particle(renderer, with_stress(renderer.scene, share * LARGEST)) for share in (-1, 0, 1)
    )
    assert minus[2] - minus[0] > 100  # blue, ...
    assert plus[0] - plus[2] > 100  # ... red: the two colours that all kinds of colour-blind eyes tell apart
    assert np.ptp(none) < 5  # grey
    assert none.max() < 230  # not the white of the background


def test_profile_panel_shows_the_stress_of_particles_and_the_exact_one(renderer):
    channel, rect = renderer.scene, renderer.layout.profile
    lowest, highest = renderer.quantity.profile_range
    shift = 0.5 * LARGEST
    snapshot = make_snapshot(channel, 5.0)
    frame = renderer.render(replace(snapshot, stress_xy=snapshot.stress_xy + shift)).astype(float)
    row = rect.top + int((1 - 3.5 / channel.rows) * rect.height)  # through the fourth row of particles
    exact = channel.exact_polymer_stress(channel.gap * 3.5 / channel.rows, 5.0)[1]
    for colour, stress in ((style.EXACT, exact), (style.PARTICLES, exact + shift)):
        distance = np.abs(frame[row, rect.left + 1 : rect.right - 1] - style.rgb(colour)).max(axis=1)
        columns = np.flatnonzero(distance < 40)  # the core of line or dot, not its soft rim
        expected = (stress - lowest) / (highest - lowest) * rect.width
        assert columns.mean() + 1.5 == pytest.approx(expected, abs=1.0)  # a pixel


def test_error_of_the_stress_is_named(renderer):
    channel = renderer.scene
    snapshot = make_snapshot(channel, 10.0)
    field = "stress_xy", "Sxy"
    wrong = replace(snapshot, stress_xy=1.02 * snapshot.stress_xy)
    assert error_label(channel, field)(wrong) == f"L2 error of Sxy 2.0{TIMES}10⁻²"
    assert error_label(channel, field)(make_snapshot(channel, 0.0)) == "unresolved: 0.0 spacings"


def test_particles_with_wrong_stress_do_not_stop_the_picture(renderer):
    colour = colour_under_the_particle(renderer, with_stress(renderer.scene, np.nan))
    assert colour[0] - colour[2] > 100  # the colour of the largest


@pytest.mark.parametrize(
    ("flow", "expected"),
    [
        ({}, False),
        ({**DEVELOPED}, False),
        ({"top": WallMotion(0.0), "acceleration": 2e-3}, False),
        ({"acceleration": 2e-3}, False),
        ({"acceleration": -2e-3}, True),  # backflow: g H^2/(2 nu U) = -20
        ({"acceleration": -0.5e-4, **DEVELOPED}, False),  # -1/2: the drive does not turn the fluid round ...
        ({"acceleration": -0.5e-4}, True),  # ... except early on, where it does not feel the wall yet
        ({"bottom": WallMotion(-0.002)}, True),
        ({"bottom": WallMotion(0.002)}, False),
        ({"top": WallMotion(0.0, 0.005, 3.0)}, True),
        ({"top": WallMotion(0.0, before=0.005), **DEVELOPED}, True),
        ({"top": WallMotion(0.002, before=0.005), **DEVELOPED}, False),
    ],
)
def test_flows_that_cross_zero_or_die_away_are_known(flow, expected):
    assert make_channel(**flow).vanishing_scale == expected


def test_error_is_a_multiple_of_the_reference_velocity_where_u_crosses_zero():
    channel = make_channel(bottom=WallMotion(-0.002))
    assert error_label(channel)(make_snapshot(channel, 5.0, slip=3e-3)) == f"rms error 3.0{TIMES}10⁻³ U"
