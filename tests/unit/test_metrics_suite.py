"""The verification suite: what its criteria pass and fail, its runs, its tables. Nothing is simulated."""

import json
import math
import subprocess

import h5py
import numpy as np
import pytest
from ruamel.yaml import YAML

from tisph.config import load
from tisph.errors import ConfigError
from tisph.study import verify
from tisph.verification import page, suite
from tisph.verification.criteria import Result, at_most, near, order, same_bits, same_velocities
from tisph.verification.table import format_table


def make_result(folder=None, speed=0.5, **errors):
    """Result of a run with the given l2 errors, keyed t18 for t* = 0.018."""
    samples = [
        {
            "t_star": float(key[1:]) / 1000,
            "l2": value,
            "max_transverse_velocity": 1e-7,
            "density_variation": 2e-5,
        }
        for key, value in errors.items()
    ]
    numbers = {"mach": 0.1, "sound_speed": 10 * speed}
    return Result(folder, {"status": "done", "samples": samples, "numbers": numbers})


def test_a_bound_passes_at_the_bound_and_fails_above():
    criterion = at_most("lattice", 0.018, "l2", 1.5e-3)
    assert criterion.judge(make_result(t18=1.5e-3)).passed
    assert not criterion.judge(make_result(t18=1.51e-3)).passed


def test_transverse_velocity_is_measured_in_wall_speeds():
    check = at_most("long", 1.0, "transverse", 1e-6).judge(make_result(speed=0.5, t1000=0.0))
    assert check.value == pytest.approx(2e-7, rel=1e-14)
    assert check.passed


@pytest.mark.parametrize("ours", [{}, {"t27": 1e-9}, {"t18": None}])
def test_a_run_without_the_number_fails(ours):
    """It stopped before the sample, or its velocities are not finite."""
    stopped, good = make_result(**ours), make_result(t18=1e-3)
    for criterion, results in (
        (at_most("a", 0.018, "l2", 1.0), [stopped]),
        (near("a", "b", 0.018, 0.05), [stopped, good]),
        (near("a", "b", 0.018, 0.05), [good, stopped]),
        (order("a", {"a": 25, "b": 50}, 0.018, 1.0), [good, stopped]),
    ):
        check = criterion.judge(*results)
        assert math.isnan(check.value)
        assert not check.passed


def test_nearness_is_two_sided():
    criterion = near("other", "lattice", 0.018, 0.05)
    for factor, passed in ((1.049, True), (0.951, True), (1.051, False), (0.949, False)):
        assert criterion.judge(make_result(t18=factor * 1e-3), make_result(t18=1e-3)).passed is passed


@pytest.mark.parametrize(("power", "passed"), [(1.9, True), (1.8, False)])
def test_order_is_the_power_with_which_the_error_falls(power, passed):
    resolutions = {"a": 25, "b": 50, "c": 100}
    results = [make_result(t27=3.0 * number**-power) for number in resolutions.values()]
    check = order("a/b/c", resolutions, 0.027, 1.85).judge(*results)
    assert check.value == pytest.approx(power, rel=1e-12)
    assert check.passed is passed


def make_samples(folder, u, v=0.0):
    """A results folder with one sample of three particles."""
    folder.mkdir()
    with h5py.File(folder / "samples.h5", "w") as file:
        group = file.create_group("sample_000")
        group["x"] = np.array([0.1, 0.2, 0.3])
        group["u"] = np.array([0.0, 1.0, 2.0]) + u
        group["v"] = np.full(3, v)
    return folder


def test_velocities_are_compared_in_wall_speeds(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0), speed=0.5)
    shifted = make_result(make_samples(tmp_path / "b", 1e-7), speed=0.5)
    transverse = make_result(make_samples(tmp_path / "c", 0.0, v=-1e-6), speed=0.5)
    criterion = same_velocities("si", "reference", 1e-6)
    assert criterion.judge(shifted, reference).value == pytest.approx(2e-7, rel=1e-6)
    assert criterion.judge(shifted, reference).passed
    assert criterion.judge(transverse, reference).value == pytest.approx(2e-6, rel=1e-6)
    assert not criterion.judge(transverse, reference).passed


