"""Data of a flow without an exact solution, judged by runs that refine: right, changed in one thing, and bad input."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from tisph import cli
from tisph.assessment.judge import Question
from tisph.config import load
from tisph.errors import ConfigError
from tisph.studies import referee, until
from tisph.studies.store import Store

TEXT = """
name: array
scene: lattice
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {length: 1.0, height: 1.0}
bodies: [{type: circle, centre: [0.5, 0.5], radius: 0.25, motion: fixed}]
drive: {acceleration: 1.0}
initial: {jitter: 0.2}
discretisation: {particles_across: 18}
time: {end: 0.2, samples: [0.1, 0.2]}
output: {video: null}
runtime: {threads: 1}
"""
DETAIL = 0.01
"""Difference that the tests with real runs ask for: ten times the usual one, so that the runs are short."""


def flow(config, points, t):
    """Velocities (n, 2) of runs that are made up, of a driven flow that grows; they err with the spacing cubed."""
    x, y = points.T
    grown = (1.0 - np.exp(-40.0 * config.kinematic_viscosity * t)) * 0.1 / config.kinematic_viscosity
    u = 1.0 + 0.3 * np.sin(2 * np.pi * y) + grown * np.cos(2 * np.pi * x)
    return np.stack([u, grown * np.sin(2 * np.pi * (x + y))], axis=1) * (1.0 + 3.0 * config.spacing**3)


def drag(config, t):
    return (2.0 + np.exp(-10.0 * t)) * (1.0 + 3.0 * config.spacing**3)


@pytest.fixture
def runs(monkeypatch):
    """Names of runs that are made up by ``flow`` and ``drag``."""
    names = []

    def made(self, name, config):
        samples = [{"t": t, "resolved": True, "drag": float(drag(config, t))} for t in config.time.samples]
        cost = {"wall_loop_s": 1e-3, "wall_total_s": 1e-3}
        result = SimpleNamespace(folder=name, config=config, summary={"cost": cost, "samples": samples})
        result.last = samples[-1]
        names.append(name)
        return self.results.setdefault(name, result)

    def at(self, result, points):
        values = flow(result.config, points, result.config.time.samples[self.samples[0]])
        return values if "u" in self.parts else values[:, :1] - values[:, :1].mean()

    monkeypatch.setattr(until.Runs, "_result", made)
    monkeypatch.setattr(referee.Field, "at", at)
    return names


@pytest.fixture
def config(tmp_path):
    (tmp_path / "array.yaml").write_text(TEXT)
    return load(str(tmp_path / "array.yaml"), ())


def fields(path, viscosity=0.1, factor=1.0, shift=0.0, noise=0.0):
    """Write exact data of two times, changed, into a file."""
    random = np.random.default_rng(3)
    points, tables = random.uniform(0.02, 0.98, (900, 2)), []
    points = points[np.hypot(*(points - 0.5).T) > 0.3]
    for t in (0.1, 0.2):
        exact = flow(SimpleNamespace(kinematic_viscosity=viscosity, spacing=0.0), points - [shift, 0.0], t)
        values = factor * exact + noise * random.standard_normal(exact.shape)
        tables.append(np.column_stack([np.full(len(points), t), points, values]))
    np.savetxt(path, np.concatenate(tables), delimiter=",", header="t,x,y,u,v", comments="")
    return path


def numbers(path, factor=1.0):
    rows = [[t, factor * drag(SimpleNamespace(spacing=0.0), t)] for t in np.linspace(0.05, 0.2, 7)]
    np.savetxt(path, rows, delimiter=",", header="t,drag", comments="")
    return path


def compared(config, path, **options):
    return referee.compare(config, [path], Question(), path.parent / "reference", **options)


def test_exact_data_agree_at_the_least_cost(config, tmp_path, runs):
    found = compared(config, fields(tmp_path / "data.csv"))
    assert [each.verdict for each in found.findings] == ["agrees", "agrees"]
    assert all(each.bar <= referee.DETAIL / referee.SURE for each in found.findings)
    assert found.explained == []
    assert set(runs) == {"across_18", "across_18_shorter_steps", "across_25", "across_36"}


@pytest.mark.parametrize(
    ("change", "name", "value"),
    [
        ({"viscosity": 0.101}, "viscosity", 0.01),
        ({"factor": 1.02}, "factor", 0.02),
        ({"shift": 0.01}, "place", 0.01),
    ],
)
def test_one_change_of_the_data_is_named_with_its_value(config, tmp_path, runs, change, name, value):
    found = compared(config, fields(tmp_path / "data.csv", **change))
    assert "differs" in {each.verdict for each in found.findings}  # at the first time the change may be too small
    assert [each.name for each in found.explained] == [name]
    (best,) = found.explained
    assert abs(best.values[0] - value) < 3.0 * best.uncertain[0]
    assert best.uncertain[0] < 0.15 * value


def test_a_wrong_pressure_is_not_explained_by_velocities(config, tmp_path, runs):
    path = fields(tmp_path / "data.csv")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    pressure = np.concatenate([flow(config, half[:, 1:3], half[0, 0])[:, :1] for half in np.split(table, 2)])
    np.savetxt(path, np.hstack([table, 1.5 * pressure]), delimiter=",", header="t,x,y,u,v,p", comments="")
    found = compared(config, path)
    verdicts = {each.quantity.name: each.verdict for each in found.findings}
    assert verdicts["velocity at t = 0.2"] == "agrees"
    assert verdicts["pressure at t = 0.2"] == "differs"
    assert "factor" in {each.name for each in found.explained}


def test_noise_in_the_data_hides_no_factor_and_is_none(config, tmp_path, runs):
    found = compared(config, fields(tmp_path / "data.csv", noise=0.02))
    assert {each.verdict for each in found.findings} == {"agrees"}
    assert all(each.difference < 0.01 < 0.015 < each.quantity.scatter < 0.03 for each in found.findings)
    found = compared(config, fields(tmp_path / "data.csv", noise=0.02, factor=1.05))
    assert {each.verdict for each in found.findings} == {"differs"}
    assert "factor" in {each.name for each in found.explained}


def test_a_wrong_drag_is_called_so_with_exit_status_one(config, tmp_path, runs):
    path = numbers(tmp_path / "drag.csv", factor=1.021)
    arguments = ["compare", str(path), "--config", str(tmp_path / "array.yaml"), "--bound", "0.01"]
    shown = CliRunner().invoke(cli.app, [*arguments, "--out", str(tmp_path / "out")])
    assert shown.exit_code == 1, shown.output
    assert "drag: differs: 2.09 % too large" in shown.output
    (entry,) = json.loads((tmp_path / "out" / "comparison.json").read_text())["quantities"]
    assert entry["verdict"] == "differs"
    assert abs(entry["difference"] - 0.021 / 1.021) < entry["bar"]
    assert (tmp_path / "array_reference" / "accuracy.json").is_file()


def test_a_chain_that_is_refused_leaves_data_undecided(config, tmp_path, runs, monkeypatch):
    monkeypatch.setattr(until, "MOST_RUNS", 2)
    found = compared(config, numbers(tmp_path / "drag.csv", factor=1.0005))
    assert [each.verdict for each in found.findings] == ["undecided"]
    assert "no bar inside the goal in 2 runs" in found.findings[0].text
    with pytest.raises(ConfigError, match=r"no reference: .*--at-most"):
        compared(config, tmp_path / "drag.csv", at_most="0.001s")


def test_runs_of_the_program_judge_its_finer_run_and_are_kept(config, tmp_path):
    data = load(str(tmp_path / "array.yaml"), ["discretisation.particles_across=28", "initial.seed=1"]).resolved()
    result, message = Store(tmp_path / "data").outcome("finer", {key: data[key] for key in data if key != "name"})
    assert not message
    found = compared(config, result.folder / "samples.h5", detail=DETAIL)
    assert {each.quantity.name: each.verdict for each in found.findings} == {
        f"{name} at t = {t}": "agrees" for name in ("velocity", "pressure") for t in (0.1, 0.2)
    }
    summaries = {path: path.stat().st_mtime_ns for path in (result.folder / "reference").rglob("summary.json")}
    assert len(summaries) > 3
    assert compared(config, result.folder / "samples.h5", detail=DETAIL).agrees
    assert summaries == {path: path.stat().st_mtime_ns for path in summaries}


@pytest.mark.parametrize(
    ("difference", "bar", "noise", "expected"),
    [
        (0.02, 0.003, 0.0, "differs"),
        (0.02, 0.009, 0.0, "undecided"),  # the bar is larger than a third of the difference
        (0.009, 0.003, 0.0, "agrees"),
        (0.02, 0.03, 0.0, "undecided"),  # inside a bar that is larger than what is asked
        (0.001, 0.02, 0.0, "undecided"),
        (0.001, float("inf"), 0.0, "undecided"),
        (0.02, 0.003, 0.03, "agrees"),  # but for the scatter of the data
        (0.02, 0.003, 0.01, "undecided"),
    ],
)
def test_verdicts_need_a_bar_that_can_tell(difference, bar, noise, expected):
    assert referee.verdict(difference, bar, noise, DETAIL) == expected


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("t,drug\n0.1,1\n0.2,2\n", "none is a number of a sample; nearest: drag"),
        ("t,drag\n0.1,1\n0.3,2\n", r"0.3: is not within the run, from t = 0 to time.end = 0.2"),
        ("drag,lift\n0.1,1\n0.3,2\n", "has 2 values of drag without times"),
        ("t,drag\n0.1,0\n0.2,0\n", "no column is recognised as y"),
        ("t,x,y,u,v\n" + "0.1,0.5,0.5,1,1\n" * 9, "0 of 9 points are in the fluid"),
        ("t,y,u,v\n" + "0.1,0.1,1,1\n" * 9, "this flow needs x, too"),
    ],
)
def test_data_that_cannot_be_compared_are_refused(config, tmp_path, table, message):
    (tmp_path / "data.csv").write_text(table)
    with pytest.raises(ConfigError, match=message):
        compared(config, tmp_path / "data.csv")


def test_scatter_of_the_data_is_no_difference():
    random = np.random.default_rng(0)
    places, noise = random.uniform(0.0, 1.0, (400, 2)), 0.05 * random.standard_normal((400, 1))
    quantity = referee.Quantity("u", np.ones((400, 1)) + noise, places, np.zeros(1))
    quantity.reference = np.ones((400, 1))
    assert quantity.scatter == pytest.approx(0.05, rel=0.15)  # a standard error of 4 %, and that of neighbours
    assert quantity.difference < 0.05 * (4 / 400) ** 0.25 * 2
    quantity.data = 1.2 + noise
    assert quantity.difference == pytest.approx(0.2 / 1.2, rel=0.03)
