"""Velocities as arrows: which way they point, how long they are, and that there are none where no fluid is."""

from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import END, Drawn, make_channel, make_snapshot, make_video

from tisph.report.layout import arrange
from tisph.report.overlays import Vectors
from tisph.snapshot import Snapshot

SCENE = SimpleNamespace(
    origin=(0.0, 0.0), extent=(1.0, 1.0), periodic=(True, True), spacing=1 / 40, reference_velocity=2.0,
    bodies=(), walls=(),
)  # fmt: skip
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


def test_arrow_lengths_are_proportional_to_velocity_and_limited():
    pitch = 40 * LAYOUT.scale
    for speed, expected in ((0.5, 0.375 * pitch), (1.0, 0.75 * pitch), (0.05, 0.0)):
        ink = arrow(speed, 0.0)
        assert np.count_nonzero(ink.max(axis=0) > 0.3) == pytest.approx(expected, abs=2)  # a pixel at either end
    assert np.array_equal(paint(3.0, 0.0), paint(30.0, 0.0))


def test_there_are_no_arrows_where_there_are_no_particles():
    ink = paint(0.0, 1.0, keep=lambda x, y: np.hypot(x - 0.5, y - 0.5) > 0.3)
    rows, columns = (np.mgrid[: ink.shape[0], : ink.shape[1]] + 0.5) / LAYOUT.pixels_per_length
    away = np.hypot(columns - 0.5, rows - 0.5)
    reach = (1.2 + 0.5) / 40 + 0.5 * 0.75 * 40 * LAYOUT.scale / LAYOUT.pixels_per_length  # of one beside it
    assert not ink[away < 0.3 - reach].any()
    assert ink[away > 0.35].any()


def test_a_run_that_went_wrong_and_one_without_arrows_get_their_pictures():
    channel = make_channel()
    plain, arrows = (Drawn(channel, make_video(overlay=each), "", END) for each in ("none", "vectors"))
    snapshot = make_snapshot(channel, 5.0)
    before = plain.render(snapshot).copy()
    assert not np.array_equal(arrows.render(snapshot), before)
    snapshot.u[3] = np.nan
    assert np.array_equal(arrows.render(snapshot), plain.render(snapshot))
