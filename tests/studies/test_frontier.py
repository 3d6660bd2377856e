"""Run time against error: points, front, and rows of the frontier."""

import json
import math

import pytest
from typer.testing import CliRunner

from tisph.cli import app
from tisph.config import load
from tisph.errors import TisphError
from tisph.exact import cavity
from tisph.studies import frontier
from tisph.studies.frontier import (
    FLOWS,
    GROUPS,
    Measured,
    comparison_table,
    comparisons,
    equal_resolution,
    fastest,
    pareto_front,
    peer_rows,
    peer_runs,
    speedups,
)

FLOW = "couette_2.7"


def row(method, l2, *loops, code="tisph", flow=FLOW, quoted=False):
    return Measured(flow, method, 50, 2, 10, l2, loops, loops, code, quoted)


def lammps(l2, *loops):
    return row("LAMMPS SPH, 2 processes", l2, *loops, code="LAMMPS")


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("group", GROUPS)
def test_every_point_is_a_valid_config_of_its_own(tmp_path, group, quick):
    points = frontier.points(group, quick)
    assert len({point.name for point in points}) == len(points)
    for point in points:
        path = tmp_path / "case.yaml"
        path.write_text(json.dumps(point.config))  # JSON is YAML
        assert load(path, ()).particles_across == point.across


def test_the_front_holds_what_nothing_beats_in_both_error_and_time():
    slow, fast, beaten, stopped = row("a", 1e-4, 2.0), row("b", 1e-3, 1.0), row("c", 2e-3, 3.0), row("d", math.nan, 0.1)
    assert pareto_front([slow, fast, beaten, stopped]) == [slow, fast]


def test_the_fastest_run_to_an_error_is_chosen_among_our_selected_settings():
    rows = [row("explicit", 9e-4, 1.0), row("implicit 4", 1e-5, 0.5), row("implicit 4", 2e-3, 0.1), lammps(1e-6, 0.01)]
    assert fastest(rows, 1e-3) == rows[1]
    assert fastest(rows, 1e-3, "explicit") == rows[0]
    assert fastest(rows, 1e-6) is None


def test_a_peer_is_compared_with_our_fastest_run_that_is_as_accurate():
    rows = [row("implicit 4", 2e-3, 1.0, 1.0, 2.0), row("implicit 4", 1e-1, 0.01), lammps(5e-2, 15.0, 9.0, 16.0)]
    (found,) = comparisons(rows)
    assert (found.ours, found.ratios["ratio"], found.passed) == (rows[0], pytest.approx(15.0), True)
    assert "| 15 (8..15) | >= 10 | PASS |" in comparison_table([found])  # of medians, and its range
    (line,) = speedups([row("explicit", 9e-4, 4.0), row("implicit 4, fast", 5e-4, 0.1), row("implicit 4", 2e-3, 0.01)])
    assert "is 40 times faster than explicit, 50 across" in line


@pytest.mark.parametrize(("flow", "bound"), [(key, bound) for key in FLOWS for bound in FLOWS[key].bounds])
def test_a_peer_that_comes_too_close_misses_the_bound(flow, bound):
    ours = row("implicit 4", 1e-3, 1.0, flow=flow)
    peer, speedup = bound["peer"], bound["speedup"]
    near, far = (row(peer, 1e-2, factor * speedup, code=peer, flow=flow) for factor in (0.99, 1.01))
    assert [found.passed for found in comparisons([ours, near, far])] == [False, True]


def test_a_missed_bound_is_what_show_returns_and_the_files_hold(tmp_path):
    ours = row("implicit 4", 1e-3, 1.0)
    assert frontier.show(tmp_path, [ours, lammps(1e-2, 20.0)])
    assert not frontier.show(tmp_path, [ours, lammps(1e-2, 5.0)])
    numbers = json.loads((tmp_path / "frontier.json").read_text())
    assert [(one["ratio"], one["passed"]) for one in numbers["comparisons"]] == [(5.0, False)]
    assert numbers["machine"]["processor"]
    assert (tmp_path / "frontier.png").is_file()


def vortex(method, l2, loop, across=50, code="tisph", quoted=False):
    return Measured("taylor_green_2", method, across, 1, 10, l2, (loop,), (), code, quoted)


def test_with_as_many_particles_we_have_to_be_more_accurate_and_faster():
    edac = vortex("PySPH EDAC, 1 thread", 2e-2, 90.0, code="PySPH")

    def passed(l2, loop):
        (found,) = equal_resolution([vortex("implicit 4, balanced", l2, loop), edac])
        return found.passed

    assert [passed(9e-5, 80.0), passed(1.1e-4, 80.0), passed(9e-5, 100.0)] == [True, False, False]


