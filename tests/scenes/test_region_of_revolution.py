"""Axisymmetric regions and views: walls of outlines, what is refused, and what movies show."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import config, scenes
from tisph.config.schema import colours
from tisph.report.layout import arrange
from tisph.report.movie import FullCut
from tisph.report.panels import TimePanel
from tisph.report.quantities import quantity
from tisph.simulation.state import start_snapshot, start_values

CAN = "walls.around={type: polygon, corners: [[1, 0], [1, 1], [3, 1], [3, 0]]}"
RING = "walls.around={type: circle, centre: [0, 2], radius: 0.5}"
TURNING = "turning=[{wall: around, angular_velocity: 2.0}]"
SIDE = "turning=[{wall: around_0, angular_velocity: 2.0}]"


def test_sides_of_a_polygon_are_walls_but_the_one_on_the_axis(load_flow):
    scene = scenes.of(load_flow("region_of_revolution", CAN, SIDE))
    assert scene.names == ("around_0", "around_1", "around_2")
    assert [body.spin.largest_speed for body in scene.bodies] == [2.0, 0.0, 0.0]
    assert (scene.origin, scene.extent, scene.region.area) == ((1.0, 0.0), (2.0, 1.0), 2.0)
    assert scene.reference_velocity == 2.0
    normals = [body.nearest(np.array([[2.0, 0.5]])).normal[0].tolist() for body in scene.bodies]
    assert np.allclose(normals, [[1, 0], [0, -1], [-1, 0]])
    assert not scenes.of(load_flow("region_of_revolution", CAN, TURNING)).singular


def test_rounded_outline_is_one_wall_on_both_sides_of_the_axis(load_flow):
    scene = scenes.of(load_flow("region_of_revolution", CAN, TURNING, "walls.around.corner_radius=0.2"))
    assert scene.names == ("around",)
    assert scene.bodies[0].crosses_axis
    assert scene.region.area == pytest.approx(2.0 - 2 * 0.04 * (1 - np.pi / 4))


def test_ring_is_drawn_as_two_walls_each_in_its_half(load_flow):
    cut = FullCut(scenes.of(load_flow("region_of_revolution", RING, TURNING)))
    assert cut.sides == (1.0, -1.0)
    image = cut.bodies[1].nearest(np.array([[0.0, -2.0]])).distance
    assert image == pytest.approx(0.5, rel=1e-4)  # of a polygon of 400 corners


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
    panel = TimePanel(scene, arrange(scene, 1280, 640), scene.movie_series(), 100.0, ends=(0.0, 0.3))
    assert list(panel.levels) == [1.0, 1.0]  # torques are over those of laminar flow
    assert panel.range[0] < 1.0 < panel.range[1]
    assert panel.series.level_name == "laminar"
