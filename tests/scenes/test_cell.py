"""Bodies in cells: scenes that configs describe, what is refused, scales, and mean velocities."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import Drawn, make_video

from tisph import scenes
from tisph.config import load
from tisph.config.yaml_text import parse
from tisph.measures.fits import cell_mean, section_mean
from tisph.measures.resolution import resolution
from tisph.observers.samples import Samples, read_samples
from tisph.report.labels import error_label
from tisph.report.plots import profile_figure
from tisph.scenes._cell import Cell
from tisph.scenes._cell_flow import STRESS_BY_BODIES, STRESS_BY_CONTACTS, STRESS_ON_WALLS
from tisph.scenes.channel import Channel
from tisph.snapshot import Bodies, Snapshot

CONFIGS = Path(__file__).parents[2] / "configs"

LATTICE, CHANNEL, REGION = "lattice_of_cylinders", "cylinder_in_shear", "turning_circle"
SANGANI_ACRIVOS = {0.05: 15.56, 0.1: 24.83, 0.2: 51.53, 0.3: 102.90, 0.4: 217.89}
"""Drag over dynamic viscosity times mean velocity, by solid fraction of a square array."""


@pytest.mark.parametrize(("text", "area", "count"), [
    (LATTICE, 1.0 - math.pi / 16, 1),
    (CHANNEL, 1.5 - math.pi * 0.04, 3),
    (REGION, math.pi * (1.0 - 0.09), 2),
])  # fmt: skip
def test_particles_fill_what_bodies_and_walls_leave(load_flow, text, area, count):
    scene = scenes.of(load_flow(text))
    assert isinstance(scene, Cell)
    assert len(scene.bodies) == len(scene.names) == count
    places = np.stack(scene.jittered(1, 0.2), axis=1)
    assert len(places) == scene.particles == round(area / scene.spacing**2)
    assert scene.distance(places, 0.0).min() > 0.2 * scene.spacing  # a quarter, before the last sweeps


def test_a_channel_without_bodies_is_what_it_was(load_flow, tmp_path):
    config = load_flow(CHANNEL, "bodies=[]")
    assert type(scenes.of(config)) is Channel
    assert config.parallel
    assert "bodies" not in config.resolved_yaml()
    path = tmp_path / "case.yaml"
    path.write_text(config.resolved_yaml())
    program = f"import sys; from tisph.config import load; load({str(path)!r}); "
    program += "print([name for name in sys.modules if 'bodies.' in name or '_cell' in name])"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "['tisph.bodies._files']"  # drawings, which give walls their outlines, too


def test_a_channel_with_bodies_is_two_dimensional(load_flow, tmp_path):
    config = load_flow(CHANNEL)
    assert not config.parallel
    scene = scenes.of(config)
    assert [name for name, _ in scene.walls] == ["top", "bottom"]
    assert scene.names == ("", "_bottom", "_top")
    assert scene.reference_velocity == 1.0
    assert scene.reference_length == pytest.approx(0.4)
    (tmp_path / "again.yaml").write_text(config.resolved_yaml())
    assert load(tmp_path / "again.yaml") == config


def test_what_a_config_has_of_what_it_needs_is_stated(load_flow):
    lines = dict(scenes.of(load_flow(CHANNEL)).parameters())
    assert lines["smallest radius"] == "0.2 m, 4.8 spacings (at least 2, a circle 2.5; resolved from 3 on)"
    assert lines["narrowest gap"] == "0.3 m, 7.2 spacings (at least 2; resolved from 3 on)"


@pytest.mark.parametrize(("viscosity", "scale"), [(0.5, 2.0 * 3.0 * (2.0 - math.pi / 16)), (100.0, 200.0)])
def test_forces_are_measured_by_what_drives_or_by_viscosity(load_flow, viscosity, scale):
    """Of a fluid of density 2 under an acceleration of 3 in a cell of area 2, and of a speed of 1."""
    changes = "drive.acceleration=3.0", "geometry.length=2.0", "reference={velocity: 1.0}"
    scene = scenes.of(load_flow(LATTICE, *changes, f"fluid.kinematic_viscosity={viscosity}"))
    assert scene.force_scale == pytest.approx(scale, rel=1e-9)


@pytest.mark.parametrize("fraction", SANGANI_ACRIVOS)
def test_the_driven_velocity_is_of_the_size_of_the_true_one(load_flow, fraction):
    # within a factor of 4 in slow flow: steps refer to half of it or to the true one, whichever is larger
    radius = math.sqrt(fraction / math.pi)
    scene = scenes.of(load_flow(LATTICE, f"bodies=[{{centre: [0.5, 0.5], radius: {radius}}}]"))
    true = scene.acceleration / (scene.kinematic_viscosity * SANGANI_ACRIVOS[fraction])
    assert 0.25 < scene.reference_velocity / true < 4.0


def snapshot_of(scene, u, v, t=0.0):
    x, y = scene.jittered(0, 0.2)
    zero = np.zeros_like(x)
    return Snapshot(t, 0, x, y, u(x, y), v(x, y), zero, zero)


def test_the_mean_velocity_counts_what_is_solid(load_flow):
    body = "bodies=[{centre: [0.9, 0.1], radius: 0.25, motion: {velocity: [3.0, 1.0], angular_velocity: 2.0}}]"
    scene = scenes.of(load_flow(LATTICE, body))
    snapshot = snapshot_of(scene, lambda x, y: 3.0 + 0 * x, lambda x, y: 1.0 + 0 * x)
    mean = cell_mean(scene, snapshot)
    # the body turns about its centre: nothing on average, but for the nodes of the lattice, 1/32 apart
    assert mean == pytest.approx([3.0, 1.0], abs=2e-3)


def test_the_mean_velocity_does_not_depend_on_where_particles_are_many(load_flow):
    # u = r^2 - a^2 around a cylinder, in a cell of side 2; left are errors of the fits at the edges of the cell,
    # where u has kinks, and of the lattice of nodes at the cylinder
    changes = ["geometry={length: 2.0, height: 2.0}", "bodies=[{centre: [1.0, 1.0], radius: 0.5}]"]
    scene = scenes.of(load_flow(LATTICE, *changes, "discretisation.particles_across=48"))
    field = lambda x, y: np.hypot(x - 1.0, y - 1.0) ** 2 - 0.25  # noqa: E731
    x, y = np.meshgrid(*[(np.arange(2000) + 0.5) / 1000] * 2)
    exact = np.maximum(field(x, y), 0.0).mean()
    snapshot = snapshot_of(scene, field, lambda x, y: 0 * x)
    assert cell_mean(scene, snapshot)[0] == pytest.approx(exact, rel=2e-3)


def test_the_flow_rate_is_that_through_a_section_without_bodies(load_flow):
    # bodies from x = 0.65 to 1.15 and from 0.1 to 0.3; the mean of u over every section is 1, by continuity
    bodies = "bodies=[{centre: [0.9, 0.3], radius: 0.25}, {centre: [0.2, 0.8], radius: 0.1}]"
    scene = scenes.of(load_flow(LATTICE, bodies, "discretisation.particles_across=40"))
    assert scene.open_section(0.0) == pytest.approx(0.475, rel=1e-12)
    k = 2.0 * np.pi
    u, v = (lambda x, y: 1.0 + np.sin(k * x) * np.cos(k * y)), (lambda x, y: -np.cos(k * x) * np.sin(k * y))
    # errors of quadratic fits are of the order (k spacing)^3 / 6 = 6e-4 of the wave, and cancel in its mean
    assert section_mean(scene, snapshot_of(scene, u, v), 0.475, degree=2) == pytest.approx(1.0, abs=6e-4)
    closed = "bodies=[{centre: [0.5, 0.3], radius: 0.25}, {centre: [0.0, 0.7], radius: 0.28}]"
    assert scenes.of(load_flow(LATTICE, closed)).open_section(0.0) is None


def test_a_movie_shows_the_distance_of_two_free_bodies(load_flow):
    """Through the periodic side: they are 0.4 apart there, 1.1 in the box."""
    free = [f"{{centre: [{x}, 0.5], radius: 0.125, motion: free}}" for x in (0.2, 1.3)]
    scene = scenes.of(load_flow(CHANNEL, f"bodies=[{', '.join(free)}]"))
    series = scene.movie_series()
    assert series.measure(SimpleNamespace(bodies=Bodies.at(0.0, scene.bodies))) == pytest.approx([0.4])
    assert (series.levels, series.level_name) == ([0.25 + scene.contact_distance], "contact")
    name, happens = series.event
    near = [happens(np.array([0.25 + share * scene.contact_distance])) for share in (0.99, 1.01)]
    assert (name, near) == ("contact", [True, False])


def test_mean_stresses_have_stresslets_and_loads_by_where_they_act(load_flow):
    """In a flow of uniform shear: of stresslets 3 and 0.5, the torque 4, and the force 2 at 0.1 above mid-gap, and -7.

    The first body is free to turn and the second is held, by what the fluid and contact do not give.
    """
    free = "{centre: [0.4, 0.6], radius: 0.2, motion: free, force: [2.0, 0.0], torque: 4.0}"
    scene = scenes.of(load_flow(CHANNEL, f"bodies=[{free}, {{centre: [1.1, 0.4], radius: 0.2}}]"))
    loads, contact = np.zeros((2, 4, 4)), np.zeros((4, 4))
    loads[0, 0], loads[0, 1], contact[1] = [-5.0, 1.0, 9.0, 3.0], [6.0, 0.0, 2.0, 0.5], [1.0, 0.0, 1.5, 0.25]
    loads[0, 2:, 0] = [5.0, -4.0]  # bottom and top
    snapshot = snapshot_of(scene, lambda x, y: y, lambda x, y: 0 * x)
    found = scene.mean_stresses(replace(snapshot, bodies=Bodies.at(0.0, scene.bodies, loads, contact=contact)))
    added = (3.0 + 4.0 / 2 - 0.1 * 2.0) + (0.5 + 0.25 - 3.5 / 2 - 0.1 * 7.0)
    assert found[STRESS_ON_WALLS] == pytest.approx(0.5 * (5.0 + 4.0) / 1.5, rel=1e-12)
    assert found[STRESS_BY_CONTACTS] == pytest.approx(0.25 / 1.5, rel=1e-12)
    assert found[STRESS_BY_BODIES] == pytest.approx(scene.dynamic_viscosity * 1.0 + added / 1.5, rel=1e-12)


def test_narrow_gaps_and_small_radii_are_not_resolved(load_flow):
    """At any time, in samples and pictures, be the layers as deep as they may."""
    wide, tight, small = (
        scenes.of(load_flow(CHANNEL, f"bodies=[{{centre: [0.5, {height}], radius: {radius}}}]"))
        for height, radius in ((0.5, 0.2), (0.3, 0.2), (0.5, 2.8 / 24))
    )
    assert resolution(wide, 10.0) == (True, None)
    text = "the gap between body and wall bottom is 2.4 spacings; resolved from 3 on"
    assert resolution(tight, 10.0) == (False, text)
    assert resolution(small, 10.0) == (False, "the smallest radius of body is 2.8 spacings; resolved from 3 on")
    for scene, words in ((wide, ""), (tight, "unresolved: gap of 2.4 spacings")):
        snapshot = snapshot_of(scene, lambda x, y: 0 * x, lambda x, y: 0 * x, 10.0)
        snapshot = replace(snapshot, bodies=Bodies.at(10.0, scene.bodies))
        assert error_label(scene)(snapshot) == words
        legend = profile_figure(scene, [snapshot]).legends[0]
        assert ("unresolved" in legend.texts[0].get_text()) == bool(words)
        video = make_video(640, 320)
        renderer = Drawn(scene, video, "gap", 10.0)
        picture = renderer.render(snapshot)
        label = picture[renderer.layout.error_label.slices]
        assert (label < 128).any() == bool(words)
        assert not (label[:, :3] < 250).any()  # all of it has room


def test_the_layer_in_front_of_a_body_stays_thin(load_flow):
    """Hiemenz: 99 % of the velocity at 2.4 sqrt(nu/a), a = 2 U/R; the smallest radius counts, the start comes first."""
    scene = scenes.of(load_flow(CHANNEL, "fluid.kinematic_viscosity=0.005"))
    nu = scene.kinematic_viscosity
    front = 2.4 * math.sqrt(nu * 0.2 / 2.0)
    assert scene.thinnest_layer(1e3)[:2] == (pytest.approx(front), "the layer in front of a body")
    assert scene.thinnest_layer(0.01)[0] == pytest.approx(math.sqrt(0.01 * nu))
    text = f"the layer in front of a body is {front * 24:.2g} spacings thin; resolved from 2 spacings on"
    assert resolution(scene, 1e3) == (False, text)
    turning = scenes.of(load_flow(REGION, "bodies=[]"))
    assert turning.thinnest_layer(1.0)[1] == "the layer at bodies and walls"


def test_gaps_of_bodies_that_move_are_those_of_the_time(load_flow):
    rising = "bodies=[{centre: [0.5, 0.5], radius: 0.2, motion: {velocity: [0.0, 0.2]}}]"
    scene = scenes.of(load_flow(CHANNEL, rising))
    # from a hundred points on the circle and a parabola: the fourth power of their distance; at 0.9 the gap is less
    # than three spacings, at 0.5 it is more, and not computed
    assert [scene.narrowest(t)[1][0] for t in (0.0, 0.9)] == pytest.approx([0.3, 0.12], rel=1e-6)
    assert scene.narrowest(0.5)[1][0] >= 0.2


def test_divergent_velocities_are_not_resolved(load_flow, tmp_path):
    scene = scenes.of(load_flow(CHANNEL))
    snapshot = replace(snapshot_of(scene, lambda x, y: y, lambda x, y: 0 * x, 10.0), divergence=0.08)
    text = "the divergence is 0.08 of the velocity gradient; resolved up to 0.01"
    assert resolution(scene, 10.0, snapshot) == (False, text)
    assert error_label(scene)(snapshot) == "unresolved: divergence 0.08"
    samples = Samples(tmp_path / "samples.h5", scene, [10.0])
    samples.observe(snapshot)
    samples.close()
    assert read_samples(tmp_path / "samples.h5")[0].divergence == 0.08


def shipped(name):
    return scenes.of(load(CONFIGS / f"{name}.yaml"))


def test_the_movie_of_an_ellipse_in_shear_shows_its_angle_beside_jefferys():
    series = shipped("jeffery_orbit").movie_series()
    assert series.columns == ["angle"]
    assert series.reference == "Jeffery, without walls: period 15.71 s"
    times = np.linspace(0.0, 2.0 * np.pi * 2.5, 2001)  # a whole turn
    angle = series.exact(times)[:, 0]
    # dphi/dt = -G (a^2 sin^2 phi + b^2 cos^2 phi)/(a^2 + b^2), G = 1; central differences are off by 1e-5
    expected = -(0.2**2 * np.sin(angle) ** 2 + 0.1**2 * np.cos(angle) ** 2) / 0.05
    assert np.allclose(np.gradient(angle, times)[1:-1], expected[1:-1], atol=5e-5)
    assert angle[[0, -1]] == pytest.approx([0.5 * np.pi, -1.5 * np.pi], rel=1e-12)


@pytest.mark.parametrize(
    ("name", "columns", "drive"),
    [
        ("settling_disc", ["u"], ("gravity", (981.0, 0.0))),
        ("drafting_kissing_tumbling", ["distance"], ("gravity", (981.0, 0.0))),
        ("migration", ["y"], ("drive", (0.0, 0.0))),
        ("segre_silberberg", ["y"], ("drive", (2.337e-4, 0.0))),
        ("falling_ball", ["velocity"], ("force on the sphere", (-0.5, 0.0))),
    ],
)
def test_movies_show_the_motion_that_a_case_is_about_and_its_cause(name, columns, drive):
    scene = shipped(name)
    assert scene.movie_series().columns == columns
    assert (scene.drive_shown[0], scene.drive_shown[2]) == drive


TITLES = parse((Path(__file__).parent / "data" / "titles.yaml").read_text(encoding="utf-8")).data


@pytest.mark.parametrize(("name", "flow"), TITLES.items())
def test_titles_name_the_flow(name, flow):
    config = load(CONFIGS / f"{name}.yaml")
    assert config.flow == flow
    assert config.heading.startswith(config.title or f"{flow}, ")
