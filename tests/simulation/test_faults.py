"""Faults and interrupts: whatever ends a run, its folder can be read, and what was written is still there."""

import contextlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from faults_case import CASE, END, require_readable

from tisph import config, simulation
from tisph.errors import TisphError
from tisph.folder import Folder
from tisph.observers.history import read_history
from tisph.observers.samples import Samples, Storage, read_frames, read_samples
from tisph.report.drawing_process import DrawingProcess
from tisph.simulation import checkpoint
from tisph.simulation.recording import write_summary
from tisph.snapshot import Snapshot

pytestmark = [pytest.mark.taichi, pytest.mark.skipif(os.name == "nt", reason="sends signals")]

SUPPORT = Path(__file__).parents[1] / "support"


@pytest.fixture
def start(tmp_path):
    """Return a function that starts ``tisph run`` of the case in a process of its own, into the folder ``out``."""
    (tmp_path / "small.yaml").write_text(CASE)
    processes = []

    def call(*arguments):
        command = [sys.executable, "-m", "tisph", "run", "small.yaml", "--out", "out", *arguments]
        streams = {"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL, "text": True}
        processes.append(subprocess.Popen(command, cwd=tmp_path, **streams))
        return processes[-1]

    yield call
    for process in processes:
        process.kill()
        process.wait()
        process.stderr.close()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Results of the case without a fault, and without pictures."""
    root = tmp_path_factory.mktemp("whole")
    (root / "small.yaml").write_text(CASE)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])
        simulation.run(config.load(root / "small.yaml"), root / "out")
    return Folder(root / "out")


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path / "out")


def until_claimed(process, folder):
    """Wait until the process has taken the folder: from then on errors are its own, not Python's."""
    while not (folder.root / ".lock").exists():
        assert process.poll() is None
        time.sleep(0.001)


def until_stepping(process, folder):
    """Wait until a tenth of ``END`` is done."""
    while not folder.history.exists() or not np.any(read_history(folder.history)[0] > 0.1 * END):
        assert process.poll() is None
        time.sleep(0.005)


def ended(process, status):
    """Wait for the end of a process; return what it said, which has no traceback and at most one error."""
    said = process.communicate()[1]
    assert process.returncode == status, said
    assert "Traceback" not in said
    assert said.count("error") == (status not in (0, 130)), said
    return said


def same_results(one, other):
    """Compare the samples, frames and history of two folders bit by bit."""
    for read, path in ((read_samples, "samples"), (read_frames, "frames")):
        first, second = list(read(getattr(one, path))), list(read(getattr(other, path)))
        assert [snapshot.step for snapshot in first] == [snapshot.step for snapshot in second]
        for a, b in zip(first, second, strict=True):
            assert all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("x", "y", "u", "v", "density"))
    assert one.history.read_text() == other.history.read_text()


# --- killed


def test_a_repeatedly_killed_run_ends_bitwise_like_an_uninterrupted_one(start, folder, whole):
    draw = random.Random(1)
    moments = [("claimed", 0.8), ("stepping", 0.5), ("ending", 0.4)]
    for place, latest in moments:
        how = [] if not folder.root.exists() else ["--resume"] if folder.checkpoint.exists() else ["--overwrite"]
        process = start(*how)
        until_claimed(process, folder)
        if place != "claimed":
            until_stepping(process, folder)
        if place == "ending":
            process.stderr.read()  # to the end of what it says, which is the last step
        time.sleep(draw.uniform(0.0, latest))
        process.kill()
        process.wait()
        require_readable(folder)
    assert folder.checkpoint.exists()
    ended(start("--resume"), 0)
    same_results(folder, whole)
    assert not [*folder.root.glob("*.partial"), *folder.root.glob("*.spare")]


@pytest.mark.parametrize("kind", ["samples", "summary"])
def test_a_visible_file_is_never_modified(tmp_path, kind):
    """So that no kill between two writes, of which few fall into a test, costs what was written before."""
    storage = Storage(tmp_path / "samples", "sample_{:03d}")
    storage.start([])
    write_summary(tmp_path / "summary", {"step": -1})
    for step in range(4):
        with (tmp_path / kind).open("rb") as seen:
            before = seen.read()
            storage.add(Snapshot(float(step), step, *np.ones((6, 100))))
            write_summary(tmp_path / "summary", {"step": step})
            seen.seek(0)
            assert seen.read() == before
        assert [snapshot.step for snapshot in read_samples(tmp_path / "samples")] == list(range(step + 1))


# --- disk full, folder gone


LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits a process as Linux alone lets")


@LINUX
def test_no_write_that_fails_costs_what_was_written_before(tmp_path):
    (tmp_path / "small.yaml").write_text(CASE)
    program = [sys.executable, SUPPORT.joinpath("full_disk.py"), "small.yaml"]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr  # HDF5 would end the process
    counts = [tuple(map(int, line.split())) for line in done.stdout.splitlines()]
    assert {samples for samples, _ in counts} == {lines for _, lines in counts} == set(range(6))
    for number, expected in enumerate(counts):
        samples, frames, lines = require_readable(Folder(tmp_path / f"out{number}"))
        assert (samples, lines) == expected
        assert frames == 0


