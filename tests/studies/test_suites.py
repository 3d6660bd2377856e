"""Suites as files: ours say what they mean, a mistake in a suite of a user gets one message. Nothing is simulated."""

import json
import math
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from scipy.integrate import quad

from tisph.config import load
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError
from tisph.exact.taylor_vortices import critical_reynolds
from tisph.studies import checks, processes, suites, verify
from tisph.studies.processes import Result
from tisph.studies.suites import Suite

STOPPED = Result(Path(), {"status": "diverged", "samples": []})
WHOLE = [suites.whole(False), suites.whole(True)]
LONG = [suites.ours(name, long=True) for name in ("cavity", "free_bodies", "heat")]
EACH = pytest.mark.parametrize("suite", [*WHOLE, *LONG], ids=["whole", "quick", "cavity", "free_bodies", "heat"])


def rows(suite, case, words=""):
    return [each for each in suite.criteria if each.case == case and words in each.quantity]


@EACH
def test_runs_that_show_an_order_differ_in_their_spacing_only(suite):
    for criterion in suite.criteria:
        if "order" in criterion.quantity:
            rest = [{**suite.runs[name], "discretisation": None} for name in criterion.runs]
            assert all(config == rest[0] for config in rest)


@EACH
def test_every_run_is_needed(suite):
    assert {name for criterion in suite.criteria for name in criterion.runs} == set(suite.runs)


@EACH
def test_every_bound_accepts_what_it_says(suite):
    """A number beyond it by a hundredth does not pass, one within it by as much does."""
    ways = {"<=": 1.0, ">=": -1.0}
    for criterion in suite.criteria:
        sign, _, number = criterion.bound.partition(" ")
        if sign in ways and float(number):
            bound, way = float(number), ways[sign]
            beyond, within = (bound + side * way * 0.01 * abs(bound) for side in (1, -1))
            assert (criterion.accepts(beyond), criterion.accepts(within)) == (False, True), criterion.quantity


@EACH
def test_no_row_of_a_run_that_stopped_passes(suite):
    for criterion in suite.criteria:
        if criterion.quantity != "samples called resolved":
            assert not criterion.judge(*(STOPPED for _ in criterion.runs)).passed, criterion


@EACH
def test_every_run_is_a_valid_config(suite, tmp_path):
    for name, config in suite.runs.items():
        path = tmp_path / f"{name}.yaml"
        YAML(typ="safe", pure=True).dump({"name": name, **config}, path)
        assert load(path).time.samples == tuple(config["time"]["samples"])


@pytest.mark.parametrize("name", ["bodies", "free_bodies"])
def test_numbers_of_bodies_are_those_of_their_runs(name):
    """Constants in expressions and measures repeat the config: area, drive, load, viscosity."""
    for entry in parse((suites.FOLDER / f"{name}.yaml").read_text(encoding="utf-8")).data["checks"]:
        if not isinstance(entry.get("run"), str):
            continue
        config = suites.config_of(name, entry["run"])
        body = config["bodies"][0]
        area = math.pi * body["radius"] ** 2 if "radius" in body else None
        if "with" in entry and "area" in entry["with"]:
            assert entry["with"]["area"] == pytest.approx(area, rel=1e-9)
            assert entry["with"]["density"] == body["density"]
        if "number" in entry and "drag + " in entry["number"] and "*" in entry["number"]:
            drive, solid = entry["number"].split("(drag + ")[1].split(")")[0].split("*")
            assert float(drive) == config["drive"]["acceleration"]
            assert float(solid) == pytest.approx(area, rel=1e-9)
        if entry.get("called") == "stress of the walls":
            scale = 2 * config["geometry"]["length"] * config["fluid"]["kinematic_viscosity"]
            assert float(entry["number"].rpartition("/")[2]) == pytest.approx(scale)


def test_released_bodies_have_the_acceleration_of_their_added_mass():
    """-(rho - 1)/(rho + C), C = (1 - phi - s)/phi; Maxwell's s = (1 - phi)/(1 + phi) has an error of some phi^5."""
    phi = math.pi / 16
    inner = 0.305827 * phi**4 / (1.0 - 1.402958 * phi**8) + 0.013362 * phi**8
    added = (1.0 - phi - (1.0 - 2.0 * phi / (1.0 + phi - inner))) / phi
    for density in (0.0, 0.1, 0.5, 2.0, 1000.0):
        for row in rows(WHOLE[0], f"released_{density:g}"):
            acceleration = -(density - 1.0) / (density + added)
            t = float(row.quantity.rpartition(" ")[2])
            sample = {"t": t, "v": acceleration * t}
            assert row.judge(Result(Path(), {"status": "done", "samples": [sample]})).value < 1e-11


