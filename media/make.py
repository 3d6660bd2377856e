"""Make the pictures and movies that README.md and docs/ show: ``make media``, or some of them by name.

``python media/make.py cavity`` makes that one alone; without names, all, and the drawing of the walls. The gallery of
the documentation is made with the documentation (docs/_gallery.py).
"""

import shutil
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import walls
from PIL import Image

from tisph import config, scenes
from tisph.observers.samples import read_frames
from tisph.report.encoder import write_gif

ROOT = Path(__file__).resolve().parents[1]
MEDIA = ROOT / "media"

DYED = ["output.video.overlay=none", "output.video.color_by=dye"]

MOVIES = {
    "couette": (0.06, []),  # the profile is then curved across the whole gap
    "oldroyd_b_couette": (0.7, ["output.video.style=field"]),  # the shear wave has just crossed the gap
    "taylor_green": (0.5, []),
    "circular_couette": (0.1, []),  # the outer cylinder begins to feel it
    "cylinder_in_channel": (9.0, ["output.video.overlay=streamlines"]),
    "eccentric_annulus": (25.0, DYED),
    "drafting_kissing_tumbling": (13.0, []),  # they tumble
    "suspension": (6.5, []),
    "taylor_vortices": (0.8, []),  # they have saturated
    "falling_ball": (7.0, []),  # it falls at its final velocity, and is on its way
    "cavity": (3.5, [*DYED, "discretisation.particles_across=64", "time.end=6.0"]),
}
"""Configs, the t* of each preview (the first frame after it), and what is set."""

MOVING = "cavity"
"""The movie at the top of README.md, also as GIF."""


def make(name, preview_t_star, changes):
    """Run ``configs/NAME.yaml`` and leave its movie and a preview frame in media/."""
    folder = ROOT / "runs" / "media" / name
    command = [sys.executable, "-m", "tisph", "run", str(ROOT / "configs" / f"{name}.yaml"), "--out", str(folder)]
    subprocess.run([*command, "--overwrite", *(word for text in changes for word in ("--set", text))], check=True)
    shutil.copyfile(folder / "movie.mp4", MEDIA / f"{name}.mp4")
    if name == MOVING:
        write_gif(folder / "movie.mp4", MEDIA / f"{name}.gif")
    scene = scenes.of(config.load(folder / "config.resolved.yaml"))
    times = [frame.t / scene.time_scale for frame in read_frames(folder / "frames.h5")]
    film = imageio_ffmpeg.read_frames(str(folder / "movie.mp4"))
    size = next(film)["size"]
    preview = next(frame for frame, t_star in zip(film, times, strict=True) if t_star >= preview_t_star)
    Image.frombytes("RGB", size, preview).save(MEDIA / f"{name}.png", optimize=True)


if __name__ == "__main__":
    chosen = sys.argv[1:] or list(MOVIES)
    if not sys.argv[1:]:
        walls.draw(MEDIA / "walls.png")
    for name in chosen:
        make(name, *MOVIES[name])
