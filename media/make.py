"""Make the pictures and movies that README.md shows: ``make media``."""

import shutil
import subprocess
import sys
from pathlib import Path

from tisph import config
from tisph.observers.frames import read_frames
from tisph.report.movie import Movie
from tisph.scenes.channel import Channel

ROOT = Path(__file__).resolve().parents[1]
MEDIA = ROOT / "media"

PREVIEW_T_STAR = 0.06
"""The preview is the first frame after this t*: the profile is then curved across the whole gap."""


def make(name):
    """Run ``configs/NAME.yaml`` and leave its movie and a preview frame in media/."""
    folder = ROOT / "runs" / "media" / name
    command = [sys.executable, "-m", "tisph", "run", str(ROOT / "configs" / f"{name}.yaml")]
    subprocess.run([*command, "--out", str(folder), "--overwrite"], check=True)
    shutil.copyfile(folder / "movie.mp4", MEDIA / f"{name}.mp4")
    shutil.copyfile(folder / "profiles.png", MEDIA / f"{name}_profiles.png")
    settings = config.load(folder / "config.resolved.yaml")
    channel = Channel.from_config(settings)
    frames = read_frames(folder / "frames.h5")
    preview = next(frame for frame in frames if frame.t >= PREVIEW_T_STAR * channel.viscous_time)
    movie = Movie(MEDIA / "unused.mp4", channel, settings.output.video, settings.name)
    movie.save_frame(MEDIA / f"{name}.png", preview)


if __name__ == "__main__":
    make("couette")
