"""The case that all codes run: plane Couette flow from rest, the top wall moving, at Reynolds number 50.

Any self-consistent units. Sound speed ten times the wall speed, particles on a square lattice, periodic along
the walls. Standard library only: this file is read by three Python environments.
"""

import argparse
import json

GAP = 1.0
LENGTH = 2.0
DENSITY = 1.0
KINEMATIC_VISCOSITY = 0.01
WALL_VELOCITY = 0.5
SOUND_SPEED = 5.0

COURANT = 0.25
"""Step over smoothing length / (sound speed + wall speed), with smoothing length = spacing."""

VISCOUS = 0.125
"""Step over smoothing length^2 / kinematic viscosity. Source of both limits, which both peers get here:
J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214-226."""

SUPPORT = 3
"""Radius of the peers' kernels (quintic spline with smoothing length = spacing, Lucy's) over the spacing."""


def lattice_neighbours():
    """Number of particles of a square lattice within the kernel of one of them, itself and the rim not counted."""
    offsets = range(-SUPPORT, SUPPORT + 1)
    return sum(0 < x**2 + y**2 < SUPPORT**2 for x in offsets for y in offsets)


def spacing(across):
    """Particle spacing [length] with ``across`` particles between the walls."""
    return GAP / across


def particles(across):
    """Number of fluid particles."""
    return across * round(LENGTH / spacing(across))


def stable_time_step(across):
    """Largest stable step [time] of an explicit scheme with this sound speed."""
    width = spacing(across)
    return min(COURANT * width / (SOUND_SPEED + WALL_VELOCITY), VISCOUS * width**2 / KINEMATIC_VISCOSITY)


def argument_parser(description):
    """Command line that the two peers' scripts share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--across", type=int, default=50, help="particles between the walls")
    parser.add_argument("--steps", type=int, default=1000, help="number of steps")
    parser.add_argument(
        "--end", type=float, help="time to reach in these steps (default: steps of largest stable size)"
    )
    parser.add_argument("--profile", help="file for y and u of every fluid particle at the end")
    parser.add_argument("--dump", help="file for the end as the code itself writes it, for tisph compare")
    return parser


def time_step(arguments):
    """Step that the command line asks for; ValueError if it is above the stability limit."""
    limit = stable_time_step(arguments.across)
    step = limit if arguments.end is None else arguments.end / arguments.steps
    if step > limit * (1 + 1e-9):  # rounding of end / steps
        raise ValueError(f"--end {arguments.end:g} in {arguments.steps} steps: step {step:.3g} above {limit:.3g}")
    return step


def report(*, version, across, steps, loop_seconds, threads):
    """Print one measurement as a line of JSON; a step is one evaluation of all forces."""
    measured = {
        "version": version,
        "threads": threads,
        "particles": particles(across),
        "steps": steps,
        "loop_seconds": loop_seconds,
        "particle_steps_per_s": particles(across) * steps / loop_seconds,
    }
    print(json.dumps(measured))


def write_profile(path, rows):
    """Write the (y, u) pairs in ``rows`` as two columns of text."""
    with open(path, "w", encoding="utf-8") as stream:
        stream.writelines(f"{y!r} {u!r}\n" for y, u in rows)
