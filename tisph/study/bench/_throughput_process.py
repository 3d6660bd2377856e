"""What a step of a config costs, part by part, in a process of its own.

    python -m tisph.study.bench._throughput_process CONFIG SECONDS

Starts the scheme of CONFIG, lets it run for about SECONDS, and prints a line of JSON: nanoseconds per fluid particle.
"""

import json
import math
import sys
import time
from collections import Counter
from functools import partial

from tisph import runtime, scenes, schemes
from tisph.config import load, memory
from tisph.runtime import real, ti
from tisph.schemes._momentum import EVERY_STEP_UNTIL
from tisph.simulation.results import peak_memory_mb
from tisph.simulation.run import start_values

WARM_UP = {"wcsph": 3, "implicit": 2}
"""Steps before the first that is timed: they compile what the start has not."""

LEAST_STEPS = {"wcsph": 20, "implicit": 2}
FORCED_REBUILDS = 2
LEAST_PASSES = 5

EXPLICIT_PARTS = {
    "binning": (("cells", "sort"), ("particles", "reorder")),
    "list": (("lists", "build"),),
    "walls": (("walls", "lay_out"),),
    "kernel": (("stepper", "step"),),
}
IMPLICIT_PARTS = {
    "neighbours": (("ghosts", "find"), ("points", "find_neighbours"), ("ghosts", "weigh")),
    "assembly": (("rows", "assemble"),),
    "systems": (("viscous", "advance"),),
}
"""Methods of the parts of a scheme, by what they are to be counted as."""

REBUILDING = ("binning", "list", "walls")


class Clock:
    """Adds up the ``seconds`` and ``calls`` of the methods of ``scheme`` that ``parts`` names."""

    def __init__(self, scheme, parts):
        self.seconds, self.calls = Counter(), Counter()
        for part, methods in parts.items():
            for owner, method in methods:
                self._watch(part, getattr(scheme, owner), method)

    def _watch(self, part, owner, method):
        call = getattr(owner, method)

        def timed(*words):
            began = time.perf_counter()
            found = call(*words)
            self.seconds[part] += time.perf_counter() - began
            self.calls[part, method] += 1
            return found

        setattr(owner, method, timed)


@ti.data_oriented
class Pass:
    """The sums over the neighbours alone: rates of all particles, into fields that nobody reads.

    Rates are stored as vectors: from their sum the compiler makes other code of the loop, up to a fifth slower.
    """

    def __init__(self, scheme):
        self.operators, self.fluid, self.serial = scheme.operators, scheme.particles.fluid, scheme.serial
        vector = ti.types.vector(2, real())
        self.acceleration, self.transport = (ti.field(vector, shape=self.fluid) for _ in range(2))
        self.compression = ti.field(real(), shape=self.fluid)

    @ti.kernel
    def evaluate(self, now: ti.i32):
        """Compute the rates at the mid-step values in buffer ``now``."""
        ti.loop_config(serialize=self.serial)
        for i in range(self.fluid):
            rates = self.operators.rates(now, i)
            self.acceleration[i] = rates.acceleration
            self.transport[i] = rates.transport
            self.compression[i] = rates.compression


def seconds_of(action):
    """Return the seconds that a call takes."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def run_for(scheme, seconds, least):
    """Advance for ``seconds`` but at least ``least`` steps; return seconds, steps, and seconds of the fastest step."""
    began, first, fastest = time.perf_counter(), scheme.steps, math.inf
    while time.perf_counter() - began < seconds or scheme.steps - first < least:
        before = scheme.steps
        fastest = min(fastest, seconds_of(scheme.advance) / (scheme.steps - before))
    return time.perf_counter() - began, scheme.steps - first, fastest


def time_explicit(scheme, start, seconds):
    """Return the costs of a step, of what is done at a rebuild only, and the steps between two rebuilds."""
    start()
    scheme.steps = EVERY_STEP_UNTIL - 1  # from there on the momentum balance costs what it costs in a long run
    run_for(scheme, 0.0, WARM_UP["wcsph"])
    clock = Clock(scheme, EXPLICIT_PARTS)
    before = scheme.rebuilds
    total, steps, fastest = run_for(scheme, seconds, LEAST_STEPS["wcsph"])
    rebuilds = scheme.rebuilds - before
    stepping = total - sum(clock.seconds[part] for part in REBUILDING)
    peak = peak_memory_mb()
    for _ in range(FORCED_REBUILDS):
        scheme.rebuild()
    each = 1e9 / scheme.particles.fluid
    kernel = each * clock.seconds["kernel"] / steps
    once = {part: each * clock.seconds[part] / (rebuilds + FORCED_REBUILDS) for part in REBUILDING}
    return {
        "peak_mb": peak,
        "steps": steps,
        # where no rebuild was seen, one at once: the least time between two, and so the most that they cost
        "interval": steps / max(1, rebuilds),
        "rebuilds": rebuilds,
        "step": each * stepping / steps,
        "fastest": each * fastest,
        "kernel": kernel,
        "pass": kernel * part_of_pass(scheme, clock, seconds),
        **once,
    }


def part_of_pass(scheme, clock, seconds):
    """Return the time of the sums over the neighbours as a part of that of the whole kernel.

    Both take turns, and the fastest of each count: what else the machine does can only add.
    """
    alone, sums, kernels = Pass(scheme), [], []
    alone.evaluate(scheme.now)
    began = time.perf_counter()
    while time.perf_counter() - began < 0.5 * seconds or len(sums) < LEAST_PASSES:
        before, steps = clock.seconds["kernel"], scheme.steps
        scheme.advance()
        kernels.append((clock.seconds["kernel"] - before) / (scheme.steps - steps))
        sums.append(seconds_of(partial(alone.evaluate, scheme.now)))
    return min(sums) / min(kernels)


def time_implicit(scheme, start, seconds):
    """Return the costs of a step, of an assembly, and of the other parts of a step."""
    start()
    run_for(scheme, 0.0, WARM_UP["implicit"])
    clock = Clock(scheme, IMPLICIT_PARTS)
    total, steps, _ = run_for(scheme, seconds, LEAST_STEPS["implicit"])
    each = 1e9 / scheme.points.fluid
    return {
        "peak_mb": peak_memory_mb(),
        "steps": steps,
        "step": each * total / steps,
        "assembly": each * clock.seconds["assembly"] / clock.calls["assembly", "assemble"],
        "neighbours": each * clock.seconds["neighbours"] / steps,
        "systems": each * clock.seconds["systems"] / steps,
    }


def main(path, seconds):
    """Measure the config at ``path``."""
    config = load(path, ())
    channel = scenes.of(config)
    runtime.start(config.discretisation.precision, config.runtime.threads)
    kind, threads = config.scheme.type, config.runtime.threads
    scheme = schemes.build(config, channel, [config.time.end], serial=threads == 1)
    start = partial(scheme.start, *start_values(channel, config.initial))
    found = (time_implicit if kind == "implicit" else time_explicit)(scheme, start, float(seconds))
    particles = channel.rows * channel.columns
    found["particles"] = particles
    found["estimated_mb"] = 1e-6 * memory.estimated_bytes(particles, config, kind == "implicit")
    found["neighbours_mean"] = scheme.numbers()["neighbours_mean"]
    print(json.dumps(found))
    runtime.stop()


if __name__ == "__main__":
    main(*sys.argv[1:])
