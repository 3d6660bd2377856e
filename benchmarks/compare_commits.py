"""Compare two checkouts: seconds of runs, interleaved, and their errors.

    python benchmarks/compare_commits.py OLD NEW --configs configs/couette.yaml --set output.video=null --rounds 7
    python benchmarks/compare_commits.py OLD NEW --errors-only          # every config of OLD once, in one table

OLD and NEW are folders that hold a package ``tisph``, such as clones or ``git worktree``s. In every round each config
runs once in each checkout, the order alternating, so that whatever else the machine does meets both; a round before the
first fills the caches. Times are medians of ``cost`` in summary.json: of the time loop, of everything beside it, and of
the whole run; behind each ratio are the smallest and the largest of the rounds. Of errors the table has the largest
ratio over all samples and quantities.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ERRORS = ("l2", "linf", "rms")
ERROR_ENDINGS = ("_l2", "_linf", "_rms", "_error")
"""How errors begin and end; a value beside its ``_exact`` has an error, too."""

ROUND_OFF = 1e-11
"""Errors, over the value where that is above 1, below which a ratio says nothing."""

NOT_COMPARED = ("t", "step", "t_star", "resolved", "density_variation", "divergence_over_gradient", "momentum_drift")
NOT_COMPARED += ("max_transverse_velocity", "nearest_two", "largest_hole", "min_distance", "max_void_radius")
"""Of a state, but of no flow: they say how particles lie, or are round-off."""

UNLIKE = ("_exact", "_change")


def main():
    """Run everything and print the tables."""
    options = arguments()
    checkouts = [options.old.resolve(), options.new.resolve()]
    configs = [path.resolve() for path in options.configs or sorted((checkouts[0] / "configs").glob("*.yaml"))]
    with tempfile.TemporaryDirectory() as folder:
        for checkout in checkouts:
            check(checkout, folder)
        lines = []
        for config in configs:
            rounds = [in_turn(checkouts, config, options, number, folder) for number in range(options.rounds)]
            rounds = rounds[1:] or rounds  # the first fills the caches
            lines.append((config.stem, rounds))
            print(error_row(config.stem, *rounds[0]), file=sys.stderr, flush=True)
    print("| config | old: samples, status | new | largest error ratio, new / old | largest change of another value |")
    print("|---|---|---|---|---|")
    print("\n".join(error_row(name, *rounds[0]) for name, rounds in lines))
    if not options.errors_only:
        print("\n| config | loop, new / old | beside the loop | whole run | median seconds of the loop: old, new |")
        print("|---|---|---|---|---|")
        print("\n".join(time_row(name, rounds) for name, rounds in lines))


def arguments():
    """Return the words of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--configs", type=Path, nargs="+", help="default: all of OLD/configs")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--errors-only", action="store_true", help="one round, without pictures and times")
    options = parser.parse_args()
    options.rounds = 1 if options.errors_only else options.rounds + 1
    return options


def check(checkout, folder):
    """Stop unless the package in ``checkout`` is what runs."""
    found = python(checkout, folder, "-c", "import tisph; print(tisph.__file__)").stdout.strip()
    if not found.startswith(str(checkout)):
        sys.exit(f"{checkout}: there is no package tisph that runs, but {found or 'none'}")


def in_turn(checkouts, config, options, number, folder):
    """Return the summaries (old, new) of a round."""
    found = {}
    for checkout in checkouts if number % 2 == 0 else reversed(checkouts):
        out = Path(folder) / "out"
        more = ["--no-pictures"] if options.errors_only else []
        words = ["run", config, "--out", out, "--overwrite", *more]
        done = python(checkout, folder, "-m", "tisph", *words, *(w for s in options.settings for w in ("--set", s)))
        path = out / "summary.json"
        found[checkout] = json.loads(path.read_text()) if path.is_file() else {"status": done.stderr[-200:].strip()}
        path.unlink(missing_ok=True)
    return [found[checkout] for checkout in checkouts]


def python(checkout, folder, *words):
    """Run Python with the package of ``checkout``, from a folder that has none."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def error_row(name, old, new):
    """Return the line of a config: ``old`` and ``new`` are summaries."""
    ratios, changes = [], []
    for before, after in zip(old.get("samples", ()), new.get("samples", ()), strict=False):
        for key, (error, value) in quantities(before).items():
            other = quantities(after).get(key)
            what = f"{key} at t = {before['t']:.4g}"
            if other is None:
                changes.append((math.inf, f"{what} missing"))
            elif error is None:
                change = abs(other[1] / value - 1) if abs(value) > ROUND_OFF else abs(other[1] - value)
                changes.append((change, f"{change:.2g} ({what}: {value:.6g}, {other[1]:.6g})"))
            elif max(error, other[0]) > ROUND_OFF * max(1.0, abs(value)):
                ratio = other[0] / error if error else math.inf
                ratios.append((ratio, f"{ratio:.3f} ({what}: {error:.3g}, {other[0]:.3g})"))
    states = [f"{len(one.get('samples', ()))} {one['status']}" for one in (old, new)]
    return f"| {name} | {states[0]} | {states[1]} | {largest(ratios)} | {largest(changes)} |"


def quantities(sample):
    """Return (error, value) of every number of a sample, by key; error None where there is no exact one.

    The parts of a mapping, such as the forces on a body, go by ``body.drag``.
    """
    found, values = {}, dict(flat(sample))
    for key, value in values.items():
        if key in NOT_COMPARED or key.endswith(UNLIKE):
            continue
        exact = values.get(f"{key}_exact")
        if key.startswith(ERRORS) or key.endswith(ERROR_ENDINGS):
            found[key] = (value, value)
        else:
            found[key] = (None if exact is None else abs(value - exact), value)
    return found


def flat(mapping, prefix=""):
    """Yield (key, number) of all finite numbers of a mapping in mappings and lists."""
    entries = mapping.items() if isinstance(mapping, dict) else enumerate(mapping)
    for key, value in entries:
        if isinstance(value, dict | list):
            yield from flat(value, f"{prefix}{key}.")
        elif isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
            yield f"{prefix}{key}", value


def largest(found):
    """Return the words of the largest number."""
    return max(found)[1] if found else ""


def time_row(name, rounds):
    """Return the line of a config: ``rounds`` hold the summaries (old, new)."""
    costs = [[one.get("cost") for one in both] for both in rounds]
    if any(one is None or not one["steps"] for both in costs for one in both):
        return f"| {name} | did not run in both | | | |"
    cells = [ratio(costs, seconds) for seconds in (loop, beside, whole)]
    medians = ", ".join(f"{statistics.median(loop(both[k]) for both in costs):.3f}" for k in (0, 1))
    return f"| {name} | {' | '.join(cells)} | {medians} |"


def ratio(costs, seconds):
    """Return the ratio of the medians, with the smallest and largest ratio of a round."""
    old, new = ([seconds(both[k]) for both in costs] for k in (0, 1))
    each = [after / before for before, after in zip(old, new, strict=True)]
    return f"{statistics.median(new) / statistics.median(old):.3f} ({min(each):.2f}..{max(each):.2f})"


def loop(cost):
    """Seconds of the time loop."""
    return cost["wall_loop_s"]


def whole(cost):
    """Seconds of the run."""
    return cost["wall_total_s"]


def beside(cost):
    """Seconds of everything but the time loop."""
    return whole(cost) - loop(cost)


if __name__ == "__main__":
    main()
