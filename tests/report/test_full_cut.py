"""Movies of axisymmetric flow: both halves of a cut through the axis, the second as the mirror image of the first."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import Drawn, make_video

from tisph import config, scenes
from tisph.report.layout import arrange
from tisph.report.movie import FullCut
from tisph.report.overlays import Streamlines
from tisph.simulation.state import start_snapshot, start_values

CONFIGS = Path(__file__).parents[2] / "configs"


def start(name):
    """Scene and first snapshot of a config with few particles."""
    one = config.load(CONFIGS / f"{name}.yaml", ["discretisation.particles_across=20"])
    scene = scenes.of(one)
    return scene, start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.2, seed=0)), "f64")


def picture(scene, snapshot, **video):
    """The box of a frame, int (rows, columns, 3), without the columns around the line of its profile."""
    drawn = Drawn(scene, make_video(960, 480, **video))
    box = drawn.render(snapshot)[drawn.layout.box.slices].astype(int)
    line = (drawn.quantity.profile.line.place - drawn.layout.low[0]) * drawn.layout.pixels_per_length
    columns = np.arange(box.shape[1])
    return box[:, np.minimum(abs(columns - line), box.shape[1] - abs(columns - line)) > 6]


@pytest.mark.parametrize("overlay", ["none", "vectors", "streamlines"])
@pytest.mark.parametrize(
    ("name", "colour"), [("taylor_vortices", "swirl"), ("taylor_vortices", "v"), ("sphere_in_tube", "stream_function")]
)
def test_lower_half_is_the_mirror_image_of_the_upper_one(name, colour, overlay):
    scene, snapshot = start(name)
    if name == "sphere_in_tube":  # past a sphere that stands still
        snapshot = replace(snapshot, u=snapshot.u + 1.0, v=0.5 * np.sin(np.pi * snapshot.x) * snapshot.y)
    box = picture(scene, snapshot, color_by=colour, overlay=overlay)
    different = np.abs(box - box[::-1]).max(axis=2) > 24
    # edges of walls and strokes may fall between pixels otherwise; a stroke on the wrong side would be several wide
    thick = different[1:-1, 1:-1] & different[:-2, 1:-1] & different[2:, 1:-1]
    assert thick.mean() < 1e-3
    assert box.std() > 10  # something is drawn


def test_streamlines_are_lines_of_the_stream_function_of_stokes_in_both_halves():
    scene, snapshot = start("taylor_vortices")
    cut = FullCut(scene)
    lines = Streamlines(cut, arrange(cut, 640, 320)).lines(cut.mirrored(snapshot))
    assert len(lines) == 20  # ten lines in each half
    sides = [np.sign(line[:, 1].mean()) for line in lines]
    assert sides.count(1.0) == sides.count(-1.0) == 10
    for x, y in (line.T for line in lines):
        radius = np.abs(y)
        psi = radius * 16.0 * ((radius - 1.0) * (2.0 - radius)) ** 2 * np.sin(2 * np.pi * x / scene.length)
        assert np.ptp(psi) < 0.05 * 1.6  # of the largest; means of the nearest are of second order


def test_walls_are_in_either_half_and_bodies_on_the_axis_are_whole():
    cut = FullCut(start("taylor_vortices")[0])
    assert cut.extent[1] == 4.0
    assert cut.sides == (1.0, -1.0, 1.0, -1.0)
    assert len(FullCut(start("pipe")[0]).bodies) == 2
    assert len(FullCut(start("sphere_in_tube")[0]).bodies) == 3