def test_one_bit_makes_a_difference(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0))
    criterion = same_bits("repeat", "reference")
    assert criterion.judge(make_result(make_samples(tmp_path / "b", 0.0)), reference).passed
    one_bit = make_result(make_samples(tmp_path / "c", np.array([0.0, 2.3e-16, 0.0])))
    signed_zero = make_result(make_samples(tmp_path / "d", 0.0, v=-0.0))
    for different in (one_bit, signed_zero):
        assert criterion.judge(different, reference).value == 1
        assert not criterion.judge(different, reference).passed


def test_missing_arrays_are_not_equal_arrays(tmp_path):
    for criterion in (same_bits("a", "b"), same_velocities("a", "b", 1e-6)):
        nothing = make_result(tmp_path / "nothing")
        assert not criterion.judge(nothing, nothing).passed


@pytest.mark.parametrize("quick", [True, False])
def test_every_run_is_needed_and_every_needed_run_exists(quick):
    needed = {name for criterion in suite.criteria(quick) for name in criterion.runs}
    assert needed == set(suite.runs(quick))


@pytest.mark.parametrize("quick", [True, False])
def test_all_runs_are_the_same_flow(quick):
    """Re = 50 and samples at the t* that the criteria ask for."""
    runs = suite.runs(quick)
    for config in runs.values():
        walls, gap = config["walls"], config["geometry"]["gap"]
        viscosity = config["fluid"]["kinematic_viscosity"]
        speed = max(abs(walls[name]["velocity"]) for name in ("bottom", "top"))
        assert speed * gap / viscosity == pytest.approx(50, rel=1e-14)
        rows = config["discretisation"]["particles_across"]
        columns = config["geometry"]["length"] / gap * rows
        assert columns == pytest.approx(round(columns), rel=1e-12)
        assert config["time"]["end"] == config["time"]["samples"][-1]
    for criterion in suite.criteria(quick):
        if "t*" in criterion.quantity:
            t_star = float(criterion.quantity.rpartition(" ")[2])
            for name in criterion.runs:
                viscous_time = runs[name]["geometry"]["gap"] ** 2 / runs[name]["fluid"]["kinematic_viscosity"]
                times = [t / viscous_time for t in runs[name]["time"]["samples"]]
                assert any(math.isclose(time, t_star, rel_tol=1e-9) for time in times)


@pytest.mark.parametrize("quick", [True, False])
def test_every_run_is_a_valid_config(quick, tmp_path):
    for name, config in suite.runs(quick).items():
        path = tmp_path / f"{name}.yaml"
        YAML(typ="safe", pure=True).dump({"name": name, **config}, path)
        assert load(path).time.samples == tuple(config["time"]["samples"])


def test_a_table_is_aligned_markdown():
    text = format_table(("case", "l2"), [("a", "0.1"), ("longer", "12.5")])
    assert text == "| case   |   l2 |\n|:-------|-----:|\n| a      |  0.1 |\n| longer | 12.5 |"


def page_summary(status="done", **changes):
    sample = {
        "t": 1.8,
        "t_star": 0.018,
        "slope": 0.343,
        "slope_exact": 0.35,
        "intercept": -0.0973,
        "l2": 0.0013,
        "centreline": 0.0042,
        "centreline_exact": 0.0041,
        "wall_shear_bottom": 4e-11,
        "wall_shear_bottom_exact": 3.9e-11,
        "wall_shear_top": 2.1e-5,
        "wall_shear_top_exact": 2.11e-5,
        "density_variation": 2e-5,
    }
    return {
        "status": status,
        "numbers": {"reynolds": 50.0, "mach": 0.1},
        "samples": [{**sample, **changes}],
    }


def test_the_pages_slopes_stand_beside_ours():
    header, _, row = page.page_table({"re50": page_summary()}).splitlines()[:3]
    cells = dict(zip(*([cell.strip() for cell in line.split("|")] for line in (header, row)), strict=True))
    assert cells["page: slope (error)"] == "0.49 (2 %)"
    assert cells["slope"] == "0.34300"
    assert cells["off exact"] == "2 %"
    assert cells["off 0.5"] == "31 %"
    assert cells["top shear (exact) [Pa]"] == "0.0021 (0.00211)"  # 1 kg/(cm s^2) = 100 Pa
    assert cells["centreline (exact) [cm/s]"] == "0.00420 (0.00410)"


