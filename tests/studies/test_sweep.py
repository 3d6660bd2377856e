"""Sweeps: which runs a study means, one table whatever happens on the way, orders and the cheapest run."""

import csv
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from threading import Timer

import h5py
import pytest
import sweep_worker
from fake_runs import FakeRuns, sleeper
from ruamel.yaml import YAML
from sweep_worker import summary

import tisph
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError
from tisph.folder import held
from tisph.rheometry.viscometers import Reading
from tisph.studies import processes, sweep
from tisph.studies.store import fingerprint
from tisph.studies.sweep import run

CASE = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.01}
geometry: {gap: 1.0, length: 2.0}
walls: {top: {velocity: 0.5}}
time: {end: 2.0}
"""

STUDY = """\
base: case.yaml
vary:
  discretisation.particles_across: [10, 20, 40]
  time.end: {from: 1, to: 4, count: 3, spacing: log}
collect: [l2, wall_shear_top, steps]
bound: 6.0e-3
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "case.yaml").write_text(CASE)
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    return path


@pytest.fixture
def undrawn(monkeypatch):
    """Draw no picture: seconds that only one test needs."""
    monkeypatch.setattr(sweep, "plot", lambda *_: False)


@pytest.fixture
def runs(monkeypatch):
    """Stands in for the processes of `tisph run`."""
    fakes = FakeRuns(summary)
    monkeypatch.setattr(processes, "start", fakes)
    return fakes


def test_each_run_is_refined_until_its_goal_is_reached(study):
    study.write_text(f"{STUDY}until: {{wall_shear_top: 0.1%}}\n")
    assert all(case.config["accuracy"] == {"wall_shear_top": "0.1%"} for case in sweep.read(study).cases)
    study.write_text(f"{STUDY}until: {{wall_shear_top: 0}}\n")
    assert all("accuracy" in case.refusal for case in sweep.read(study).cases)


def test_keys_vary_each_with_each_or_together(study):
    together = "  'fluid.density, walls.top.velocity': [[1.0, 0.5], [2.0, 0.25]]\ncollect"
    study.write_text(STUDY.replace("bound", '"error": l2\nbound').replace("collect", together))
    found = sweep.read(study)
    assert found.keys == ("discretisation.particles_across", "time.end", "fluid.density", "walls.top.velocity")
    cases = [tuple(case.values.values()) for case in found.cases]
    assert cases[:3] == [(10, 1, 1.0, 0.5), (10, 1, 2.0, 0.25), (10, 2, 1.0, 0.5)]
    assert found.cases[1].config["walls"]["top"]["velocity"] == 0.25
    assert len(cases) == len({case.name for case in found.cases}) == 3 * 3 * 2
    assert all(case.config["runtime"]["threads"] == 1 for case in found.cases)
    assert all(case.config["runtime"]["threads"] == 1 for case in found.cases)


MISTAKES = parse((Path(__file__).parent / "data" / "mistakes.yaml").read_text(encoding="utf-8")).data["sweeps"]


@pytest.mark.parametrize(("old", "new", "says"), MISTAKES)
def test_a_study_with_a_mistake_is_one_message(study, old, new, says):
    study.write_text(STUDY.replace(old, new))
    if says == "no such file":  # of the base, in every row
        assert says in sweep.read(study).cases[0].refusal
        return
    with pytest.raises(ConfigError, match=says):
        sweep.read(study)


def test_table_order_and_cheapest_run(study, runs, tmp_path, capsys):
    rows = run(study, tmp_path / "out", 2)
    assert runs.most_at_once == 2
    lines = list(csv.DictReader((tmp_path / "out/table.csv").open()))
    assert [line["discretisation.particles_across"] for line in lines] == ["10"] * 3 + ["20"] * 3 + ["40"] * 3
    assert [float(line["l2"]) for line in lines[:3]] == pytest.approx([0.01, 0.02, 0.04])
    with h5py.File(tmp_path / "out/table.h5") as file:
        assert file["l2"][3] == float(lines[3]["l2"])
        assert file["loop_s"][0] == pytest.approx(0.01)
    printed = capsys.readouterr().out
    assert "9 runs: 9 done" in printed
    orders = sweep.orders(sweep.read(study), rows)
    assert orders["discretisation.particles_across"] == (pytest.approx(-2.0), 3)
    assert list(orders) == ["discretisation.particles_across"]  # the end of the run is no resolution
    assert "cheapest run with l2 <= 0.006: discretisation.particles_across = 20, time.end = 1" in printed
    assert (tmp_path / "out/sweep.png").stat().st_size > 10_000