@LINUX
@pytest.mark.parametrize("limit", [0, pytest.param(30_000, marks=pytest.mark.slow)])
def test_a_run_that_cannot_write_any_more_says_so_and_loses_nothing(tmp_path, folder, whole, limit, monkeypatch):
    (tmp_path / "small.yaml").write_text(CASE)
    program = [sys.executable, SUPPORT.joinpath("limited_run.py"), str(limit), str(0.1 * END)]
    command = [*program, "run", "small.yaml", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert re.search(r"out/\w+\.(h5|csv): cannot be written: File too large", done.stderr)
    assert "Traceback" not in done.stderr
    before, after = require_readable(Folder(tmp_path / "before")), require_readable(folder)
    assert all(now >= earlier > 0 for now, earlier in zip(after, before, strict=True))
    monkeypatch.setattr("tisph.simulation.recording.begin_pictures", lambda *_: [])  # which are not compared
    simulation.run(config.load(tmp_path / "small.yaml"), folder.root, resume=True)
    same_results(folder, whole)


def test_a_folder_removed_under_a_run_is_one_error(start, folder):
    process = start("--set", "time.end=1000.0")  # longer than any machine waits
    until_stepping(process, folder)
    while folder.root.exists():  # it may write while its files are removed one by one
        with contextlib.suppress(OSError):
            shutil.rmtree(folder.root)
    said = ended(process, 1)
    assert "cannot be written: No such file or directory" in said
    assert not folder.root.exists()


# --- interrupted


@pytest.mark.parametrize(
    ("moment", "pause"),
    [
        ("stepping", 0.05),
        pytest.param("claimed", 0.0, marks=pytest.mark.slow),  # there is next to nothing to lose
        pytest.param("claimed", 0.05, marks=pytest.mark.slow),
        pytest.param("stepping", 0.0, marks=pytest.mark.slow),
    ],
)
def test_a_second_interrupt_leaves_a_readable_folder(start, folder, moment, pause):
    process = start("--set", "time.end=1000.0")  # longer than any machine waits
    until_claimed(process, folder)
    if moment == "stepping":
        until_stepping(process, folder)
    for _ in range(2):
        process.send_signal(signal.SIGINT)
        time.sleep(pause)
    said = ended(process, 130)
    require_readable(folder)
    assert ("--resume" in said) == folder.checkpoint.exists()
    if moment == "stepping":
        assert json.loads(folder.summary.read_text())["status"] == "interrupted"
        with h5py.File(folder.checkpoint) as file:
            saved = json.loads(file.attrs["host"])["steps"]
        assert saved == json.loads(folder.summary.read_text())["cost"]["steps"]


def test_an_interrupt_ends_the_coarser_runs_of_an_estimate(start, folder):
    endless = "--set", "discretisation.particles_across=28", "--set", "time.end=1000.0"
    process = start("--estimate-error", *endless)
    coarser = Folder(folder.root / "coarser" / "across_14")
    until_stepping(process, coarser)
    process.send_signal(signal.SIGINT)
    said = ended(process, 130)
    assert json.loads(coarser.summary.read_text())["status"] == "interrupted"
    assert not (coarser.root / ".lock").exists()  # no process is left that would hold it
    assert sorted(path.name for path in folder.root.iterdir()) == ["coarser"]
    assert f"partial results are in {folder.root.name}; the same command with --overwrite begins again" in said


@pytest.fixture
def interrupted_folder(tmp_path):
    (tmp_path / "small.yaml").write_text(CASE)
    return Folder(tmp_path / "out")


def test_a_second_interrupt_waits_for_the_checkpoint_and_the_summary(interrupted_folder, tmp_path, monkeypatch):
    save = checkpoint.save

    def interrupted_save(*arguments):
        signal.raise_signal(signal.SIGINT)  # first that of the config, then that of the interrupt
        save(*arguments)

    monkeypatch.setattr(checkpoint, "save", interrupted_save)
    with pytest.raises(KeyboardInterrupt):
        simulation.run(config.load(tmp_path / "small.yaml"), interrupted_folder.root)
    assert json.loads(interrupted_folder.summary.read_text())["status"] == "interrupted"
    assert not interrupted_folder.profiles_picture.exists()  # it has no time for what render can make


@pytest.mark.usefixtures("hang_up_heard")
def test_a_hang_up_leaves_results_and_a_checkpoint(interrupted_folder, tmp_path, monkeypatch):
    observe = Samples.observe

    def hung_up(self, snapshot):
        signal.raise_signal(signal.SIGHUP)
        observe(self, snapshot)

    monkeypatch.setattr(Samples, "observe", hung_up)
    settings = config.load(tmp_path / "small.yaml", ["output.video=null", "time={end: 0.02, samples: [0.01, 0.02]}"])
    with pytest.raises(KeyboardInterrupt):
        simulation.run(settings, interrupted_folder.root)
    assert json.loads(interrupted_folder.summary.read_text())["status"] == "interrupted"
    assert interrupted_folder.checkpoint.exists()
    assert require_readable(interrupted_folder)[0] == 1


def test_a_failed_picture_is_reported_once_and_loses_no_other_result(interrupted_folder, tmp_path, monkeypatch):
    gone = DrawingProcess()
    gone._process.kill()
    monkeypatch.setattr("tisph.simulation.recording.shared", lambda: gone)
    with pytest.raises(TisphError, match="the process that draws has ended"):
        simulation.run(config.load(tmp_path / "small.yaml"), interrupted_folder.root)
    assert json.loads(interrupted_folder.summary.read_text())["status"] == "done"
    assert require_readable(interrupted_folder) == (20, 40, 401)
    assert not interrupted_folder.profiles_picture.exists()


def test_an_interrupt_while_python_clears_up_is_not_heard():
    # what is registered first is called last
    program = "import atexit, signal; atexit.register(signal.raise_signal, signal.SIGINT); import tisph.cli as cli; "
    done = subprocess.run([sys.executable, "-c", program + "cli.main()", "list"], capture_output=True, text=True)
    assert done.returncode == 0
    assert done.stderr == ""
