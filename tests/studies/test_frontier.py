"""Run time against error: points, front, and rows of the frontier."""

import json
import math
import os
import re
from itertools import combinations
from pathlib import Path

import pytest
from typer.testing import CliRunner

import tisph
from tisph.cli import app
from tisph.config import load
from tisph.errors import TisphError
from tisph.exact import cavity
from tisph.report.style import plot_style
from tisph.studies import frontier
from tisph.studies.frontier import (
    FLOWS,
    GROUPS,
    Measured,
    comparison_table,
    comparisons,
    equal_resolution,
    equal_resolution_table,
    fastest,
    figure_of,
    pareto_front,
    peer_rows,
    peer_runs,
    speedups,
    styles_of,
)

FLOW = "couette_2.7"
QUOTED = ("channel", "taylor_green")
"""Groups of flows of which some peers are quoted."""


def row(method, l2, *loops, code="tisph", flow=FLOW, quoted=False):
    return Measured(flow, method, 50, 2, 10, l2, loops, loops, code, quoted)


def lammps(l2, loop):
    return row("LAMMPS SPH, 2 processes", l2, loop, code="LAMMPS")


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


def test_times_are_medians_of_the_rounds():
    assert row("explicit", 1e-3, 5.0, 1.0, 2.0).loop == 2.0


def test_the_fastest_run_to_an_error_is_chosen_among_our_selected_settings():
    rows = [row("explicit", 9e-4, 1.0), row("implicit 4", 1e-5, 0.5), row("implicit 4", 2e-3, 0.1), lammps(1e-6, 0.01)]
    assert fastest(rows, 1e-3) == rows[1]
    assert fastest(rows, 1e-3, "explicit") == rows[0]
    assert fastest(rows, 1e-6) is None


def test_the_speedup_of_the_implicit_scheme_is_the_ratio_of_medians():
    (line,) = speedups([row("explicit", 9e-4, 4.0), row("implicit 4, fast", 5e-4, 0.1), row("implicit 4", 2e-3, 0.01)])
    assert "is 40 times faster than explicit, 50 across" in line


def test_the_speedup_of_viscoelastic_flow_is_at_equal_error():
    methods = [("explicit", 9e-4, 4.0), ("explicit", 1e-4, 8.0), ("implicit 4, fast", 5e-4, 0.5)]
    (line,) = speedups([row(*method, flow="oldroyd_b_couette") for method in methods])
    assert "error <= 0.0009: implicit 4, fast" in line
    assert "is 8 times faster than explicit" in line


def test_a_peer_is_compared_with_our_fastest_run_that_is_as_accurate():
    rows = [row("implicit 4", 2e-3, 0.1), row("implicit 4", 1e-1, 0.01), lammps(5e-2, 1.5)]
    (found,) = comparisons(rows)
    assert (found.ours, found.ratios["ratio"]) == (rows[0], pytest.approx(15.0))
    assert found.passed


def test_the_table_has_the_ratio_of_medians_and_its_range():
    rows = [row("implicit 4", 2e-3, 1.0, 1.0, 2.0), row("LAMMPS SPH", 5e-2, 15.0, 9.0, 16.0, code="LAMMPS")]
    assert "| 15 (8..15) | >= 10 | PASS |" in comparison_table(comparisons(rows))


@pytest.mark.parametrize(("flow", "bound"), [(key, bound) for key in FLOWS for bound in FLOWS[key].bounds])
def test_a_peer_that_comes_too_close_misses_the_bound(flow, bound):
    ours = row("implicit 4", 1e-3, 1.0, flow=flow)
    peer, speedup = bound["peer"], bound["speedup"]
    near, far = (row(peer, 1e-2, factor * speedup, code=peer, flow=flow) for factor in (0.99, 1.01))
    assert [found.passed for found in comparisons([ours, near, far])] == [False, True]


def test_an_error_that_we_do_not_reach_misses_the_bound():
    (found,) = comparisons([row("explicit", 1e-2, 0.1), lammps(1e-3, 100.0)])
    assert not found.passed
    assert "not reached" in comparison_table([found])


def test_peers_that_failed_are_not_compared_and_quoted_ones_not_judged():
    quoted = row("JAX-SPH, quoted", 1e-2, 0.1, code="JAX-SPH", quoted=True)
    (found,) = comparisons([row("explicit", 1e-3, 1.0), lammps(math.nan, 1.0), quoted])
    assert found.peer == quoted
    assert found.passed


def test_a_missed_bound_is_what_show_returns_and_the_files_hold(tmp_path):
    ours = row("implicit 4", 1e-3, 1.0)
    assert frontier.show(tmp_path, [ours, lammps(1e-2, 20.0)])
    assert not frontier.show(tmp_path, [ours, lammps(1e-2, 5.0)])
    numbers = json.loads((tmp_path / "frontier.json").read_text())
    assert [(one["ratio"], one["passed"]) for one in numbers["comparisons"]] == [(5.0, False)]
    assert numbers["machine"]["processor"]
    assert (tmp_path / "frontier.png").is_file()