def test_rounding_errors_are_not_shown_as_numbers():
    exact = page_summary(slope=0.5 + 1e-16, slope_exact=0.5, intercept=-1e-17)
    row = page.page_table({"developed": exact}).splitlines()[2]
    assert row.count("< 1e-6 %") == 2
    assert "-0.00000" not in row


def test_the_page_table_survives_runs_that_did_not():
    """A sample that is not finite gives dashes, a run without samples its status."""
    broken = page_summary("diverged", slope=None, l2=None)
    text = page.page_table({"re50": broken, "re5": {"status": "failed", "samples": []}})
    rows = [line for line in text.splitlines() if line.startswith("| re")][1:]
    assert "re50 (diverged)" in rows[0]
    assert " - " in rows[0]
    assert "re5 (failed)" in rows[1]


@pytest.fixture
def fake_process(monkeypatch):
    """Stands in for `tisph run`: records the configs, leaves a summary with an l2 of the test's choice."""
    seen = []
    l2_by_name = {}

    def start(command, **_):
        config = YAML(typ="safe", pure=True).load(verify.Path(command[4]))
        seen.append(config)
        folder = verify.Path(command[6])
        folder.mkdir()
        if l2_by_name.get(config["name"]) == "diverged":
            return subprocess.CompletedProcess(command, 3, "", "diverged: velocity of particle 7\n")
        summary = make_result(t18=l2_by_name.get(config["name"], 1e-3)).summary
        (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(verify.subprocess, "run", start)
    return seen, l2_by_name


@pytest.fixture
def small_suite(monkeypatch):
    runs = {name: suite.runs(True)[name] for name in ("lattice", "jitter_0.2")}
    monkeypatch.setattr(suite, "runs", lambda quick: runs)
    monkeypatch.setattr(
        suite,
        "criteria",
        lambda quick: [at_most("lattice", 0.018, "l2", 1.5e-3), near("jitter_0.2", "lattice", 0.018, 0.15)],
    )
    return runs


def test_each_case_runs_once_with_its_config(fake_process, small_suite, capsys):
    seen, _ = fake_process
    assert verify.run(quick=True) is True
    assert seen == [{"name": name, **config} for name, config in small_suite.items()]
    assert capsys.readouterr().out.count("pass |") == 2


def test_a_failed_bound_fails_the_suite(fake_process, small_suite, capsys):
    fake_process[1]["jitter_0.2"] = 1.2e-3
    assert verify.run(quick=True) is False
    assert "FAIL" in capsys.readouterr().out


def test_a_diverged_run_fails_its_checks_and_says_why(fake_process, small_suite, capsys):
    fake_process[1]["jitter_0.2"] = "diverged"
    assert verify.run(quick=True) is False
    output = capsys.readouterr().out
    assert "nan" in output
    assert "jitter_0.2 did not finish: diverged: velocity of particle 7" in output


@pytest.fixture
def page_configs(monkeypatch, tmp_path):
    """A checkout with the configs of two readings, as the working directory."""
    (tmp_path / "configs").mkdir()
    for name in ("re50", "developed"):
        (tmp_path / "configs" / f"vm_sph_001_{name}.yaml").write_text(f"name: {name}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(page, "READINGS", {"re50": "water", "developed": "linear"})
    return tmp_path


def test_the_page_needs_every_reading_to_finish(fake_process, page_configs, monkeypatch, capsys):
    seen, outcomes = fake_process
    monkeypatch.setattr(page, "page_table", lambda summaries: f"table of {', '.join(summaries)}")
    assert verify.run(page=True) is True
    assert [config["name"] for config in seen] == ["re50", "developed"]
    assert "table of re50, developed" in capsys.readouterr().out
    outcomes["developed"] = "diverged"
    assert verify.run(page=True) is False
    assert "developed did not finish: diverged" in capsys.readouterr().out


def test_without_the_pages_configs_the_message_says_where_they_are(page_configs, monkeypatch):
    monkeypatch.setattr(page, "READINGS", {"no_such_reading": ""})
    with pytest.raises(ConfigError, match="vm_sph_001_no_such_reading"):
        verify.run(page=True)
