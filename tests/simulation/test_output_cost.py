"""Output is a small part of a run: seconds of processor time, and lines of the history."""

import json
from pathlib import Path

import pytest

from tisph import config
from tisph.observers.history import read_history
from tisph.simulation.run import run

pytestmark = pytest.mark.taichi

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


@pytest.mark.parametrize(
    ("name", "settings", "share"),
    # measured: 0.18 and 0.13; with a history of 401 lines, and a mean over the cell in each, 0.4 and 1.4. The share of
    # a short run is larger, as files and provenance cost the same in every run.
    [("couette", (), 0.33), ("cylinder_lattice", ("time={end: 0.02, samples: [0.02]}",), 0.33)],
)
def test_output_takes_a_small_part_of_a_run(tmp_path, name, settings, share):
    run(config.load(CONFIGS / f"{name}.yaml", ("runtime.threads=1", *settings)), tmp_path, pictures=False, video=False)
    cost = json.loads((tmp_path / "summary.json").read_text())["cost"]
    times, _ = read_history(tmp_path / "history.csv")
    assert len(times) <= cost["steps"] + 1
    assert (times[1:] > times[:-1]).all()
    assert cost["processor_output_s"] <= share * cost["processor_loop_s"]
