"""Benchmarks: which points, which of them make the front, what the peers' rows are made of."""

import json
import math

import pytest
from typer.testing import CliRunner

from tisph.cli import app
from tisph.config import load
from tisph.study.bench import cases, frontier, peers
from tisph.study.bench.frontier import Measured


def row(way, l2, *loops, flow="couette_2.7"):
    return Measured(flow, way, 50, 10, l2, loops, loops)


@pytest.mark.parametrize("quick", [False, True])
def test_every_point_is_a_valid_config_of_its_own(tmp_path, quick):
    points = cases.points(quick)
    assert len({point.name for point in points}) == len(points)
    for point in points:
        path = tmp_path / "case.yaml"
        path.write_text(json.dumps(point.config))  # JSON is YAML
        assert load(path, ()).particles_across == point.across


def test_the_front_holds_what_nothing_beats_in_both_error_and_time():
    slow, fast, beaten, stopped = row("a", 1e-4, 2.0), row("b", 1e-3, 1.0), row("c", 2e-3, 3.0), row("d", math.nan, 0.1)
    assert frontier.front([slow, fast, beaten, stopped]) == [slow, fast]


def test_times_are_medians_of_the_rounds():
    assert row("explicit", 1e-3, 5.0, 1.0, 2.0).loop == 2.0


def test_the_fastest_way_to_an_error_is_sought_among_the_wanted_ones():
    rows = [row("explicit", 9e-4, 1.0), row("implicit 4", 1e-5, 0.5), row("implicit 4", 2e-3, 0.1)]
    assert frontier.fastest(rows, 1e-3, "explicit", "implicit") == rows[1]
    assert frontier.fastest(rows, 1e-3, "explicit") == rows[0]
    assert frontier.fastest(rows, 1e-6, "explicit") is None


def test_comparisons_are_ratios_of_medians():
    rows = [row("explicit", 9e-4, 4.0), row("implicit 4, fast", 5e-4, 0.1), row("LAMMPS SPH", 5e-2, 1.5)]
    lines = frontier.comparisons(rows)
    assert "is 40 times faster than explicit, 50 across" in lines[0]
    # at its own error, and at the error that is asked for
    assert sum("is 15 times faster than LAMMPS SPH" in line for line in lines) == 2


def test_quoted_peers_are_multiples_of_lammps_and_long_pysph_runs_of_short_ones():
    one = {"steps": 2970, "l2": 5e-2, "loop_seconds": 2.0}
    measured = {
        (flow, label): {**one, "loop_seconds": 10.0} if flow == "couette_20" else one
        for label, (_, _, flows) in peers.MEASURED.items()
        for flow in flows
    }
    rows = {(found.flow, found.way): found for found in peers.merged([measured])}
    quoted = rows["couette_20", "SPHinXsys, quoted"]
    assert (quoted.loop, quoted.elsewhere) == (pytest.approx(5.7), True)
    assert rows["couette_20", "PySPH TVF, 1 thread"].loop == pytest.approx(2.0 * 20 / 2.7)
    assert peers.merged([]) == []


def test_a_folder_without_the_peers_scripts_is_refused(tmp_path):
    result = CliRunner().invoke(app, ["bench", "frontier", "--peers", str(tmp_path)])
    assert result.exit_code == 2
    assert "there is no measure.py" in result.stderr
