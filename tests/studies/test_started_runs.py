"""Runs that studies start: those of the command line, from a process that has imported what they need."""

import json
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from couette import couette_text

from tisph.studies import processes

pytestmark = pytest.mark.taichi

CASE = {"initial": {"jitter": 0.2}, "time": {"end": 0.5}}


def test_they_have_the_bits_of_the_command_line(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(couette_text(**CASE))
    for folder in ("first", "second"):  # the server starts with the first one
        began = time.perf_counter()
        result, message = processes.run_config(path, tmp_path / folder)
        assert (message, result.summary["status"]) == ("", "done")
        assert result.summary["cost"]["wall_total_s"] < time.perf_counter() - began
    command = [sys.executable, "-m", "tisph", "run", path, "--out", tmp_path / "command", "--no-pictures"]
    subprocess.run(command, check=True, capture_output=True)
    expected, *found = (tmp_path / folder for folder in ("command", "first", "second"))
    for own in found:
        assert (own / "history.csv").read_bytes() == (expected / "history.csv").read_bytes()
        assert all(np.array_equal(*pair) for pair in zip(arrays(own), arrays(expected), strict=True))
        assert sorted(each.name for each in own.iterdir()) == sorted(each.name for each in expected.iterdir())
        assert not list(own.glob("*.png"))
    assert json.loads((expected / "summary.json").read_text())["samples"] == result.summary["samples"]
    assert not list(tmp_path.glob("*.messages"))


def test_one_that_is_refused_says_why(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(couette_text(time={"end": -1}))
    result, message = processes.run_config(path, tmp_path / "refused")
    assert result.summary["status"] == "failed"
    assert "time.end = -1: must be greater than 0" in message


SCRIPT = """
import sys
from concurrent.futures import ThreadPoolExecutor

import tisph

for folder, executor in (("alone", None), ("threads", ThreadPoolExecutor(2))):
    rows = tisph.sweep("study.yaml", folder, processes=2, executor=executor)
    assert [row["status"] for row in rows] == ["done", "done"], rows
"""
"""Without ``if __name__ == "__main__"``, which processes of multiprocessing need that import their script."""


def test_runs_do_not_import_the_script_that_sweeps(tmp_path):
    study = {"base": "case.yaml", "vary": {"walls.top.velocity": [0.2, 0.4]}, "collect": ["l2", "steps"]}
    (tmp_path / "case.yaml").write_text(couette_text(**CASE))
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    tables = [(tmp_path / folder / "table.csv").read_bytes() for folder in ("alone", "threads")]
    assert tables[0] == tables[1]


def arrays(folder):
    with h5py.File(folder / "samples.h5") as file:
        return [group[name][...] for group in file.values() for name in group]
