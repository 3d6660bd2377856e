"""Cost of the movie: milliseconds a frame for drawing and encoding 5000 particles at 1280 x 640.

    python benchmarks/video.py

No simulation: particles move along with the exact start-up flow, slightly disordered. The time of encoding is
what the run waits for ffmpeg, its start and the finishing of the file included; the processor time of drawing
tells whether the machine was busy with something else. Prints a Markdown table.
"""

import os
import platform
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tisph.report.encoder import Encoder
from tisph.report.painter import FramePainter
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

FRAMES, WIDTH, HEIGHT, FRAMES_PER_SECOND = 120, 1280, 640, 30
END = 20.0  # seconds of flow
SUBSTEPS = 8  # of the path integration between two frames
BOUND = 20.0  # milliseconds a frame


def couette() -> Channel:
    """Return the channel of configs/couette.yaml: 100 x 50 particles, Re = 50."""
    return Channel(
        gap=0.01, length=0.02, density=1000.0, kinematic_viscosity=1e-6, bottom_velocity=0.0, top_velocity=0.005,
        initial_state="rest", start_time=0.0, spacing=0.0002, columns=100, rows=50,
        units=SimpleNamespace(length="m", mass="kg", time="s"),
    )  # fmt: skip


def moving_particles(channel: Channel) -> list[Snapshot]:
    """Return the snapshots of all frames; every row moves with the exact velocity at its middle."""
    x, y = channel.jittered(seed=0, jitter=0.15)
    row = channel.lattice()[1]
    step, snapshots = END / (FRAMES - 1), []
    for frame in range(FRAMES):
        t, zero = frame * step, np.zeros_like(x)
        snapshots.append(Snapshot(t, frame, x, y, channel.exact_velocity(y, t), zero, zero, zero))
        middles = t + (np.arange(SUBSTEPS) + 0.5) * step / SUBSTEPS
        moved = sum(channel.exact_velocity(row, middle) for middle in middles) * step / SUBSTEPS
        x = np.mod(x + moved, channel.length)
    return snapshots


def measure(path: Path) -> tuple[float, float, float]:
    """Write the movie to ``path``; return ms a frame of drawing, of it on the processor, and of encoding."""
    channel = couette()
    snapshots = moving_particles(channel)
    painter = FramePainter(channel, WIDTH, HEIGHT, title="couette")
    drawing, processor, start = 0.0, 0.0, time.perf_counter()
    encoder = Encoder(path, WIDTH, HEIGHT, FRAMES_PER_SECOND)
    for snapshot in snapshots:
        before = time.perf_counter(), time.process_time()
        frame = painter.paint(snapshot)
        drawing += time.perf_counter() - before[0]
        processor += time.process_time() - before[1]
        encoder.write(frame)
    encoder.close()
    total = time.perf_counter() - start
    return tuple(1e3 * seconds / FRAMES for seconds in (drawing, processor, total - drawing))


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "movie.mp4"
        draw, processor, encode = measure(path)
        size = path.stat().st_size / 1e6
    cells = {
        "particles": "5000",
        "frames": f"{FRAMES} of {WIDTH} x {HEIGHT}",
        "draw [ms]": f"{draw:.1f}",
        "on the processor [ms]": f"{processor:.1f}",
        "encode [ms]": f"{encode:.1f}",
        "total [ms]": f"{draw + encode:.1f}",
        f"at most {BOUND:g} ms": "pass" if draw + encode <= BOUND else "FAIL",
        "file [MB]": f"{size:.2f}",
    }
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}\n")
    for row in (cells.keys(), ["---"] * len(cells), cells.values()):
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
