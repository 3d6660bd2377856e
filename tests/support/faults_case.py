"""A small run that faults befall, and what can be read of it afterwards."""

import json

import h5py
import numpy as np
from couette import couette_text
from PIL import Image

from tisph import config
from tisph.observers.history import read_history
from tisph.observers.samples import read_frames, read_samples

END = 5.0
SAMPLES = [END * k / 20 for k in range(1, 21)]
OUTPUT = {"video": {"frames": 40, "width": 640, "height": 320}, "checkpoint_every": END / 50}
CASE = couette_text(
    initial={"jitter": 0.2}, scheme={"type": "wcsph"}, time={"end": END, "samples": SAMPLES}, output=OUTPUT
)
"""Some 1300 steps in a second, with five hundred writes on the way."""


def require_readable(folder):
    """Read every file that is there; return how many samples, frames and lines of the history there are."""
    if folder.summary.exists():
        assert json.loads(folder.summary.read_text())["name"] == "small"
    if folder.config.exists():
        assert config.load(folder.config).name == "small"
    if folder.checkpoint.exists():
        with h5py.File(folder.checkpoint) as file:
            assert all(np.isfinite(values[...]).all() for values in file.values())
    for picture in folder.root.glob("*.png"):
        Image.open(picture).load()
    samples = read_samples(folder.samples) if folder.samples.exists() else []
    frames = list(read_frames(folder.frames)) if folder.frames.exists() else []
    if folder.history.exists():
        text = folder.history.read_text()
        assert text.endswith("\n")
        assert len({line.count(",") for line in text.splitlines() if not line.startswith("#")}) == 1
    times = read_history(folder.history)[0] if folder.history.exists() else []
    for found in ([snapshot.t for snapshot in samples], [snapshot.t for snapshot in frames], times):
        assert np.all(np.diff(found) > 0)
    assert all(np.isfinite(snapshot.u).all() for snapshot in (*samples, *frames))
    return len(samples), len(frames), len(times)
