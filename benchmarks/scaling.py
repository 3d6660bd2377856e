"""Cost of a particle and step, pressure iterations and memory of the implicit scheme from 2500 particles to a million.

    python benchmarks/scaling.py            # to 100 thousand particles, two minutes
    python benchmarks/scaling.py --large    # to a million

Each case is a short ``tisph run`` in a process of its own, which says all this in its summary. Ends with status 1 where
the cost of a particle or the number of iterations grows by more than the bounds from the smallest case to the largest.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

COST, ITERATIONS = 1.5, 1.5
"""Bounds on their growth; in the channel that of the cost is 1.2."""

VORTEX = {
    "scene": "taylor_green",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"length": 1.0},
    "initial": {"velocity": 1.0, "jitter": 0.2},
}
CHANNEL = {
    "scene": "channel",
    "fluid": {"density": 1000.0, "dynamic_viscosity": 1.0e-3},
    "geometry": {"gap": 0.01, "length": 0.02},
    "walls": {"bottom": {"velocity": 0.0}, "top": {"velocity": 0.005}},
    "initial": {"jitter": 0.2},
    "time": {"end": 2.7},
}
STEPS = 25
"""Of a vortex, roughly: a step is at least half a spacing over the velocity of 1."""

HEADER = "| flow | particles | threads | step [us per particle] | pressure iterations a step | memory [MB] |"


def main():
    """Run the cases, print their table and the growth of each column."""
    sizes = [(50, 1), (100, 1), (316, 1), (316, 2), *([(1000, 2)] if "--large" in sys.argv else [])]
    print(f"{HEADER}\n|{'---|' * 6}")
    vortices = [measured("vortex", {**VORTEX, "time": {"end": 0.5 * STEPS / size[0]}}, *size) for size in sizes]
    channels = [measured("channel", CHANNEL, across, 1) for across in (50, 100, 200)]
    growths = [
        ("cost of a particle, vortex", vortices[2]["us"] / vortices[0]["us"], COST),
        ("iterations of the pressure", vortices[-1]["iterations"] / vortices[0]["iterations"], ITERATIONS),
        ("cost of a particle, channel", channels[-1]["us"] / channels[0]["us"], 1.2),
    ]
    for what, value, bound in growths:
        print(f"{'PASS' if value <= bound else 'FAIL'}: growth of the {what}: {value:.2f} (<= {bound:g})")
    sys.exit(any(value > bound for _, value, bound in growths))


def measured(flow, config, across, threads):
    """Run a case, print its line, and return its numbers."""
    change = {"discretisation": {"particles_across": across}, "runtime": {"threads": threads}}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.yaml"
        path.write_text(json.dumps({"name": flow, **config, **change, "output": {"video": None}}), encoding="utf-8")
        command = [sys.executable, "-m", "tisph", "run", path, "--out", Path(folder) / "out", "--no-pictures"]
        subprocess.run(list(map(str, command)), check=True, capture_output=True)
        summary = json.loads((Path(folder) / "out" / "summary.json").read_text(encoding="utf-8"))
    found = {
        "us": 1e6 / summary["cost"]["particle_steps_per_s"],
        "iterations": summary["numbers"].get("iterations_pressure"),
    }
    iterations = "" if found["iterations"] is None else f"{found['iterations']:.2f}"
    particles = summary["numbers"]["particles_fluid"]
    memory = summary["cost"]["peak_memory_mb"]
    print(f"| {flow} | {particles} | {threads} | {found['us']:.2f} | {iterations} | {memory:.0f} |", flush=True)
    return found


if __name__ == "__main__":
    main()
