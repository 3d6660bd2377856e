"""Quantities, colours, limits and stresses that movies show."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from report_scene import (
    END,
    Drawn,
    make_annulus,
    make_channel,
    make_polymer_channel,
    make_snapshot,
    make_video,
    particles,
    shown,
)

from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.labels import error_label
from tisph.report.quantities import Extremes, Spread, limits_of
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

DEVELOPED = {"initial_state": "developed"}
PARABOLA = 2e-3 * 0.01**2 / 8e-6  # largest speed g H^2/(8 nu) of the developed driven flow


def test_plane_couette_reaches_from_rest_to_the_wall_velocity():
    speed = shown("speed", make_channel(), end=20.0)
    assert speed.colour_range == (0.0, 0.005)
    assert speed.profile_range == pytest.approx((-0.08 * 0.005, 1.08 * 0.005))


def test_ranges_fit_the_run_and_not_the_flow_that_it_would_become():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    long, short = (shown("speed", channel, end).colour_range[1] for end in (300.0, 5.0))
    assert long == pytest.approx(PARABOLA, rel=1e-12)  # three digits, rounded up: 0.025
    # At mid-gap t* = 0.05 the walls are not felt: u is close to g t, and rounding up adds 1 % at most.
    assert short == pytest.approx(2e-3 * 5.0, rel=0.1)


def test_profile_axis_shows_a_flow_back():
    channel = make_channel(acceleration=-4e-3)
    speed = shown("speed", channel, end=300.0)
    # Developed: u = U eta - 4 P eta (1 - eta) with P = g H^2/(8 nu) = 0.05, smallest at eta = (1 - U/4P)/2.
    eta = 0.5 * (1.0 - 0.005 / 0.2)
    lowest = 0.005 * eta - 0.2 * eta * (1.0 - eta)
    width = 0.005 - lowest
    # Looked at in steps of a hundredth of the gap: 4 P (1/200)^2 = 5e-6 above the minimum at most, plus its margin.
    assert speed.profile_range == pytest.approx((lowest - 0.08 * width, 0.005 + 0.08 * width), abs=6e-6)
    assert speed.colour_range[1] == pytest.approx(-lowest, rel=0.01)  # rounded up to three digits


@pytest.mark.parametrize("frequency", [0.3, 20.0])
def test_profile_axis_shows_all_of_an_oscillation(frequency):
    channel = make_channel(top=WallMotion(0.0, -0.005, frequency), **DEVELOPED)
    speed = shown("speed", channel, end=20.0)
    # 2000 times over 64 periods are 30 a period: the largest is missed by 1 - cos(pi/30) = 0.5 % at most.
    assert speed.profile_range == pytest.approx((-1.16 * 0.005, 1.16 * 0.005), rel=0.01)


def test_colours_of_a_stopped_flow_follow_most_of_its_run():
    channel = make_channel(top=WallMotion(0.0, before=0.005), **DEVELOPED)
    view, speed = channel.movie_view("speed", 20.0), shown("speed", channel, end=20.0)
    beyond = np.mean(np.abs(view.values) > speed.colour_range[1])
    assert 0.0 < beyond < 0.01  # by construction; in whole, the colours of most frames would be those of rest
    assert speed.colour_range[1] < 0.75 * 0.005
    assert speed.profile_range[1] > 0.005


def test_profile_axis_covers_an_early_overshoot():
    class Overshooting(Channel):
        def exact_velocity(self, y, t):
            return 0.005 * (1.0 + 1.8 * np.exp(-(((t - 1.0) / 0.5) ** 2))) + 0.0 * np.asarray(y)

    channel = Overshooting(**vars(make_channel()))
    # Around t = 1 the times are 0.3 apart: within 0.15 of the peak, exp(-0.09) = 0.91 of the overshoot.
    assert shown("speed", channel, end=100.0).profile_range[1] >= 0.005 * (1.0 + 1.8 * 0.91)


def test_run_that_ends_before_anything_moves_has_axes_all_the_same():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    speed = shown("speed", channel, end=0.0)
    assert speed.colour_range == (0.0, 1.0)
    assert speed.profile_range[0] < speed.profile_range[1]


def test_shear_stress_is_centred_at_zero_and_reaches_what_the_run_reaches():
    channel = make_polymer_channel()
    for end, largest in ((0.5, 2e-4), (5.0, 4e-4)):
        stress = shown("shear_stress", channel, end)
        # linear in y, but growing in time up to t = 1: a tenth of the colours may be cut off
        low, high = stress.colour_range
        assert low == -high
        assert 0.9 * largest < high <= largest
        assert stress.profile_range == pytest.approx((-1.16 * high, 1.16 * high), rel=0.01)
    assert stress.unit == "Pa"


def test_quantities_take_discs_and_profile_from_the_snapshot():
    channel = make_polymer_channel()
    snapshot = make_snapshot(channel, 1.0)
    object.__setattr__(snapshot, "v", snapshot.u * 0.75)
    speed, stress = (shown(name, channel, 1.0) for name in ("speed", "shear_stress"))
    assert np.allclose(channel.movie_view("speed", 1.0).of(snapshot), 1.25 * np.abs(snapshot.u), rtol=1e-14)
    assert np.array_equal(speed.profile.of(snapshot), snapshot.u)
    assert np.array_equal(channel.movie_view("shear_stress", 1.0).of(snapshot), snapshot.stress_xy)
    assert np.array_equal(stress.profile.of(snapshot), snapshot.stress_xy)
    y = np.array([0.0, 0.01])
    assert stress.profile.exact(None, y, 1.0).tolist() == [4e-4, -4e-4]


BLIND = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""Linear RGB as such eyes see it: G. M. Machado et al., IEEE Trans. Vis. Comput. Graph. 15 (2009) 1291, severity 1."""


