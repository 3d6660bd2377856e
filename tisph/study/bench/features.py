"""What each part costs, and that a scene pays for nothing that it does not use: tables and numbers.

Rounds of measurements are kept in the folder of the results: an interrupted benchmark goes on with the same command.
"""

import json
import tempfile
from functools import partial
from pathlib import Path
from statistics import median, quantiles

from rich.console import Console

from tisph.config import load
from tisph.study.bench import lockstep, machine, video
from tisph.study.bench.feature_cases import AGAIN, EXPLICIT, GROUPS, PARTS, WITHOUT_CODE
from tisph.study.bench.stripped import STRIPPED, WHOLE, added_kernels, copy_twice
from tisph.study.store import config_text, fingerprint
from tisph.verification.flows import merged
from tisph.verification.table import format_table

ROUNDS, CYCLES = 3, 20
QUICK_ROUNDS, QUICK_CYCLES = 1, 12
COMPILED_STEPS = 60
"""Steps in which everything has happened once: rebuilt lists, a new time step, a balance of momentum."""

NOISE = 0.03
"""Of the time of a step: what a part that is not used may seem to cost."""

VIDEO_BOUND = 25.0
"""Milliseconds a frame."""

EVENT_NAMES = {"records": "line of history at 10 tracers, 401 a run", "checkpoints": "checkpoint"}


