"""A channel with open ends whose walls are no planes: its config, its ends and particles, and a short run."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import tisph
from tisph import scenes
from tisph.config import load
from tisph.errors import ConfigError
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.outline import Outline
from tisph.observers.samples import Description
from tisph.observers.vtk import POLY_LINE, append_bodies, has_outlines
from tisph.schemes.implicit.planar.wall_points import WallPoints
from tisph.snapshot import Bodies, Snapshot

STEP = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.05}
geometry: {gap: 1.0, length: 2.0}
ends: {left: {type: inlet, times: [0.0, 0.5], velocities: [0.0, 1.0], profile: parabolic}, right: {type: outlet}}
walls: {bottom: {outline: [[0.0, 0.5], [0.8, 0.5], [0.8, 0.0], [2.0, 0.0]], corner_radius: 0.2}}
discretisation: {particles_across: 12}
time: {end: 0.1}
runtime: {threads: 1}
"""


def loaded(tmp_path, *changes, text=STEP):
    path = tmp_path / "case.yaml"
    path.write_text(text)
    return load(path, changes)


def test_ends_reach_from_wall_to_wall(tmp_path):
    config = loaded(
        tmp_path, "walls.top={outline: [[0.0, 1.0], [0.8, 1.0], [1.4, 0.8], [2.0, 0.8]], corner_radius: 0.2}"
    )
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


def test_particles_fill_the_region_behind_a_step(tmp_path):
    scene = scenes.of(loaded(tmp_path))
    places = np.stack(scene.jittered(1, 0.1), axis=1)
    moved = 0.3 * (0.5 + 1.0) / scene.spacing  # particles keep 0.3 spacings away from both ends
    assert abs(len(places) - (1.6 / scene.spacing**2 - moved)) <= 0.5
    assert scene.distance(places, 0.0).min() > 0.2 * scene.spacing
    gap = dict(scene.parameters())["narrowest gap"]
    assert gap.startswith("0.5 m, 6 spacings")  # the ends are no walls


@pytest.mark.parametrize(("change", "said"), [
    ("ends=null", "both ends of a periodic wall must be at one height, not at y = 0 and 0.5"),
    ("walls.bottom.smooth=true", "walls.bottom.corner_radius = 0.2: is not for a smooth wall"),
    ("walls.bottom={outline: [[0, 0.5], [1, 0.5], [1, 0], [2, 0]], smooth: true}", "x must rise from place to place"),
    ("walls.bottom={outline: [[0, 0], [0.9, 0], [1, 0.3], [2, 0]], smooth: true}", "outline = [[0.0, 0.0],"),
    ("scheme.type=wcsph", "take auto or implicit"),
    ("walls.bottom.velocity=1.0", "walls.bottom.velocity = 1.0: is not for a wall with an outline: it is at rest"),
    ("walls.bottom.outline=null", "walls.bottom.corner_radius = 0.2: is only for a wall with an outline"),
    ("walls.bottom.corner_radius=null", "a corner of radius 0 has 0 spacings; it needs at least 2"),
    ("walls.bottom.corner_radius=0.1", "walls.bottom.corner_radius = 0.1: a corner of radius 0.1 has 1.2 spacings"),
    ("walls.bottom.corner_radius=0.3", "corners of radius 0.3 do not fit: at most 0.25"),
    ("geometry.length=2.5", "must lead from x = 0 to x = 2.5, not from 0 to 2"),
    ("walls.bottom.outline=[[0.0, -0.1], [2.0, 0.0]]", "y from 0 to 1"),
    ("walls.bottom.outline=[[0.0, 0.7], [2.0, 0.7]]", "leaves a passage 0.3 wide: leave 6 spacings, 0.5"),
    ("walls.top={outline: [[0.0, 0.2], [2.0, 0.9]]}", "meets the other wall"),
    ("walls.bottom.outline=[[0.0, 0.5], [0.0, 0.0], [2.0, 0.0]]", "between the ends of the wall"),
    ("initial.state=developed", "must be rest where a wall has an outline"),
])  # fmt: skip
def test_impossible_outlines_are_refused_in_words(tmp_path, change, said):
    with pytest.raises(ConfigError) as refused:
        loaded(tmp_path, change)
    assert said in str(refused.value)