def all_rows(group):
    """A row of every method in every flow of a group, of every peer, and of all that are quoted."""
    resolutions = frontier.DATA["resolutions"]
    ours = [row(method, 1e-4, 0.1, flow=key) for key in flows_of(group) for method in resolutions[FLOWS[key].methods]]
    peers = [row(run.label, 1e-3, 1.0, code=run.label.split()[0], flow=run.flow) for run in peer_runs(group)]
    scale = [run for run in peer_runs(group) if run.flow == "couette_20" and run.code == "lammps"]
    quoted = peer_rows([{run: {"steps": 1, "l2": 1e-3, "loop_seconds": 1.0} for run in scale}], group)
    return [*ours, *peers, *(one for one in quoted if one.quoted)]


def flows_of(group):
    return [key for key, flow in FLOWS.items() if flow.group == group]


@pytest.mark.parametrize("group", GROUPS)
def test_every_way_looks_different_and_only_what_was_measured_elsewhere_is_hollow(group):
    styles = styles_of(all_rows(group))
    assert len({(options["color"], options["marker"]) for _, options in styles.values()}) == len(styles)
    hollow = {method for method, (_, options) in styles.items() if options["markerfacecolor"] == "none"}
    assert hollow == {method for method, (kind, _) in styles.items() if kind == frontier.QUOTED}
    assert bool(hollow) == (group in QUOTED)


@pytest.mark.parametrize("flows", [*map(flows_of, GROUPS), ["couette_20"]])
def test_no_legend_of_the_picture_covers_another_or_a_panel(flows):
    rows = [one for one in all_rows(FLOWS[flows[0]].group) if one.flow in flows]
    with plot_style():
        figure = figure_of(rows, {flow: [] for flow in flows})
        figure.draw_without_rendering()
        boxes = [part.get_tightbbox() for part in (*figure.legends, *figure.axes)]
    assert len(figure.legends) == len({kind for kind, _ in styles_of(rows).values()})
    assert all(
        first.xmax <= second.xmin or second.xmax <= first.xmin or first.ymax <= second.ymin or second.ymax <= first.ymin
        for first, second in combinations(boxes, 2)
    )


def vortex(method, l2, loop, across=50, code="tisph", quoted=False):
    return Measured("taylor_green_2", method, across, 1, 10, l2, (loop,), (), code, quoted)


def test_with_as_many_particles_we_have_to_be_more_accurate_and_faster():
    edac = vortex("PySPH EDAC, 1 thread", 2e-2, 90.0, code="PySPH")

    def passed(l2, loop):
        (found,) = equal_resolution([vortex("implicit 4, balanced", l2, loop), edac])
        return found.passed

    assert [passed(9e-5, 80.0), passed(1.1e-4, 80.0), passed(9e-5, 100.0)] == [True, False, False]


def test_only_runs_of_the_rival_way_with_as_many_particles_are_compared():
    rows = [
        vortex("implicit 4, high", 1e-6, 1.0),
        vortex("implicit 4, balanced", 1e-4, 2.0),
        vortex("implicit 4, balanced", math.nan, 1.0, across=25),
        vortex("PySPH EDAC", 2e-2, 90.0, code="PySPH"),
        vortex("PySPH EDAC", 3e-2, 20.0, across=25, code="PySPH"),
        row("explicit", 1e-3, 1.0),
        lammps(1e-2, 3.0),
    ]
    (found,) = equal_resolution(rows)
    assert (found.peer, found.ours) == (rows[3], rows[1])
    assert "| 200 | 45 | error >= 200, time > 1 | PASS |" in " ".join(equal_resolution_table([found]).split())


def test_quoted_peers_of_the_vortex_are_shown_and_not_judged(tmp_path, capsys):
    rows = [vortex("implicit 4, balanced", 1e-2, 1000.0), *peer_rows([], "taylor_green")]
    assert frontier.show(tmp_path, rows)
    point, compared = [line for line in capsys.readouterr().out.splitlines() if "JAX-SPH TVF, quoted" in line]
    assert "quoted 23.000" in point
    assert compared.split("|")[-2].strip() == "-"
    numbers = json.loads((tmp_path / "frontier.json").read_text())
    assert all(point["elsewhere"] and point["steps"] is None for point in numbers["points"] if point["code"] != "tisph")


def test_a_missed_bound_at_equal_number_is_what_show_returns(tmp_path):
    fast, edac = vortex("implicit 4, fast", 1e-2, 0.1), vortex("PySPH EDAC", 2e-2, 90.0, code="PySPH")
    assert frontier.show(tmp_path, [fast, vortex("implicit 4, balanced", 1e-4, 2.0), edac])
    assert not frontier.show(tmp_path, [fast, vortex("implicit 4, balanced", 2e-4, 2.0), edac])
    assert [one["passed"] for one in json.loads((tmp_path / "frontier.json").read_text())["equal_number"]] == [False]


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
    assert CliRunner().invoke(app, ["bench", "frontier", "--flow", "annulus"]).exit_code == 2


