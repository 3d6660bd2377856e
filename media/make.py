"""Make the pictures and movies that README.md shows: ``make media``."""

import shutil
import subprocess
import sys
from pathlib import Path

import walls

from tisph import config
from tisph.observers.frames import read_frames
from tisph.report.movie import Movie
from tisph.scenes.channel import Channel

ROOT = Path(__file__).resolve().parents[1]
MEDIA = ROOT / "media"

MOVIES = {
    "couette": 0.06,  # the profile is then curved across the whole gap
}
"""Configs, and the t* of each preview: the first frame after it."""


def make(name, preview_t_star):
    """Run ``configs/NAME.yaml`` and leave its movie, its profiles and a preview frame in media/."""
    folder = ROOT / "runs" / "media" / name
    command = [sys.executable, "-m", "tisph", "run", str(ROOT / "configs" / f"{name}.yaml")]
    subprocess.run([*command, "--out", str(folder), "--overwrite"], check=True)
    shutil.copyfile(folder / "movie.mp4", MEDIA / f"{name}.mp4")
    shutil.copyfile(folder / "profiles.png", MEDIA / f"{name}_profiles.png")
    settings = config.load(folder / "config.resolved.yaml")
    channel = Channel.from_config(settings)
    frames = read_frames(folder / "frames.h5")
    preview = next(frame for frame in frames if frame.t >= preview_t_star * channel.viscous_time)
    movie = Movie(MEDIA / "unused.mp4", channel, settings.output.video, settings.name, settings.time.end)
    movie.save_frame(MEDIA / f"{name}.png", preview)


if __name__ == "__main__":
    walls.draw(MEDIA / "walls.png")
    for name, preview_t_star in MOVIES.items():
        make(name, preview_t_star)
