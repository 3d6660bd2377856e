"""What movies of axisymmetric flow show beside the planar ones: numbers as they are measured, colours, references."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import config, scenes
from tisph.config.checks import colours
from tisph.report.layout import arrange
from tisph.report.panels import TimePanel
from tisph.report.quantities import quantity
from tisph.simulation.state import start_snapshot, start_values

CONFIGS = Path(__file__).parents[2] / "configs"
ONLY_AROUND_AN_AXIS = {"swirl", "stream_function"}
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"


def scene_of(name, *changes):
    """The scene of a config."""
    return scenes.of(config.load(CONFIGS / f"{name}.yaml", changes))


def test_panel_of_a_pipe_has_the_force_and_not_its_ratio():
    series = scene_of("pipe").movie_series()
    assert (series.unit, len(series.sizes)) == ("whole_force", 0)
    # that of the pressure gradient 4 on the whole cross-section, when steady; the series of Bessel functions, 1e-8
    assert series.exact(np.array([5.0]))[0] == pytest.approx([4.0 * np.pi], rel=1e-7)


def test_movie_of_spin_up_shows_the_exact_swirl():
    scene = scene_of("spin_up")
    view = scene.movie_view("swirl", 0.5)
    assert view.profile.exact is not None
    assert view.ends == pytest.approx((0.0, 1.0), abs=1e-9)  # at rest, and the wall's; to rounding of the series
    assert quantity(view, scene, "auto").colour_range == (0.0, 1.0)  # of one sign


def test_colours_around_the_axis_are_those_of_axisymmetric_flow_alone():
    for path in sorted(CONFIGS.glob("*.yaml")):
        one = config.load(path)
        assert ONLY_AROUND_AN_AXIS.intersection(colours(one)) == (ONLY_AROUND_AN_AXIS if one.axisymmetric else set())


def test_trace_of_a_conformation_at_rest_is_three():
    scene = scene_of("pipe", POLYMER)
    assert scene.movie_fields("conformation_trace") == ("stress_xx", "stress_yy", "stress_tt")
    assert scene.movie_fields("speed") == ()
    snapshot = start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.0, seed=0)), "f64")
    assert np.all(scene.movie_view("conformation_trace", 1.0).of(snapshot) == 3.0)


def test_torques_of_laminar_flow_are_in_sight_and_named():
    scene = scene_of("taylor_vortices")
    panel = TimePanel(scene, arrange(scene, 1280, 640), scene.movie_series(), 100.0, ends=(-0.1, 0.1))
    assert panel.levels == pytest.approx([-scene.laminar_torque, scene.laminar_torque])
    assert panel.range[0] < panel.levels[0] < panel.levels[1] < panel.range[1]
    assert panel.series.level_name == "steady laminar flow"
