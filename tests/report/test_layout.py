from itertools import combinations
from types import SimpleNamespace

import pytest
from matplotlib.text import Text
from report_scene import END, make_channel, make_polymer_channel, shown

from tisph.geometry.motion import WallMotion
from tisph.report import style
from tisph.report.layout import arrange
from tisph.report.movie import build_figure
from tisph.report.panels import TimePanel
from tisph.report.text import DriveLabel, wall_labels

RATIOS = [0.3, 0.5, 1.0, 2.0, 4.0, 10.0, 20.0]


@pytest.mark.parametrize("ratio", RATIOS)
def test_channel_has_one_scale_in_both_directions_and_long_ones_are_cut(ratio):
    layout = arrange(make_channel(gap=1.0, length=ratio), 1280, 640)
    assert layout.shown_length == min(ratio, 4.0)
    # Whole pixels: half a pixel of rounding at most.
    assert abs(layout.box.width - layout.shown_length * layout.pixels_per_length) <= 0.5
    assert abs(layout.box.height - layout.pixels_per_length) <= 0.5


def visible_texts(figure) -> list[Text]:
    """All texts that are drawn: tick labels only where their tick is in sight."""
    hidden = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            lowest, highest = sorted(axis.get_view_interval())
            slack = 1e-9 * (highest - lowest)
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                if not axes.axison or not lowest - slack <= tick.get_loc() <= highest + slack:
                    hidden |= {tick.label1, tick.label2}
    return [text for text in figure.findobj(Text) if text.get_text() and text.get_visible() and text not in hidden]


DEVELOPED = {"initial_state": "developed"}
LONG_UNITS = SimpleNamespace(length="long.unit_of.16c", mass="kg", time="long.unit_of.16c")
SHORT_UNITS = SimpleNamespace(length="m", mass="kg", time="s")


FLOWS = {
    "couette": {"top": WallMotion(0.005)},
    "both walls": {"bottom": WallMotion(-0.25), "top": WallMotion(0.5)},
    "large": {"bottom": WallMotion(2e5), "top": WallMotion(0.0)},
    "long units": {"bottom": WallMotion(-3e-7), "top": WallMotion(-1.23456e-7), "units": LONG_UNITS},
    "driven": {"top": WallMotion(0.0), "acceleration": 2e-3},
    "backflow": {"top": WallMotion(0.005), "acceleration": -1e-2},
    "driven, long units": {"top": WallMotion(-1.23456e-7), "acceleration": -1.23456e-11, "units": LONG_UNITS},
    "oscillating": {"top": WallMotion(0.0, 0.5, 3.0), "bottom": WallMotion(1.23e-5, 0.0, 3.0)},
    "oscillating, long units": {"top": WallMotion(0.0, 1.23e-9, 3.0), "units": LONG_UNITS},
    "stopped": {"top": WallMotion(0.0, before=0.5), "bottom": WallMotion(-0.5, before=0.123), **DEVELOPED},
    "changed, long units": {"top": WallMotion(-2.34567e-7, before=1.23456e-7), "units": LONG_UNITS, **DEVELOPED},
    "stopped, long units": {"top": WallMotion(0.0, before=1.23e-7), "units": LONG_UNITS, **DEVELOPED},
}


def boxes_of(channel, layout, color_by):
    """All texts of a frame with their places, from the lower left corner as in matplotlib."""
    panel = TimePanel(channel, layout, channel.movie_series(), END)
    with style.plot_style():
        figure = build_figure(channel, layout, "a-name-of-64-characters" * 3, shown(color_by, channel, END), panel)
        figure.draw_without_rendering()
        texts = visible_texts(figure)
        boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
    if channel.units.length == SHORT_UNITS.length:
        assert min(text.get_fontsize() for text in texts) >= 12 * layout.scale  # the least that can be read
    places = {"time": layout.time_label, "error": layout.error_label}
    names = ("top wall", "bottom wall")
    for name, motion, label in zip(names, (channel.top, channel.bottom), wall_labels(channel, layout), strict=True):
        if motion.largest_speed:
            places[name] = label.box
    if channel.acceleration:
        places["drive"] = DriveLabel(channel, layout).box
    for name, place in places.items():
        y0, y1 = layout.height - place.bottom, layout.height - place.top
        boxes.append((name, SimpleNamespace(x0=place.left, x1=place.right, y0=y0, y1=y1)))
    return boxes


def assert_legible(boxes, width, height):
    for (one, a), (other, b) in combinations(boxes, 2):
        apart = a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
        assert apart, f"{one!r} overlaps {other!r}"
    for text, box in boxes:
        inside = 0 <= box.x0 < box.x1 <= width and 0 <= box.y0 < box.y1 <= height
        assert inside, f"{text!r} leaves the frame"


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("ratio", [0.3, *(pytest.param(more, marks=pytest.mark.slow) for more in (1.0, 2.0, 20.0))])
def test_no_text_overlaps_another_or_leaves_the_frame(ratio, flow):
    channel = make_channel(gap=0.01, length=0.01 * ratio, **FLOWS[flow])
    layout = arrange(channel, 1280, 640)
    assert_legible(boxes_of(channel, layout, "speed"), 1280, 640)


@pytest.mark.parametrize("units", [SHORT_UNITS, LONG_UNITS])
@pytest.mark.parametrize("ratio", [0.3, 2.0])
def test_no_text_about_stress_overlaps_another_or_leaves_the_frame(ratio, units):
    channel = make_polymer_channel(length=0.01 * ratio, acceleration=-2e-3, units=units)
    layout = arrange(channel, 1280, 640)
    assert_legible(boxes_of(channel, layout, "shear_stress"), 1280, 640)
