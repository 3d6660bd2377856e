"""One run of one code of the comparison to a time, as a line of JSON: what ``tisph bench frontier`` calls.

python benchmarks/peers/measure.py --code lammps --threads 2 --across 50 --until 20
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import codes

CODES = {"lammps": codes.measure_lammps, "pysph": codes.measure_pysph, "tisph": codes.measure_tisph}


def main():
    """Make the environments if they are not there, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--threads", type=int, default=codes.THREADS)
    parser.add_argument("--across", type=int, default=50)
    parser.add_argument("--until", type=float, required=True, help="time to reach")
    arguments = parser.parse_args()
    subprocess.run(["make", "--silent", "-C", codes.HERE], check=True, stdout=sys.stderr)
    codes.THREADS = arguments.threads
    with tempfile.TemporaryDirectory() as folder:
        run = codes.Run.until(arguments.across, arguments.until)
        print(json.dumps(CODES[arguments.code](run, Path(folder))))


main()