def test_failed_and_refused_runs_are_rows_with_messages(study, runs, undrawn, tmp_path, capsys):
    study.write_text(STUDY.replace("[10, 20, 40]", "[10, 13, -1]").replace("count: 3", "count: 1"))
    rows = run(study, tmp_path / "out", 2)
    assert [row.status for row in rows] == ["done", "failed", "refused"]
    assert rows[1].message == "particle 7 left the channel"
    assert "particles_across = -1" in rows[2].message
    assert "refused, 1 of 3: --set discretisation.particles_across=-1: " in capsys.readouterr().out
    assert "left the channel" in (tmp_path / "out/table.csv").read_text()


def test_numbers_of_rheometry_are_collected(study, runs, undrawn, tmp_path, monkeypatch):
    class Run:
        def __init__(self, folder):
            self.folder = folder

        def rheometry(self):
            across = YAML(typ="safe").load(self.folder.with_suffix(".yaml"))["discretisation"]["particles_across"]
            if across == 20:
                raise ConfigError("not a rheometer")
            return Reading("start-up", [], {"viscosity_at_the_end": 0.1 * across}, [])

    monkeypatch.setattr(sweep, "open_run", Run)
    study.write_text(STUDY.replace("steps]", "viscosity_at_the_end]").replace("count: 3", "count: 1"))
    rows = run(study, tmp_path / "out", 1)
    assert [row.numbers["viscosity_at_the_end"] for row in rows] == [1.0, None, 4.0]
    assert [row.message for row in rows] == ["", "not a rheometer", ""]


