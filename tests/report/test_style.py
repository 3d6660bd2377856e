"""Colours that colour-blind eyes can read, themes, and what a movie without a reference takes its limits from."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from report_scene import END, Drawn, make_annulus, make_channel, make_snapshot, make_video, shown

from tisph.report import style
from tisph.report.quantities import Extremes

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


def test_limits_leave_out_what_stands_out_and_are_reached():
    extremes = Extremes()
    for size in (*np.ones(19), 100.0):  # one frame, and one particle of a thousand in each, is at a corner
        values = size * np.linspace(-1.0, 1.0, 1001)
        values[500] = 1e3
        extremes.add(values)
    assert extremes.ends == pytest.approx((-0.96, 0.96), rel=0.01)  # 98 % of a line from -1 to 1
    extremes = Extremes(whole=True)
    extremes.add(np.array([-3.0, 0.0, 2.0]))
    assert extremes.ends == (-3.0, 2.0)
    extremes = Extremes()
    extremes.add(np.array([np.nan]))
    assert extremes.ends == (0.0, 0.0)


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