WAVES = """\
fluid: {density: 1.0, kinematic_viscosity: 1.0}
drive: {acceleration: 1.0}
discretisation: {particles_across: 12}
time: {end: 0.1}
runtime: {threads: 1}
"""
CHANNEL = WAVES + "scene: channel\ngeometry: {gap: 1.0, length: 2.0}\n"
REGION = WAVES + "scene: region\ngeometry: {height: 1.0, length: 2.0}\n"
WAVE = "walls.top={outline: [[0.0, 1.0], [0.5, 0.8], [1.0, 0.6], [1.5, 0.8], [2.0, 1.0]], smooth: true}"


@pytest.mark.parametrize(("change", "said"), [
    ("walls.top.outline=[[0, 1], [0.9, 0.9], [1, 0.6], [1.1, 0.9], [2, 1]]", "a bend of radius 0.0"),
    ("walls.top.outline=[[0, 1], [1, 0.9], [2, 0.9]]", "must be at one height, not at y = 0.9 and 1"),
    ("walls.top.smooth=null", "a corner of radius 0 has 0 spacings"),
    ("walls.top.outline=null", "walls.top.smooth = true: is only for a wall with an outline"),
    ("scheme.type=wcsph", "wcsph has no treatment of walls with outlines"),
    ("walls.bottom={shear_stress: 1.0}", "with a wall that is no plane no stress can drive a wall"),
    ("walls.bottom={times: [0, 1], velocities: [0, 1]}", "must be left out with a wall that is no plane"),
    ("initial.state=developed", "no developed flow is known there"),
    ("initial={state: exact, time: 1.0}", "with a wall that is no plane no exact flow is known"),
    ("probes.count=5", "probes: must be left out"),
    ("drive.acceleration=0.0", "nothing moves"),
    ("geometry.gap=0.75", "must be within the box: y from 0 to 0.75"),
])  # fmt: skip
def test_a_channel_with_waves_is_refused_what_needs_planes(tmp_path, change, said):
    with pytest.raises(ConfigError) as refused:
        loaded(tmp_path, WAVE, change, text=CHANNEL)
    assert said in str(refused.value)


def test_waves_of_a_channel_and_of_a_region_are_one_flow(tmp_path):
    """The area between a wave and a plane, the throat as the narrowest gap, and no stress of a suspension."""
    channel, region = (scenes.of(loaded(tmp_path, WAVE, text=text)) for text in (CHANNEL, REGION))
    assert channel.bodies == region.bodies
    assert channel.region.area == pytest.approx(1.6, rel=1e-3)  # four places make a wave to 3e-3 of its height
    assert channel.particles == round(channel.region.area / channel.spacing**2)
    assert dict(channel.parameters())["narrowest gap"].startswith("0.6 m")
    moving = "drive.acceleration=0.0", "walls.bottom.velocity=1.0"
    body = "bodies=[{centre: [0.0, 0.4], radius: 0.22, motion: free}]"
    sheared = scenes.of(loaded(tmp_path, WAVE, body, *moving, text=CHANNEL))
    assert sheared.has_free_bodies
    assert sheared.mean_stress_names == ()


@pytest.mark.parametrize("kind", ["corner_radius: 0.2", "smooth: true"])
def test_a_straight_outline_is_the_plane_wall(tmp_path, kind):
    """Particles at the start, points on walls, distances and planes, to rounding."""
    straight = f"walls.top={{outline: [[0.0, 1.0], [0.9, 1.0], [2.0, 1.0]], {kind}}}"
    scene, outlined = (scenes.of(loaded(tmp_path, *changes, text=REGION)) for changes in ((), (straight,)))
    one, other = (np.stack(each.jittered(1, 0.1), axis=1) for each in (scene, outlined))
    assert np.abs(one - other).max() < 1e-10
    planes, curves = (WallPoints(each.bodies, each.spacing, (0.0, 0.0)) for each in (scene, outlined))
    for plane, curve in zip(planes.nearest_walls(one, 0.0), curves.nearest_walls(one, 0.0), strict=True):
        assert np.abs(plane - curve).max() < 1e-10
    assert np.abs(planes.at(0.0)[0] - curves.at(0.0)[0]).max() < 1e-10


