"""What a step of the implicit scheme costs, and how many iterations it takes, in a process of its own.

    python -m tisph.study.bench._scaling_process CONFIG SECONDS

Starts the scheme that CONFIG stands for, lets it run for about SECONDS, but not beyond the end, and prints a line of
JSON.
"""

import json
import sys
import time

from tisph import runtime, scenes, schemes
from tisph.config import load, memory
from tisph.simulation.results import peak_memory_mb
from tisph.simulation.run import start_values, threads
from tisph.study.bench._throughput_process import Clock

WARM_UP, LEAST_STEPS = 16, 3
"""Steps before the first that is timed, until they have their length, and in channels long enough to have used both
solvers; steps that are timed at least."""


class Iterations:
    """Adds up those of a solver."""

    def __init__(self, solver):
        self.solver, self.solve, self.total = solver, solver.solve, 0.0
        solver.solve = self

    def __call__(self, *words):
        """Solve as before."""
        found = self.solve(*words)
        self.total += self.solver.iterations
        return found


def advance(scheme, seconds, least):
    """Advance for ``seconds`` but at least ``least`` steps, and not beyond the end; return seconds and steps."""
    began, first = time.perf_counter(), scheme.steps
    while not scheme.finished and (time.perf_counter() - began < seconds or scheme.steps - first < least):
        scheme.advance()
    return time.perf_counter() - began, scheme.steps - first


def main(path, seconds):
    """Measure the config at ``path``."""
    config = load(path, ())
    scene = scenes.of(config)
    count = threads(config, scene)
    runtime.start(config.discretisation.precision, count)
    chosen, _ = schemes.resolve(config)
    scheme = schemes.build(chosen, scene, [config.time.end], serial=count == 1)
    scheme.start(*start_values(scene, config.initial))
    advance(scheme, 0.0, WARM_UP)
    clock = Clock(scheme, {"assembly": (("rows", "assemble"),)})
    pressures = getattr(scheme, "iterations", None)  # the scheme of a flow that turns counts its own
    before, others = pressures[0] if pressures else 0.0, None if pressures else Iterations(scheme.solver)
    total, steps = advance(scheme, float(seconds), LEAST_STEPS)
    iterations = others.total if others else pressures[0] - before
    each = 1e6 / (scene.particles * steps)
    print(
        json.dumps(
            {
                "particles": scene.particles,
                "threads": count,
                "step_us": each * total,
                "assembly_us": each * clock.seconds["assembly"],
                "iterations": iterations / steps,
                "peak_mb": peak_memory_mb(),
                "estimated_mb": 1e-6 * memory.estimated_bytes(scene.particles, config, True),
            }
        )
    )
    runtime.stop()


if __name__ == "__main__":
    main(*sys.argv[1:])
