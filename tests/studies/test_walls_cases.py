"""The comparison of wall treatments: its runs, its rows, its recommendation and its text. Nothing is simulated."""

import math

import pytest
from fake_runs import make_result

from tisph import registry
from tisph.config import load
from tisph.studies import walls
from tisph.studies.processes import Result
from tisph.studies.store import config_text

TREATMENTS = ("comoving_image", "consistent_image")
FULL = walls.DATA["full"]


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


@pytest.mark.parametrize("flow", walls.FLOWS)
def test_every_run_is_a_valid_config_of_that_treatment_on_one_thread(flow, tmp_path):
    path = tmp_path / "run.yaml"
    for case in walls.cases(flow, registry.names("walls"), FULL):
        _, treatment, arrangement = case
        for number in FULL["resolutions"][::3]:
            config = walls.config_of(case, number)
            path.write_text(config_text(walls.name_of(case, number), config), encoding="utf-8")
            loaded = load(path)
            assert loaded.walls.treatment.type == treatment
            assert loaded.runtime.threads == 1
            assert loaded.initial.jitter == walls.ARRANGEMENTS[arrangement]
            assert loaded.time.samples[-1] == loaded.time.end
            assert round(loaded.geometry.length * number) == 10


@pytest.mark.parametrize("flow", walls.FLOWS)
def test_dimensionless_times_are_those_of_the_config(flow):
    """t* = nu t/gap^2."""
    config = walls.config_of((flow, "adami", "lattice"), 50)
    scale = config["geometry"]["gap"] ** 2 / config["fluid"]["kinematic_viscosity"]
    times = [t_star * scale for t_star in walls.FLOWS[flow]["t_star"]]
    assert config["time"]["samples"] == pytest.approx(times, rel=1e-12)


def test_a_flow_has_every_arrangement_of_every_treatment():
    expected = {("couette", name, arrangement) for name in TREATMENTS for arrangement in ("lattice", "jitter 0.2")}
    assert set(walls.cases("couette", TREATMENTS, FULL)) == expected


def test_where_the_velocity_crosses_zero_the_error_is_the_rms():
    assert {name for name, flow in walls.FLOWS.items() if flow["measure"] == "rms"} == {"backflow", "oscillating"}


def run_result(error, seconds=2.0, steps=1000, status="done"):
    """Result of a run of the driven flow with the given l2 error at t* = 0.1."""
    result = make_result(t100=error)
    shears = {
        "wall_shear_bottom": 1.01,
        "wall_shear_bottom_exact": 1.0,
        "wall_shear_top": -1,
        "wall_shear_top_exact": -1,
    }
    result.summary["samples"][0] |= shears
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


def test_the_cost_of_a_step_is_relative_to_plain_images():
    seconds = {"comoving_image": 2.0, "adami": 2.4}
    results = {(name, number): (run_result(0.1, seconds[name]), "") for name in seconds for number in (25, 50)}
    assert [row["cost"] for row in rows_of(results, seconds)] == [1.0, pytest.approx(1.2, rel=1e-12)]


def test_a_row_with_a_stopped_run_has_no_order():
    nothing = Result(None, {"status": "failed", "samples": []})
    stopped = (nothing, "diverged: u of particle 7")
    (row,) = rows_of({(25,): (run_result(0.1), ""), (50,): (run_result(0.02), ""), (100,): stopped})
    assert (row["errors"][25], row["errors"][50]) == (0.1, 0.02)
    assert math.isnan(row["errors"][100])
    assert math.isnan(row["order"])
    assert row["stopped"] == {"poiseuille-comoving_image-lattice-100": "diverged: u of particle 7"}


def test_the_smallest_geometric_mean_is_recommended():
    """Half the error in one flow outweighs a third more in another, however small the errors there."""
    first = [make_row("a", 1e-2), make_row("a", 4e-6, flow="couette")]
    second = [make_row("b", 2e-2), make_row("b", 1e-6, flow="couette")]
    assert best(*first, *second) == "b"
    assert walls.standings([*first, *second], 50)[0]["error"] == pytest.approx(2e-4, rel=1e-12)


def test_a_treatment_that_stops_somewhere_is_not_recommended():
    stopped = make_row("a", 1e-6, stopped={"poiseuille-a-lattice-100": "diverged"})
    assert best(stopped, make_row("b", 1e-2)) == "b"
    assert best(make_row("a", math.nan), make_row("b", 1e-2)) == "b"
    assert best(stopped) is None


@pytest.mark.parametrize(("cost", "chosen"), [(1.3, "a"), (1.31, "b"), (math.nan, "b")])
def test_a_treatment_that_costs_too_much_is_not_recommended(cost, chosen):
    assert best(make_row("a", 1e-6, cost=cost), make_row("b", 1e-2)) == chosen


def test_the_geometric_mean_of_the_costs_counts():
    rows = [make_row("a", 1e-6, cost=1.6), make_row("a", 1e-6, cost=1.0)]
    assert walls.standings(rows, 50)[0]["cost"] == pytest.approx(math.sqrt(1.6), rel=1e-12)
    assert best(*rows) == "a"
    assert best(make_row("a", 1e-6, cost=1.6), make_row("a", 1e-6, cost=1.1)) is None


def line_of(row):
    return dict(zip(walls.header(FULL), walls.cells(row), strict=True))


def text_below(*rows):
    found = walls.standings(rows, 50)
    name = walls.recommended(found)
    numbers = {"measured_at": 50, "recommended": name, "treatments": found, "rows": rows, "laplacians": []}
    return walls.conclusion(numbers, "picture: there").splitlines()


def test_the_table_says_what_is_compared():
    line = line_of(make_row("adami", 1.234e-3, cost=1.25, flow="backflow"))
    assert line["flow"] == "Couette-Poiseuille, backflow"
    assert line["error"] == "rms"
    assert (line["25 across"], line["50 across"]) == ("4.9e-03", "1.2e-03")
    assert (line["order"], line["wall shear"], line["S_xy"], line["cost"]) == ("2.00", "0.12 %", "", "1.25")


def test_every_cell_fits_its_column():
    room = walls.widths(FULL, TREATMENTS)
    for flow in walls.FLOWS:
        for _, treatment, arrangement in walls.cases(flow, TREATMENTS, FULL):
            row = make_row(treatment, 1e-3, flow=flow, arrangement=arrangement)
            assert all(len(cell) <= width for cell, width in zip(walls.cells(row), room, strict=True))


def test_a_run_that_stopped_shows_in_the_table_and_below_it():
    stopped = {"poiseuille-adami-lattice-50": "diverged: u of particle 7"}
    row = make_row("adami", math.nan, cost=math.nan, stopped=stopped)
    line = line_of(row)
    assert line["50 across"] == "stopped"
    assert line["cost"] == "-"
    below = text_below(row)
    assert "poiseuille-adami-lattice-50 stopped: diverged: u of particle 7" in below
    assert "| adami     |          - |         - |            1 |" in below


def test_the_recommendation_names_treatment_and_rule():
    text = text_below(make_row("consistent_image", 1e-3))[-1]
    assert text.startswith("recommended: consistent_image")
    assert "geometric mean of the errors at 50 across" in text
    assert "1.3 x comoving_image" in text
    assert text_below(make_row("consistent_image", math.nan))[-1].startswith("recommended: none")
