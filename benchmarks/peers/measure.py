"""One run of one peer, as a line of JSON: what ``tisph bench`` calls.

    python benchmarks/peers/measure.py --code lammps --threads 2 --across 50 --until 20
    python benchmarks/peers/measure.py --code pysph --threads 1 --across 224 --steps 40

Keys: ``code``, ``version``, ``threads``, ``particles`` (fluid), ``steps``, ``loop_seconds``, ``particle_steps_per_s``,
``l2`` (null with ``--steps``: after a few steps nothing but a layer at the wall has moved) and ``neighbours``, those of
a particle of the lattice within the reach of the kernel.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import codes
import couette_case as case

CODES = {"lammps": codes.measure_lammps, "pysph": codes.measure_pysph, "pysph-edac": codes.measure_pysph_edac}


def main():
    """Make the environments if they are not there, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--threads", type=int, default=codes.THREADS)
    parser.add_argument("--across", type=int, default=50)
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument("--until", type=float, help="time to reach")
    length.add_argument("--steps", type=int, help="steps of the largest stable size to take")
    arguments = parser.parse_args()
    subprocess.run(["make", "--silent", "-C", codes.HERE], check=True, stdout=sys.stderr)
    codes.THREADS = arguments.threads
    print(json.dumps(measured(arguments)))


def measured(arguments):
    """What the run that the command line asks for gave, as a dictionary."""
    short = arguments.until is None
    run = (
        codes.Run.of_steps(arguments.across, arguments.steps)
        if short
        else codes.Run.until(arguments.across, arguments.until)
    )
    with tempfile.TemporaryDirectory() as folder:
        found = CODES[arguments.code](run, Path(folder))
    l2 = None if short else found["l2"]
    return {"code": arguments.code, **found, "l2": l2, "neighbours": case.lattice_neighbours()}


main()