def lab(colours, eyes):
    """CIELAB (n, 3) of sRGB colours (n, 3), 0 to 1, as ``eyes`` see them."""
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    linear = np.clip(linear @ np.array(BLIND[eyes]).T, 0.0, 1.0) if eyes else linear
    xyz = linear @ np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]).T
    f = np.cbrt(xyz / [0.9505, 1.0, 1.089])
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


@pytest.mark.parametrize("eyes", [None, *BLIND])
def test_colour_maps_can_be_read_by_all_eyes(eyes):
    levels = np.linspace(0.0, 1.0, 9)
    for name in (style.COLOUR_MAP, style.DIVERGING_MAP):
        seen = lab(matplotlib.colormaps[name](levels)[:, :3], eyes)
        apart = np.linalg.norm(seen[:, None] - seen[None], axis=2) + 99.0 * np.eye(len(seen))
        assert apart.min() > 5.0  # two levels of nine; a just noticeable difference is 2.3
    for colours in (style.DYES, style.LIGHT.series, style.DARK.series):
        seen = lab(np.array([matplotlib.colors.to_rgb(colour) for colour in colours]), eyes)
        apart = np.linalg.norm(seen[:, None] - seen[None], axis=2) + 99.0 * np.eye(len(seen))
        assert apart.min() > 15.0


