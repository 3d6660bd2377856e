"""A scene in a process of its own that does what it is told, and says what it has cost.

    python -m tisph.study.bench.stepping CONFIG [--without-shifting]

Answers each line of JSON on standard input, {"do": "steps", "times": 50}, by one with the seconds that a single step
took. Seconds are those of the processor for this process: what else the machine does meanwhile does not count.
"""

import json
import math
import sys
import tempfile
import time
from collections import deque
from pathlib import Path

from tisph import runtime, scenes, schemes
from tisph.config import load
from tisph.observers.history import History
from tisph.runtime import ti
from tisph.simulation import checkpoint
from tisph.simulation.run import start_values

WARM_UP = 10
"""Steps before the first that are timed."""

NUMBER_BYTES = {ti.f64: 8, ti.f32: 4, ti.i64: 8, ti.i32: 4, ti.u8: 1}


class Stepping:
    """A started scheme of a config, on one thread.

    Every method but ``facts`` does a thing ``times`` times and returns the mean of its ``seconds``.
    """

    def __init__(self, config, without_shifting=False):
        self.config = config
        self.channel = scenes.of(config)
        runtime.start(config.discretisation.precision, 1)
        chosen, _ = schemes.resolve(config)
        self.scheme = schemes.build(chosen, self.channel, [config.time.end], serial=True)
        self.scheme.start(*start_values(self.channel, config.initial))
        if without_shifting:
            self.scheme.shift.spread = lambda: False
        self.steps(WARM_UP)

    def facts(self):
        """Return the number of particles and the bytes of every field."""
        particles = self.channel.rows * self.channel.columns
        return {"particles": particles, "fields": {name: size(field) for name, field in fields(self.scheme).items()}}

    def steps(self, times):
        """Take steps; also says how far they went."""
        began = self.scheme.time
        seconds = _seconds_each(self.scheme.advance, times)
        return {"seconds": seconds, "advanced": self.scheme.time - began}

    def records(self, times):
        """Write lines of the history: read the state, interpolate to the tracers, append."""
        followed = self.channel.followed(**self.config.followed)
        with tempfile.TemporaryDirectory() as folder:
            history = History(Path(folder) / "history.csv", self.channel, followed, self.config.time.end)
            history.observe(self.scheme.snapshot())  # what compiles, does so now
            seconds = _seconds_each(lambda: history.observe(self.scheme.snapshot()), times)
            return {"seconds": seconds, "bytes": history.path.stat().st_size / (times + 1)}

    def checkpoints(self, times):
        """Write checkpoints, each in place of the one before."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "checkpoint.h5"
            checkpoint.save(path, self.scheme, "none")
            seconds = _seconds_each(lambda: checkpoint.save(path, self.scheme, "none"), times)
            return {"seconds": seconds, "bytes": path.stat().st_size}


def _seconds_each(action, times):
    began = time.process_time()
    for _ in range(times):
        action()
    return (time.process_time() - began) / times


def fields(scheme):
    """Return every Taichi field that ``scheme`` holds, by the shortest way of attributes to it."""
    found, seen, waiting = {}, {id(scheme)}, deque([("", scheme)])
    while waiting:
        way, owner = waiting.popleft()
        for name, value in _members(owner):
            if id(value) in seen:
                continue
            seen.add(id(value))
            if isinstance(value, ti.Field):
                found[f"{way}{name}"] = value
            else:
                waiting.append((f"{way}{name}.", value))
    return found


def _members(owner):
    if isinstance(owner, dict):
        return owner.items()
    if isinstance(owner, list | tuple):
        return enumerate(owner)
    return vars(owner).items() if type(owner).__module__.startswith("tisph.") and hasattr(owner, "__dict__") else ()


def size(field):
    """Return the bytes of the numbers in ``field``."""
    numbers = field.n * field.m if isinstance(field, ti.MatrixField) else 1
    return math.prod(field.shape) * numbers * NUMBER_BYTES[field.dtype]


def main(path, *words):
    """Answer the lines of standard input until it ends."""
    stepping = Stepping(load(path, ()), without_shifting="--without-shifting" in words)
    print(json.dumps(stepping.facts()), flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        print(json.dumps(getattr(stepping, order["do"])(order["times"])), flush=True)
    runtime.stop()


if __name__ == "__main__":
    main(*sys.argv[1:])
