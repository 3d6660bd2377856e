"""A program that writes results and does nothing else, killed again and again: each kill falls into a write.

``endless_writer.py CONFIG TIMES`` leaves the folders out0, out1, ... and prints for each how often all of its files
had been written.
"""

import os
import random
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tisph import config
from tisph.folder import Folder
from tisph.observers.history import History
from tisph.observers.samples import Frames, Samples
from tisph.scenes.channel import Channel
from tisph.simulation.recording import write_summary
from tisph.snapshot import Snapshot

TIMES = [0.01 * k for k in range(2000)]


def write(folder, channel, pipe):
    """Write all kinds of results into ``folder``, and a byte to ``pipe`` after each of ``TIMES``."""
    values = np.random.default_rng(0).uniform(0.1, 0.9, (6, channel.rows * channel.columns))
    movie = SimpleNamespace(add=lambda snapshot: None, close=lambda: None)
    history = History(folder.history, channel, channel.time_series(4), TIMES[-1])
    observers = [Samples(folder.samples, channel, TIMES), history, Frames(folder.frames, movie, TIMES)]
    for step, t in enumerate(TIMES):
        for observer in observers:
            observer.observe(Snapshot(t, step, *values))
            observer.flush()
        write_summary(folder.summary, {"name": "small", "step": step})
        os.write(pipe, b".")


def write_and_die(folder, channel, times, seconds):
    """Write in a process that is killed ``seconds`` after it has written everything so many times; return how often."""
    folder.root.mkdir()
    end, pipe = os.pipe()
    process = os.fork()
    if not process:
        write(folder, channel, pipe)
        os._exit(1)
    os.close(pipe)
    with open(end, "rb", buffering=0) as complete:
        done = sum(len(complete.read(1)) for _ in range(times))
        time.sleep(seconds)
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        return done + len(complete.readall())


def main(path, kills):
    """Kill as many writers, each after another while."""
    channel = Channel.from_config(config.load(path))
    draw = random.Random(2)
    for number in range(kills):
        print(write_and_die(Folder(Path(f"out{number}")), channel, draw.randint(1, 4), draw.uniform(0.0, 0.006)))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
