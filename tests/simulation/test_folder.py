"""A folder is held by one process at a time, and what holds it leaves nothing behind."""

import os
import shutil
import subprocess
import sys

import pytest
from filelock import FileLock, Timeout

from tisph.folder import LOCK, held

WORKER = """
import os, sys, time
from pathlib import Path
from filelock import Timeout
from tisph.folder import held

root, tries = Path(sys.argv[1]), 0
while tries < 40:
    try:
        with held(root):
            os.close(os.open(root / "inside", os.O_CREAT | os.O_EXCL))  # fails where another one is inside
            tries += 1
            os.unlink(root / "inside")
    except Timeout:
        pass
"""


def test_is_made_held_and_left_without_a_trace(tmp_path):
    root = tmp_path / "a" / "b"
    for _ in range(2):
        with held(root):
            assert [path.name for path in root.iterdir()] == [LOCK]
            with pytest.raises(Timeout), held(root):
                pass
            assert (root / LOCK).exists()
        assert list(root.iterdir()) == []
        (root / LOCK).write_text("")  # as a killed process leaves it


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps a file that is open")
def test_whoever_has_opened_the_file_that_goes_does_not_hold_the_folder(tmp_path, monkeypatch):
    # the moment between opening and locking, in which the holder removes the file and another one makes a new one
    import fcntl  # what filelock locks with

    lock, third = fcntl.flock, []

    def flock(descriptor, operation):
        if not third:
            os.unlink(tmp_path / LOCK)
            third.append(FileLock(tmp_path / LOCK, timeout=0))
            third[0].acquire()
        return lock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", flock)
    with pytest.raises(Timeout), held(tmp_path):
        pass


def test_a_folder_that_replaces_the_held_one_keeps_its_lock(tmp_path):
    root = tmp_path / "out"
    with held(root):
        shutil.move(root, tmp_path / "old")
        root.mkdir()
        (root / LOCK).write_text("of another run")
    assert (root / LOCK).exists()


def test_processes_that_take_turns_are_never_inside_together(tmp_path):
    workers = [
        subprocess.Popen([sys.executable, "-c", WORKER, str(tmp_path)], stderr=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    said = [worker.communicate()[1] for worker in workers]
    assert said == ["", "", ""]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="interrupts a call of POSIX systems")
@pytest.mark.parametrize("call", ["LOCK_EX", "LOCK_UN"])
def test_interrupts_while_a_folder_is_taken_or_given_back_are_one_interrupt(tmp_path, monkeypatch, call):
    import fcntl  # what filelock locks with

    lock, heard = fcntl.flock, []

    def interrupted(descriptor, operation):
        if operation & getattr(fcntl, call) and not heard:
            heard.append(operation)
            raise KeyboardInterrupt
        return lock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", interrupted)
    with pytest.raises(KeyboardInterrupt), held(tmp_path):
        raise KeyboardInterrupt
    assert heard
    with held(tmp_path):  # it is free again
        pass
