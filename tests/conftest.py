"""Every run of the tests draws the same examples: a failure comes with a change, not with luck."""

import gc
import os
import signal

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)  # a busy machine is no failure
settings.load_profile("repeatable")

# matrices here are small, and threads of NumPy's that wait for one another only keep other tests from the processors
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

gc.set_threshold(200_000, 20, 20)  # as the command line does, and for the same reason


@pytest.fixture(scope="module")
def kept_program():
    """Taichi starts once for many tests of a file.

    Numbers of fields are compiled in, and they follow from what was asked for before: in a file always the same, so
    that the next run of the tests finds its kernels in the cache. Tests of one file run in one process for that.
    """
    import kept_program  # it imports Taichi, which most tests do without

    kept_program.install()
    yield
    kept_program.uninstall()


@pytest.fixture
def hang_up_heard():
    """Let a hang-up be heard during a test, as in a terminal, where the tests were started to ignore it (nohup)."""
    number = getattr(signal, "SIGHUP", None)  # Windows has none
    ignored = number is not None and signal.getsignal(number) is signal.SIG_IGN
    if ignored:
        signal.signal(number, signal.SIG_DFL)
    yield
    if ignored:
        signal.signal(number, signal.SIG_IGN)
