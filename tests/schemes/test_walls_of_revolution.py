"""Walls of axisymmetric flow as points: which of them lead the flow to the axis."""

from pathlib import Path

import pytest

from tisph import scenes
from tisph.config import load
from tisph.schemes._two_dimensional.wall_points import WallsOfRevolution

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize(
    ("config", "across"),
    [("pipe", False), ("taylor_vortices", False), ("spin_up", False), ("sphere_in_tube", True), ("rotating_end", True)],
)
def test_flow_along_spheres_and_plates_goes_to_the_axis(config, across):
    scene = scenes.of(load(CONFIGS / f"{config}.yaml"))
    assert WallsOfRevolution(scene.bodies, scene.spacing, scene.origin).across_axis == across
