"""Runs of a study as processes: what ends the study ends them."""

import os
import signal
import subprocess
import sys

import pytest

STUDY = """
import multiprocessing, sys, time
from pathlib import Path
import typer
from tisph.cli.terminal import reported
from tisph.studies import processes

def sleeper(*_):
    processes.prepare()
    process = multiprocessing.get_context(processes.METHOD).Process(target=time.sleep, args=(600,))
    process.start()
    return process

processes.start = sleeper

class Named(processes.Process):
    @property
    def finished(self):  # asked for as soon as the study knows of the run
        print(self._process.pid, flush=True)
        return super().finished

try:
    reported(lambda: list(processes.run_side_by_side(["run"], lambda name: Named("config.yaml", Path(name)), 1)))()
except typer.Exit as ending:
    sys.exit(ending.exit_code)
"""


@pytest.mark.skipif(os.name == "nt", reason="sends signals")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_study_that_is_ended_leaves_no_run_behind(number):
    with subprocess.Popen([sys.executable, "-c", STUDY], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as study:
        run = int(study.stdout.readline())
        study.send_signal(number)
        _, errors = study.communicate()
    assert study.returncode == 130
    assert errors.decode().strip() == "interrupted"
    with pytest.raises(ProcessLookupError):
        os.kill(run, 0)