def test_a_wavy_pipe_has_the_volume_and_the_sections_of_its_walls(tmp_path):
    """Cosines through 24 places, of an inner and an outer wall."""
    x = np.linspace(0.0, 2.0, 25)
    wave = 0.15 * (1.0 - np.cos(np.pi * x))
    outer, inner = (np.stack([x, y], axis=1).round(12).tolist() for y in (1.5 - wave, 0.5 + 0.5 * wave))
    walls = f"walls={{top: {{outline: {outer}, smooth: true}}, bottom: {{outline: {inner}, smooth: true}}}}"
    around = "coordinates=axisymmetric", "geometry.inner_radius=0.5"
    scene = scenes.of(loaded(tmp_path, *around, walls, text=REGION))
    assert scene.region.area == pytest.approx(2.0 * (1.0 - 0.15 - 0.075), rel=1e-6)
    low, height = scene.section(np.array([0.0, 0.5, 1.0]))
    assert low == pytest.approx([0.5, 0.575, 0.65], abs=1e-6)
    assert height == pytest.approx([1.0, 0.775, 0.55], abs=1e-6)
    with pytest.raises(ConfigError, match=r"is the axis where geometry\.inner_radius is 0"):
        loaded(tmp_path, around[0], "geometry.height=1.5", walls, text=REGION)


def test_files_for_paraview_have_the_outline_as_a_line(tmp_path):
    config = loaded(tmp_path)
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


def test_flow_over_a_step_leaves_as_it_enters(tmp_path):
    """Nothing crosses a wall, and what flows in flows out."""
    simulation = tisph.Simulation(loaded(tmp_path))
    while not simulation.finished:
        simulation.step()
    state, boundary = simulation.state, simulation.scheme.boundary
    (ends,) = boundary.parts
    wall = simulation.scene.bodies[0].shape
    assert wall.nearest(np.stack([state.x, state.y], axis=1)).distance.min() > 0.1 * simulation.scene.spacing
    flux = -boundary.walls.length * np.sum(boundary.velocity * boundary.walls.at(state.t)[1], axis=1)
    inflow, outflow = -flux[ends.of_inlets].sum(), flux[ends.of_outlet].sum()
    assert inflow == pytest.approx(0.5 * 0.2, rel=0.02)  # the sum over six points of a parabola is 1.4 % too large
    assert outflow == pytest.approx(inflow, rel=0.05)  # measured: 3.4 %, six points against twelve make 1 % of it
    assert np.abs(boundary.velocity[boundary.walls.solid]).max() == 0.0


def test_a_table_above_a_step_has_the_width_of_the_inlet(tmp_path):
    table = "ends.left.profile={{heights: [0.0, 0.25, {}], velocities: [0.0, 1.0, 0.0]}}"
    inlet = scenes.of(loaded(tmp_path, table.format(0.5))).inlet
    found = inlet.velocity(np.array([[0.0, 0.5], [0.0, 0.75], [0.0, 1.0]]), 1.0)[:, 0]
    assert found == pytest.approx([0.0, found.max(), 0.0], abs=1e-12)
    with pytest.raises(ConfigError, match=r"must end at the width of the inlet, 0\.5"):
        loaded(tmp_path, table.format(1.5))


@pytest.mark.parametrize("mirrored", [False, True])
def test_flow_reattaches_where_its_shear_changes_sign(tmp_path, mirrored):
    """At x = 1.45, behind a step with linear shear, of which fits of degree 4 are exact; or at its mirror image."""
    outline = np.array([[0.0, 0.5], [0.8, 0.5], [0.8, 0.0], [2.0, 0.0]])
    sides, image = ("left", "right"), lambda x: 2.0 - x if mirrored else x
    if mirrored:
        outline, sides = image(outline)[::-1] * [1.0, -1.0] + [0.0, 2.0], sides[::-1]
    ends = f"ends={{{sides[0]}: {{type: inlet, velocity: 1.0, profile: parabolic}}, {sides[1]}: {{type: outlet}}}}"
    scene = scenes.of(loaded(tmp_path, ends, f"walls.bottom.outline={outline.tolist()}"))
    x, y = scene.jittered(1, 0.3)
    part = 2.0 * y - 1.0
    u = np.where(image(x) < 0.9, 6.0 * part * (1.0 - part), (image(x) - 1.45) * y) * (-1.0 if mirrored else 1.0)
    snapshot = Snapshot(0.0, 0, x, y, u, 0.0 * x, 0.0 * x, 0.0 * x)
    found = scene.diagnostics(replace(snapshot, bodies=Bodies.at(0.0, scene.bodies)), [])
    assert found["reattachment_bottom"] == pytest.approx(image(1.45), abs=1e-9)
    assert 0.6 < image(found["separation_bottom"]) < 1.0  # at the step
