"""The peers' points of the frontier: measured by the scripts in ``benchmarks/peers``, or quoted and scaled.

Codes that the package index does not have are quoted from measurements of the same case on another machine of two
cores, as multiples of what LAMMPS took there with two processes (``docs/performance.md``).
"""

import json
import subprocess
import sys

MEASURED = {
    "LAMMPS SPH, 2 processes": ("lammps", 2, ("couette_2.7", "couette_20")),
    "PySPH TVF, 1 thread": ("pysph", 1, ("couette_2.7",)),
    "PySPH TVF, 2 threads": ("pysph", 2, ("couette_2.7",)),
}
"""Code, threads and flows by label."""

ENDS = {"couette_2.7": 2.7, "couette_20": 20.0}
ACROSS = 50

PYSPH_LONG = 20.0 / 2.7
"""PySPH's steps are alike from the first to the last: its time to t = 20 is that to 2.7 by the ratio of steps."""

PYSPH_L2_AT_20 = 1.8e-3

QUOTED = {
    "SPHinXsys, quoted": (0.57, 2.3e-3, 7038),
    "DualSPHysics mDBC, quoted": (5.3, 4.1e-3, 17738),
    "JAX-SPH, quoted": (52.0, 3.0e-4, 22000),
}
"""Loop time to t = 20 over that of LAMMPS, L2, and steps, by label."""


def measure(scripts, folder, turn):
    """Rows of one round, as {(flow, label): {steps, l2, loop_seconds}}; those of an earlier call are used again."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for label, (code, threads, flows) in MEASURED.items():
        for flow in flows:
            kept = folder / f"{code}_{threads}_{flow}_round_{turn}.json"
            if not kept.is_file():
                words = ["--code", code, "--threads", threads, "--across", ACROSS, "--until", ENDS[flow]]
                command = [sys.executable, scripts / "measure.py", *words]
                done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
                kept.write_text(done.stdout, encoding="utf-8")
            found[flow, label] = json.loads(kept.read_text(encoding="utf-8"))
    return found


def merged(rounds):
    """``Measured`` of every peer over all rounds, those scaled and quoted included."""
    from tisph.study.bench.frontier import Measured

    rows = []
    for flow, label in rounds[0] if rounds else ():
        ones = [one[flow, label] for one in rounds]
        loops = tuple(one["loop_seconds"] for one in ones)
        rows.append(Measured(flow, label, ACROSS, ones[0]["steps"], ones[0]["l2"], loops, ()))
        if label.startswith("PySPH"):
            long = tuple(PYSPH_LONG * loop for loop in loops)
            steps = round(PYSPH_LONG * ones[0]["steps"])
            rows.append(Measured("couette_20", label, ACROSS, steps, PYSPH_L2_AT_20, long, (), elsewhere=True))
    lammps = next((row for row in rows if row.flow == "couette_20" and row.way.startswith("LAMMPS")), None)
    if lammps:
        for label, (factor, l2, steps) in QUOTED.items():
            times = (factor * lammps.loop,)
            rows.append(Measured("couette_20", label, ACROSS, steps, l2, times, (), elsewhere=True))
    return rows
