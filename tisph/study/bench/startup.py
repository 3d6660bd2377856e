"""Start-up: import, compiling cold and warm, and the first frames, config by config.

Each config runs twice, to a thousandth of its time and with two frames, in processes of their own with a cache folder
of their own: empty the first time (cold), filled the second time (warm).
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from tisph.config import load
from tisph.errors import ConfigError, TisphError
from tisph.verification.table import format_header, format_row

HEADER = ("config", "import [s]", "compile cold [s]", "compile warm [s]", "first frames [s]", "whole warm [s]")
PART = 1e-3

BOUNDED = "couette.yaml"
COLD_BOUND, WARM_BOUND = 8.0, 1.5
"""Seconds of import and compiling before the first step of that config."""


def run(folder, configs, quick=False):
    """Print a line for each of ``configs`` (paths) and leave ``startup.json`` in ``folder``; ``quick``: for one only.

    Returns whether the bounds on the first step are kept.
    """
    if not configs:
        raise ConfigError("no configs: run this where configs/ is, or name a folder with --configs")
    configs = [path for path in configs if path.name == BOUNDED] if quick else configs
    folder.mkdir(parents=True, exist_ok=True)
    widths = [max(len(HEADER[0]), *(len(path.name) for path in configs)), *map(len, HEADER[1:])]
    print(format_header(HEADER, widths), flush=True)
    rows = []
    for path in configs:
        with tempfile.TemporaryDirectory() as home:
            cold, warm = (_costs(path, Path(home)) for _ in range(2))
        rows.append({"config": path.name, "cold": cold, "warm": warm})
        seconds = (
            warm["wall_import_s"],
            cold["wall_compile_s"],
            warm["wall_compile_s"],
            warm["wall_output_s"],
            warm["wall_total_s"],
        )
        print(format_row((path.name, *(f"{value:.2f}" for value in seconds)), widths), flush=True)
    (folder / "startup.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    passed = [_within(row) for row in rows if row["config"] == BOUNDED]
    print(f"\nnumbers: {folder / 'startup.json'}")
    return all(passed)


def _within(row):
    """Print what it takes before the first step, cold and warm, beside the bounds; return whether they are kept."""
    cold, warm = (row[key]["wall_import_s"] + row[key]["wall_compile_s"] for key in ("cold", "warm"))
    passed = cold <= COLD_BOUND and warm <= WARM_BOUND
    bounds = f"cold {cold:.2f} s (<= {COLD_BOUND:g}), warm {warm:.2f} s (<= {WARM_BOUND:g})"
    print(f"\n{'PASS' if passed else 'FAIL'}: before the first step of {BOUNDED}: {bounds}")
    return passed


def _costs(path, home):
    """Costs of a short run of the config ``path`` with its compiled kernels in ``home``."""
    config = load(path, ())
    end = config.start_time + PART * (config.time.end - config.start_time)
    changes = [f"time={{end: {end!r}}}", "output.video.frames=2"]
    out = home / "out"
    command = [sys.executable, "-m", "tisph", "run", path, "--out", out, "--overwrite"]
    command += [word for change in changes for word in ("--set", change)]
    environment = {**os.environ, "HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache")}
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise TisphError(f"{path}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))["cost"]
