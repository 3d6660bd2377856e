"""Throughput: which cases, what is made of their numbers, what is kept, and what is called."""

import json
import subprocess
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from tisph.cli import app
from tisph.config import load
from tisph.errors import TisphError
from tisph.study.bench import _throughput_reference as reference
from tisph.study.bench import throughput
from tisph.study.bench._throughput_cases import Case, cases
from tisph.study.bench._throughput_results import LAMMPS, Check, Results, checks, ratios
from tisph.study.bench._throughput_table import spread

EXPLICIT = {
    "peak_mb": 200.0,
    "estimated_mb": 1.0,
    "steps": 100,
    "rebuilds": 2,
    "interval": 50.0,
    "step": 80.0,
    "fastest": 79.0,
    "kernel": 78.0,
    "pass": 70.0,
    "binning": 20.0,
    "list": 100.0,
    "walls": 5.0,
    "neighbours_mean": 21.0,
    "particles": 5000,
}
IMPLICIT = {
    "peak_mb": 220.0,
    "estimated_mb": 12.0,
    "steps": 9,
    "step": 2500.0,
    "assembly": 600.0,
    "neighbours": 200.0,
    "systems": 900.0,
    "neighbours_mean": 26.0,
    "particles": 5000,
}
REFERENCE = {"particles": 5000, "step": 45.0, "rebuild": 100.0}
PEER = {"particles": 5000, "steps": 1000, "loop_seconds": 1.0, "neighbours": 24}


def explicit(**changes):
    return {**EXPLICIT, **changes}


@pytest.mark.parametrize("quick", [False, True])
def test_every_case_is_a_valid_config_of_its_own(tmp_path, quick):
    found = cases(quick)
    assert len({case.name for case in found}) == len(found)
    for case in found:
        path = tmp_path / "case.yaml"
        path.write_text(json.dumps(case.config))  # JSON is YAML
        config = load(path, ())
        assert config.particles_across * config.columns == case.particles
        assert (config.runtime.threads, config.discretisation.precision) == (case.threads, case.precision)


def test_the_lists_last_as_long_as_at_the_smallest_size_at_least():
    results, small, large = Results(), Case("standard", "f64", 1, 50), Case("standard", "f64", 2, 707)
    results.cases = {small: [explicit(interval=60.0)], large: [explicit(interval=20.0)]}
    assert results.interval(large) == 60.0
    results.cases[large] = [explicit(interval=value) for value in (300.0, 200.0, 10.0)]
    assert results.interval(large) == 200.0


def test_the_cost_of_a_step_has_its_part_of_a_rebuild():
    results, case = Results(), Case("standard", "f64", 1, 50)
    results.cases = {case: [explicit(), explicit(step=90.0)]}
    results.references = {("f64", 1, 50): [REFERENCE]}
    assert results.cost(case) == [pytest.approx(80.0 + 125.0 / 50.0), pytest.approx(90.0 + 125.0 / 50.0)]
    assert results.reference_cost(case) == [pytest.approx(45.0 + 100.0 / 50.0)]
    assert sum(results.parts(case).values()) == pytest.approx(85.0 + 125.0 / 50.0)


def test_a_particle_needs_what_a_process_grows_by():
    results, small, large = Results(), Case("standard", "f64", 1, 50), Case("standard", "f64", 2, 224)
    results.cases = {
        small: [explicit(), explicit(peak_mb=210.0)],
        large: [explicit(peak_mb=260.0, estimated_mb=50.176), explicit(peak_mb=247.676, estimated_mb=50.176)],
    }
    assert results.memory(large) == (pytest.approx(500.0), pytest.approx(500.0))