def test_an_interrupted_sweep_keeps_what_is_done_and_goes_on(study, runs, undrawn, tmp_path, monkeypatch):
    run(study, tmp_path / "whole", 2)
    whole = (tmp_path / "whole/table.csv").read_bytes()

    write, written = sweep.write, []

    def interrupted(*arguments):
        write(*arguments)
        written.append(len(arguments[1]))
        if len(written) == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(sweep, "write", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(study, tmp_path / "out", 2)
    kept = list(csv.DictReader((tmp_path / "out/table.csv").open()))
    assert len(kept) == 4
    monkeypatch.setattr(sweep, "write", write)
    runs.configs.clear()
    run(study, tmp_path / "out", 1)
    assert len(runs.configs) == 9 - 4
    assert (tmp_path / "out/table.csv").read_bytes() == whole
    runs.configs.clear()
    run(study, tmp_path / "out", 1)
    assert runs.configs == []


def test_a_run_that_outlives_a_killed_sweep_is_waited_for(study, runs, undrawn, tmp_path):
    """Else the new run of the same name would be refused: its folder is in use."""
    study.write_text(STUDY.replace("[10, 20, 40]", "[10]").replace("count: 3", "count: 1"))
    run(study, tmp_path / "out", 1)
    (name,) = [path.name for path in (tmp_path / "out/runs").iterdir() if path.is_dir()]
    (tmp_path / "out/runs" / name / "summary.json").unlink()
    started = []
    with ExitStack() as outlived:
        outlived.enter_context(held(tmp_path / "out/runs" / name))
        Timer(0.3, lambda: (started.append(len(runs.configs)), outlived.pop_all().close())).start()
        run(study, tmp_path / "out", 1)
    assert started == [1]  # the one of the first sweep: the second did not start before the folder was free
    assert len(runs.configs) == 2


PARTS = 20


def test_the_last_of_twenty_parts_writes_the_table_of_all(study, runs, undrawn, tmp_path, capsys):
    study.write_text(STUDY.replace("[10, 20, 40]", "[10, 13, -1, 16, 20, 24]"))
    run(study, tmp_path / "whole", 2)
    whole = (tmp_path / "whole/table.csv").read_bytes()
    assert b"particle 7 left the channel" in whole
    runs.configs.clear()
    capsys.readouterr()
    for part in range(PARTS, 0, -1):
        assert not (tmp_path / "out/table.csv").exists()
        run(study, tmp_path / "out", 2, part=f"{part}/{PARTS}")
        left = 15 - len(runs.configs)
        assert (f"{left} runs of other parts are missing" in capsys.readouterr().out) is (left > 0)
        if not left:
            break
    assert (tmp_path / "out/table.csv").read_bytes() == whole
    # a whole sweep afterwards makes the failed runs again, and no others
    run(study, tmp_path / "out", 2)
    assert len(runs.configs) == 15 + 3
    assert (tmp_path / "out/table.csv").read_bytes() == whole


@pytest.mark.parametrize("part", ["0/20", "21/20", "3", "3/0", "-1/2", "a/b"])
def test_a_part_that_does_not_exist_is_refused(study, tmp_path, part):
    with pytest.raises(ConfigError, match=r"^--part .*: must be one of 1/N to N/N"):
        run(study, tmp_path / "out", 1, part=part)


def test_parts_take_about_the_same_time():
    seconds = {f"{index:03d}": 1.5**index for index in range(30)}
    parts = sweep.split(seconds, 3)
    assert sorted(name for part in parts for name in part) == sorted(seconds)
    sums = [sum(seconds[name] for name in part) for part in parts]
    assert max(sums) <= min(sums) + max(seconds.values())
    assert sweep.split(dict(reversed(seconds.items())), 3) == parts


def test_a_run_that_another_command_makes_is_not_made_again(study, runs, undrawn, tmp_path):
    run(study, tmp_path / "whole", 1)
    shutil.copytree(tmp_path / "whole/runs", tmp_path / "out/runs")
    name = next((tmp_path / "out/runs").glob("*/summary.json")).parent.name
    kept, hidden = tmp_path / "out/runs" / name, tmp_path / "hidden"
    runs.configs.clear()
    with ExitStack() as other:
        other.enter_context(held(tmp_path / "out/runs", f"{name}.lock"))
        kept.rename(hidden)
        Timer(0.3, lambda: (hidden.rename(kept), other.pop_all().close())).start()
        run(study, tmp_path / "out", 2, part="1/1")
    assert runs.configs == []
    assert (tmp_path / "out/table.csv").read_bytes() == (tmp_path / "whole/table.csv").read_bytes()


@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_any_executor_gives_the_same_table(study, runs, undrawn, tmp_path, monkeypatch, capsys, kind):
    run(study, tmp_path / "whole", 2)
    monkeypatch.setattr(sweep, "run_config", sweep_worker.stand_in)
    capsys.readouterr()
    spawned = {"mp_context": multiprocessing.get_context("spawn"), "initializer": sweep_worker.install}
    with ThreadPoolExecutor(3) if kind == "threads" else ProcessPoolExecutor(2, **spawned) as executor:
        rows = tisph.sweep(study, tmp_path / "out", executor=executor)
    assert [row["discretisation.particles_across"] for row in rows] == [10] * 3 + [20] * 3 + [40] * 3
    assert [row["l2"] for row in rows[:3]] == pytest.approx([0.01, 0.02, 0.04])
    assert (tmp_path / "out/table.csv").read_bytes() == (tmp_path / "whole/table.csv").read_bytes()
    assert capsys.readouterr() == ("", "")


@pytest.mark.skipif(os.name == "nt", reason="kills by signal")
def test_dask_with_a_killed_worker_gives_the_same_table(study, runs, undrawn, tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="Dask is an extra")
    run(study, tmp_path / "whole", 2)
    monkeypatch.undo()
    workers = []

    def start(address):
        program = Path(sweep_worker.__file__)
        workers.append(subprocess.Popen([sys.executable, str(program), address], stderr=subprocess.DEVNULL))

    write, written = sweep.write, []

    def and_kill(*arguments):
        write(*arguments)
        written.append(len(arguments[1]))
        if len(written) == 3:
            workers[0].send_signal(signal.SIGKILL)

    monkeypatch.setattr(sweep, "write", and_kill)
    # a scheduler in a process of its own would be the same to the client; here its port is known at once
    with distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=None) as cluster:
        try:
            start(cluster.scheduler_address)
            start(cluster.scheduler_address)
            with distributed.Client(cluster) as client:
                client.wait_for_workers(2, timeout=60)
            run(study, tmp_path / "out", 1, cluster.scheduler_address)
        finally:
            for worker in workers:
                worker.kill()
                worker.wait()
    assert workers[0].returncode == -signal.SIGKILL
    assert max(written) == 9
    assert (tmp_path / "out/table.csv").read_bytes() == (tmp_path / "whole/table.csv").read_bytes()
    kept = json.loads(next((tmp_path / "out/runs").glob("*/summary.json")).read_text())
    assert kept["status"] == "done"


def test_a_worker_that_dask_started_as_a_daemon_may_start_runs(monkeypatch):
    def run_config(path, folder):
        process = sleeper()
        process.terminate()
        process.join()
        return None, "ended"

    monkeypatch.setattr(sweep, "run_config", run_config)
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    assert sweep.run_on_worker("name", {}, fingerprint()) == ("name", {}, "ended")


def test_no_scheduler_is_one_message(study, tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="Dask is an extra")
    connect = sweep._imported().Client
    monkeypatch.setattr(sweep._imported(), "Client", lambda address, timeout: connect(address, timeout="1s"))
    with pytest.raises(ConfigError, match="cannot be reached"):
        run(study, tmp_path / "out", 1, "tcp://127.0.0.1:9")
