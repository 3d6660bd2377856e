"""Start ``tisph run`` in processes of their own, without each importing what the one before it has imported.

Where processes can be forked safely, that is on Linux, a server imports it once and is forked for each run before
Taichi is initialised: the run is a process like any other, a second sooner. Elsewhere each starts from nothing.
"""

import multiprocessing
import os
import runpy
import sys
import time

from tisph import clock, registry

METHOD = "forkserver" if sys.platform == "linux" else "spawn"

COMPILED = ("tisph.schemes.implicit._scheme", "tisph.schemes.wcsph._scheme")
IMPORTED = ("tisph.cli", "tisph.simulation", *registry.modules("scenes"), *registry.modules("schemes"), *COMPILED)
"""What the server imports; a run imports the rest that it needs."""


def prepare():
    """Let the server get ready, beside what this process does, if there is to be one and it does not run yet."""
    if METHOD == "forkserver":
        from multiprocessing import forkserver  # not everywhere

        forkserver.set_forkserver_preload(list(IMPORTED))
        forkserver.ensure_running()


def start(arguments, messages):
    """Start the command line with ``arguments`` and return its ``multiprocessing.Process``.

    Its standard error goes to the file ``messages``, what it prints nowhere.
    """
    prepare()
    words = [str(each) for each in arguments]
    process = multiprocessing.get_context(METHOD).Process(target=_be, args=(words, str(messages)))
    process.start()
    return process


def _be(arguments, messages):
    """Be that process: as ``python -m tisph`` with ``arguments``."""
    clock.PROCESS_START = time.perf_counter()
    for path, descriptor in ((os.devnull, 1), (messages, 2)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, descriptor)
        os.close(file)
    sys.stderr.reconfigure(encoding="utf-8")  # as which messages are read
    sys.argv[1:] = arguments
    runpy.run_module("tisph", run_name="__main__")