def test_an_ellipse_turns_once_in_the_time_of_its_series():
    """17.11633 over shear rate; the coefficients have six digits, the slowest rotation is 0.17."""
    (row,) = rows(WHOLE[0], "ellipse_0")

    def rate(angle):
        """The angular velocity of which the row says that it is off by nothing: off = |1/series - 1| for 1."""
        result = Result(Path(), {"status": "done", "samples": [{"angle": angle, "angular_velocity": -1e-9}]})
        return -1e-9 / (1.0 - row.judge(result).value)

    time, _ = quad(lambda angle: -1 / rate(angle), 0.0, 2 * math.pi)
    assert time == pytest.approx(17.11633, rel=2e-5)


def test_critical_runs_are_around_the_critical_reynolds_number():
    for name, ratio, wave in (("0.5", 0.5, 3.16248), ("0.714", 5 / 7, 3.13780), ("0.883", 0.883, 3.12928)):
        critical = critical_reynolds(ratio, wave)
        for part in (0.95, 1.0, 1.05):
            config = suites.config_of("axisymmetric", f"critical_{name}_{part:g}")
            assert 1.0 / config["fluid"]["kinematic_viscosity"] == pytest.approx(part * critical, rel=1e-10)
        assert f"{critical:.6g}" in rows(WHOLE[0], f"ratio {name}")[0].quantity


def test_drag_of_a_confined_cylinder_is_read_at_its_weissenberg_number():
    """117.78 at Wi = 0.6 (Hulsen et al. 2005), over viscosity and velocity; the drive pushes the area, pi, too."""
    (row,) = rows(WHOLE[0], "confined_cylinder")
    config = WHOLE[0].runs["confined_cylinder"]
    velocity = 0.6 / config["fluid"]["rheology"]["relaxation_time"]
    force = 117.78 * config["fluid"]["kinematic_viscosity"] * velocity
    sample = {"superficial_velocity": velocity, "drag": force - math.pi * config["drive"]["acceleration"]}
    assert row.judge(Result(Path(), {"status": "done", "samples": [sample]})).value == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("status", "resolved", "passed"),
    [("done", [False, False], True), ("done", [False, True], False), ("failed", [], False)],
)
def test_a_cavity_with_too_few_particles_is_not_resolved(status, resolved, passed):
    (row,) = rows(LONG[0], "cavity_re10000_100")
    assert LONG[0].runs[row.case]["fluid"]["kinematic_viscosity"] == 1e-4
    summary = {"status": status, "samples": [{"resolved": each} for each in resolved]}
    assert row.judge(Result(Path(), summary)).passed == passed


@pytest.fixture
def small_suite(monkeypatch):
    runs = {name: suites.ours("couette", quick=True).runs[name] for name in ("lattice", "jitter_0.2")}
    entries = [
        {"run": "lattice", "t_star": 0.018, "at_most": {"l2": 1.5e-3}},
        {"run": "jitter_0.2", "near": "lattice", "t_star": 0.018, "within": {"l2": 0.15}},
    ]
    criteria = [one for entry in entries for one in checks.criteria(entry, set(runs))]
    monkeypatch.setattr(suites, "whole", lambda quick: Suite("", runs, criteria))
    monkeypatch.setattr(suites, "ours", lambda *_: Suite("", runs, criteria))
    return runs


def test_each_case_runs_once_with_its_config(fake_process, small_suite, capsys):
    seen, _ = fake_process
    assert verify.run(quick=True) is True
    assert seen == [{"name": name, **config} for name, config in small_suite.items()]
    output = capsys.readouterr().out
    assert output.count("pass |") == 2
    assert output.endswith("\n\n2 of 2 rows passed\n")


