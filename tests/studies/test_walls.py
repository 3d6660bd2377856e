"""The comparison of wall treatments: its runs, rows, recommendation and text. Nothing is simulated."""

import math

import pytest
from fake_runs import FakeRuns, make_result

from tisph import registry
from tisph.studies import processes, store, walls
from tisph.studies.processes import Result

TREATMENTS = ["comoving_image", "consistent_image"]
SMALL = {"resolutions": [25, 50], "measured_at": 50, "arrangements": ["lattice", "jitter 0.2"]}
RUNS_OF_A_FLOW = 2 * 2 * 2
LAPLACIAN = {"treatment": "comoving_image", "profile": "bent", "arrangement": "lattice", "kernel": "quintic_spline"}
LAPLACIAN |= {"ratio": 1.0, "errors": {25: (0.1, 0.0), 50: (0.4, 0.0)}, "orders": [-2.0, math.nan]}


@pytest.fixture
def runs(monkeypatch):
    """Runs of two flows with two treatments, whose errors fall with the second order."""

    def summary(config):
        across = config["discretisation"]["particles_across"]
        consistent = config["walls"]["treatment"]["type"] == "consistent_image"
        error = (0.5 if consistent else 1.0) / across**2
        shears = {f"wall_shear_{wall}{end}": 1.0 for wall in ("bottom", "top") for end in ("", "_exact")}
        result = make_result(t27=error, t100=error).summary
        for sample in result["samples"]:
            sample |= {**shears, "rms": error}
        return {**result, "cost": {"wall_loop_s": 1.2 if consistent else 1.0, "steps": 1000}}

    fake = FakeRuns(summary)
    monkeypatch.setattr(processes, "start", fake)
    monkeypatch.setattr(processes, "POLL_SECONDS", 0.0)
    monkeypatch.setattr(registry, "names", lambda family: TREATMENTS)
    monkeypatch.setitem(walls.DATA, "full", SMALL)
    flows = {name: walls.FLOWS[name] for name in ("couette", "poiseuille")}
    monkeypatch.setattr(walls, "FLOWS", flows)
    monkeypatch.setattr(walls, "laplacians", lambda treatments, resolutions: [LAPLACIAN])
    return fake


def test_a_comparison_runs_each_case_once_and_goes_on_where_it_was(runs, tmp_path, monkeypatch):
    monkeypatch.setattr(walls, "plot_walls", lambda path, rows, laplacians: None)
    assert walls.run(tmp_path) is True
    assert len({config["name"] for config in runs.configs}) == len(runs.configs) == 2 * RUNS_OF_A_FLOW
    assert walls.run(tmp_path) is True
    assert len(runs.configs) == 2 * RUNS_OF_A_FLOW


def test_a_run_that_diverged_is_kept_and_one_that_failed_is_not(runs, tmp_path):
    keeper = store.Store(tmp_path / "runs")
    for status, kept in (("diverged", True), ("done", True), ("failed", False), ("interrupted", False)):
        runs.summary = lambda config, status=status: {"status": status, "message": "why", "samples": []}
        keeper.launch(status, {}).outcome()
        assert (keeper.kept(status, {}) is not None) is kept


def test_without_any_treatment_that_finishes_the_comparison_fails(runs, tmp_path, capsys):
    runs.summary = lambda config: "refused"
    assert walls.run(tmp_path) is False
    assert "recommended: none" in capsys.readouterr().out
    assert (tmp_path / "verify_walls.png").is_file()


def make_row(treatment, error, cost=1.0, flow="poiseuille", arrangement="lattice", stopped=()):
    return {
        "case": {"flow": flow, "treatment": treatment, "arrangement": arrangement},
        "errors": {12: 16 * error, 25: 4 * error, 50: error, 100: error / 4},
        "order": 2.0,
        "wall_shear": 0.0012,
        "stress_error": None,
        "cost": cost,
        "stopped": dict(stopped),
        "measure": walls.FLOWS[flow]["measure"],
    }


def best(*rows):
    return walls.recommended(walls.standings(rows, 50))


def run_result(error, seconds=2.0, steps=1000, status="done"):
    """Result of a run of the driven flow with the given l2 error at t* = 0.1."""
    result = make_result(t100=error)
    bottom = {"wall_shear_bottom": 1.01, "wall_shear_bottom_exact": 1.0}
    result.summary["samples"][0] |= {**bottom, "wall_shear_top": -1, "wall_shear_top_exact": -1}
    return Result(None, {**result.summary, "status": status, "cost": {"wall_loop_s": seconds, "steps": steps}})


def rows_of(results, treatments=("comoving_image",), measured_at=50):
    """Rows of the driven flow from a lattice; ``results`` by particles across, or by treatment and these."""
    extent = {"resolutions": list({key[-1]: 0 for key in results}), "measured_at": measured_at}
    cases = [("poiseuille", name, "lattice") for name in treatments]
    outcomes = {
        walls.name_of(case, number): results.get((case[1], number), results.get((number,)))
        for case in cases
        for number in extent["resolutions"]
    }
    return list(walls.rows_of(cases, outcomes, extent))


def test_a_row_is_read_from_its_runs():
    (row,) = rows_of({(number,): (run_result(number**-1.5), "") for number in (25, 50, 100)})
    assert row["errors"][50] == 50**-1.5
    assert row["order"] == pytest.approx(1.5, rel=1e-12)
    assert row["wall_shear"] == pytest.approx(0.01, rel=1e-12)
    assert row["stress_error"] is None
    assert row["stopped"] == {}


def test_the_largest_error_of_all_times_counts(monkeypatch):
    later = run_result(0.01)
    later.summary["samples"].append({**later.summary["samples"][0], "t_star": 0.2, "l2": 0.03})
    monkeypatch.setitem(walls.FLOWS["poiseuille"], "t_star", [0.1, 0.2])
    (row,) = rows_of({(number,): (later, "") for number in (25, 50)})
    assert row["errors"] == {25: 0.03, 50: 0.03}


def test_the_smallest_geometric_mean_is_recommended():
    """Half the error in one flow outweighs a third more in another, however small the errors there."""
    first = [make_row("a", 1e-2), make_row("a", 4e-6, flow="couette")]
    second = [make_row("b", 2e-2), make_row("b", 1e-6, flow="couette")]
    assert best(*first, *second) == "b"
    assert walls.standings([*first, *second], 50)[0]["error"] == pytest.approx(2e-4, rel=1e-12)


@pytest.mark.parametrize(
    ("row", "chosen"),
    [
        (make_row("a", 1e-6, stopped={"poiseuille-a-lattice-100": "diverged"}), "b"),
        (make_row("a", math.nan), "b"),
        (make_row("a", 1e-6, cost=1.3), "a"),
        (make_row("a", 1e-6, cost=1.31), "b"),
        (make_row("a", 1e-6, cost=math.nan), "b"),
    ],
)
def test_treatments_that_stop_or_cost_too_much_are_not_recommended(row, chosen):
    assert best(row, make_row("b", 1e-2)) == chosen
    assert best(row) == ("a" if chosen == "a" else None)
