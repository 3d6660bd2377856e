"""The sweep of 60 small runs in benchmarks/sweep.yaml: two processes against one, killed and gone on with, on Dask.

    python benchmarks/sweep.py FOLDER

needs a quiet machine of two cores for eight minutes, and Dask. It prints a line for each part and ends with status 1
where two processes are not 1.8 times as fast as one, or where a table differs from that of the first part.
"""

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

STUDY = Path(__file__).with_name("sweep.yaml")

ROUNDS = 2
"""Times that one process and two run, interleaved: the sums are compared."""

FASTER = 1.8
"""What two processes must be faster by."""

HALF = 30
"""Rows of the table after which something is killed."""

ADDRESS = "tcp://127.0.0.1:8786"


def main():
    """Run all parts and say what came of them."""
    folder = Path(sys.argv[1])
    rounds = [[timed(folder / f"{number}", "--processes", number) for number in (1, 2)] for _ in range(ROUNDS)]
    for one, two in [*rounds, map(sum, zip(*rounds, strict=True))]:
        print(f"1 process {one:.1f} s, 2 processes {two:.1f} s: {one / two:.2f} times as fast", flush=True)
    lines = {"2 processes": folder / "2", "killed, gone on with": killed(folder), "on Dask": on_dask(folder)}
    first = (folder / "1" / "table.csv").read_bytes()
    same = {name: (path / "table.csv").read_bytes() == first for name, path in lines.items()}
    for name, equal in same.items():
        print(f"{name}: {'the same table' if equal else 'ANOTHER TABLE'}")
    sys.exit(one / two < FASTER or not all(same.values()))


def timed(folder, *options):
    """Seconds that the sweep takes, from the first run on."""
    shutil.rmtree(folder, ignore_errors=True)
    start = time.perf_counter()
    sweep(folder, *options).wait()
    return time.perf_counter() - start


def killed(folder):
    """Kill a sweep when it is half done, go on with it, and return its folder."""
    own = folder / "killed"
    process = sweep(own, "--processes", 2)
    wait_for_half(own)
    process.send_signal(signal.SIGKILL)
    process.wait()
    print(f"killed with {rows(own)} of 60 runs in its table")
    sweep(own, "--processes", 2).wait()
    return own


def on_dask(folder):
    """Run a sweep on two workers, of which one is killed when it is half done, and return its folder."""
    own = folder / "dask"
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", ADDRESS, "--no-dashboard"]
    join = [sys.executable, "-m", "distributed.cli.dask_worker", ADDRESS, "--nthreads", "1", "--no-dashboard"]
    servers = [subprocess.Popen(words, stderr=subprocess.DEVNULL) for words in (start, join, join)]
    try:
        process = sweep(own, "--scheduler", ADDRESS)
        wait_for_half(own)
        servers[1].kill()
        print(f"one of two workers killed with {rows(own)} of 60 runs in the table")
        process.wait()
    finally:
        for server in servers:
            server.terminate()
            server.wait()
    return own


def sweep(folder, *options):
    """Start the command."""
    words = [sys.executable, "-m", "tisph", "sweep", STUDY, "--out", folder, *options]
    return subprocess.Popen(list(map(str, words)), stdout=subprocess.DEVNULL)


def wait_for_half(folder):
    """Wait until half the runs are in the table."""
    while rows(folder) < HALF:
        time.sleep(0.05)


def rows(folder):
    """Runs in the table so far."""
    path = folder / "table.csv"
    return len(path.read_text(encoding="utf-8").splitlines()) - 1 if path.is_file() else 0


if __name__ == "__main__":
    main()
