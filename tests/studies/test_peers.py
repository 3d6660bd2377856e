"""The peers' rows of the benchmark: how they are run, kept, and put together."""

import os

import pytest

from tisph.errors import TisphError
from tisph.studies import peers
from tisph.studies.frontier import FLOWS, GROUPS, peer_rows, peer_runs

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
    first = peers.measure(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert set(first) == set(QUICK_RUNS)
    assert sorted(calls(tmp_path)) == sorted(" ".join(run.words) for run in QUICK_RUNS)
    assert peers.measure(scripts, tmp_path / "kept", 0, QUICK_RUNS) == first
    assert len(calls(tmp_path)) == len(QUICK_RUNS)
    peers.measure(scripts, tmp_path / "kept", 1, QUICK_RUNS)
    assert len(calls(tmp_path)) == 2 * len(QUICK_RUNS)


def test_results_older_than_a_script_are_made_again(tmp_path, scripts):
    peers.measure(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    for path in (tmp_path / "kept").iterdir():
        os.utime(path, (0, 0))
    peers.measure(scripts, tmp_path / "kept", 0, QUICK_RUNS)
    assert len(calls(tmp_path)) == 2 * len(QUICK_RUNS)


def test_a_peer_that_fails_is_named_with_its_message_and_leaves_nothing(tmp_path, scripts):
    (scripts / "measure.py").write_text("import sys; sys.exit('Lost atoms')")
    with pytest.raises(TisphError, match=r"--code lammps.*Lost atoms"):
        peers.measure(scripts, tmp_path / "kept", 0, QUICK_RUNS)
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
