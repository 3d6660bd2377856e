"""Regions in axisymmetric coordinates: walls of outlines, what is refused, pictures of rings."""

from pathlib import Path

import numpy as np
import pytest

from tisph import config, scenes
from tisph.errors import ConfigError
from tisph.report.movie import FullCut

TEXT = """
scene: region
coordinates: axisymmetric
fluid: {density: 1.0, kinematic_viscosity: 1.0}
time: {end: 1.0}
discretisation: {particles_across: 20}
"""
CAN = "walls.around={type: polygon, corners: [[1, 0], [1, 1], [3, 1], [3, 0]]}"
RING = "walls.around={type: circle, centre: [0, 2], radius: 0.5}"
TURNING = "turning=[{wall: around, angular_velocity: 2.0}]"
SIDE = "turning=[{wall: around_0, angular_velocity: 2.0}]"


def loaded(tmp_path, *changes):
    path = Path(tmp_path) / "region.yaml"
    path.write_text(TEXT)
    return config.load(path, changes)


def test_sides_of_a_polygon_are_walls_but_the_one_on_the_axis(tmp_path):
    scene = scenes.of(loaded(tmp_path, CAN, SIDE))
    assert scene.names == ("around_0", "around_1", "around_2")
    assert [body.spin.largest_speed for body in scene.bodies] == [2.0, 0.0, 0.0]
    assert (scene.origin, scene.extent, scene.region.area) == ((1.0, 0.0), (2.0, 1.0), 2.0)
    assert scene.reference_velocity == 2.0
    normals = [body.nearest(np.array([[2.0, 0.5]])).normal[0].tolist() for body in scene.bodies]
    assert np.allclose(normals, [[1, 0], [0, -1], [-1, 0]])
    assert not scenes.of(loaded(tmp_path, CAN, TURNING)).singular


def test_rounded_outline_is_one_wall_on_both_sides_of_the_axis(tmp_path):
    scene = scenes.of(loaded(tmp_path, CAN, TURNING, "walls.around.corner_radius=0.2"))
    assert scene.names == ("around",)
    assert scene.bodies[0].crosses_axis
    assert scene.region.area == pytest.approx(2.0 - 2 * 0.04 * (1 - np.pi / 4))


def test_ring_is_drawn_as_two_walls_each_in_its_half(tmp_path):
    cut = FullCut(scenes.of(loaded(tmp_path, RING, TURNING)))
    assert cut.sides == (1.0, -1.0)
    image = cut.bodies[1].nearest(np.array([[0.0, -2.0]])).distance
    assert image == pytest.approx(0.5, rel=1e-4)  # of a polygon of 400 corners


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ([CAN, "turning=[{wall: around_3, angular_velocity: 1.0}]"], "turning"),
        ([CAN], "drive.acceleration"),
        ([CAN, TURNING, "coordinates=planar"], "turning"),
        ([CAN, SIDE, "time.tolerance=1e-6"], "time.tolerance"),
        ([CAN, TURNING, "discretisation.precision=f32"], "discretisation.precision"),
        ([CAN, TURNING, "bodies=[{type: circle, centre: [2, 0.5], radius: 0.2, motion: free}]"], "bodies"),
        ([CAN, TURNING, "bodies=[{type: circle, centre: [2, 0.25], radius: 0.2}]"], "bodies"),
        ([RING, TURNING, "walls.around.centre=[0, 0.4]"], "walls.around"),
        ([RING, TURNING, "walls.around.motion={angular_velocity: 1.0}"], "walls.around.motion"),
        (["walls.around={type: polygon, corners: [[0, 0], [2, 0], [1, 1]]}", TURNING], "walls.around"),  # 45 degrees
        (["geometry={length: 1.0, height: 1.0}", "walls.bottom.velocity=1.0"], "walls.bottom"),
        (["geometry={length: 1.0, height: 1.0}", "walls.top={shear_stress: 1.0}"], "walls.top"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, changes, key):
    with pytest.raises(ConfigError) as error:
        loaded(tmp_path, *changes)
    assert f"{key}" in str(error.value)
    assert "Traceback" not in str(error.value)