def test_each_flow_has_the_error_that_its_title_names():
    def error(flow, **sample):
        return FLOWS[flow].error_of(sample)

    known = cavity.extremes(100.0)
    exact = {"u_extreme": known["u_min"], "v_min": known["v_min"], "v_max": known["v_max"]}
    assert error("cavity_10", **exact) == 0.0
    assert error("cavity_10", **{**exact, "v_max": 1.03 * known["v_max"]}) == pytest.approx(0.03)
    assert error("cylinder", drag=1068.12, superficial_velocity=0.5) == pytest.approx(1.0)
    assert error("circular_couette_2", l2=1e-3) == 1e-3
    assert math.isnan(error("circular_couette_2", l2=None))
    assert error("oldroyd_b_couette", l2=1e-5, shear_stress_l2=3e-5, normal_stress_l2=2e-5) == 3e-5
    assert math.isnan(error("oldroyd_b_couette", l2=1e-5, shear_stress_l2=3e-5, normal_stress_l2=None))
    assert error("oldroyd_b_cylinders", l2=1e-3, torque_inner=1.01, torque_inner_exact=1.0) == pytest.approx(0.01)


QUICK_RUNS = [run for group in GROUPS for run in peer_runs(group, quick=True)]

SCRIPT = """
import json, pathlib, sys
with open(pathlib.Path(__file__).parent.parent / "calls", "a") as stream:
    print(*sys.argv[1:], file=stream)
print(json.dumps({"steps": 3, "l2": 0.1, "loop_seconds": 2.0}))
"""


@pytest.fixture
def scripts(tmp_path):
    """A folder with a script in place of that which runs the peers; it lists its calls in ``calls`` beside it."""
    folder = tmp_path / "scripts"
    folder.mkdir()
    (folder / "measure.py").write_text(SCRIPT)
    return folder


def calls(tmp_path):
    return (tmp_path / "calls").read_text().splitlines()


def test_every_run_is_asked_for_once_and_kept(tmp_path, scripts):
    first = frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert set(first) == set(QUICK_RUNS)
    assert sorted(calls(tmp_path)) == sorted(" ".join(run.words) for run in QUICK_RUNS)
    assert frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS) == first
    assert len(calls(tmp_path)) == len(QUICK_RUNS)
    frontier.measure_peers(scripts, tmp_path / "kept", 1, QUICK_RUNS)
    assert len(calls(tmp_path)) == 2 * len(QUICK_RUNS)


def test_a_peer_that_fails_is_named_with_its_message_and_leaves_nothing(tmp_path, scripts):
    (scripts / "measure.py").write_text("import sys; sys.exit('Lost atoms')")
    with pytest.raises(TisphError, match=r"--code lammps.*Lost atoms"):
        frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert list((tmp_path / "kept").iterdir()) == []


CHANNEL = peer_runs("channel")
SCALE = next(run for run in CHANNEL if (run.flow, run.code) == ("couette_20", "lammps"))


def test_quoted_peers_are_multiples_of_lammps_and_none_without_it():
    done = {run: {"steps": 2970, "l2": 5e-2, "loop_seconds": 1.0} for run in CHANNEL}
    rows = peer_rows([{**done, SCALE: {"steps": 9, "l2": 0.1, "loop_seconds": 10.0}}], "channel")
    (quoted,) = (row for row in rows if row.method == "SPHinXsys, quoted")
    assert (quoted.loop, quoted.quoted, quoted.flow) == (pytest.approx(5.7), True, "couette_20")
    short = [{run: {"steps": 9, "l2": 0.1, "loop_seconds": 1.0} for run in peer_runs("channel", quick=True)}]
    assert not any(row.quoted for row in peer_rows(short, "channel"))
    assert peer_rows([], "channel") == []


def test_quoted_peers_of_the_vortex_are_shown_and_not_judged(tmp_path, capsys):
    rows = [vortex("implicit 4, balanced", 1e-2, 1000.0), *peer_rows([], "taylor_green")]
    assert frontier.show(tmp_path, rows)
    point, compared = [line for line in capsys.readouterr().out.splitlines() if "JAX-SPH TVF, quoted" in line]
    assert "quoted 23.000" in point
    assert compared.split("|")[-2].strip() == "-"
    numbers = json.loads((tmp_path / "frontier.json").read_text())
    assert all(point["elsewhere"] and point["steps"] is None for point in numbers["points"] if point["code"] != "tisph")


def test_the_groups_of_the_command_line_are_those_that_there_are(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        frontier, "run", lambda folder, **options: asked.append((folder.name, options["group"])) or True
    )
    for group in GROUPS:
        assert CliRunner().invoke(app, ["bench", "frontier", "--flow", group]).exit_code == 0
    assert CliRunner().invoke(app, ["bench"]).exit_code == 0
    others = [(f"frontier_{group}", group) for group in GROUPS if group != "channel"]
    assert asked == [("frontier", "channel"), *others, ("frontier", "channel")]
