"""Runs against exact solutions: the bounds of the verification suite, one test each.

The bounds and where they come from stand in ``tisph/suites``. A run is simulated once, when the first
test asks for it, and all processes of the tests read what it left.
"""

from pathlib import Path

import pytest
from filelock import FileLock

from tisph import config, simulation
from tisph.config.yaml_text import parse
from tisph.errors import DivergedError
from tisph.studies import suites, verify
from tisph.studies.processes import read_result
from tisph.studies.suites import Suite

HERE = {"runtime": {"threads": 1}, "output": {"video": None}}
"""Of a run in the tests' own process. One thread gives the bits of several, and costs less beside other tests."""

LONG = parse((Path(__file__).parent / "data" / "slow_rows.yaml").read_text(encoding="utf-8")).data


def checks(quick):
    """The suite's criteria, with a readable test name each."""
    return [
        pytest.param(
            criterion,
            id=f"{criterion.case}: {criterion.quantity} {criterion.bound}",
            marks=[pytest.mark.slow] if criterion.case in LONG else [],
        )
        for criterion in suites.whole(quick).criteria
    ]


def run_here(config_path, folder):
    """Run one config in this process; return ``Result`` and message: no pictures, and little history."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])
        monkeypatch.setattr("tisph.observers.history.RECORDS", 81)  # a quarter shows scatter (resolution.LEAST_TURNS)
        try:
            simulation.run(config.load(config_path), folder)
        except DivergedError as error:
            return read_result(folder), str(error)
    return read_result(folder), ""


class SharedRunner(verify.Runner):
    """A Runner that shares its runs with other processes; repeated runs have a process of their own."""

    def outcome(self, name, config):
        folder = self.store.folder / name
        with FileLock(self.store.folder / f"{name}.shared"):
            if folder.exists():
                return read_result(folder), ""
            if name.endswith("repeat"):
                return super().outcome(name, config)
            return run_here(self.store.write(name, {**config, **HERE}), folder)


@pytest.fixture(scope="module")
def quick_runner(tmp_path_factory, worker_id, kept_program):
    folder = tmp_path_factory.getbasetemp()
    shared = (folder if worker_id == "master" else folder.parent) / "quick suite"
    return SharedRunner(Suite("", suites.whole(quick=True).runs), shared)


@pytest.fixture(scope="module")
def full_runner(tmp_path_factory):
    return verify.Runner(suites.whole(quick=False), tmp_path_factory.mktemp("full"))


@pytest.mark.verification
@pytest.mark.parametrize("criterion", checks(quick=True))
def test_quick_suite(quick_runner, criterion):
    check = quick_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {quick_runner.failures}"


@pytest.mark.verification
@pytest.mark.slow
@pytest.mark.timeout(1800)  # the longest run has 110 000 steps of 5000 particles
@pytest.mark.parametrize("criterion", checks(quick=False))
def test_full_suite(full_runner, criterion):
    check = full_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {full_runner.failures}"
