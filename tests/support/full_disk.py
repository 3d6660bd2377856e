"""A program that writes under a limit of the size of files, from none to enough: each falls into another write.

``full_disk.py CONFIG`` leaves the folders out0, out1, ... and prints for each how many samples and lines of the history
were written when the first of them could not be.
"""

import resource
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

from tisph import config
from tisph.errors import TisphError
from tisph.folder import Folder
from tisph.observers.history import History
from tisph.observers.samples import Samples
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

TIMES = range(1, 6)
LIMITS = range(0, 100_000, 1997)


def write(observer, values, limit):
    """Write until that fails, and return how often it did not."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        for step, t in enumerate(TIMES):
            observer.observe(Snapshot(t, step, *values))
        return len(TIMES)
    except TisphError as error:
        if "cannot be written: File too large" not in str(error):
            raise
        return step
    finally:
        with suppress(TisphError):  # the history has the exact solution to add
            observer.close()


def main(path):
    """Write samples and history under each of the limits, that of the history a hundredth."""
    channel = Channel.from_config(config.load(path))
    values = np.random.default_rng(0).uniform(0.1, 0.9, (6, channel.rows * channel.columns))
    for number, limit in enumerate(LIMITS):
        folder = Folder(Path(f"out{number}"))
        folder.root.mkdir()
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        samples = Samples(folder.samples, channel, TIMES)
        history = History(folder.history, channel, channel.time_series(4), TIMES[-1])
        print(write(samples, values, limit), write(history, values, limit // 100))


if __name__ == "__main__":
    main(sys.argv[1])
