"""A channel with open ends whose walls are no planes: its config, its ends and particles, and a short run."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.errors import ConfigError
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.outline import Outline
from tisph.geometry.wanted_spacing import InBox
from tisph.observers.samples import Description
from tisph.observers.vtk import POLY_LINE, append_bodies, has_outlines
from tisph.schemes.implicit.planar.wall_points import WallPoints
from tisph.snapshot import Bodies, Snapshot


def test_ends_reach_from_wall_to_wall(load_flow, tmp_path):
    top = "walls.top={outline: [[0.0, 1.0], [0.8, 1.0], [1.4, 0.8], [2.0, 0.8]], corner_radius: 0.2}"
    config = load_flow("step", top)
    scene = scenes.of(config)
    assert scene.names == ("_bottom", "_top", "_left", "_right")
    inlet, outlet = scene.bodies[-2:]
    assert inlet.shape.extent.tolist() == [[0.0, 0.5], [0.0, 1.0]]
    assert outlet.shape.extent.tolist() == [[2.0, 0.0], [2.0, 0.8]]
    middle = inlet.velocity(np.array([[0.0, 0.5], [0.0, 0.75], [0.0, 1.0]]), 1.0)
    assert np.allclose(middle, [[0.0, 0.0], [1.5, 0.0], [0.0, 0.0]], rtol=0, atol=1e-12)
    assert scene.region.area == pytest.approx(1.6 - 0.06 - 0.12, rel=1e-6)  # corners in and out take equal parts
    (tmp_path / "again.yaml").write_text(config.resolved_yaml())
    assert load(tmp_path / "again.yaml", ()) == config


def test_particles_fill_the_region_behind_a_step(load_flow):
    scene = scenes.of(load_flow("step"))
    places = np.stack(scene.jittered(1, 0.1), axis=1)
    moved = 0.3 * (0.5 + 1.0) / scene.spacing  # particles keep 0.3 spacings away from both ends
    assert abs(len(places) - (1.6 / scene.spacing**2 - moved)) <= 0.5
    assert scene.distance(places, 0.0).min() > 0.2 * scene.spacing
    gap = dict(scene.parameters())["narrowest gap"]
    assert gap.startswith("0.5 m, 6 spacings")  # the ends are no walls


def test_a_finer_corner_has_finer_particles_and_wall_points(load_flow):
    """Near the corner and at the ends particles keep local distances; points of the walls are as far apart."""
    scene = replace(scenes.of(load_flow("step")), spacing_sources=(InBox((1.0, 0.5), (1.0, 0.5), 0.02, 0.05),))
    wanted = scene.wanted_spacing
    places = np.stack(scene.jittered(1, 0.1), axis=1)
    assert len(places) == scene.particles
    assert (scene.distance(places, 0.0) > 0.2 * wanted.at(places)).all()
    for end in scene.bodies[-2:]:
        assert end.nearest(places).distance.min() > 0.3 * wanted.at(end.shape.extent).min()
    walls = WallPoints(scene.bodies, scene.spacing, (0.0, 0.0), wanted=wanted)
    points = walls.at(0.0)[0][walls.parts[0]]
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(apart, walls.spacings[walls.parts[0]][1:], rtol=0.1)  # the growth of the spacing
    assert walls.length[walls.parts[0]].sum() == pytest.approx(scene.bodies[0].shape.length, rel=1e-12)
    one = WallPoints(scene.bodies, scene.spacing, (0.0, 0.0))
    assert (one.spacings == scene.spacing).all()


WAVE = "walls.top={outline: [[0.0, 1.0], [0.5, 0.8], [1.0, 0.6], [1.5, 0.8], [2.0, 1.0]], smooth: true}"


def test_waves_of_a_channel_and_of_a_region_are_one_flow(load_flow):
    """The area between a wave and a plane, the throat as the narrowest gap, and no stress of a suspension."""
    channel, region = (scenes.of(load_flow(text, WAVE)) for text in ("periodic_channel", "periodic_region"))
    assert channel.bodies == region.bodies
    assert channel.region.area == pytest.approx(1.6, rel=1e-3)  # four places make a wave to 3e-3 of its height
    assert channel.particles == round(channel.region.area / channel.spacing**2)
    assert dict(channel.parameters())["narrowest gap"].startswith("0.6 m")
    moving = "drive.acceleration=0.0", "walls.bottom.velocity=1.0"
    body = "bodies=[{centre: [0.0, 0.4], radius: 0.22, motion: free}]"
    sheared = scenes.of(load_flow("periodic_channel", WAVE, body, *moving))
    assert sheared.has_free_bodies
    assert sheared.mean_stress_names == ()


@pytest.mark.parametrize("kind", ["corner_radius: 0.2", "smooth: true"])
def test_a_straight_outline_is_the_plane_wall(load_flow, kind):
    """Particles at the start, points on walls, distances and planes, to rounding."""
    straight = f"walls.top={{outline: [[0.0, 1.0], [0.9, 1.0], [2.0, 1.0]], {kind}}}"
    scene, outlined = (scenes.of(load_flow("periodic_region", *changes)) for changes in ((), (straight,)))
    one, other = (np.stack(each.jittered(1, 0.1), axis=1) for each in (scene, outlined))
    assert np.abs(one - other).max() < 1e-10
    planes, curves = (WallPoints(each.bodies, each.spacing, (0.0, 0.0)) for each in (scene, outlined))
    for plane, curve in zip(planes.nearest_walls(one, 0.0), curves.nearest_walls(one, 0.0), strict=True):
        assert np.abs(plane - curve).max() < 1e-10
    assert np.abs(planes.at(0.0)[0] - curves.at(0.0)[0]).max() < 1e-10


def test_a_wavy_pipe_has_the_volume_and_the_sections_of_its_walls(load_flow):
    """Cosines through 24 places, of an inner and an outer wall."""
    x = np.linspace(0.0, 2.0, 25)
    wave = 0.15 * (1.0 - np.cos(np.pi * x))
    outer, inner = (np.stack([x, y], axis=1).round(12).tolist() for y in (1.5 - wave, 0.5 + 0.5 * wave))
    walls = f"walls={{top: {{outline: {outer}, smooth: true}}, bottom: {{outline: {inner}, smooth: true}}}}"
    around = "coordinates=axisymmetric", "geometry.inner_radius=0.5"
    scene = scenes.of(load_flow("periodic_region", *around, walls))
    assert scene.region.area == pytest.approx(2.0 * (1.0 - 0.15 - 0.075), rel=1e-6)
    low, height = scene.section(np.array([0.0, 0.5, 1.0]))
    assert low == pytest.approx([0.5, 0.575, 0.65], abs=1e-6)
    assert height == pytest.approx([1.0, 0.775, 0.55], abs=1e-6)
    with pytest.raises(ConfigError, match=r"is the axis where geometry\.inner_radius is 0"):
        load_flow("periodic_region", around[0], "geometry.height=1.5", walls)


def test_files_for_paraview_have_the_outline_as_a_line(load_flow, tmp_path):
    config = load_flow("step")
    scene = scenes.of(config)
    assert has_outlines(scene)
    with h5py.File(tmp_path / "bodies.vtkhdf", "w") as file:
        bodies = Bodies.at(0.0, scene.bodies, np.zeros((2, 4, 4)))
        append_bodies(file, SimpleNamespace(t=0.0, bodies=bodies), Description(config, scene))
        root = file["VTKHDF"]
        assert root["Types"][()].tolist() == [POLY_LINE]
        points = root["Points"][()]
    wall = scene.bodies[0].shape
    assert np.abs(wall.nearest(points[:, :2]).distance).max() < 1e-12
    assert np.ptp(points[:, 0]) == pytest.approx(2.0, abs=0.5 * scene.spacing)


def test_walls_are_known_to_places_beside_a_sloped_end():
    """The nearest place of the wall may then be beyond the end, where it has no points."""
    bodies = [Body(Outline(((0.0, 0.6), (0.7, 0.3), (2.0, 0.3)), 0.2)), Body(Line((2.0, 1.0), (-1.0, 0.0), 2.0))]
    places = np.stack([np.full(20, 0.02), np.linspace(0.6, 0.98, 20)], axis=1)
    planes, distances, curvatures = WallPoints(bodies, 0.05, (0.0, 0.0)).nearest_walls(places, 0.0)
    foot = bodies[0].nearest(places)
    assert foot.point[:, 0].min() < -0.1
    assert np.isfinite(planes).all()
    assert (curvatures == 0.0).all()
    assert np.array_equal(distances.min(axis=1), np.minimum(foot.distance, 1.0 - places[:, 1]))


def test_a_table_above_a_step_has_the_width_of_the_inlet(load_flow):
    inlet = scenes.of(
        load_flow("step", "ends.left.profile={heights: [0.0, 0.25, 0.5], velocities: [0.0, 1.0, 0.0]}")
    ).inlet
    found = inlet.velocity(np.array([[0.0, 0.5], [0.0, 0.75], [0.0, 1.0]]), 1.0)[:, 0]
    assert found == pytest.approx([0.0, found.max(), 0.0], abs=1e-12)


@pytest.mark.parametrize("mirrored", [False, True])
def test_flow_reattaches_where_its_shear_changes_sign(load_flow, mirrored):
    """At x = 1.45, behind a step with linear shear, of which fits of degree 4 are exact; or at its mirror image."""
    outline = np.array([[0.0, 0.5], [0.8, 0.5], [0.8, 0.0], [2.0, 0.0]])
    sides, image = ("left", "right"), lambda x: 2.0 - x if mirrored else x
    if mirrored:
        outline, sides = image(outline)[::-1] * [1.0, -1.0] + [0.0, 2.0], sides[::-1]
    ends = f"ends={{{sides[0]}: {{type: inlet, velocity: 1.0, profile: parabolic}}, {sides[1]}: {{type: outlet}}}}"
    scene = scenes.of(load_flow("step", ends, f"walls.bottom.outline={outline.tolist()}"))
    x, y = scene.jittered(1, 0.3)
    part = 2.0 * y - 1.0
    u = np.where(image(x) < 0.9, 6.0 * part * (1.0 - part), (image(x) - 1.45) * y) * (-1.0 if mirrored else 1.0)
    snapshot = Snapshot(1.0, 0, x, y, u, 0.0 * x, 0.0 * x, 0.0 * x)
    found = scene.diagnostics(replace(snapshot, bodies=Bodies.at(0.0, scene.bodies)), [])
    assert found["reattachment_bottom"] == pytest.approx(image(1.45), abs=1e-9)
    assert 0.6 < image(found["separation_bottom"]) < 1.0  # at the step
    shown = replace(snapshot, bodies=Bodies.at(0.0, scene.bodies))
    marks = {name: place for name, *place in scene.movie_marks(shown)}
    assert marks["reattachment"] == pytest.approx([image(1.45), 0.0], abs=1e-9)
    series = scene.movie_series()
    measured = dict(zip(series.columns, series.measure(shown), strict=True))
    assert measured["reattachment_bottom"] == marks["reattachment"][0]
