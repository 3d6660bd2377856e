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


def run(folder, configs):
    """Print a line for each of ``configs`` (paths) and leave ``startup.json`` in ``folder``."""
    if not configs:
        raise ConfigError("no configs: run this where configs/ is, or name a folder with --configs")
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
    print(f"\nnumbers: {folder / 'startup.json'}")


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
