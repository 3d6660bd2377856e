"""A run with a shape from a file goes on without the file, from its resolved config, as it does from the config."""

import json

import numpy as np
import pytest

from tisph import simulation
from tisph.config import load
from tisph.errors import ConfigError

pytestmark = pytest.mark.taichi

CASE = """\
scene: lattice
fluid: {density: 1.0, kinematic_viscosity: 10.0}
geometry: {length: 1.0, height: 1.0}
bodies: [{type: curve, file: shape.csv}]
drive: {acceleration: 500.0}
discretisation: {particles_across: 18}
time: {end: 0.002, samples: [0.002]}
runtime: {threads: 1}
output: {video: null, checkpoint_every: 0.001}
"""
LATER = "time={end: 0.004, samples: [0.002, 0.004]}"


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_a_run_needs_no_drawing_to_go_on(tmp_path):
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    shape = tmp_path / "shape.csv"
    np.savetxt(shape, 0.5 + 0.25 * np.stack([np.cos(angle), np.sin(angle)], axis=1), delimiter=",")
    (tmp_path / "case.yaml").write_text(CASE)
    for name in ("with", "without"):
        simulation.run(load(tmp_path / "case.yaml"), tmp_path / name, pictures=False, video=False)
    simulation.run(load(tmp_path / "case.yaml", [LATER]), tmp_path / "with", pictures=False, video=False, resume=True)
    shape.unlink()
    resolved = tmp_path / "without" / "config.resolved.yaml"
    simulation.run(load(resolved, [LATER]), tmp_path / "without", pictures=False, video=False, resume=True)
    drags = [summary(tmp_path / name)["samples"][-1]["drag"] for name in ("with", "without")]
    assert drags[0] == drags[1] != 0.0
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        load(tmp_path / "case.yaml")


def test_a_changed_drawing_is_another_config(tmp_path):
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    (tmp_path / "case.yaml").write_text(CASE)
    found = []
    for radius in (0.25, 0.26):
        np.savetxt(tmp_path / "shape.csv", 0.5 + radius * circle, delimiter=",")
        found.append(load(tmp_path / "case.yaml"))
    assert found[0] != found[1]
