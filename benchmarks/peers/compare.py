"""Throughput of tisph beside PySPH (transport velocity) and LAMMPS (SPH): same flow, same machine, same call.

    python benchmarks/peers/compare.py [--across 50] [--repeats 3] [--steps 1000] [--errors]

Makes the peers' environments first (see Makefile; once), then runs the codes in turn, ``--repeats`` times,
with two threads or processes each and no output in the time loop, and prints one table;
benchmarks/results/peers.json keeps every run. What is timed is the time loop alone, after a short run of each
code that fills its compile cache. A particle-step is one fluid particle in one evaluation of all forces. The
ratio is the median over the rounds of tisph's throughput over that of the peer in the same round, so that a
machine that is slower for a while disturbs it least.

Exit status 1 if a ratio is below its bound, or if the machine was too busy to say (DISTURBED). ``--errors``
runs each code to t = 2.7 as well and prints its L2.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import couette_case as case
from codes import CODES, HERE, THREADS, Run
from load import OtherLoad

SPREAD = 1.15
"""Fastest over median run of a code above which it was disturbed: undisturbed runs stay within 1.1."""

OTHER_LOAD = 0.15
"""Median number of cores busy with other programs above which a code was disturbed."""

RESULT = HERE.parent / "results" / "peers.json"

WARM_UP_STEPS = 20
ERROR_TIME = 2.7
"""Time of the error comparison: nu t/gap^2 = 0.027, the later time of the tables of the peers' errors."""


def measure_rounds(run, repeats, folder):
    """Every code in turn, ``repeats`` times, after a short run of each; label -> list of measurements."""
    for code in CODES:
        note(f"warm-up: {code.label}")
        code.measure(Run.of_steps(run.across, WARM_UP_STEPS), folder)
    measured = {code.label: [] for code in CODES}
    for index in range(repeats):
        for code in CODES:
            note(f"round {index + 1} of {repeats}: {code.label}")
            with OtherLoad() as other:
                one = code.measure(run, folder)
            measured[code.label].append({**one, "other_load": other.cores})
    return measured


def note(text):
    """Say on the error stream what is being done: the output keeps the table alone."""
    print(text, file=sys.stderr, flush=True)


def summary_of(numbers):
    """Median and range as a dictionary."""
    return {"median": median(numbers), "min": min(numbers), "max": max(numbers)}


def other_load(runs):
    """Median number of cores busy with other programs; None where the system does not tell."""
    loads = [one["other_load"] for one in runs]
    return None if None in loads else median(loads)


def disturbed(runs):
    """Whether other programs may have slowed most of the runs of a code."""
    speeds = [one["particle_steps_per_s"] for one in runs]
    return max(speeds) > SPREAD * median(speeds) or (other_load(runs) or 0.0) > OTHER_LOAD


def verdict_on(code, ratio, measured):
    """PASS or FAIL of the bound of ``code``, DISTURBED where the machine was too busy, "" without a bound."""
    if code.bound is None:
        return ""
    if disturbed(measured[CODES[0].label]) or disturbed(measured[code.label]):
        return "DISTURBED"
    return "PASS" if ratio >= code.bound else "FAIL"


def row_of(code, measured):
    """One row of the table as a dictionary: throughput, ratio and verdict of ``code``."""
    tisph, own = ([one["particle_steps_per_s"] for one in measured[label]] for label in (CODES[0].label, code.label))
    ratio = summary_of([ours / theirs for ours, theirs in zip(tisph, own, strict=True)])
    return {
        "code": code.label,
        "version": measured[code.label][0]["version"],
        "particle_steps_per_s": summary_of(own),
        "ns_per_particle_step": 1e9 / median(own),
        "other_load": other_load(measured[code.label]),
        "ratio": ratio,
        "bound": code.bound,
        "verdict": verdict_on(code, ratio["median"], measured),
    }


def spread(numbers, digits):
    """Median and range of a quantity as text."""
    return "{median:.{0}f} ({min:.{0}f}..{max:.{0}f})".format(digits, **numbers)


def table(rows):
    """Markdown table of the rows."""
    lines = [
        "| code | 10^6 particle-steps/s, median (min..max) | ns per particle-step | other load, cores "
        "| tisph / code | bound | |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        bound = "-" if row["bound"] is None else f">= {row['bound']:g}"
        speed = {key: 1e-6 * value for key, value in row["particle_steps_per_s"].items()}
        cells = (
            row["code"],
            spread(speed, 3),
            f"{row['ns_per_particle_step']:.0f}",
            "unknown" if row["other_load"] is None else f"{row['other_load']:.2f}",
            spread(row["ratio"], 2),
            bound,
            row["verdict"],
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def machine():
    """Processor, cores and load of this machine: without them a throughput says nothing."""
    processor = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        models = [
            line.split(":", 1)[1].strip()
            for line in information.read_text(encoding="utf-8").splitlines()
            if line.startswith("model name")
        ]
        processor = models[0] if models else processor
    return {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
    }


def parse():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=int, default=50, help="particles between the walls")
    parser.add_argument("--repeats", type=int, default=3, help="rounds")
    parser.add_argument("--steps", type=int, default=1000, help="steps of the peers in a run")
    parser.add_argument("--errors", action="store_true", help=f"also run to t = {ERROR_TIME} and compare L2")
    return parser.parse_args()


def measure_errors(across, folder):
    """One run of each code to ``ERROR_TIME``; label -> measurement."""
    measured = {}
    for code in CODES:
        note(f"error at t = {ERROR_TIME}: {code.label}")
        measured[code.label] = code.measure(Run.until(across, ERROR_TIME), folder)
    return measured


def print_report(arguments, place, rows, errors):
    """Say what was measured, on what and with what, and show the table."""
    count = case.particles(arguments.across)
    print(f"{count} fluid particles, {arguments.steps} steps, {THREADS} threads or processes each")
    print(", ".join(f"{key} {value}" for key, value in place.items()))
    print("; ".join(f"{row['code']} {row['version']}" for row in rows))
    print("\n" + table(rows))
    if any(row["verdict"] == "DISTURBED" for row in rows):
        print("DISTURBED: other programs were running; measure on a quiet machine")
    for label, one in errors.items():
        cost = f"{one['steps']} steps, {one['loop_seconds']:.1f} s"
        print(f"L2 at t = {ERROR_TIME}: {label} {one['l2']:.2e} ({cost})")


def main():
    """Measure, print the table, keep the numbers; returns the exit status."""
    arguments = parse()
    subprocess.run(["make", "--silent", "-C", HERE], check=True, stdout=sys.stderr)
    place = machine()
    with tempfile.TemporaryDirectory() as name:
        run = Run.of_steps(arguments.across, arguments.steps)
        measured = measure_rounds(run, arguments.repeats, Path(name))
        errors = measure_errors(arguments.across, Path(name)) if arguments.errors else {}
    rows = [row_of(code, measured) for code in CODES]
    print_report(arguments, place, rows, errors)
    RESULT.parent.mkdir(parents=True, exist_ok=True)
    kept = {"machine": place, "case": vars(arguments), "table": rows, "runs": measured, "errors": errors}
    RESULT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    return 0 if all(row["verdict"] in ("", "PASS") for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