def test_only_a_run_that_is_asked_to_states_its_error(fake_process, small_suite, tmp_path, monkeypatch):
    start, asked = processes.start, {}

    def listening(arguments, messages):
        asked[arguments[1].stem] = "--estimate-error" in arguments
        return start(arguments, messages)

    monkeypatch.setattr(processes, "start", listening)
    runner = verify.Runner(Suite("", small_suite, [], estimated={"lattice"}), tmp_path)
    for name in small_suite:
        runner.result(name)
    assert asked == {"lattice": True, "jitter_0.2": False}


DIVERGED = "diverged: velocity of particle 7"


@pytest.mark.parametrize(
    ("outcome", "said"),
    [
        (1.2e-3, ["FAIL |", "\n1 of 2 rows passed; FAIL: jitter_0.2 l2 off lattice at t* = 0.018\n"]),
        (DIVERGED, ["nan", f"jitter_0.2: did not finish: {DIVERGED}"]),
    ],
)
def test_a_bound_that_fails_and_a_run_that_diverges_fail_the_suite(fake_process, small_suite, capsys, outcome, said):
    fake_process[1]["jitter_0.2"] = outcome
    assert verify.run(quick=True) is False
    output = capsys.readouterr().out
    assert [text for text in said if text not in output] == []


def test_all_checks_are_printed_as_json(fake_process, small_suite, capsys):
    fake_process[1]["jitter_0.2"] = DIVERGED
    assert verify.run(quick=True, as_json=True) is False
    found = json.loads(capsys.readouterr().out)
    assert [(row["passed"], row["value"] is None) for row in found["checks"]] == [(True, False), (False, True)]
    assert found["failures"] == {"jitter_0.2": f"did not finish: {DIVERGED}"}


def test_a_suite_with_a_folder_takes_finished_runs_from_there(fake_process, small_suite, tmp_path, capsys):
    seen, l2 = fake_process
    assert verify.run("couette", quick=True, out=tmp_path / "kept") is True
    first = capsys.readouterr().out
    l2["lattice"] = 1.0  # were it run again it would fail
    assert verify.run("couette", quick=True, out=tmp_path / "kept") is True
    assert capsys.readouterr().out == first
    assert len(seen) == len(small_suite)
    assert verify.run("couette", quick=True) is False  # nothing is kept without one


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "couette", "long": True}, "--long: couette has no long section"),
        ({"name": "manufactured", "long": True}, "--long: manufactured has no long section"),
        ({"name": "no_such.yaml"}, "no_such.yaml: cannot be read: No such file"),
    ],
)
def test_a_suite_that_does_not_exist_is_refused(arguments, message):
    with pytest.raises(ConfigError, match=message):
        verify.suite_of(**arguments)


GOOD = """\
title: Mine
base: flow.yaml
runs:
  coarse: {samples: [0.1]}
  fine: {like: coarse, discretisation.particles_across: 32}
checks:
  - {order: l2, runs: {coarse: 16, fine: 32}, t: 0.1, at_least: 3}
"""
FLOW = """\
name: flow
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {gap: 1.0, length: 1.0}
walls: {bottom: {velocity: 0.0}, top: {velocity: 1.0}}
discretisation: {particles_across: 16}
time: {end: 1.0}
"""


MISTAKES = parse((Path(__file__).parent / "data" / "mistakes.yaml").read_text(encoding="utf-8")).data["suites"]


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES)
def test_a_mistake_in_a_suite_names_file_line_key_and_fix(old, new, message, tmp_path):
    (tmp_path / "flow.yaml").write_text(FLOW)
    (tmp_path / "mine.yaml").write_text(GOOD.replace(old, new))
    with pytest.raises(ConfigError, match=message):
        verify.suite_of(str(tmp_path / "mine.yaml"))


def test_quick_and_long_sections_have_runs_and_checks_of_their_own(tmp_path):
    (tmp_path / "flow.yaml").write_text(FLOW)
    section = "quick:\n  checks:\n    - {run: coarse, t: 0.1, at_most: {l2: 1.0}}\n"
    (tmp_path / "mine.yaml").write_text(GOOD + section)
    assert set(suites.read(tmp_path / "mine.yaml", quick=True).runs) == {"coarse"}
    assert set(suites.read(tmp_path / "mine.yaml").runs) == {"coarse", "fine"}
    with pytest.raises(ConfigError, match="mine has no long section"):
        suites.read(tmp_path / "mine.yaml", long=True)