def run(folder, quick=False):
    """Measure, print the tables, leave ``features.json`` in ``folder``; False where a scene pays for unused parts."""
    kept = folder / "rounds"
    kept.mkdir(parents=True, exist_ok=True)
    print(f"finished rounds are kept in {kept} and used again by the same command\n", flush=True)
    with tempfile.TemporaryDirectory() as folder_of_copies, Console(stderr=True).status("") as status:
        copies, code = Path(folder_of_copies), fingerprint()
        deleted = copy_twice(copies, {flag for part in PARTS for flag in part.flags})
        cycles, rounds = QUICK_CYCLES if quick else CYCLES, {name: [] for name in GROUPS}
        for turn in range(QUICK_ROUNDS if quick else ROUNDS):
            for name in GROUPS:
                status.update(f"{name} scheme, round {turn + 1}")
                mark = _mark(code, GROUPS[name], cycles)
                measure = partial(lockstep.measure, GROUPS[name], copies, cycles)
                rounds[name].append(kept_round(kept / f"{name}_{turn}.json", mark, measure))
        status.update("compiled kernels")
        kernels = compare_kernels(copies)
        status.update("movie")
        movies = {case: video.measure(case) for case in list(video.CASES)[: 1 if quick else None]}
    rows = [row(name, comparison, rounds[name]) for name in GROUPS for comparison in GROUPS[name].comparisons]
    events = [event_row(name, event, rounds[name]) for name in GROUPS for event in lockstep.EVENTS]
    unused = [unused_row(part, deleted) for part in PARTS]
    verdicts = judge(rows, unused, kernels, movies)
    _show(rows, events, movies, unused)
    print("\n" + "\n".join(f"{'pass' if passed else 'FAIL'}: {text}" for text, passed in verdicts.items()))
    place = machine.describe()
    numbers = {"machine": place, "parts": rows, "events": events, "movies": movies, "unused": unused}
    numbers |= {"kernels": kernels, "verdicts": verdicts}
    (folder / "features.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    print(f"\n{place['processor']}, {place['cores']} cores, one thread; numbers: {folder / 'features.json'}")
    return all(verdicts.values())


def _mark(code, group, cycles):
    """What a round depends on, as JSON gives it back."""
    scenes = {name: vars(scene) for name, scene in group.scenes.items()}
    return json.loads(json.dumps([code, scenes, group.steps, cycles]))


def kept_round(path, mark, measure):
    """Return what ``measure()`` gave, in an earlier call if that left the same ``mark`` in the file ``path``."""
    if path.is_file():
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["mark"] == mark:
            return found["scenes"]
    measured = measure()
    path.write_text(json.dumps({"mark": mark, "scenes": measured}), encoding="utf-8")
    return measured


def compare_kernels(copies):
    """Return how many kernels the plain explicit scene compiles to, and how many others without the unused parts.

    ``copies``: the folder of ``copy_twice``.
    """
    plain = GROUPS["explicit"].scenes["plain"]

    def take_steps(program, environment):
        remote = lockstep.Remote(plain, copies / program, environment)
        try:
            remote.facts()
            remote.do("steps", COMPILED_STEPS)
        finally:
            remote.close()

    ours, others = added_kernels([partial(take_steps, program) for program in (WHOLE, STRIPPED)])
    return {"plain": len(ours), "others_without_unused_parts": len(others)}


def row(scheme, comparison, rounds):
    """Return what one comparison gave: seconds a step and bytes with and without, and the ratio of seconds.

    The ratio is the median over all turns of all rounds; half of them lie between ``low`` and ``high``. ``steps`` is
    the ratio of the numbers of steps to the same time.
    """
    pairs = [(one[comparison.scene], one[comparison.without]) for one in rounds]
    ratios = [ratio for with_it, without in pairs for ratio in _ratios(with_it["seconds"], without["seconds"])]
    low, middle, high = quantiles(ratios, n=4)
    with_it, without = pairs[0]
    return {
        "scheme": scheme,
        "part": comparison.part,
        "scene": comparison.scene,
        "without_part": comparison.without,
        "without": median(seconds for _, one in pairs for seconds in one["seconds"]),
        "with": median(seconds for one, _ in pairs for seconds in one["seconds"]),
        "ratio": middle,
        "low": low,
        "high": high,
        "steps": sum(without["advanced"]) / sum(with_it["advanced"]),
        "particles": with_it["particles"],
        "bytes_without": sum(without["fields"].values()),
        "bytes_with": sum(with_it["fields"].values()),
        "added_fields": {name: size for name, size in with_it["fields"].items() if name not in without["fields"]},
    }


def _ratios(some, others):
    return [one / other for one, other in zip(some, others, strict=True)]


def event_row(scheme, event, rounds):
    """Return seconds and bytes of something that happens now and then, and as how many steps it counts."""
    seconds = median(one["plain"][event]["seconds"] for one in rounds)
    step = median(seconds for one in rounds for seconds in one["plain"]["seconds"])
    size = rounds[0]["plain"][event]["bytes"]
    return {"scheme": scheme, "event": event, "seconds": seconds, "steps": seconds / step, "bytes": size}


def unused_row(part, deleted):
    """Return what there is of a part that a scene does not use.

    ``same_config``: saying so outright gives the same config as saying nothing. ``branches``: of code, which the
    stripped program does not have.
    """
    return {
        "part": part.name,
        "said": json.dumps(part.unused).replace('"', ""),
        "same_config": _resolved(merged(EXPLICIT, part.unused)) == _resolved(EXPLICIT),
        "branches": sum(deleted[flag] for flag in part.flags),
    }


def _resolved(config):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "config.yaml"
        path.write_text(config_text("scene", config), encoding="utf-8")
        return load(path, ())


def judge(rows, unused, kernels, movies):
    """Return whether each bound is met, by a line that says which and what was found."""
    carried = next(row for row in rows if row["without_part"] == WITHOUT_CODE)
    noise = max(abs(row["ratio"] - 1.0) for row in rows if row["scene"] == AGAIN)
    others, plain = kernels["others_without_unused_parts"], kernels["plain"]
    slowest = max(movie["total_ms"] for movie in movies.values())
    outright = all(one["same_config"] for one in unused)
    return {
        "leaving a part out and saying that it is not used are the same config": outright,
        f"without the code of unused parts {others} of {plain} compiled kernels differ (bound: 0)": others == 0,
        "without it the fields take as many bytes": carried["bytes_with"] == carried["bytes_without"],
        f"with it a step takes {carried['ratio']:.3f} of the time (bound: within {NOISE:.0%}; the same program twice: "
        f"{noise:.1%})": abs(carried["ratio"] - 1.0) <= NOISE,
        f"a frame of the movie takes {slowest:.1f} ms (bound: {VIDEO_BOUND:g})": slowest <= VIDEO_BOUND,
    }


def _show(rows, events, movies, unused):
    header = ("scheme", "part", "without [us]", "with [us]", "ratio", "spread", "steps", "without [B]", "with [B]", "+")
    print(format_table(header, list(map(_part_cells, rows))))
    print(
        "processor time of a step; half of the ratios are in the spread; number of steps to the same time, over that\n"
        "without; bytes of fields a particle, and bytes that are added in all\n"
    )
    print(format_table(("scheme", "now and then", "each [ms]", "steps", "kB"), list(map(_event_cells, events))))
    print("processor time, and as many steps as take that time\n")
    header = (f"movie of {video.FRAMES} frames", "the run waits [ms]", "drawing [ms]", "whole frame [ms]", "file [MB]")
    print(format_table(header, [_movie_cells(case, movie) for case, movie in movies.items()]) + "\n")
    print(format_table(("part", "not used", "config", "branches deleted"), list(map(_unused_cells, unused))))


def _part_cells(one):
    return (
        one["scheme"],
        one["part"],
        f"{1e6 * one['without']:.0f}",
        f"{1e6 * one['with']:.0f}",
        f"{one['ratio']:.3f}",
        f"{one['low']:.3f}..{one['high']:.3f}",
        f"{one['steps']:.2f}",
        f"{one['bytes_without'] / one['particles']:.1f}",
        f"{one['bytes_with'] / one['particles']:.1f}",
        str(one["bytes_with"] - one["bytes_without"]),
    )


def _event_cells(one):
    numbers = f"{1e3 * one['seconds']:.2f}", f"{one['steps']:.1f}", f"{one['bytes'] / 1e3:.1f}"
    return (one["scheme"], EVENT_NAMES[one["event"]], *numbers)


def _movie_cells(case, movie):
    times = (f"{movie[kind]:.1f}" for kind in ("waiting_ms", "drawing_ms", "total_ms"))
    return (case, *times, f"{movie['bytes'] / 1e6:.2f}")


def _unused_cells(one):
    return (one["part"], one["said"], "the same" if one["same_config"] else "ANOTHER", str(one["branches"]))
