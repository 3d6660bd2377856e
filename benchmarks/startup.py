"""What a run costs beside its time loop, beside the least that a Taichi program costs on this machine.

    python benchmarks/startup.py --output startup.json
    python -m pyperf stats startup.json

The least is a process that imports Taichi, NumPy and h5py, starts Taichi and runs one kernel that is in the cache. Each
process of a case has a cache of its own: empty (cold), filled by the same run (warm), or by one with another
resolution, length and end (resized), for which no kernel may be compiled. ``with movie`` is the warm run with its
movie. Medians over that of the least are printed at the end.
"""

import atexit
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

import pyperf

CONFIGS = Path(__file__).resolve().parents[1] / "configs"

LEAST = """\
import os
os.environ.update(ENABLE_TAICHI_HEADER_PRINT="0", TI_SKIP_VERSION_CHECK="ON")
import h5py, numpy, taichi as ti
ti.init(ti.cpu, offline_cache=True)
x = ti.field(ti.f64, 100)
@ti.kernel
def fill():
    for i in x:
        x[i] = i
fill()
"""

PLAIN = ("output.video=null",)
COUETTE = (
    "discretisation.particles_across=37", "geometry.length=0.03", "time.end=3.1", "time.samples=[2.9, 3.1]", *PLAIN
)  # fmt: skip
POLYMER = ("scheme={type: wcsph}", "time={end: 0.002}", *PLAIN)
CASES = {
    "couette, cold": ("couette", None, PLAIN),
    "couette, warm": ("couette", PLAIN, PLAIN),
    "couette, resized": ("couette", PLAIN, COUETTE),
    "couette, with movie": ("couette", (), ()),
    "explicit, polymer, warm": ("oldroyd_b_couette", POLYMER, POLYMER),
    "explicit, polymer, resized": ("oldroyd_b_couette", POLYMER, (*POLYMER, "discretisation.particles_across=40")),
}
"""Config, overrides of the run that fills the cache (None: none), and of those that are timed, by name."""


def beside_the_loop(times, config, first, settings):
    """Return the seconds of so many runs less those of their loops."""
    total = 0.0
    for _ in range(times):
        home = filled(config, first) if first is not None else cache_folder()
        kernels = set(home.rglob("*.tic"))
        total += run(home, config, settings)
        if first is not None and set(home.rglob("*.tic")) != kernels:
            raise SystemExit(f"{config}: kernels were compiled for {settings} after {first}")
    return total


def least(times):
    """Return the seconds of so many of the least programs."""
    home = filled("least", ())
    return sum(clocked(home, [sys.executable, home / "least.py"]) for _ in range(times))


@cache
def filled(config, first):
    """Return a home whose cache a run has filled, the same one for every call in this process."""
    home = cache_folder()
    if config == "least":
        (home / "least.py").write_text(LEAST, encoding="utf-8")
        clocked(home, [sys.executable, home / "least.py"])
    else:
        run(home, config, first)
    return home


def cache_folder():
    """Return a new folder, which this process removes at its end."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def run(home, config, settings):
    """Run a config; return the seconds of the process less those of its loop."""
    words = [word for setting in settings for word in ("--set", setting)]
    out = home / "out"
    command = [sys.executable, "-m", "tisph", "run", CONFIGS / f"{config}.yaml", "--out", out, "--overwrite", *words]
    seconds = clocked(home, command)
    return seconds - json.loads((out / "summary.json").read_text(encoding="utf-8"))["cost"]["wall_loop_s"]


def clocked(home, command):
    """Return the seconds of a process that has its caches, Python's own among them, in ``home``."""
    places = {"HOME": home, "XDG_CACHE_HOME": home / ".cache", "PYTHONPYCACHEPREFIX": home / "modules"}
    began = time.perf_counter()
    subprocess.run(
        list(map(str, command)),
        check=True,
        capture_output=True,
        env={**os.environ, **{k: str(v) for k, v in places.items()}},
    )
    return time.perf_counter() - began


def main():
    """Measure all cases and print their ratios to the least."""
    runner = pyperf.Runner(values=1, warmups=0, loops=1, processes=5)
    found = {"least": runner.bench_time_func("least", least)}
    for name, case in CASES.items():
        found[name] = runner.bench_time_func(name, beside_the_loop, *case)
    if None not in found.values():
        for name, one in found.items():
            print(f"{name}: {one.median():.2f} s, {one.median() / found['least'].median():.2f} times the least")


if __name__ == "__main__":
    main()
