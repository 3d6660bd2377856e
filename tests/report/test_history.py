"""History of bodies: axes by kind, lines that can be told apart, and what is known of the steady state."""

import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.report.plots import history_figure

LATTICE = """
scene: lattice
fluid: {density: 2.0, kinematic_viscosity: 0.5}
geometry: {length: 1.0, height: 1.0}
bodies: [{centre: [0.5, 0.5], radius: 0.25}]
drive: {acceleration: 1.0}
discretisation: {particles_across: 32}
time: {end: 1.0}
"""


CAVITY = """
scene: cavity
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {width: 1.0, height: 1.0}
walls: {lid: {velocity: 1.0}}
time: {end: 1.0}
"""


def lattice(folder, *changes):
    (folder / "case.yaml").write_text(LATTICE)
    return scenes.of(load(folder / "case.yaml", changes))


def test_like_bodies_are_told_apart_on_axes_with_units(tmp_path):
    two = "bodies=[{centre: [0.2, 0.5], radius: 0.1}, {centre: [0.7, 0.5], radius: 0.1}]"
    scene = lattice(tmp_path, two)
    times = np.linspace(0.0, 1.0, 401)
    drag, noise = 3.0 - 2.0 * np.exp(-5.0 * times), np.full(401, 1e-9)
    values = np.stack([*2 * [drag, noise, noise], 0.1 * times], axis=1)  # drag, lift, torque of each; mean velocity
    figure = history_figure(scene, {}, times, values)
    drags, lifts, *_ = figure.axes
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "drag per length [N/m]",
        "lift per length [N/m]",
        "torque per length [N]",
        "superficial velocity [m/s]",
    ]
    first, second = drags.lines
    assert np.array_equal(first.get_ydata(), second.get_ydata())
    assert not {*range(401)[slice(*_marked(first))]} & {*range(401)[slice(*_marked(second))]}
    assert drags.get_ylim()[0] < 0.0 < 3.0 < drags.get_ylim()[1]
    assert min(np.abs(lifts.get_ylim())) >= 1e-3 * scene.force_scale  # noise stays flat
    assert [text.get_text() for text in figure.legends[0].get_texts()[:3]] == ["body 0", "body 1", "mean over the cell"]


def test_a_body_alone_has_the_drag_that_drives_the_fluid(tmp_path):
    scene, times = lattice(tmp_path), np.linspace(0.0, 1.0, 11)
    figure = history_figure(scene, {}, times, np.zeros((11, 4)))
    level = figure.axes[0].lines[1]
    assert level.get_ydata()[0] == pytest.approx(
        2.0 * (1.0 - np.pi * 0.25**2), rel=1e-9
    )  # density, acceleration 1, area
    assert [len(axes.lines) for axes in figure.axes[1:]] == [1, 1, 1]


@pytest.mark.parametrize(("start", "shown"), [(0.0, 0.0), (np.inf, 1.0), (50.0, 1.0)])
def test_a_start_that_is_not_resolved_is_shown_unless_it_is_large(tmp_path, start, shown):
    """Numbers from 1 to 2 at resolved times; the axis has a tenth more on both sides."""
    (tmp_path / "cavity.yaml").write_text(CAVITY)
    values, resolved = np.array([start, *np.linspace(1.0, 2.0, 10)])[:, None], np.arange(11) > 0
    scene = scenes.of(load(tmp_path / "cavity.yaml"))
    (axes,) = history_figure(scene, {}, np.linspace(0.0, 1.0, 11), values, resolved).axes
    margin = 0.1 * (2.0 - shown)
    assert axes.get_ylim() == pytest.approx((shown - margin, 2.0 + margin), rel=1e-12)


def _marked(line):
    start, step = line.get_markevery()
    return start, None, step
