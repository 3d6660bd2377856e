"""Cost of the movie: milliseconds a frame for drawing and encoding 5000 particles at 1280 x 640.

    python benchmarks/video.py

No simulation: particles move along with the exact flow, slightly disordered. Plane Couette flow coloured by speed, an
oscillating wall, whose label changes in every frame, and start-up of an Oldroyd-B liquid coloured by polymer shear
stress. The time of encoding is what the run waits for ffmpeg, its start and the finishing of the file included; the
processor time of drawing tells whether the machine was busy with something else. Prints a Markdown table.
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
from tisph.scenes._motion import Polymer, WallMotion
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

FRAMES, WIDTH, HEIGHT, FRAMES_PER_SECOND = 120, 1280, 640, 30
SUBSTEPS = 8  # of the path integration between two frames
BOUND = 20.0  # milliseconds a frame


def channel(**flow) -> Channel:
    """Return a channel of 100 x 50 particles with walls at rest, but for what ``flow`` says."""
    settings = {
        "gap": 1.0, "length": 2.0, "density": 1.0, "kinematic_viscosity": 0.01, "bottom": WallMotion(0.0),
        "top": WallMotion(0.0), "initial_state": "rest", "start_time": 0.0, "units": UNITS, **flow,
    }  # fmt: skip
    return Channel(**settings, spacing=0.02 * settings["gap"], columns=100, rows=50)


UNITS = SimpleNamespace(length="m", mass="kg", time="s")
CASES = {  # channel, end in seconds, color_by
    "couette": (channel(top=WallMotion(0.5)), 20.0, "speed"),
    "oscillating wall": (channel(top=WallMotion(0.0, 0.5, 1.0)), 20.0, "speed"),
    "oldroyd_b couette": (
        channel(kinematic_viscosity=1.0, top=WallMotion(1.0), polymer=Polymer(1.0, 0.1)),
        2.0,
        "shear_stress",
    ),
}


def moving_particles(channel: Channel, end: float) -> list[Snapshot]:
    """Return the snapshots of all frames; every row moves with the exact velocity at its middle."""
    x, y = channel.jittered(seed=0, jitter=0.15)
    rows = (np.arange(channel.rows) + 0.5) * channel.spacing
    step, snapshots = end / (FRAMES - 1), []
    for frame in range(FRAMES):
        t, zero = frame * step, np.zeros_like(x)
        normal, shear = channel.exact_polymer_stress(y, t)
        snapshots.append(Snapshot(t, frame, x, y, channel.exact_velocity(y, t), zero, zero, zero, normal, shear, zero))
        middles = t + (np.arange(SUBSTEPS) + 0.5) * step / SUBSTEPS
        moved = sum(channel.exact_velocity(rows, middle) for middle in middles) * step / SUBSTEPS
        x = np.mod(x + np.repeat(moved, channel.columns), channel.length)
    return snapshots


def measure(path: Path, case: str) -> tuple[float, float, float]:
    """Write the movie to ``path``; return ms a frame of drawing, of it on the processor, and of encoding."""
    channel, end, color_by = CASES[case]
    snapshots = moving_particles(channel, end)
    painter = FramePainter(channel, SimpleNamespace(width=WIDTH, height=HEIGHT, color_by=color_by), case, end)
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


def row(case: str) -> dict[str, str]:
    """Measure ``case`` and return its cells in the table by their headings."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "movie.mp4"
        draw, processor, encode = measure(path, case)
        size = path.stat().st_size / 1e6
    return {
        "flow": case,
        "coloured by": CASES[case][2],
        "particles": "5000",
        "frames": f"{FRAMES} of {WIDTH} x {HEIGHT}",
        "draw [ms]": f"{draw:.1f}",
        "on the processor [ms]": f"{processor:.1f}",
        "encode [ms]": f"{encode:.1f}",
        "total [ms]": f"{draw + encode:.1f}",
        f"at most {BOUND:g} ms": "pass" if draw + encode <= BOUND else "FAIL",
        "file [MB]": f"{size:.2f}",
    }


def main() -> None:
    """Print the table."""
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}\n")
    for index, cells in enumerate(map(row, CASES)):
        if index == 0:
            print("| " + " | ".join(cells) + " |\n" + "|---" * len(cells) + "|")
        print("| " + " | ".join(cells.values()) + " |", flush=True)


if __name__ == "__main__":
    main()
