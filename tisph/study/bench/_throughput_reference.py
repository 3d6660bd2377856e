"""The tuned C++ loop that throughput is compared with: ``benchmarks/reference.cpp``, compiled and run.

    python -m tisph.study.bench._throughput_reference CONFIG PROGRAM SECONDS

Runs PROGRAM for about SECONDS on the particles with which the explicit scheme of CONFIG starts; prints a line of JSON.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import tisph
from tisph import scenes
from tisph.config import load
from tisph.errors import TisphError
from tisph.schemes._estimate import explicit

SOURCE = Path(tisph.__file__).resolve().parents[1] / "benchmarks" / "reference.cpp"

FLAGS = ["-std=c++17", "-O3", "-march=native", "-ffast-math", "-fopenmp"]

TUNING = (
    ["-mprefer-vector-width=256", "-mtune-ctrl=^use_gather,^use_gather_2parts,^use_gather_4parts,^use_gather_8parts"],
    ["-mprefer-vector-width=256", "-mtune-ctrl=^use_gather,^use_gather_2parts,^use_gather_4parts"],
    ["-mprefer-vector-width=256"],
    [],
)
"""Flags that a compiler may not know, best first: vectors of 512 bits and gather instructions are slower here."""

WARM_UP = 20
GUESS = 60e-9
"""Seconds that a particle and step take on one thread, roughly: to know how many steps to ask for."""


def compiled(folder):
    """Compile the loop into ``folder``; return the program's path, or None without source or compiler.

    Raises TisphError where a compiler is there but cannot compile it.
    """
    compiler = shutil.which("c++")
    if compiler is None or not SOURCE.is_file():
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


def main(path, program, seconds):
    """Time a step, and a rebuild of its lists, on the particles of the config at ``path``."""
    config = load(path, ())
    channel = scenes.of(config)
    particles = channel.rows * channel.columns
    x, y = channel.jittered(config.initial.seed, config.initial.jitter)
    steps = max(WARM_UP, round(float(seconds) / (GUESS * particles)))
    with tempfile.TemporaryDirectory() as folder:
        state = Path(folder) / "state.bin"
        write_state(state, x, y, channel.initial_velocity(y), np.zeros_like(x))
        found = run(program, config, channel, state=state, steps=steps, warm_up=WARM_UP)
    once = found["rebuild_seconds"]
    each = 1e9 / particles
    stepping = found["loop_seconds"] - found["rebuilds"] * once
    print(json.dumps({"particles": particles, "step": each * stepping / steps, "rebuild": each * once}))


if __name__ == "__main__":
    main(*sys.argv[1:])
