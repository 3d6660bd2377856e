"""PySPH's own Taylor-Green example, on one thread; prints one line of JSON.

Run it with env-pysph's Python. Period, speed and density are 1, the Reynolds number 100, the sound speed 10: all as in
the example, as are kernel (quintic spline, h = spacing), steps and the background pressure of both schemes. With
``--perturb`` 0.2 its particles start up to 0.2 spacings off a lattice, to one side; tisph's start as far to either.

``loop_seconds`` are seconds of the processor: one thread can have no more of them than of the clock's. What else the
machine does counts less then, but it still counts: compare what was timed on a quiet one.
"""

import argparse
import json
import tempfile
import time

import pysph
from pysph.examples import taylor_green as example

REYNOLDS = 100.0
PERTURBATION = 0.2


def main():
    """Set up (compiling at the first time), run the time loop, and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scheme", choices=("tvf", "edac"), default="tvf")
    parser.add_argument("--across", type=int, default=50, help="particles along the period")
    parser.add_argument("--end", type=float, default=2.0, help="time to reach")
    parser.add_argument("--particles", required=True, help="file for x, y, u and v of every particle at the end")
    arguments = parser.parse_args()
    options = ["--quiet", "--disable-output", "--scheme", arguments.scheme, "--nx", str(arguments.across)]
    options += ["--re", str(REYNOLDS), "--perturb", str(PERTURBATION), "--tf", repr(arguments.end)]
    with tempfile.TemporaryDirectory() as folder:
        application = example.TaylorGreen(output_dir=folder)
        application.setup(options)
        start = time.process_time()
        application.solver.solve(show_progress=False)
        loop_seconds = time.process_time() - start
    (fluid,) = application.particles
    real = fluid.tag == 0  # the others are periodic images
    write(arguments.particles, [column[real].tolist() for column in (fluid.x, fluid.y, fluid.u, fluid.v)])
    report(application.solver, int(real.sum()), loop_seconds)


def write(path, columns):
    """Write columns of numbers as text."""
    with open(path, "w", encoding="utf-8") as stream:
        stream.writelines(" ".join(map(repr, row)) + "\n" for row in zip(*columns, strict=True))


def report(solver, particles, loop_seconds):
    """Print one measurement as a line of JSON."""
    measured = {
        "version": pysph.__version__,
        "threads": 1,
        "particles": particles,
        "steps": solver.count,
        "time": float(solver.t),
        "loop_seconds": loop_seconds,
        "particle_steps_per_s": particles * solver.count / loop_seconds,
        "length": example.L,
        "speed": example.U,
        "kinematic_viscosity": example.U * example.L / REYNOLDS,
    }
    print(json.dumps(measured))


if __name__ == "__main__":
    main()
