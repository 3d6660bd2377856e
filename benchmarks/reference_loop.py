"""The C++ loop with the arithmetic of ``operators: standard``, ``benchmarks/reference.cpp``: compiled and run.

    python benchmarks/reference_loop.py --across 224 --threads 1

prints nanoseconds per particle and step, rebuilds of the lists left out: beside those of ``step.py``, how much faster a
loop written for this one purpose is. A test compares where both move the particles to.
"""

import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from tisph import scenes
from tisph.config import load
from tisph.errors import TisphError
from tisph.schemes._estimate import explicit

SOURCE = Path(__file__).with_name("reference.cpp")

FLAGS = ["-std=c++17", "-O3", "-march=native", "-ffast-math", "-fopenmp"]

TUNING = (
    ["-mprefer-vector-width=256", "-mtune-ctrl=^use_gather,^use_gather_2parts,^use_gather_4parts,^use_gather_8parts"],
    ["-mprefer-vector-width=256"],
    [],
)
"""Flags that a compiler may not know, best first: vectors of 512 bits and gather instructions are slower here."""

STEPS, WARM_UP = 500, 20


def compiled(folder):
    """Compile the loop into ``folder``; return the program's path, or None without a compiler.

    Raises TisphError where a compiler is there but cannot compile it.
    """
    compiler = shutil.which("c++")
    if compiler is None:
        return None
    program = folder / "reference"
    for tuning in TUNING:
        command = [compiler, *FLAGS, *tuning, str(SOURCE), "-o", str(program)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return program
    raise TisphError(f"{SOURCE} does not compile: {' '.join(command)}\n{done.stderr[-500:]}")


def step_limit(config, channel):
    """Return the length of the explicit scheme's steps and its sound speed."""
    numbers = explicit(config, channel)
    return numbers["time_step"], numbers["sound_speed"]


def write_state(path, x, y, u, v):
    """Write what the program starts from: arrays of one number for each particle."""
    np.stack([x, y, u, v], 1).astype(np.float64).tofile(path)


def run(program, config, channel, **words):
    """Run the program on ``config`` and return what it prints.

    ``words``: ``state`` (a file of ``write_state``), ``steps``, ``warm_up``, and ``out`` where wanted (such a file).
    """
    time_step, sound_speed = step_limit(config, channel)
    words = {
        "precision": config.discretisation.precision,
        "threads": config.runtime.threads,
        "rows": channel.rows,
        "columns": channel.columns,
        "gap": channel.gap,
        "length": channel.length,
        "viscosity": channel.kinematic_viscosity,
        "sound_speed": sound_speed,
        "bottom": channel.bottom.velocity(channel.start_time),
        "top": channel.top.velocity(channel.start_time),
        "smoothing_ratio": config.discretisation.smoothing_ratio,
        "time_step": time_step,
        **words,
    }
    command = [str(program), *(f"{key}={value}" for key, value in words.items())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise TisphError(f"{program}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def main():
    """Time a step on the particles with which the explicit scheme starts."""
    from step import SCHEMES, sized

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", type=int, default=224)
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path, state = folder / "case.yaml", folder / "state.bin"
        path.write_text(json.dumps(sized(SCHEMES["standard"], options.across, options.threads)), encoding="utf-8")
        config = load(path, ())
        channel = scenes.of(config)
        x, y = channel.jittered(config.initial.seed, config.initial.jitter)
        write_state(state, x, y, channel.initial_velocity(y), np.zeros_like(x))
        found = run(compiled(folder), config, channel, state=state, steps=STEPS, warm_up=WARM_UP)
    stepping = found["loop_seconds"] - found["rebuilds"] * found["rebuild_seconds"]
    print(f"{1e9 * stepping / (STEPS * len(x)):.1f} ns per particle and step, {len(x)} particles")


if __name__ == "__main__":
    main()
