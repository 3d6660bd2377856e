"""What several test files of this folder start from."""

import pytest
from fake_runs import FakeRuns, make_result

from tisph.config import load
from tisph.studies import processes

COUETTE = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
time: {end: 2.0}
"""


@pytest.fixture
def couette(tmp_path):
    """Path of a config of start-up Couette flow that leaves open whatever it can."""
    path = tmp_path / "case.yaml"
    path.write_text(COUETTE)
    return path


@pytest.fixture
def case(couette):
    """Return a function that loads this config with ``key.path=value`` overrides."""

    def load_case(*overrides):
        return load(couette, overrides)

    return load_case


@pytest.fixture
def fake_process(monkeypatch):
    """Stands in for `tisph run`: leaves a summary with an l2 of the test's choice, or stops with an error."""
    l2_by_name = {}

    def summary(config):
        l2 = l2_by_name.get(config["name"], 1e-3)
        return l2 if isinstance(l2, str) else make_result(t18=l2).summary

    runs = FakeRuns(summary)
    monkeypatch.setattr(processes, "start", runs)
    return runs.configs, l2_by_name
