"""The C++ loop in benchmarks/, an implementation of its own, moves particles as the explicit scheme does."""

import json

import numpy as np
import pytest
import reference_loop as reference
from flows import flow_config

from tisph import registry, runtime, scenes
from tisph.config import load
from tisph.simulation.state import start_values

CASE = flow_config("explicit_channel")
DISCRETISATION = {"kernel": "wendland_c2", "smoothing_ratio": 1.3}


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    path = reference.compiled(tmp_path_factory.mktemp("reference"))
    if path is None:
        pytest.skip("no C++ compiler")
    return path


def scene(folder, precision, across, **initial):
    """Config and channel of a case with standard operators on one thread, a fifth as long."""
    path = folder / "case.yaml"
    discretisation = {**DISCRETISATION, "particles_across": across, "precision": precision}
    start = {"state": "developed", "jitter": 0.1, **initial}
    path.write_text(json.dumps({**CASE, "discretisation": discretisation, "initial": start}))  # JSON is YAML
    config = load(path, ())
    return config, scenes.of(config)


def run_reference(program, folder, case, start, **words):
    """State (particles, 4) of x, y, u, v that the C++ loop reaches from the arrays ``start``."""
    state, out = folder / "state.bin", folder / "out.bin"
    reference.write_state(state, *start)
    found = reference.run(program, *case, state=state, out=out, warm_up=0, **words)
    return np.fromfile(out).reshape(-1, 4), found


STEPS = 200
"""Long enough for the lists to be made anew."""


@pytest.mark.verification
# double: the program's table of weights is within 1e-5 of the largest, measured 1.5e-6; single: velocities up to 0.5
# are rounded to 3e-8 in each of 200 steps, which is 2e-4 of the velocities across the channel, measured 1.4e-4
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-5), ("f32", 1e-3)])
def test_the_loop_moves_the_same_particles_to_the_same_places(program, tmp_path, precision, tolerance):
    config, channel = scene(tmp_path, precision, 50)
    position, velocity, _ = start_values(channel, config.initial)
    runtime.start(precision, 1)
    scheme = registry.load("schemes", "wcsph").build(config, channel, [config.time.end], serial=True)
    scheme.start(position, velocity)
    time_step = scheme.length
    while scheme.steps < STEPS:
        scheme.advance()
    ours = scheme.snapshot()
    words = {"steps": STEPS, "time_step": time_step}
    state, found = run_reference(program, tmp_path, (config, channel), (*position.T, *velocity.T), **words)
    assert scheme.rebuilds > 1, "a test without a rebuild of the lists"
    assert found["rebuilds"] > 0
    apart = (state[:, 0] - ours.x + 0.5 * channel.length) % channel.length - 0.5 * channel.length
    moved = np.abs(ours.v).max()  # velocities across the channel start from zero: all of them are sums over neighbours
    assert np.abs(state[:, 2] - ours.u).max() < tolerance * moved
    assert np.abs(state[:, 3] - ours.v).max() < tolerance * moved
    assert np.abs(apart).max() < 1e-3 * channel.spacing
    assert np.abs(state[:, 1] - ours.y).max() < 1e-3 * channel.spacing
