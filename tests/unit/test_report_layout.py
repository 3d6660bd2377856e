from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.text import Text
from report_scene import make_channel, make_snapshot

from tisph.report import style
from tisph.report.layout import arrange
from tisph.report.painter import FramePainter
from tisph.report.stage import build_figure

RATIOS = [0.3, 0.5, 1.0, 2.0, 4.0, 10.0, 20.0]
SIZES = [(1280, 640), (1920, 1080), (640, 480), (480, 960), (2000, 400)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("ratio", RATIOS)
def test_parts_lie_inside_the_frame_and_apart(ratio, size):
    layout = arrange(ratio, 1.0, *size)
    parts = [layout.channel, layout.profile, layout.colour_bar, layout.time_label, layout.error_label]
    for part in parts:
        assert 0 <= part.left < part.right <= size[0]
        assert 0 <= part.top < part.bottom <= size[1]
    for one, other in combinations(parts, 2):
        assert one.right <= other.left or other.right <= one.left or one.bottom <= other.top or other.bottom <= one.top


@pytest.mark.parametrize("ratio", RATIOS)
def test_channel_has_one_scale_in_both_directions_and_long_ones_are_cut(ratio):
    layout = arrange(ratio, 1.0, 1280, 640)
    assert layout.shown_length == min(ratio, 4.0)
    # Whole pixels: half a pixel of rounding at most.
    assert abs(layout.channel.width - layout.shown_length * layout.pixels_per_length) <= 0.5
    assert abs(layout.channel.height - layout.pixels_per_length) <= 0.5


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


LONG_UNITS = SimpleNamespace(length="long.unit_of.16c", mass="kg", time="long.unit_of.16c")
SHORT_UNITS = SimpleNamespace(length="m", mass="kg", time="s")


@pytest.mark.parametrize(
    ("velocities", "units"),
    [
        ((0.0, 0.005), SHORT_UNITS),
        ((-0.25, 0.5), SHORT_UNITS),
        ((2e5, 0.0), SHORT_UNITS),
        ((-3e-7, -1.23456e-7), LONG_UNITS),
    ],
)
@pytest.mark.parametrize("ratio", [0.3, 1.0, 2.0, 20.0])
def test_no_text_overlaps_another_or_leaves_the_frame(ratio, velocities, units):
    bottom, top = velocities
    channel = make_channel(gap=0.01, length=0.01 * ratio, bottom_velocity=bottom, top_velocity=top, units=units)
    layout = arrange(channel.length, channel.gap, 1280, 640)
    ends = (1.08 * min(0.0, *velocities), 1.08 * max(0.0, *velocities))
    with style.plot_style():
        figure = build_figure(channel, layout, ends, "a-name-of-64-characters" * 3)
        figure.canvas.draw()
        boxes = [(text.get_text(), text.get_window_extent()) for text in visible_texts(figure)]
    for label in (layout.time_label, layout.error_label):
        box = SimpleNamespace(x0=label.left, x1=label.right, y0=640 - label.bottom, y1=640 - label.top)
        boxes.append((label, box))
    for (one, a), (other, b) in combinations(boxes, 2):
        apart = a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
        assert apart, f"{one!r} overlaps {other!r}"
    for text, box in boxes:
        inside = 0 <= box.x0 < box.x1 <= 1280 and 0 <= box.y0 < box.y1 <= 640
        assert inside, f"{text!r} leaves the frame"


@pytest.mark.parametrize("size", [(240, 240), (240, 1200), (1200, 240)])
def test_small_and_odd_shaped_frames_can_be_drawn(size):
    channel = make_channel(rows=6)
    frame = FramePainter(channel, *size, title="extreme").paint(make_snapshot(channel, 1.0))
    assert frame.shape == (size[1], size[0], 3)
    assert np.all(frame[0, 0] == 255)
