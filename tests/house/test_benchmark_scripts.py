"""The scripts in benchmarks/: what they run is valid, and what they compare are errors of the same quantity."""

import json
from pathlib import Path

import compare_commits
import h5py
import pytest

from tisph.config import load


@pytest.mark.parametrize("parts", [False, True])
def test_every_case_of_the_cost_of_a_step_is_a_valid_config(tmp_path, parts):
    pytest.importorskip("pyperf")
    import step

    path = tmp_path / "case.yaml"
    for _, config in step.cases(parts, [50]):
        path.write_text(json.dumps(config))  # JSON is YAML
        loaded = load(path, ())
        assert loaded.particles_across * loaded.columns == 5000


def summary(**sample):
    return {"status": "done", "samples": [{"t": 1.0, "nearest_two": 0.8, **sample}]}


def test_errors_are_compared_and_other_values_by_their_change():
    old = summary(l2=1e-4, torque=2.0, torque_exact=2.001, drag=10.0)
    new = summary(l2=1.1e-4, torque=2.0, torque_exact=2.002, drag=10.1)
    row = compare_commits.error_row("case", old, new)
    assert "2.000 (torque at t = 1: 0.001, 0.002)" in row
    assert "0.01 (drag at t = 1: 10, 10.1)" in row


def test_round_off_is_no_error():
    row = compare_commits.error_row("case", summary(l2=1e-16), summary(l2=5e-15))
    assert row == "| case | 1 done | 1 done |  |  |"


def test_a_quantity_that_is_missing_is_named():
    assert "drag at t = 1 missing" in compare_commits.error_row("case", summary(drag=1.0), summary())


def test_times_are_ratios_of_medians_with_the_range_of_the_rounds():
    def cost(loop):
        return {"cost": {"steps": 5, "wall_loop_s": loop, "wall_total_s": loop + 1.0}}

    row = compare_commits.time_row("case", [(cost(1.0), cost(1.1)), (cost(2.0), cost(2.0)), (cost(1.0), cost(1.2))])
    assert "| 1.200 (1.00..1.20) | 1.000 (1.00..1.00) |" in row


def test_the_bits_of_results_are_compared(tmp_path):
    for name, value in (("old", 1.0), ("same", 1.0), ("new", 1.0 + 2.0**-52)):
        (tmp_path / name).mkdir()
        with h5py.File(tmp_path / name / "samples.h5", "w") as file:
            file["samples/0/u"], file.attrs["version"] = [value, 2.0], name
    assert compare_commits.difference(tmp_path / "old", tmp_path / "same") == ""
    assert compare_commits.difference(tmp_path / "old", tmp_path / "new") == "/samples/0/u"
    assert compare_commits.difference(tmp_path / "old", tmp_path / "none") == "no samples"


def test_every_case_of_the_bits_is_a_valid_config():
    for config, settings in compare_commits.frozen_cases(Path(__file__).parents[2]).values():
        load(config, settings)
