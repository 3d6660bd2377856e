"""Processor time of output beside that of the steps, of 20 configs without pictures; with ``--movie`` what movies add.

    python benchmarks/output.py [NAME ...] [--movie]

Each config runs alone, on one thread; NAME restricts the list. The bound is a tenth of the steps where these take 5 s
or more, else 0.3 s on an idle machine. On a busy one only ratios count. ``--movie`` runs each again with a movie of 120
frames and adds the seconds of the clock by which the whole run is longer, at most 2 s on an idle machine.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

CONFIGS = Path(__file__).resolve().parents[1] / "configs"

CASES = {
    "couette": (),
    "couette_re1000": (),
    "oldroyd_b_couette": (),
    "stopped_wall": (),
    "creep_and_recovery": (),
    "flow_curve": (),
    "cylinder_in_channel": (),
    "cylinder_lattice": (),
    "free_cylinder": (),
    "jeffery_orbit": ("time={end: 1.0, samples: [1.0]}",),
    "backward_step": ("time={end: 1.0, samples: [1.0]}",),
    "cylinder_in_stream": ("time={end: 0.2, samples: [0.2]}",),
    "taylor_green": (),
    "shear_layer": (),
    "cavity_regular": ("time={end: 5.0, samples: [5.0]}",),
    "circular_couette": (),
    "eccentric_annulus": (),
    "taylor_vortices": (),
    "pipe": (),
    "sphere_in_tube": (),
}
"""Config -> overrides, which shorten the longest runs."""

SHORT, SHARE, LEAST = 5.0, 0.1, 0.3
"""Seconds of steps below which output may take ``LEAST`` seconds, and its share of the steps above."""


def run(name, *options):
    """Return the cost of a run, and the number of lines of its history."""
    with tempfile.TemporaryDirectory() as folder:
        settings = [word for override in ("runtime.threads=1", *CASES[name]) for word in ("--set", override)]
        command = [sys.executable, "-m", "tisph", "run", CONFIGS / f"{name}.yaml", "--out", folder, "--quiet"]
        subprocess.run([*command, *settings, *options], check=True)
        lines = (Path(folder) / "history.csv").read_text(encoding="utf-8").splitlines()
        cost = json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8"))["cost"]
    return cost, sum(not line.startswith("#") for line in lines) - 1


def main():
    """Print a line for each config, and how many are within the bound."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--movie", action="store_true", help="also with a movie of 120 frames")
    chosen = parser.parse_args()
    names = chosen.names or CASES
    print("| config | steps | lines | steps [s] | output [s] | output/steps | within |" + " movie [s] |" * chosen.movie)
    print("|---|---|---|---|---|---|---|" + "---|" * chosen.movie)
    within = 0
    for name in names:
        cost, lines = run(name, "--no-pictures")
        loop, output = cost["processor_loop_s"], cost["processor_output_s"]
        good = output <= (SHARE * loop if loop >= SHORT else LEAST)
        within += good
        row = f"| {name} | {cost['steps']} | {lines} | {loop:.2f} | {output:.2f} | {output / loop:.3f} | {good} |"
        if chosen.movie:
            film, _ = run(name, "--set", "output.video.frames=120")
            row += f" {film['wall_total_s'] - cost['wall_total_s']:.1f} |"
        print(row, flush=True)
    print(f"{within} of {len(names)} within the bound")


if __name__ == "__main__":
    main()
