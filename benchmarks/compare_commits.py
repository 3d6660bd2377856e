"""Compare two checkouts: seconds of runs, interleaved, their errors, and the bits of their results.

    python benchmarks/compare_commits.py OLD NEW --configs configs/couette.yaml --set output.video=null --rounds 7
    python benchmarks/compare_commits.py OLD NEW --errors-only          # every config of OLD once, in one table
    python benchmarks/compare_commits.py OLD NEW --bits                 # the same bits? of a few steps of everything

OLD and NEW are folders that hold a package ``tisph``, such as clones or ``git worktree``s. In every round each config
runs once in each checkout, the order alternating, so that whatever else the machine does meets both; a round before the
first fills the caches. Times are medians of ``cost`` in summary.json: of the time loop, of everything beside it, and of
the whole run; behind each ratio are the smallest and the largest of the rounds. Of errors the table has the largest
ratio over all samples and quantities.

``--bits`` runs every config of OLD and the cases of freeze.yaml on one thread, each to a fraction of its end, in both
checkouts at the same time, and compares the arrays of samples.h5. The exit status is 1 where one of them differs, or
where a case does not run in OLD. ``--only TEXT``: cases with this text in their names.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
from ruamel.yaml import YAML

ERRORS = ("l2", "linf", "rms")
ERROR_ENDINGS = ("_l2", "_linf", "_rms", "_error")
"""How errors begin and end; a value beside its ``_exact`` has an error, too."""

ROUND_OFF = 1e-11
"""Errors, over the value where that is above 1, below which a ratio says nothing."""

NOT_COMPARED = ("t", "step", "t_star", "resolved", "density_variation", "divergence_over_gradient", "momentum_drift")
NOT_COMPARED += ("max_transverse_velocity", "nearest_two", "largest_hole", "min_distance", "max_void_radius")
"""Of a state, but of no flow: they say how particles lie, or are round-off."""

UNLIKE = ("_exact", "_change")

SHORT = {"wcsph": 400, "implicit": 40}
"""Steps of a case of ``--bits``, by scheme: enough for every order of the time integration, and for shifts."""

MOST_PARTICLE_STEPS = 1e5
"""Fewer steps are made, at least eight, where they would be more."""

PLANNED = """
import json, sys
from tisph.schemes._forecast import forecast
from tisph.config import load
config = load(sys.argv[1], sys.argv[2:])
numbers, _ = forecast(config)
kind = "wcsph" if numbers["sound_speed"] else "implicit"
print(json.dumps([numbers["particles"], numbers["steps"], config.start_time, config.time.end, kind]))
"""
"""What OLD says of a run beforehand."""


def main():
    """Run everything and print the tables; return the exit status."""
    options = arguments()
    if options.bits:
        return compare_bits(options.old.resolve(), options.new.resolve(), options.only)
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
    return 0


def arguments():
    """Return the words of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--configs", type=Path, nargs="+", help="default: all of OLD/configs")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--errors-only", action="store_true", help="one round, without pictures and times")
    parser.add_argument("--bits", action="store_true", help="a short version of everything: are the results the same?")
    parser.add_argument("--only", default="", metavar="TEXT", help="with --bits: cases with this text in their names")
    options = parser.parse_args()
    options.rounds = 1 if options.errors_only else options.rounds + 1
    return options


