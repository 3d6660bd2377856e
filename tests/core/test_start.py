"""What a run shows of its start, and that it computes a flow in the flow's own frame."""

import json

import numpy as np
import pytest

from tisph import config, simulation
from tisph.folder import Folder
from tisph.observers.history import read_history
from tisph.observers.samples import read_samples

CASE = """
scene: channel
fluid: {density: 2.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
initial: {jitter: 0.2}
discretisation: {particles_across: 6}
time: {end: 0.02, samples: [0, 0.02]}
output: {video: null}
"""
SCHEMES = ["wcsph", pytest.param("implicit", marks=pytest.mark.slow)]


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Return a function that runs the small case with ``key.path=value`` overrides; its folder, without pictures."""
    monkeypatch.setattr("tisph.simulation.drawing.pictures", lambda *_: [])
    path = tmp_path / "case.yaml"
    path.write_text(CASE)

    def call(name, *overrides):
        return Folder(simulation.run(config.load(path, overrides), tmp_path / name))

    return call


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_start_is_what_the_config_says(run, scheme):
    """Not what the impulse of the wall has made of it, which is 0.06 to 0.25 of the wall's speed next to it."""
    folder = run("out", f"scheme.type={scheme}")
    first, last = read_samples(folder.samples)
    assert (first.t, first.step) == (0.0, 0)
    assert not first.u.any()
    assert not first.v.any()
    assert not first.pressure.any()
    assert np.all(first.density == 2.0)
    assert last.step > 0
    assert last.u.max() > 0.1
    times, velocities = read_history(folder.history)
    assert times[0] == 0.0
    assert not velocities[0].any()
    assert velocities[1:].any()
    assert json.loads(folder.summary.read_text())["samples"][0]["rms"] == 0.0


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_flow_seen_from_a_moving_frame_is_the_same_flow(run, scheme):
    """Same steps and particles. The frame is 200 times as fast as the wall, which costs as many roundings of 2e-16."""
    settled = ("initial.state=developed", f"scheme.type={scheme}")
    speed, wall = 1.0, 0.005
    still, moving = (
        run(
            f"out{frame}",
            *settled,
            f"walls.bottom.velocity={frame}",
            f"walls.top={{velocity: {frame + wall}, velocity_before: {frame}}}",
        )
        for frame in (0.0, speed)
    )
    one, other = (json.loads(folder.summary.read_text()) for folder in (still, moving))
    assert one["cost"]["steps"] == other["cost"]["steps"]
    for key, value in one["numbers"].items():
        assert other["numbers"][key] == (pytest.approx(value, rel=1e-12) if isinstance(value, float) else value), key
    assert other["momentum"]["top_wall"] == pytest.approx(one["momentum"]["top_wall"], rel=1e-9)
    for before, after in zip(one["samples"], other["samples"], strict=True):
        for key in ("l2", "rms", "linf", "density_variation"):
            near = before[key] if before[key] is None else pytest.approx(before[key], rel=1e-9, abs=1e-12)
            assert after[key] == near, key
    for own, seen in zip(read_samples(still.samples), read_samples(moving.samples), strict=True):
        assert np.allclose(seen.u - speed, own.u, rtol=0, atol=1e-15)  # the last digit of the speed
        assert np.allclose((seen.x - speed * seen.t) % 2.0, own.x, rtol=0, atol=1e-14)
        assert np.allclose(seen.y, own.y, rtol=0, atol=1e-14)
