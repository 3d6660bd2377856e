"""Make the pictures and movies that README.md and docs/ show: ``make media``, or some of them by name.

``python media/make.py poiseuille`` makes that one alone; without names, all, and the drawing of the walls.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import walls

from tisph import config, scenes
from tisph.observers.frames import read_frames
from tisph.report.movie import Movie

ROOT = Path(__file__).resolve().parents[1]
MEDIA = ROOT / "media"

MOVIES = {
    "couette": 0.06,  # the profile is then curved across the whole gap
    "poiseuille": 0.1,
    "couette_poiseuille_favourable": 0.1,
    "couette_poiseuille_backflow": 0.2,
    "oscillating_wall_slow": 0.7,
    "oscillating_wall_fast": 0.04,
    "stopped_wall": 0.03,
    "oldroyd_b_couette": 0.7,  # the shear wave has just crossed the gap
    "oldroyd_b_poiseuille": 0.3,  # at the overshoot
    "taylor_green": 0.5,
    "circular_couette": 0.1,  # the outer cylinder begins to feel it
    "cavity": 19.0,
    "cylinder_in_channel": 9.0,
    "eccentric_annulus": 25.0,
}
"""Configs, and the t* of each preview: the first frame after it."""

LARGE = "couette"
SMALL = ["--set", "output.video.width=640", "--set", "output.video.height=320"]


def make(name, preview_t_star):
    """Run ``configs/NAME.yaml`` and leave its movie and a preview frame in media/."""
    folder = ROOT / "runs" / "media" / name
    command = [sys.executable, "-m", "tisph", "run", str(ROOT / "configs" / f"{name}.yaml")]
    size = [] if name == LARGE else SMALL
    subprocess.run([*command, *size, "--out", str(folder), "--overwrite"], check=True)
    shutil.copyfile(folder / "movie.mp4", MEDIA / f"{name}.mp4")
    settings = config.load(folder / "config.resolved.yaml")
    scene = scenes.of(settings)
    frames = read_frames(folder / "frames.h5")
    preview = next(frame for frame in frames if frame.t >= preview_t_star * scene.time_scale)
    movie = Movie(MEDIA / "unused.mp4", scene, settings.output.video, settings.name, settings.time.end)
    movie.save_frame(MEDIA / f"{name}.png", preview)


if __name__ == "__main__":
    chosen = sys.argv[1:] or list(MOVIES)
    if not sys.argv[1:]:
        walls.draw(MEDIA / "walls.png")
    for name in chosen:
        make(name, MOVIES[name])
