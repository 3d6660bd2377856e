"""A run that states its own error: what its coarser runs are, and that it is about right where the truth is known."""

import json
from pathlib import Path

import pytest

from tisph import simulation
from tisph.config import load
from tisph.studies.error_estimate import Coarser
from tisph.studies.processes import Result

CONFIGS = Path(__file__).parents[2] / "configs"

pytestmark = pytest.mark.taichi

CASE = """
scene: taylor_green
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {length: 1.0}
initial: {velocity: 1.0, jitter: 0.2}
discretisation: {particles_across: 28}
time: {end: 0.15, samples: [0.1, 0.15]}
"""


@pytest.fixture
def config(loader):
    return loader(CASE)


def test_steps_of_coarser_runs_are_longer_by_the_ratio_of_spacings(config, tmp_path):
    half, root_half = Coarser(config(), tmp_path).configs
    assert [each["discretisation"]["particles_across"] for each in (half, root_half)] == [14, 20]
    for each, factor in ((half, 2.0), (root_half, 1.4)):
        assert each["time"]["tolerance"] == pytest.approx(2e-6 * factor**4)  # of an error of fourth order
        assert each["scheme"]["largest_courant"] == 1.0
    half, _ = Coarser(config("time.cfl=0.2"), tmp_path).configs
    assert (half["time"]["cfl"], half["time"]["tolerance"]) == (0.2, "auto")
    cavity = load(CONFIGS / "cavity.yaml")  # without a tolerance, as its corners are singular
    assert [each["discretisation"]["particles_across"] for each in Coarser(cavity, tmp_path).configs] == [12, 18]


def test_the_error_of_a_vortex_is_estimated(config, tmp_path, monkeypatch):
    folder = tmp_path / "results"
    coarser = Coarser(config(), folder)
    folder.mkdir()
    coarser.run()
    simulation.run(config(), folder, video=False)
    text = coarser.report()
    summary = json.loads((folder / "summary.json").read_text())
    estimate = summary["error_estimate"]
    assert (estimate["reason"], estimate["particles_across"]) == (None, [14, 20, 28])
    assert 2 <= estimate["order"] <= 6
    for found, true in zip(estimate["samples"], summary["samples"], strict=True):
        assert found["t"] == true["t"]
        assert set(found["fields"]) == {"velocity", "pressure", "u along y", "v along x", "p along y"}
        assert set(found["numbers"]) == {"kinetic_energy", "dissipation"}
        # what tisph verify holds estimates to
        assert 1 / 3 < found["fields"]["velocity"]["error"] / true["l2"] < 3
    assert "estimated error, from 14, 20 and 28 particles across" in text
    monkeypatch.setattr("tisph.studies.store.Store.launch", None)  # what has run is kept
    coarser.run()


def test_a_finer_run_tells_the_error_where_no_coarser_one_can_be(config, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("tisph.studies.error_estimate.FACTORS", (100.0,))
    folder = tmp_path / "results"
    coarser = Coarser(config("discretisation.particles_across=14"), folder)
    folder.mkdir()
    coarser.run()
    assert "after the run a finer one, 21 across, tells the error instead: about" in capsys.readouterr().err
    simulation.run(config("discretisation.particles_across=14"), folder, video=False)
    text = coarser.report()
    summary = json.loads((folder / "summary.json").read_text())
    estimate = summary["error_estimate"]
    assert (estimate["reason"], estimate["particles_across"], estimate["order"]) == (None, [14, 21], None)
    for found, true in zip(estimate["samples"], summary["samples"], strict=True):
        # the difference over 1 - 1.5^-2; of order 3 to 4, as the vortex is, the error is 1.3 times less
        assert 1 / 3 < found["fields"]["velocity"]["error"] / true["l2"] < 3
        assert found["numbers"]["kinetic_energy"]["error"] > 0.0
    assert "estimated error, from 14 and 21 particles across; order none" in text


def test_where_all_other_runs_fail_there_is_no_estimate(config, tmp_path, monkeypatch):
    def ended(names, launch, most):
        yield names[0], Result(tmp_path, {"status": "failed"}), "too bad"

    monkeypatch.setattr("tisph.studies.store.run_side_by_side", ended)
    coarser = Coarser(config(), tmp_path)
    coarser.run()
    (tmp_path / "summary.json").write_text('{"status": "done", "samples": []}')
    assert coarser.message == "the coarser run across_14 did not finish: too bad"
    reason = "the finer run across_42 did not finish: too bad"
    assert coarser.report() == f"no estimate of the error: {reason}"
    assert json.loads((tmp_path / "summary.json").read_text())["error_estimate"] == {"reason": reason}
