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


def arrays(folder):
    with h5py.File(folder / "samples.h5") as file:
        return [group[name][...] for group in file.values() for name in group]
