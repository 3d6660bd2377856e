"""Bodies that the flow carries, in what a user gets of them: history, trajectories, pictures, ``tisph check``."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from report_scene import at_start

from tisph.cli.run import result_text
from tisph.config import load
from tisph.geometry.body import gap
from tisph.measures.steadiness import Followed
from tisph.observers.history import BODY_FIELDS, Trajectories
from tisph.observers.samples import Description
from tisph.report.layout import arrange
from tisph.report.overlays import BodyTracks, Solids, Tracks
from tisph.report.plots import history_figure
from tisph.results._results import Trajectories as Read
from tisph.schemes.implicit.planar.free_bodies import Contact
from tisph.simulation.recording import _steady
from tisph.snapshot import Bodies

CASE = """
scene: channel
geometry: {gap: 1.0, length: 2.0}
walls: {bottom: {velocity: -0.5}, top: {velocity: 0.5}}
initial: {state: developed}
fluid: {density: 2.0, kinematic_viscosity: 0.1}
bodies:
- {type: circle, centre: [0.5, 0.3], radius: 0.15, motion: free}
- {type: circle, centre: [1.0, 0.5], radius: 0.15}
- {type: ellipse, centre: [1.6, 0.7], half_axes: [0.2, 0.15], angle: 0.5, motion: free, density: 3.0}
discretisation: {particles_across: 20}
time: {end: 1.0, samples: [1.0]}
"""
PLACES = [[0.3 + 0.5 * (k // 2), 0.25 + 0.5 * (k % 2)] for k in range(7)]
MANY = f"bodies=[{', '.join(f'{{centre: {place}, radius: 0.13, motion: free}}' for place in PLACES)}]"


@pytest.fixture
def make(tmp_path):
    return at_start(tmp_path, CASE)


def moved(scene, snapshot, t, **changes):
    """The ``snapshot`` at time ``t`` with known loads on bodies and other numbers of them."""
    loads = np.arange(8.0 * len(scene.bodies)).reshape(2, -1, 4) + t
    bodies = Bodies.at(0.0, scene.bodies, loads, contact=np.full((len(scene.bodies), 4), t))
    return replace(snapshot, t=t, bodies=replace(bodies, **changes))


def test_history_has_places_and_velocities_beside_forces(make):
    _, scene, snapshot = make()
    series = scene.time_series()
    # centres beyond the period: it does not bring them back
    changes = {"angle": np.array([7.0, 0.0, -3.0, 0.0, 0.0]), "angular_velocity": np.arange(5.0)}
    state = moved(scene, snapshot, 0.0, centre=np.arange(10.0).reshape(5, 2), **changes)
    found = dict(zip(series.columns, series.measure(state), strict=True))
    assert [found[name] for name in ("x_0", "y_0", "angle_0", "angular_velocity_0")] == [0.0, 1.0, 7.0, 0.0]
    assert [found[name] for name in ("x_2", "y_2", "angle_2", "angular_velocity_2")] == [4.0, 5.0, -3.0, 2.0]
    assert [found[name] for name in ("drag_0", "drag_1", "torque_2")] == [0.0, 4.0, 10.0]
    assert not any(name in found for name in ("x_1", "x_top", "drag_top"))
    assert {name[:-2] for name in series.drifting} == {"x", "y", "angle"}
    _, scene, snapshot = make("bodies.1.motion=free")
    shown = scene.movie_series()
    assert (shown.name, shown.columns) == ("y", ["y_0", "y_1", "y_2"])
    assert shown.measure(moved(scene, snapshot, 0.0)).tolist() == [0.3, 0.5, 0.7]


def test_of_many_bodies_means_are_followed(make):
    _, scene, snapshot = make(MANY)
    series = scene.time_series()
    means = ["bodies_mean_u", "bodies_mean_v", "bodies_mean_angular_speed"]
    assert series.columns == [*means, *scene.mean_stress_names, "superficial_velocity"]
    count = len(scene.bodies)
    velocity = np.stack([np.arange(count), -np.ones(count)], axis=1)
    turning = moved(scene, snapshot, 0.0, velocity=velocity, angular_velocity=(-1.0) ** np.arange(count))
    assert series.measure(turning)[:3].tolist() == [3.0, -1.0, 1.0]
    shown = scene.movie_series()
    assert shown.columns == ["relative_viscosity_walls", "relative_viscosity_bodies"]
    stresses = scene.mean_stresses(turning)  # the shear rate is 1, the viscosity 0.2
    assert shown.measure(turning) == pytest.approx([stresses[name] / 0.2 for name in scene.mean_stress_names[:2]])


def test_the_picture_shows_places_and_no_forces(make):
    _, scene, _ = make()
    times, columns = np.linspace(0.0, 1.0, 11), list(scene.time_series().columns)
    values = np.ones((11, len(columns)))
    values[:, columns.index("y_0")] = 0.3 + 1e-12 * times
    resolved = np.array([True] * 3 + [False] * 4 + [True] * 4)
    figure = history_figure(scene, {}, times, values, resolved)
    names = [axes.get_ylabel() for axes in figure.axes]
    assert names == ["x [m]", "y [m]", "angle [rad]", "mean shear stress [Pa]", "superficial velocity [m/s]"]
    assert [len(axes.lines) for axes in figure.axes] == [2, 2, 2, 3, 1]
    for axes in figure.axes:  # shaded where it says so, at any time
        (shade,) = axes.patches
        assert shade.get_x() == pytest.approx(0.3, abs=1e-12)
        assert shade.get_width() == pytest.approx(0.3, abs=1e-12)
    assert figure.axes[1].get_ylim()[0] > 0.0  # around places, not from 0


def test_a_drifting_body_may_be_in_a_steady_state(tmp_path, make):
    _, scene, _ = make()
    series, path = scene.time_series(), tmp_path / "history.csv"
    history = SimpleNamespace(time_series=series, path=path)
    history.followed = lambda times, values: Followed(times, values, series.judged_sizes)
    times = 10.0 * max(scene.slow_times.values()) * np.linspace(0.0, 1.0, 101)
    columns = list(history.time_series.columns)
    for drifting, steady_since in (("x_0", 0.0), ("angle_2", 0.0), ("u_0", None)):
        rows = [[t, *(t if name == drifting else 0.0 for name in columns)] for t in times]
        history.path.write_text("".join(",".join(map(str, row)) + "\n" for row in [["t", *columns], *rows]))
        assert _steady(scene, history) == {"steady_since": steady_since}


# --- trajectories


def test_trajectories_have_bodies_with_names_and_units(tmp_path, make):
    config, scene, snapshot = make("units={length: cm, mass: g, time: s}")
    path = tmp_path / "bodies.h5"
    trajectories = Trajectories(path, scene, 1.0, about=Description(config, scene))
    assert Read(path)["t"].size == 0  # readable from the first moment on
    states = [moved(scene, snapshot, t, angle=np.arange(5.0) + 10 * t) for t in (0.0, 0.5, 1.0)]
    for state in states:
        trajectories.observe(state)
    trajectories.close()
    found = Read(path)
    assert (found.names, found.shapes) == (["0", "1", "2"], ["circle", "circle", "ellipse"])
    assert found.free.tolist() == [True, False, True]
    assert set(found) == {"t", *BODY_FIELDS}
    for name in BODY_FIELDS:
        assert np.array_equal(found[name], [getattr(state.bodies, name)[:3] for state in states])
    assert found.units["contact_force"] == found.units["force"] == "g/s^2"
    assert (found.units["angular_velocity"], found.units["t"], found.units["centre"]) == ("rad/s", "s", "cm")
    with pytest.raises(KeyError, match="speed"):
        found["speed"]
    with h5py.File(path) as file:
        (tmp_path / "again.yaml").write_text(file.attrs["config"])
    assert load(tmp_path / "again.yaml") == config


# --- pictures


def painted(layer, layout, snapshots):
    panel = np.full((layout.box.height, layout.box.width, 3), 255, dtype=np.uint8)
    for snapshot in snapshots:
        panel[:] = 255
        layer.paint(panel, snapshot)
    return panel


def test_the_spoke_of_a_free_body_turns_unless_it_is_held(make):
    dark = {}
    for hold in ("[]", "[angle]"):
        _, scene, snapshot = make(f"bodies=[{{centre: [1.0, 0.5], radius: 0.3, motion: free, hold: {hold}}}]")
        layout = arrange(scene, 1280, 640)
        for angle in (0.0, 0.5 * np.pi):
            state = moved(scene, snapshot, 0.0, angle=np.full(3, angle))
            panel = painted(Solids(scene, layout), layout, [state])
            row, column = layout.box.height // 2, layout.box.width // 2
            half = int(0.15 * layout.pixels_per_length)
            right, above = (panel[row - 2 : row + 3, column + half], panel[row - half, column - 2 : column + 3])
            dark[hold, angle] = [part[:, 0].min() < 150 for part in (right, above)]
    assert dark["[]", 0.0] == [True, False]
    assert dark["[]", 0.5 * np.pi] == [False, True]
    assert dark["[angle]", 0.0] == dark["[angle]", 0.5 * np.pi] == [False, False]


def test_bodies_leave_wider_tracks_that_end_at_periodic_sides(make):
    _, scene, snapshot = make("bodies=[{centre: [1.0, 0.5], radius: 0.3, motion: free}]")
    layout = arrange(scene, 1280, 640)
    places = 1.7, 1.9, 2.1, 2.3  # twice through the side at x = 2
    states = [moved(scene, snapshot, float(k), centre=np.full((3, 2), [x, 0.5])) for k, x in enumerate(places)]
    dark = painted(BodyTracks(scene, layout), layout, states)[:, :, 0] < 100
    columns = np.flatnonzero(dark.any(axis=0)) / layout.pixels_per_length
    head = 6.0 * layout.scale / layout.pixels_per_length
    assert (((columns > 1.7 - head) & (columns < 1.9 + head)) | ((columns > 0.1 - head) & (columns < 0.3 + head))).all()
    assert (columns > 1.7).any()
    thin = [
        SimpleNamespace(t=state.t, x=np.array([x % 2.0]), y=np.array([0.5]), passages=None)
        for state, x in zip(states, places, strict=True)
    ]
    middle = int(1.8 * layout.pixels_per_length)
    widths = [dark[:, middle].sum(), (painted(Tracks(scene, layout), layout, thin)[:, middle, 0] < 100).sum()]
    assert widths[0] > widths[1] > 0


# --- other outputs


def test_pairs_that_are_left_out_of_contact_do_not_touch(make):
    _, scene, _ = make(MANY)
    draw = np.random.default_rng(1)
    for _ in range(5):
        centres = draw.uniform((0.0, 0.1), (4.0, 0.9), (7, 2))
        bodies = [replace(body, centre=tuple(place)) for body, place in zip(scene.bodies, centres, strict=False)]
        bodies += scene.bodies[7:]
        contact = Contact(bodies, 0.1, 1.0, 0.05)
        near = contact._near_pairs([body.at() for body in bodies])
        assert 0 < len(near) < len(contact.pairs)
        assert all(gap(bodies[i], bodies[j]) > 0.1 for i, j in set(contact.pairs) - set(near))


@pytest.mark.parametrize(("count", "words"), [(0, None), (1, "touched once, for 0.5 s"), (3, "touched 3 times")])
def test_a_run_with_contacts_says_so_at_its_end(make, count, words):
    config, scene, _ = make()
    costs = dict.fromkeys(("wall_loop_s", "wall_compile_s", "wall_output_s", "wall_import_s", "wall_total_s"), 1.0)
    numbers = {"contacts": count, "contact_time": 0.5, "contact_force": 1.0}
    text = result_text(config, scene, {"samples": [], "numbers": numbers, "cost": {"steps": 3, **costs}})
    assert ("touched" in text, words is None or words in text) == (bool(words), True)
