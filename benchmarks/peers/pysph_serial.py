"""What the scripts share that run PySPH's own examples on one thread."""

import argparse
import json
import time

import pysph


def argument_parser(description, across):
    """Command line with the number of particles, ``across`` in words, and the end."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--across", type=int, default=50, help=across)
    parser.add_argument("--end", type=float, required=True, help="time to reach")
    parser.add_argument("--particles", required=True, help="file for x, y, u and v of every particle at the end")
    return parser


def solved(application, options):
    """Set ``application`` up, run its time loop, and return the seconds of the processor that the loop took."""
    application.setup(["--quiet", *options])
    start = time.process_time()
    application.solver.solve(show_progress=False)
    return time.process_time() - start


def write(path, fluid):
    """Write x, y, u and v of the particles as columns of text."""
    real = fluid.tag == 0  # the others are periodic images
    columns = [column[real].tolist() for column in (fluid.x, fluid.y, fluid.u, fluid.v)]
    with open(path, "w", encoding="utf-8") as stream:
        stream.writelines(" ".join(map(repr, row)) + "\n" for row in zip(*columns, strict=True))


def report(solver, fluid, loop_seconds, **more):
    """Print one measurement as a line of JSON."""
    particles = int((fluid.tag == 0).sum())
    measured = {
        "version": pysph.__version__,
        "threads": 1,
        "particles": particles,
        "steps": solver.count,
        "time": float(solver.t),
        "loop_seconds": loop_seconds,
        "particle_steps_per_s": particles * solver.count / loop_seconds,
        **more,
    }
    print(json.dumps(measured))
