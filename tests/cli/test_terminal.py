"""A command outlives who reads its output, and what interrupts it while it is imported is one line."""

import io
import os
import signal
import subprocess
import sys

import pytest

import tisph.__main__
import tisph.cli
from tisph.cli.terminal import held_back, lasting
from tisph.errors import ending_signals

POSIX = pytest.mark.skipif(os.name == "nt", reason="sends signals, closes descriptors")


COMMAND = f'"{sys.executable}" -m tisph list'


def shell(text):
    return subprocess.run(["sh", "-c", text], capture_output=True, text=True)


@pytest.mark.parametrize("buffered", [True, False])
def test_a_stream_whose_reader_has_gone_takes_everything(buffered):
    reader, writer = os.pipe()
    stream = lasting(io.TextIOWrapper(os.fdopen(writer, "wb", -1 if buffered else 0), line_buffering=True))
    print("read", file=stream)
    assert os.read(reader, 100) == b"read\n"
    os.close(reader)
    print("not read\n" * 10_000, file=stream, flush=True)
    stream.close()


@POSIX
@pytest.mark.parametrize(
    "text",
    [
        f"{{ {{ {COMMAND}; echo $? >&3; }} | : ; }} 3>&1",
        f"{{ {{ {COMMAND} nothing 2>&1; echo $(($? - 2)) >&3; }} | : ; }} 3>&1",
        f"{COMMAND} >&- 2>&-; echo $?",
    ],
)
def test_a_command_ends_as_it_would_without_a_reader(text):
    done = shell(text)
    assert (done.stdout, done.stderr) == ("0\n", "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
def test_output_lost_on_a_full_disk_is_an_error():
    done = shell(f"{COMMAND} > /dev/full")
    assert done.returncode == 1
    assert done.stderr == "error: standard output cannot be written: No space left on device\n"


@POSIX
def test_an_interrupt_while_the_command_is_imported_is_one_line():
    program = """
import signal, sys
import tisph.__main__

class Finder:
    def find_spec(self, name, *_):
        if name == "tisph.cli":
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Finder())
tisph.__main__.main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.parametrize(("given", "kept"), [(None, "1"), ("3", "3")])
def test_numpy_has_one_thread_unless_the_user_wants_more(monkeypatch, given, kept):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    if given:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
    seen, handler = [], signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(tisph.cli, "main", lambda: seen.append(os.environ["OPENBLAS_NUM_THREADS"]))
    try:
        tisph.__main__.main()
    finally:
        signal.signal(signal.SIGINT, handler)
    assert seen == [kept]


@POSIX
@pytest.mark.usefixtures("hang_up_heard")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGINT)])
def test_an_import_is_not_interrupted_but_what_comes_after_it(number):
    done = []

    def imports():
        with held_back():
            signal.raise_signal(number)
            done.append("import")

    with pytest.raises(KeyboardInterrupt):
        imports()
    assert done == ["import"]


@POSIX
@pytest.mark.usefixtures("hang_up_heard")
def test_a_hang_up_is_ignored_under_nohup():
    assert signal.SIGHUP in ending_signals()
    heard = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        assert ending_signals() == [signal.SIGINT, signal.SIGTERM]
    finally:
        signal.signal(signal.SIGHUP, heard)
