"""What a run shows of its start, and that it computes a flow in the flow's own frame."""

import json
import warnings

import numpy as np
import pytest

from tisph import config, simulation
from tisph.folder import Folder
from tisph.measures.metrics import sample_metrics
from tisph.observers.history import read_history
from tisph.observers.samples import read_samples
from tisph.scenes.annulus import Annulus
from tisph.simulation.state import start_snapshot, start_values

pytestmark = pytest.mark.taichi

CASE = """
scene: channel
fluid: {density: 2.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
initial: {state: developed, jitter: 0.2}
discretisation: {particles_across: 6}
time: {end: 0.02, samples: [0, 0.02]}
output: {video: null}
"""
SPEED, WALL = 1.0, 0.005
"""Of the frame, and of the wall in it: 200 times as fast, which costs as many roundings of 2e-16."""


@pytest.fixture(scope="module", params=["wcsph", pytest.param("implicit", marks=pytest.mark.slow)])
def runs(request, tmp_path_factory):
    """Folders, without pictures, of a liquid at rest in which the upper wall starts: at rest, and seen to move."""
    folder = tmp_path_factory.mktemp("runs")
    path = folder / "case.yaml"
    path.write_text(CASE)

    def run(frame):
        top = f"walls.top={{velocity: {frame + WALL}, velocity_before: {frame}}}"
        settings = config.load(path, [f"walls.bottom.velocity={frame}", top, f"scheme.type={request.param}"])
        return Folder(simulation.run(settings, folder / f"out{frame}"))

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])
        return run(0.0), run(SPEED)


def test_the_start_is_what_the_config_says(runs):
    """Not what the impulse of the wall has made of it, which is 0.06 to 0.25 of the wall's speed next to it."""
    folder = runs[0]
    first, last = read_samples(folder.samples)
    assert (first.t, first.step) == (0.0, 0)
    assert not np.any([first.u, first.v, first.pressure])
    assert np.all(first.density == 2.0)
    assert last.step > 0
    assert last.u.max() > 0.1 * WALL
    times, velocities = read_history(folder.history)
    assert times[0] == 0.0
    assert [row.any() for row in (velocities[0], velocities[1:])] == [False, True]
    assert json.loads(folder.summary.read_text())["samples"][0]["rms"] == 0.0


def test_a_flow_seen_from_a_moving_frame_is_the_same_flow(runs):
    still, moving = runs
    one, other = (json.loads(folder.summary.read_text()) for folder in runs)
    assert one["cost"]["steps"] == other["cost"]["steps"]
    for key, value in one["numbers"].items():
        assert other["numbers"][key] == (pytest.approx(value, rel=1e-12) if isinstance(value, float) else value), key
    assert other["momentum"]["top_wall"] == pytest.approx(one["momentum"]["top_wall"], rel=1e-9)
    for before, after in zip(one["samples"], other["samples"], strict=True):
        for key in ("l2", "rms", "linf", "density_variation"):
            near = before[key] if before[key] is None else pytest.approx(before[key], rel=1e-9, abs=1e-12)
            assert after[key] == near, key
    for own, seen in zip(read_samples(still.samples), read_samples(moving.samples), strict=True):
        assert np.allclose(seen.u - SPEED, own.u, rtol=0, atol=1e-15)  # the last digit of the speed
        assert np.allclose((seen.x - SPEED * seen.t) % 2.0, own.x, rtol=0, atol=1e-14)
        assert np.allclose(seen.y, own.y, rtol=0, atol=1e-14)


ANNULUS = """
scene: annulus
fluid: {density: 2.0, kinematic_viscosity: 0.01}
geometry: {inner_radius: 1.0, outer_radius: 2.0, centre: [3.0, 0.0]}
walls: {inner: {angular_velocity: 1.0}}
discretisation: {particles_across: 6}
time: {end: 1.0}
"""


def test_bodies_at_the_start_have_positions_and_no_forces(tmp_path):
    (tmp_path / "case.yaml").write_text(ANNULUS)
    settings = config.load(tmp_path / "case.yaml")
    scene = Annulus.from_config(settings)
    snapshot = start_snapshot(scene, start_values(scene, settings.initial), "f64")
    assert snapshot.bodies.centre.tolist() == [[3.0, 0.0]] * 2
    assert snapshot.bodies.angular_velocity.tolist() == [1.0, 0.0]
    assert np.isnan(scene.time_series().measure(snapshot)).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a liquid at rest, and of an infinite torque
        found = sample_metrics(scene, snapshot, None)
    assert found["rms"] == 0.0
    for name in ("torque_inner", "torque_inner_exact", "divergence_over_gradient"):
        assert found[name] is None
