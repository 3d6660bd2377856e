"""Cost of the movie: milliseconds a frame for 5000 particles at 1280 x 640, from the state to the finished file.

No simulation: particles move along with the exact flow, slightly disordered. Plane Couette flow coloured by speed, an
oscillating wall, whose label changes in every frame, and start-up of an Oldroyd-B liquid coloured by polymer shear
stress. A run waits for a frame to be stored and handed over; a process of its own draws it, another, ffmpeg, encodes
it, and at the end the run waits for both to finish the file. So there are three times: of the processor for drawing a
frame, and of the clock that the run waits for each, and that all takes where no simulation leaves time in between.
"""

import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tisph.observers.frames import Frames
from tisph.report.painter import FramePainter
from tisph.report.studio import DistantMovie, shared
from tisph.scenes._motion import Polymer, WallMotion
from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

FRAMES, WIDTH, HEIGHT, FRAMES_PER_SECOND = 120, 1280, 640, 30
SUBSTEPS = 8  # of the path integration between two frames


def _channel(**flow):
    """Return a channel of 100 x 50 particles with walls at rest, but for what ``flow`` says."""
    settings = {
        "gap": 1.0, "length": 2.0, "density": 1.0, "kinematic_viscosity": 0.01, "bottom": WallMotion(0.0),
        "top": WallMotion(0.0), "initial_state": "rest", "start_time": 0.0, "units": UNITS, **flow,
    }  # fmt: skip
    return Channel(**settings, spacing=0.02 * settings["gap"], columns=100, rows=50)


UNITS = SimpleNamespace(length="m", mass="kg", time="s")
CASES = {  # channel, end in seconds, color_by
    "couette": (_channel(top=WallMotion(0.5)), 20.0, "speed"),
    "oscillating wall": (_channel(top=WallMotion(0.0, 0.5, 1.0)), 20.0, "speed"),
    "oldroyd_b couette": (
        _channel(kinematic_viscosity=1.0, top=WallMotion(1.0), polymer=Polymer(1.0, 0.1)),
        2.0,
        "shear_stress",
    ),
}


def measure(case):
    """Return ms a frame of drawing, of waiting and of everything, and the bytes of the movie, of one of ``CASES``."""
    channel, end, color_by = CASES[case]
    settings = SimpleNamespace(width=WIDTH, height=HEIGHT, fps=FRAMES_PER_SECOND, color_by=color_by, overlay="none")
    snapshots = _moving_particles(channel, end)
    painter = FramePainter(channel, settings, case, end)
    drawing = _milliseconds_a_frame(lambda: [painter.paint(snapshot) for snapshot in snapshots], time.process_time)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "movie.mp4"
        shared().ask("abandon").result()  # it is ready, as in a run when the first frame comes
        movie = DistantMovie(shared(), path, channel, settings, case, end)
        frames = Frames(path.with_suffix(".h5"), movie, [snapshot.t for snapshot in snapshots])
        waiting = _milliseconds_a_frame(lambda: [frames.observe(snapshot) for snapshot in snapshots])
        total = waiting + _milliseconds_a_frame(frames.close)
        return {"drawing_ms": drawing, "waiting_ms": waiting, "total_ms": total, "bytes": path.stat().st_size}


def _milliseconds_a_frame(action, clock=time.perf_counter):
    began = clock()
    action()
    return 1e3 * (clock() - began) / FRAMES


def _moving_particles(channel, end):
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
