"""Start-up: what a run costs beside its time loop, counted in F, the least that a Taichi program costs on this machine.

F is a process that imports Taichi, NumPy and h5py, starts Taichi and runs one kernel that is in the cache. Each case
has a cache folder of its own, empty at first. It runs once to fill that (cold), then, in rounds, each kind in turn
beside a process that measures F: again (warm), and with another resolution, length and end time (resized), for which no
kernel may be compiled. What is said of cases is the median of the rounds.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from tisph.config import load
from tisph.errors import ConfigError, TisphError
from tisph.verification.table import format_header, format_row

PROGRAM = """\
import os

os.environ.update(ENABLE_TAICHI_HEADER_PRINT="0", TI_SKIP_VERSION_CHECK="ON")
import h5py, numpy, taichi as ti

ti.init(ti.cpu, offline_cache=True, offline_cache_file_path=os.path.join(os.path.dirname(__file__), "kernels"))
x = ti.field(ti.f64, 100)

@ti.kernel
def fill():
    for i in x:
        x[i] = i

fill()
"""

ROUNDS = 3
PART = 1e-3
"""Of the time of an explicit run that is run: its loop is none of what is measured here."""

WHOLE, COLD, MOVIE = 2.2, 7.5, 1.5
"""Bounds in F: a run but its loop, warm or resized; compiling into an empty cache, half of the 15 F that it took when
all was compiled for one number of particles; what 120 frames of a movie add."""

HEADER = ("case", "F [s]", "warm [F]", "resized [F]", "kernels compiled", "compile cold [F]", "movie [F]")


class Case(NamedTuple):
    """A config, overrides of all its runs, those that resize it, and whether its movie is measured too."""

    name: str
    config: str
    settings: tuple
    resized: tuple
    movie: bool = False


def cases(folder, quick):
    """Return the cases: the implicit scheme, and the explicit one with polymer and each wall; ``quick``: the first."""
    implicit = Case(
        "couette",
        "couette.yaml",
        (),
        ("discretisation.particles_across=37", "geometry.length=0.03", "time.end=3.1", "time.samples=[2.9, 3.1]"),
        movie=True,
    )
    if quick:
        return [implicit]
    path = folder / "oldroyd_b_couette.yaml"
    config = load(path, ())
    treatments = ("consistent_image", "comoving_image", "virtual_image", "fixed_image", "adami")
    ends = [PART * part * config.time.end for part in (1.0, 1.3)]
    first, other = ((f"time={{end: {end!r}}}",) for end in ends)
    resized = (*other, "discretisation.particles_across=40", f"geometry.length={1.5 * config.geometry.length!r}")
    explicit = [
        Case(f"polymer, {walls}", path.name, (*first, f"walls.treatment.type={walls}"), resized) for walls in treatments
    ]
    return [implicit, *explicit]


def run(folder, configs, quick=False):
    """Print a line for each case, whose configs are among ``configs`` (paths); leave ``startup.json`` in ``folder``.

    Returns whether all bounds are kept.
    """
    if not any(path.name == "couette.yaml" for path in configs):
        raise ConfigError("no configs: run this where configs/ is, or name a folder with --configs")
    where = configs[0].parent
    folder.mkdir(parents=True, exist_ok=True)
    chosen = cases(where, quick)
    widths = [max(len(case.name) for case in chosen), *map(len, HEADER[1:])]
    print(format_header(HEADER, widths), flush=True)
    rows = []
    for case in chosen:
        with tempfile.TemporaryDirectory() as home:
            rows.append(measured(case, where / case.config, Path(home)))
        print(format_row(cells(rows[-1]), widths), flush=True)
    (folder / "startup.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print(f"\nnumbers: {folder / 'startup.json'}")
    return all([kept(row) for row in rows])


def measured(case, config, home):
    """Return the figures of a case, seconds by kind, with its compiled kernels in ``home``."""
    program = home / "least.py"
    program.write_text(PROGRAM, encoding="utf-8")
    least = _clocked([sys.executable, program], home)  # fills its cache
    cold = _run(config, home, (*case.settings, "output.video=null"))
    resized = (*case.settings, *case.resized, "output.video=null")
    known = _kernels(home)
    first = _run(config, home, resized)
    compiled = len(_kernels(home) - known)
    kinds = {"warm": (*case.settings, "output.video=null"), "resized": resized}
    if case.movie:
        _run(config, home, case.settings)
        kinds["movie"] = case.settings
    rounds = {"least": [], **{kind: [] for kind in kinds}}
    for _ in range(ROUNDS):
        rounds["least"].append(_clocked([sys.executable, program], home))
        costs = {kind: _run(config, home, settings) for kind, settings in kinds.items()}
        for kind in costs.keys() - {"movie"}:
            rounds[kind].append(costs[kind]["beside"])
        if case.movie:
            rounds["movie"].append(costs["movie"]["whole"] - costs["warm"]["whole"])
    figures = {kind: statistics.median(values) for kind, values in rounds.items()}
    return {
        "case": case.name,
        "compiled": compiled,
        "compile_cold": cold["compile"],
        "first_least": least,
        "first_resized": first["beside"],
        **figures,
    }


def cells(row):
    """Return the cells of the line of a case."""
    least = row["least"]
    movie = f"{row['movie'] / least:.2f}" if "movie" in row else ""
    whole = (f"{row[kind] / least:.2f}" for kind in ("warm", "resized"))
    return (row["case"], f"{least:.2f}", *whole, str(row["compiled"]), f"{row['compile_cold'] / least:.2f}", movie)


def kept(row):
    """Print the bounds of a case; return whether they are kept."""
    least = row["least"]
    bounds = [
        ("warm run beside its loop", row["warm"] / least, WHOLE),
        ("resized run beside its loop", row["resized"] / least, WHOLE),
        ("kernels compiled for another size", row["compiled"], 0),
        ("compiling into an empty cache", row["compile_cold"] / least, COLD),
    ]
    if "movie" in row:
        bounds.append(("what the movie adds", row["movie"] / least, MOVIE))
    for what, value, bound in bounds:
        unit = "" if isinstance(bound, int) else " F"
        verdict = "PASS" if value <= bound else "FAIL"
        print(f"{verdict}: {row['case']}: {what}: {value:.3g}{unit} (<= {bound:g}{unit})")
    return all(value <= bound for _, value, bound in bounds)


def _run(config, home, settings):
    """Run a config; return the seconds of the ``whole`` process, of what is ``beside`` its loop, and on kernels."""
    out = home / "out"
    command = [sys.executable, "-m", "tisph", "run", config, "--out", out, "--overwrite"]
    seconds = _clocked([*command, *(word for setting in settings for word in ("--set", setting))], home)
    cost = json.loads((out / "summary.json").read_text(encoding="utf-8"))["cost"]
    return {"whole": seconds, "beside": seconds - cost["wall_loop_s"], "compile": cost["wall_compile_s"]}


def _clocked(command, home):
    """Return the seconds of a process that has its home, and so its caches, in ``home``.

    Python's own is among them, as of an installed package: no process parses modules that an earlier one has parsed.
    """
    places = {"HOME": home, "XDG_CACHE_HOME": home / ".cache", "PYTHONPYCACHEPREFIX": home / "modules"}
    environment = {**os.environ, **{name: str(path) for name, path in places.items()}}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    began = time.perf_counter()
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise TisphError(f"{' '.join(map(str, command))}: {done.stderr.strip().splitlines()[-1]}")
    return time.perf_counter() - began


def _kernels(home):
    return {path.name for path in home.rglob("*.tic")}