def compare_bits(old, new, only):
    """Print the table of ``--bits``; return the exit status."""
    different = []
    chosen = {name: case for name, case in frozen_cases(old).items() if only in name}
    if not chosen:
        sys.exit(f"--only {only}: no case has this in its name")
    print("| case | samples.h5 | steps: old, new | largest error ratio | largest change | loop, new / old |")
    print("|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        for checkout in (old, new):
            check(checkout, folder)
        for name, (config, settings) in chosen.items():
            settings = shortened(old, config, settings, folder)
            outs = [Path(folder) / f"{name}_{which}" for which in ("old", "new")]
            each = lambda checkout, out: summary_of(checkout, out, config, settings, ["--no-pictures"])  # noqa: B023, E731
            summaries = list(pool.map(each, (old, new), outs))
            ran = all(one.get("cost", {}).get("steps") for one in summaries)
            verdict = difference(*outs) if ran else "did not run"
            print(bits_row(name, verdict, *summaries), flush=True)
            if verdict:
                different.append(name)
    print(f"\n{len(chosen) - len(different)} of {len(chosen)} cases have the same bits", *different, sep="; ")
    return 1 if different else 0


def frozen_cases(checkout):
    """Return (config, texts of --set) by case: all configs of ``checkout``, and the cases of freeze.yaml."""
    more = YAML(typ="safe").load(Path(__file__).with_name("freeze.yaml"))
    settings = {path.stem: {} for path in sorted((checkout / "configs").glob("*.yaml"))}
    settings |= {f"{stem}-{name}": given for stem, cases in more.items() for name, given in cases.items()}
    cases = {}
    for name, given in settings.items():
        given = {"runtime.threads": 1, "output.video": None, **given}
        texts = [f"{key}={json.dumps(value)}" for key, value in given.items()]
        cases[name] = checkout / "configs" / f"{name.partition('-')[0]}.yaml", texts
    return cases


def shortened(checkout, config, settings, folder):
    """Return the texts of --set of a short run, whose number of steps ``checkout`` estimates."""
    done = python(checkout, folder, "-c", PLANNED, config, *settings)
    if done.returncode:
        sys.exit(f"{config.stem} {settings}: {done.stderr.strip().splitlines()[-1]}")
    particles, steps, start, end, kind = json.loads(done.stdout.splitlines()[-1])
    wanted = max(8, min(SHORT[kind], int(MOST_PARTICLE_STEPS / particles)))
    duration = (end - start) * min(1.0, wanted / steps)
    times = [float(f"{start + part * duration:.6g}") for part in (0.5, 1.0)]
    return [*settings, f"time.end={times[1]}", f"time.samples={times}"]


def summary_of(checkout, out, config, settings, flags):
    """Run ``config`` with the package of ``checkout`` into ``out``; return its summary, or the end of the message."""
    path = out / "summary.json"
    path.unlink(missing_ok=True)
    words = [
        "run",
        config,
        "--out",
        out,
        "--overwrite",
        *flags,
        *(word for text in settings for word in ("--set", text)),
    ]
    done = python(checkout, out.parent, "-m", "tisph", *words)
    return json.loads(path.read_text()) if path.is_file() else {"status": done.stderr[-200:].strip()}


def difference(old, new):
    """Return the names of the arrays of samples.h5 that differ between two folders, "" where all are equal."""
    contents = []
    for folder in (old, new):
        path = folder / "samples.h5"
        if not path.is_file():
            return "no samples"
        with h5py.File(path) as file:
            contents.append(dict(arrays(file)))
    before, after = contents
    unlike = [name for name in before.keys() & after.keys() if before[name].tobytes() != after[name].tobytes()]
    return ", ".join([*sorted(before.keys() ^ after.keys()), *sorted(unlike)])


def arrays(group):
    """Yield (name, array) of everything in a group of a file and the groups in it."""
    for item in group.values():
        if isinstance(item, h5py.Dataset):
            yield item.name, item[...]
        else:
            yield from arrays(item)


def bits_row(name, verdict, old, new):
    """Return the line of a case, in whose arrays ``verdict`` is unlike."""
    errors, changes = largest_changes(old, new) if verdict else ("", "")
    steps = ", ".join(str(one["cost"]["steps"]) if "cost" in one else one["status"] for one in (old, new))
    loops = [one["cost"]["wall_loop_s"] for one in (old, new) if one.get("cost", {}).get("steps")]
    times = f"{loops[1] / loops[0]:.2f}" if len(loops) == 2 else ""
    return f"| {name} | {verdict or 'same'} | {steps} | {errors} | {changes} | {times} |"


def check(checkout, folder):
    """Stop unless the package in ``checkout`` is what runs."""
    found = python(checkout, folder, "-c", "import tisph; print(tisph.__file__)").stdout.strip()
    if not found.startswith(str(checkout)):
        sys.exit(f"{checkout}: there is no package tisph that runs, but {found or 'none'}")


def in_turn(checkouts, config, options, number, folder):
    """Return the summaries (old, new) of a round."""
    found = {}
    for checkout in checkouts if number % 2 == 0 else reversed(checkouts):
        flags = ["--no-pictures"] if options.errors_only else []
        found[checkout] = summary_of(checkout, Path(folder) / "out", config, options.settings, flags)
    return [found[checkout] for checkout in checkouts]


def python(checkout, folder, *words):
    """Run Python with the package of ``checkout``, from a folder that has none."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def error_row(name, old, new):
    """Return the line of a config: ``old`` and ``new`` are summaries."""
    states = [f"{len(one.get('samples', ()))} {one['status']}" for one in (old, new)]
    return f"| {name} | {states[0]} | {states[1]} | {' | '.join(largest_changes(old, new))} |"


def largest_changes(old, new):
    """Return the words of the largest ratio of an error, and of the largest change of a value without one."""
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
    return largest(ratios), largest(changes)


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
    sys.exit(main())