def test_a_folder_without_the_peers_scripts_is_refused(tmp_path):
    result = CliRunner().invoke(app, ["bench", "frontier", "--peers", str(tmp_path)])
    assert result.exit_code == 2
    assert "there is no measure.py" in result.stderr


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


@pytest.mark.parametrize("name", ["throughput", "features", "startup", "scaling"])
def test_a_benchmark_that_has_moved_says_where_its_script_is(name):
    result = CliRunner().invoke(app, ["bench", name, "--configs", "configs"])
    assert result.exit_code == 2
    script = re.search(r"python (benchmarks/\w+\.py)", result.stderr)
    assert (Path(tisph.__file__).parents[1] / script[1]).is_file()


RUNS = [run for group in GROUPS for run in peer_runs(group)]
QUICK_RUNS = [run for group in GROUPS for run in peer_runs(group, quick=True)]
CHANNEL = peer_runs("channel")
SCALE = next(run for run in CHANNEL if (run.flow, run.code) == ("couette_20", "lammps"))

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


def round_of(loop_seconds):
    return {run: {"steps": 2970, "l2": 5e-2, "loop_seconds": loop_seconds} for run in CHANNEL}


def test_every_run_is_asked_for_once_and_kept(tmp_path, scripts):
    first = frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert set(first) == set(QUICK_RUNS)
    assert sorted(calls(tmp_path)) == sorted(" ".join(run.words) for run in QUICK_RUNS)
    assert frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS) == first
    assert len(calls(tmp_path)) == len(QUICK_RUNS)
    frontier.measure_peers(scripts, tmp_path / "kept", 1, QUICK_RUNS)
    assert len(calls(tmp_path)) == 2 * len(QUICK_RUNS)


def test_results_older_than_a_script_are_made_again(tmp_path, scripts):
    frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    for path in (tmp_path / "kept").iterdir():
        os.utime(path, (0, 0))
    frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert len(calls(tmp_path)) == 2 * len(QUICK_RUNS)


def test_a_peer_that_fails_is_named_with_its_message_and_leaves_nothing(tmp_path, scripts):
    (scripts / "measure.py").write_text("import sys; sys.exit('Lost atoms')")
    with pytest.raises(TisphError, match=r"--code lammps.*Lost atoms"):
        frontier.measure_peers(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert list((tmp_path / "kept").iterdir()) == []


def test_options_name_case_code_threads_resolution_and_time():
    (run,) = (run for run in CHANNEL if (run.flow, run.label) == ("couette_20", "PySPH TVF, 2 threads"))
    assert " ".join(run.words) == "--case couette --code pysph --threads 2 --across 25 --until 20.0"


def test_a_quick_round_has_the_coarsest_runs_of_the_quick_flows():
    assert {(run.flow, run.across) for run in QUICK_RUNS} == {
        ("couette_2.7", 25),
        ("taylor_green_2", 25),
        ("cavity_10", 25),
        ("cylinder", 24),
    }


def test_rows_have_all_times_and_the_name_of_the_code():
    rows = {
        (row.flow, row.method, row.across): row
        for row in peer_rows([round_of(2.0), round_of(5.0), round_of(3.0)], "channel")
    }
    row = rows["couette_2.7", "PySPH EDAC, 2 threads", 25]
    assert (row.loops, row.loop, row.code, row.ours) == ((2.0, 5.0, 3.0), 3.0, "PySPH", False)


def test_quoted_peers_are_multiples_of_lammps():
    rows = {
        row.method: row
        for row in peer_rows([{**round_of(1.0), SCALE: {"steps": 9, "l2": 0.1, "loop_seconds": 10.0}}], "channel")
    }
    quoted = rows["SPHinXsys, quoted"]
    assert (quoted.loop, quoted.quoted, quoted.flow) == (pytest.approx(5.7), True, "couette_20")


def test_nothing_is_quoted_without_the_run_that_it_scales_with():
    short = [{run: {"steps": 9, "l2": 0.1, "loop_seconds": 1.0} for run in peer_runs("channel", quick=True)}]
    assert not any(row.quoted for row in peer_rows(short, "channel"))
    assert peer_rows([], "channel") == []


def test_every_flow_with_peers_has_runs_of_them():
    assert {run.flow for run in RUNS} == {key for key, flow in FLOWS.items() if flow.peers}
    assert {run.flow for run in peer_runs("taylor_green")} == {"taylor_green_2"}


def test_vortices_are_quoted_of_codes_that_were_not_measured():
    assert {row.code for row in peer_rows([], "taylor_green")} == {"PySPH", "JAX-SPH"}
    (run,) = (run for run in peer_runs("taylor_green") if run.code == "pysph-edac" and run.across == 50)
    rows = peer_rows([{run: {"steps": 9, "l2": 0.02, "loop_seconds": 90.0}}], "taylor_green")
    assert [(row.method, row.quoted) for row in rows] == [
        ("PySPH EDAC, 1 thread", False),
        ("JAX-SPH TVF, quoted", True),
    ]
