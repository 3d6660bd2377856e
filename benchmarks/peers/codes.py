"""The codes of the comparison: how each is run, and what comes back.

Every ``measure_*`` takes a ``Run`` and a scratch folder and returns a dictionary: ``version``, ``threads``,
``particles`` (fluid), ``steps``, ``loop_seconds`` (time loop alone), ``particle_steps_per_s`` and ``l2``, the
relative error of the velocity at the end of the run against the exact flow, over the fluid particles.
"""

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import couette_case as case
import numpy as np

import tisph
from tisph.exact import couette

HERE = Path(__file__).resolve().parent

THREADS = 2
"""Threads or processes that each code gets."""


@dataclass(frozen=True)
class Run:
    """What a code is asked for: particles between the walls, steps, and the time that these reach."""

    across: int
    steps: int
    end: float

    @classmethod
    def of_steps(cls, across, steps):
        """``steps`` steps of the largest stable size."""
        return cls(across, steps, steps * case.stable_time_step(across))

    @classmethod
    def until(cls, across, end):
        """As few stable steps as reach ``end``."""
        # the small number keeps a quotient that is whole, but for rounding, from one more step
        return cls(across, math.ceil(end / case.stable_time_step(across) - 1e-6), end)


@dataclass(frozen=True)
class Code:
    """A program of the comparison; ``bound`` is the least ratio of tisph's throughput to its own."""

    label: str
    measure: Callable[[Run, Path], dict]
    bound: float | None = None


def measure_tisph(run, folder):
    """Throughput and L2 of tisph; its own time step, to the same time as the peers."""
    config = {
        "name": "peers",
        "scene": "channel",
        "fluid": {"density": case.DENSITY, "kinematic_viscosity": case.KINEMATIC_VISCOSITY},
        "geometry": {"gap": case.GAP, "length": case.LENGTH},
        "walls": {"treatment": {"type": "consistent_image"}, "top": {"velocity": case.WALL_VELOCITY}},
        "discretisation": {"particles_across": run.across},
        "scheme": {"equation_of_state": {"sound_speed": case.SOUND_SPEED}, "type": "wcsph"},
        "time": {"end": run.end},
        "runtime": {"threads": THREADS},
    }
    path, results = folder / "couette.yaml", folder / "results"
    path.write_text(json.dumps(config), encoding="utf-8")  # JSON is YAML
    call([sys.executable, "-m", "tisph", "run", path, "--out", results, "--no-video", "--overwrite"])
    summary = json.loads((results / "summary.json").read_text(encoding="utf-8"))
    cost = summary["cost"]
    return {
        "version": f"{tisph.__version__} (Taichi {version('taichi')})",
        "threads": THREADS,
        "particles": summary["numbers"]["particles_fluid"],
        "steps": cost["steps"],
        "loop_seconds": cost["wall_loop_s"],
        "particle_steps_per_s": cost["particle_steps_per_s"],
        "l2": summary["samples"][-1]["l2"],
    }


def measure_pysph(run, folder, options=()):
    """Throughput and L2 of PySPH, which takes its number of threads from the environment."""
    program = [HERE / "env-pysph" / "bin" / "python", HERE / "pysph_couette.py", *options]
    return measure_peer(program, run, folder, {"OMP_NUM_THREADS": str(THREADS)})


def measure_pysph_tuned(run, folder):
    """PySPH with the switches that make it faster without changing the result."""
    return measure_pysph(run, folder, ["--tuned"])


def measure_pysph_edac(run, folder):
    """PySPH with its other scheme for flow between walls."""
    return measure_pysph(run, folder, ["--scheme", "edac"])


def measure_lammps(run, folder):
    """Throughput and L2 of LAMMPS in ``THREADS`` processes of one thread."""
    program = [sys.executable, HERE / "lammps_couette.py", "--threads", str(THREADS)]
    return measure_peer(program, run, folder, {"OMP_NUM_THREADS": "1"})


def measure_peer(program, run, folder, environment):
    """The line of JSON of a peer's script, with the L2 of the profile that it writes after its time loop."""
    profile = folder / "profile.txt"
    words = ["--across", run.across, "--steps", run.steps, "--end", repr(run.end), "--profile", profile]
    output = call([*program, *map(str, words)], environment)
    return {**json.loads(output.splitlines()[-1]), "l2": l2(profile, run.end)}


def call(words, environment=None):
    """Output of a command; exits with the end of its messages if it fails."""
    done = subprocess.run(words, capture_output=True, text=True, check=False, env={**os.environ, **(environment or {})})
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))} failed:\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def l2(profile, time):
    """L2 error of a profile file (columns y and u) against the exact start-up flow at ``time``."""
    y, u = np.loadtxt(profile, unpack=True)
    exact = couette.velocity(
        y,
        time,
        gap=case.GAP,
        kinematic_viscosity=case.KINEMATIC_VISCOSITY,
        bottom=0.0,
        top=case.WALL_VELOCITY,
    )
    return float(np.sqrt(np.sum((u - exact) ** 2) / np.sum(exact**2)))


# The bounds hold against the set-up of PySPH's own example; the tuned row shows what its users can still get.
CODES = (
    Code("tisph", measure_tisph),
    Code("PySPH TVF", measure_pysph, bound=7.0),
    Code("PySPH TVF, tuned", measure_pysph_tuned),
    Code("LAMMPS SPH", measure_lammps, bound=0.6),
)
