"""A run in this process that is interrupted at the worst moment, or cannot draw: what is left is whole."""

import json
import os
import signal
import subprocess
import sys

import pytest
from faults_case import CASE, require_readable

from tisph import config, simulation
from tisph.errors import TisphError
from tisph.folder import Folder
from tisph.observers.samples import Samples
from tisph.report.drawing_process import DrawingProcess
from tisph.simulation import checkpoint

pytestmark = [pytest.mark.taichi, pytest.mark.skipif(os.name == "nt", reason="sends signals")]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "small.yaml").write_text(CASE)
    return Folder(tmp_path / "out")


def test_a_second_interrupt_waits_for_the_checkpoint_and_the_summary(folder, tmp_path, monkeypatch):
    save = checkpoint.save

    def interrupted_save(*arguments):
        signal.raise_signal(signal.SIGINT)  # first that of the config, then that of the interrupt
        save(*arguments)

    monkeypatch.setattr(checkpoint, "save", interrupted_save)
    with pytest.raises(KeyboardInterrupt):
        simulation.run(config.load(tmp_path / "small.yaml"), folder.root)
    assert json.loads(folder.summary.read_text())["status"] == "interrupted"
    assert not folder.profiles_picture.exists()  # it has no time for what render can make


@pytest.mark.usefixtures("hang_up_heard")
def test_a_hang_up_leaves_results_and_a_checkpoint(folder, tmp_path, monkeypatch):
    observe = Samples.observe

    def hung_up(self, snapshot):
        signal.raise_signal(signal.SIGHUP)
        observe(self, snapshot)

    monkeypatch.setattr(Samples, "observe", hung_up)
    settings = config.load(tmp_path / "small.yaml", ["output.video=null", "time={end: 0.02, samples: [0.01, 0.02]}"])
    with pytest.raises(KeyboardInterrupt):
        simulation.run(settings, folder.root)
    assert json.loads(folder.summary.read_text())["status"] == "interrupted"
    assert folder.checkpoint.exists()
    assert require_readable(folder)[0] == 1


def test_a_failed_picture_is_reported_once_and_loses_no_other_result(folder, tmp_path, monkeypatch):
    gone = DrawingProcess()
    gone._process.kill()
    monkeypatch.setattr("tisph.simulation.recording.shared", lambda: gone)
    with pytest.raises(TisphError, match="the process that draws has ended"):
        simulation.run(config.load(tmp_path / "small.yaml"), folder.root)
    assert json.loads(folder.summary.read_text())["status"] == "done"
    assert require_readable(folder) == (20, 40, 401)
    assert not folder.profiles_picture.exists()


def test_an_interrupt_while_python_clears_up_is_not_heard():
    # what is registered first is called last
    program = "import atexit, signal; atexit.register(signal.raise_signal, signal.SIGINT); import tisph.cli as cli; "
    done = subprocess.run([sys.executable, "-c", program + "cli.main()", "list"], capture_output=True, text=True)
    assert done.returncode == 0
    assert done.stderr == ""