def test_peers_are_compared_round_by_round():
    results, case = Results(), Case("standard", "f64", 1, 50)
    results.cases = {case: [explicit(interval=1e9), explicit(interval=1e9, step=160.0)]}
    results.peers = {(LAMMPS, 1, 50): [PEER, {**PEER, "loop_seconds": 2.0}]}
    (check,) = [one for one in checks(results) if LAMMPS in one.what]
    assert check.values == pytest.approx((2.5, 2.5))
    assert check.passed
    assert not Check("another", (1.1, 1.0, 1.3), least=1.2).passed


def test_what_was_not_measured_is_not_judged():
    assert checks(Results()) == []
    assert ratios([1.0, 2.0], []) == ()


def test_numbers_are_short():
    assert spread([1234.5]) == "1234"
    assert spread([3.0, 1.0, 2.0]) == "2 (1..3)"


def test_an_outcome_is_used_again_until_something_changes(tmp_path, monkeypatch):
    calls = []

    def run(command, **_):
        calls.append(command)
        return SimpleNamespace(returncode=len(calls) == 3, stdout='noise\n{"step": 1}\n', stderr="no memory")

    monkeypatch.setattr(throughput.subprocess, "run", run)
    path = tmp_path / "one.json"
    for key, number in ((["a"], 1), (["a"], 1), (["b"], 2)):
        assert throughput.kept(path, key, ["program"]) == {"step": 1}
        assert len(calls) == number
    with pytest.raises(TisphError, match="no memory"):
        throughput.kept(path, ["c"], ["program"])


@pytest.fixture
def fake_processes(monkeypatch):
    """Stands in for all processes, and returns their commands."""
    commands = []

    def run(command, **_):
        words = list(map(str, command))
        commands.append(words)
        found = IMPLICIT if any("implicit" in word for word in words) else EXPLICIT
        found = REFERENCE if any("_throughput_reference" in word for word in words) else found
        found = PEER if "--code" in words else found
        return SimpleNamespace(returncode=0, stdout=json.dumps(found), stderr="")

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(reference.shutil, "which", lambda name: f"/usr/bin/{name}")
    return commands


def test_the_command_measures_everything_once_and_says_whether_bounds_are_kept(tmp_path, fake_processes):
    (tmp_path / "measure.py").touch()
    words = ["bench", "throughput", "--quick", "--peers", str(tmp_path), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 1, done.output  # all sizes alike: two threads are no faster than one
    for title in ("Explicit scheme", "Implicit scheme", "Memory", "Peers", "Bounds"):
        assert f"\n{title}" in done.output
    numbers = json.loads((tmp_path / "out" / "throughput.json").read_text())
    assert {check["passed"] for check in numbers["checks"]} == {True, False}
    assert len(numbers["cases"]) == len(cases(True))
    measured = [command for command in fake_processes if "-std=c++17" not in command]
    assert len(measured) == len(cases(True)) + len(numbers["references"]) + len(numbers["peers"])
    again = CliRunner().invoke(app, words)
    assert again.output == done.output
    assert [command for command in fake_processes if "-std=c++17" not in command] == measured


def test_the_loop_is_left_out_without_a_compiler(tmp_path, fake_processes, monkeypatch, capsys):
    monkeypatch.setattr(reference.shutil, "which", lambda name: None)
    throughput.run(tmp_path, quick=True)
    assert "the C++ loop is left out" in capsys.readouterr().out
    assert not any("_throughput_reference" in word for command in fake_processes for word in command)


def test_a_flag_that_a_compiler_does_not_know_is_not_needed(tmp_path, monkeypatch):
    tried = []

    def run(command, **_):
        tried.append(command)
        return SimpleNamespace(returncode="-mprefer-vector-width=256" in command, stderr="unknown flag")

    monkeypatch.setattr(reference.shutil, "which", lambda name: name)
    monkeypatch.setattr(reference.subprocess, "run", run)
    assert reference.compiled(tmp_path) == tmp_path / "reference"
    assert len(tried) == len(reference.TUNING)
    monkeypatch.setattr(reference.subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=1, stderr="broken"))
    with pytest.raises(TisphError, match="broken"):
        reference.compiled(tmp_path)
