"""One run of one peer, as a line of JSON: what ``tisph bench`` calls.

    python benchmarks/peers/measure.py --code lammps --threads 2 --across 50 --until 20
    python benchmarks/peers/measure.py --code pysph --threads 1 --across 224 --steps 40
    python benchmarks/peers/measure.py --case taylor_green --code pysph-edac --threads 1 --across 50 --until 2
    python benchmarks/peers/measure.py --case cavity --code pysph --threads 1 --across 25 --until 10
    python benchmarks/peers/measure.py --case cylinder --code pysph --threads 1 --across 24 --until 12.5
    python benchmarks/peers/measure.py --case cylinder_in_stream --code pysph-edac --threads 1 --across 41 --until 4

Keys: ``code``, ``version``, ``threads`` or processes, ``particles`` (fluid), ``steps``, ``loop_seconds`` of the time
loop alone, ``particle_steps_per_s``, ``l2``, the relative error of the velocity at the end over the fluid particles
(null with ``--steps``: after a few steps nothing but a layer at the wall has moved), and ``neighbours``, those of a
particle of the lattice within the reach of the kernel. Cases other than Couette flow have one thread and no
``--steps``. In the cavity the error is that of the extremes on the centre lines, with cylinders that of their drag
(``tisph/suites/frontier.yaml``); with cylinders the end is in radius^2/viscosity. With the cylinder in a stream
the error is in the drag coefficient, against Schaefer and Turek.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import couette_case as case
import numpy as np

from tisph import config, scenes
from tisph.exact import couette, taylor_green
from tisph.studies.frontier import FLOWS, Point

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


def both_schemes(script):
    """The same for an example of PySPH's own that has both schemes."""
    return {code: (PYTHON, HERE / script, "--scheme", code[6:] or "tvf") for code in ("pysph", "pysph-edac")}


SERIAL = {
    "taylor_green": both_schemes("pysph_taylor_green.py"),
    "cavity": both_schemes("pysph_cavity.py"),
    "cylinder": {"pysph": (PYTHON, HERE / "pysph_cylinders.py")},
    "cylinder_in_stream": {"pysph-edac": (PYTHON, HERE / "pysph_cylinder_in_stream.py")},
}
"""The same for the cases that have one thread."""


def main():
    """Make the environments if they are not there, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=("couette", *SERIAL), default="couette")
    parser.add_argument("--code", choices=PROGRAMS, required=True)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--across", type=int, default=50)
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument("--until", type=float, help="time to reach")
    length.add_argument("--steps", type=int, help="steps of the largest stable size to take")
    arguments = parser.parse_args()
    programs = SERIAL.get(arguments.case)
    if programs and not (arguments.code in programs and arguments.threads == 1 and arguments.until):
        parser.error(f"--case {arguments.case}: --code {' or '.join(programs)}, --threads 1, --until")
    environment = f"env-{arguments.code.partition('-')[0]}/installed"
    subprocess.run(["make", "--silent", "-C", HERE, environment], check=True, stdout=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps((measured_serial if programs else measured)(arguments, Path(folder) / "profile.txt")))


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


def measured_serial(arguments, end):
    """The same of the other cases; the code writes x, y, u and v of its particles to the file ``end``."""
    words = ["--across", arguments.across, "--end", arguments.until, "--particles", end]
    output = call([*SERIAL[arguments.case][arguments.code], *words], {"OMP_NUM_THREADS": "1"})
    found = json.loads(output.splitlines()[-1])
    error = float(ERRORS[arguments.case](np.loadtxt(end, unpack=True), found, arguments))
    return {"code": arguments.code, **found, "l2": error, "neighbours": case.lattice_neighbours()}


def vortex_error(particles, found, arguments):
    """L2 error of the Taylor-Green vortex."""
    x, y, u, v = particles
    flow = {name: found.pop(name) for name in ("length", "speed", "kinematic_viscosity")}
    exact = np.array(taylor_green.velocity(x, y, found["time"], **flow))
    return np.linalg.norm(np.array([u, v]) - exact) / np.linalg.norm(exact)


def cavity_error(particles, found, arguments):
    """Error of the extremes on the centre lines of the cavity, interpolated as those of our own particles are."""
    described = Point("cavity_10", "implicit 4, balanced", arguments.across).config
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cavity.yaml"
        path.write_text(json.dumps(described), encoding="utf-8")  # JSON is YAML
        settings = config.load(path)
    scene = scenes.of(settings)
    seen = SimpleNamespace(**dict(zip("xyuv", particles, strict=True)), t=found["time"])
    u, v = scene.lines(seen, np.linspace(0.0, 1.0, 401))
    return FLOWS["cavity_10"].error_of({"u_extreme": u.min(), "v_min": v.min(), "v_max": v.max()})


def cylinder_error(particles, found, arguments):
    """Error of the drag of a cylinder, which is given over the dynamic viscosity."""
    return FLOWS["cylinder"].error_of({**found, "drag": 10.0 * found["drag"]})  # its dynamic viscosity is 10


def stream_error(particles, found, arguments):
    """Error of the drag coefficient of the cylinder in a stream, which its script knows."""
    return found.pop("error")


ERRORS = {
    "taylor_green": vortex_error,
    "cavity": cavity_error,
    "cylinder": cylinder_error,
    "cylinder_in_stream": stream_error,
}


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