@pytest.mark.parametrize("theme", style.THEMES.values(), ids=style.THEMES)
def test_words_stand_out_from_their_ground(theme):
    def luminance(colour):
        channel = style.rgb(colour) / 255.0
        linear = np.where(channel <= 0.04045, channel / 12.92, ((channel + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    for ink, ground in ((theme.text, theme.background), (theme.on_wall_moving, theme.wall_moving)):
        high, low = sorted((luminance(ink), luminance(ground)), reverse=True)
        assert (high + 0.05) / (low + 0.05) > 7.0  # contrast of WCAG 2.1, level AAA


def test_a_dark_movie_is_dark_all_over():
    channel = make_channel()
    frame = Drawn(channel, make_video(theme="dark"), "", END).render(make_snapshot(channel, 5.0))
    assert np.median(frame) < 40


def test_limits_of_the_config_hold():
    assert shown("speed", make_channel(), 20.0, (0.001, 0.002)).colour_range == (0.001, 0.002)


def test_limits_of_colours_come_from_the_whole_field_and_run():
    line = np.linspace(-1.0, 1.0, 1001)
    assert limits_of(line) == (-1.0, 1.0)  # linear values are shown as far as they go
    outlier = [1e3, np.nan, np.inf]  # one number of 2000
    assert limits_of(np.concatenate([line, line, outlier])) == (-1.0, pytest.approx(1.0, abs=0.2))
    # fluid at rest does not lower them: a vortex has the same in a box four times as large
    vortex = 1.0 / (np.hypot(*np.mgrid[-2:2:81j, -2:2:81j]).ravel() + 0.1)
    alone, padded = limits_of(vortex)[1], limits_of(np.concatenate([vortex, np.zeros(3 * vortex.size)]))[1]
    # the 99.9 % quantile, beyond which sizes are cut off, is all that sees the fluid at rest
    assert 0.75 * alone < padded < vortex.max()
    assert np.quantile(np.concatenate([vortex, np.zeros(3 * vortex.size)]), 0.98) < 0.6 * padded
    assert limits_of(-vortex) == (-alone, 0.0)
    assert limits_of(np.concatenate([vortex, [-1e-6]]))[0] == 0.0  # 1e-6 of the other sign is none
    assert limits_of(np.zeros(3)) == limits_of(np.empty(0)) == (0.0, 0.0)


def test_limits_come_from_all_frames_alike():
    spread = Spread()
    for size in (0.2, 0.6, 1.0):
        spread.add(size * np.linspace(-1.0, 1.0, 10001))
    frames = np.concatenate([size * np.linspace(-1.0, 1.0, 10001) for size in (0.2, 0.6, 1.0)])
    assert spread.ends == pytest.approx(limits_of(frames), rel=1e-2)  # of evenly chosen values
    extremes = Extremes()
    extremes.add(np.array([-3.0, 0.0, np.nan, 2.0]))
    assert extremes.ends == (-3.0, 2.0)


@pytest.mark.parametrize("rheology", ["newtonian", "power_law", "oldroyd_b"])
def test_rate_viscosity_and_stress_of_simple_shear(rheology):
    """Of u = 0.5 y: rate 0.5, viscosity mu or K rate^(n-1), or of the solvent and S/rate; fits are exact for them."""
    from polymer_laws import oldroyd_b

    from tisph import registry

    fluid = oldroyd_b(2.0, 0.5) if rheology == "oldroyd_b" else {}
    if rheology == "power_law":
        parameters = registry.load("rheology", "power_law").Parameters
        fluid = {"rheology": parameters(index=0.5, reference_rate=1.0, least_rate=1e-6)}
    channel = make_channel(rows=20, **fluid)
    x, y = channel.lattice()
    none, stress = np.zeros_like(x), np.full(x.shape, 3e-4)
    polymer = {"stress_xx": none, "stress_xy": stress, "stress_yy": none} if channel.polymer else {}
    snapshot = Snapshot(1.0, 0, x, y, 0.5 * y, none, none, none, **polymer)
    law = channel.viscous_stress(0.5) / 0.5  # solvent, or inelastic fluid
    expected = {"shear_rate": 0.5, "viscosity": law, "shear_stress": law * 0.5}
    if channel.polymer:
        expected |= {"viscosity": law + 3e-4 / 0.5, "shear_stress": 3e-4}
    for name, value in expected.items():
        found = channel.movie_view(name, 1.0).of(snapshot)
        assert np.allclose(found, value, rtol=1e-9)


def test_a_field_fills_the_fluid_with_the_colours_of_its_values():
    annulus = make_annulus(initial_state="developed")
    radius = np.linspace(1.0, 2.0, 17)[:-1] + 1.0 / 32
    angle = np.linspace(0.0, 2.0 * np.pi, 160, endpoint=False)
    x, y = (np.outer(radius, wave).ravel() for wave in (np.cos(angle), np.sin(angle)))
    snapshot = replace(make_snapshot(make_channel(), 1.0), x=x, y=y, v=x, u=-y, pressure=0 * x, density=0 * x)
    from tisph.snapshot import Bodies

    snapshot = replace(snapshot, bodies=Bodies.at(1.0, annulus.bodies, np.zeros((2, 2, 4))))
    drawn = Drawn(annulus, make_video(640, 320, limits=(0.0, 2.0)), "", END)
    box = drawn.render(snapshot)[drawn.layout.box.slices]
    rows, columns = np.mgrid[: box.shape[0], : box.shape[1]] + 0.5
    distance = np.hypot(
        drawn.layout.low[0] + columns / drawn.layout.pixels_per_length,
        drawn.layout.high[1] - rows / drawn.layout.pixels_per_length,
    )
    fluid = (distance > 1.1) & (distance < 1.9) & (np.abs(rows - box.shape[0] / 2) > 4)  # not the line of the profile
    expected = 255 * matplotlib.colormaps[style.COLOUR_MAP](distance[fluid] / 2.0)[:, :3]
    assert np.abs(box[fluid] - expected).max() < 8  # |u| = r: linear fits are off by some hundredths of a spacing


VIDEO = make_video(960, 480, color_by="shear_stress")
LARGEST = 4e-4  # of the exact stress over the run
TIMES = "\N{MULTIPLICATION SIGN}"


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
    assert error_label(channel, field)(make_snapshot(channel, 0.0)) == "unresolved: layer that starts"


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
