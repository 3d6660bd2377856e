"""One run of one peer, as a line of JSON: what ``tisph bench`` calls.

    python benchmarks/peers/measure.py --code lammps --threads 2 --across 50 --until 20
    python benchmarks/peers/measure.py --code pysph --threads 1 --across 224 --steps 40
    python benchmarks/peers/measure.py --case taylor_green --code pysph-edac --threads 1 --across 50 --until 2

Keys: ``code``, ``version``, ``threads`` or processes, ``particles`` (fluid), ``steps``, ``loop_seconds`` of the time
loop alone, ``particle_steps_per_s``, ``l2``, the relative error of the velocity at the end over the fluid particles
(null with ``--steps``: after a few steps nothing but a layer at the wall has moved), and ``neighbours``, those of a
particle of the lattice within the reach of the kernel. The Taylor-Green vortex has one thread and no ``--steps``.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import couette_case as case
import numpy as np

from tisph.exact import couette, taylor_green

HERE = Path(__file__).resolve().parent

PYTHON = HERE / "env-pysph" / "bin" / "python"
PYSPH = (PYTHON, HERE / "pysph_couette.py")
PROGRAMS = {
    "lammps": (sys.executable, HERE / "lammps_couette.py"),
    "pysph": PYSPH,
    "pysph-tuned": (*PYSPH, "--tuned"),
    "pysph-edac": (*PYSPH, "--scheme", "edac"),
}
"""Command of each code: PySPH with its transport velocity as in its own example, with the switches that make it faster
without changing the result, and with its other scheme for flow between walls."""


VORTEX = (PYTHON, HERE / "pysph_taylor_green.py")
VORTEX_PROGRAMS = {"pysph": (*VORTEX, "--scheme", "tvf"), "pysph-edac": (*VORTEX, "--scheme", "edac")}
"""The same for the Taylor-Green vortex."""


def main():
    """Make the environments if they are not there, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=("couette", "taylor_green"), default="couette")
    parser.add_argument("--code", choices=PROGRAMS, required=True)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--across", type=int, default=50)
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument("--until", type=float, help="time to reach")
    length.add_argument("--steps", type=int, help="steps of the largest stable size to take")
    arguments = parser.parse_args()
    vortex = arguments.case == "taylor_green"
    if vortex and not (arguments.code in VORTEX_PROGRAMS and arguments.threads == 1 and arguments.until):
        parser.error(f"--case taylor_green: --code {' or '.join(VORTEX_PROGRAMS)}, --threads 1, --until")
    environment = f"env-{arguments.code.partition('-')[0]}/installed"
    subprocess.run(["make", "--silent", "-C", HERE, environment], check=True, stdout=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps((measured_vortex if vortex else measured)(arguments, Path(folder) / "profile.txt")))


def measured(arguments, profile):
    """What the run that the command line asks for gave, as a dictionary; the code writes ``profile`` after its loop."""
    step = case.stable_time_step(arguments.across)
    # the small number keeps a quotient that is whole, but for rounding, from one more step
    steps = arguments.steps or math.ceil(arguments.until / step - 1e-6)
    end = arguments.until or steps * step
    words = ["--across", arguments.across, "--steps", steps, "--end", repr(end), "--profile", profile]
    if arguments.code == "lammps":
        words += ["--threads", arguments.threads]
    threads = 1 if arguments.code == "lammps" else arguments.threads
    output = call([*PROGRAMS[arguments.code], *words], {"OMP_NUM_THREADS": str(threads)})
    return {
        "code": arguments.code,
        **json.loads(output.splitlines()[-1]),
        "l2": l2(profile, end) if arguments.until else None,
        "neighbours": case.lattice_neighbours(),
    }


def measured_vortex(arguments, end):
    """The same of the Taylor-Green vortex; the code writes x, y, u and v of its particles to the file ``end``."""
    words = ["--across", arguments.across, "--end", arguments.until, "--particles", end]
    output = call([*VORTEX_PROGRAMS[arguments.code], *words], {"OMP_NUM_THREADS": "1"})
    found = json.loads(output.splitlines()[-1])
    x, y, u, v = np.loadtxt(end, unpack=True)
    flow = {name: found.pop(name) for name in ("length", "speed", "kinematic_viscosity")}
    exact = np.array(taylor_green.velocity(x, y, found["time"], **flow))
    error = float(np.linalg.norm(np.array([u, v]) - exact) / np.linalg.norm(exact))
    return {"code": arguments.code, **found, "l2": error, "neighbours": case.lattice_neighbours()}


def call(words, environment):
    """Output of a command; exits with the end of its messages if it fails."""
    command = list(map(str, words))
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **environment})
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{(done.stdout + done.stderr)[-2000:]}")
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


main()
