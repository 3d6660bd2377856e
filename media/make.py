"""Make the pictures and movies that README.md and docs/ show: ``make media``, or some of them by name.

``python media/make.py cavity`` makes that one alone; without names, all, and the drawing of the walls. The gallery of
the documentation is made with the documentation (docs/_gallery.py).

Each movie leaves its settings in media/settings.json. ``python media/make.py --check`` makes nothing: it names the
movies whose settings are other ones now, and exits with 1 if there are any. Drawings are compared by a hash of their
layout and colours, which needs no number that somebody has to raise, and which a change of code alone does not change.
"""

import hashlib
import json
import shutil
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import film
import imageio_ffmpeg
import walls
from PIL import Image

from tisph import config, scenes
from tisph.observers.samples import read_frames
from tisph.report import style
from tisph.report.encoder import write_gif
from tisph.report.layout import arrange
from tisph.report.movie import displayed

ROOT = Path(__file__).resolve().parents[1]
MEDIA = ROOT / "media"
SETTINGS = MEDIA / "settings.json"

DYED = ["output.video.overlay=none", "output.video.color_by=dye"]

MOVIES = {
    "couette": (0.06, []),  # the profile is then curved across the whole gap
    "oldroyd_b_couette": (0.7, ["output.video.style=field"]),  # the shear wave has just crossed the gap
    "taylor_green": (0.5, []),
    "circular_couette": (0.1, []),  # the outer cylinder begins to feel it
    "cylinder_in_channel": (29.0, []),
    "eccentric_annulus": (25.0, DYED),
    "drafting_kissing_tumbling": (13.0, []),  # they tumble
    "suspension": (6.5, []),
    "taylor_vortices": (0.8, []),  # they have saturated
    "falling_ball": (7.0, []),  # it falls at its final velocity, and is on its way
    "cavity": (3.5, ["discretisation.particles_across=64"]),
}
"""Configs, the t* of each preview (the first frame after it), and what is set."""

MOVING, SECONDS = "cavity", 4.0
"""The movie on the first page of the documentation, whose first seconds are also a GIF: the dye is not yet mixed."""


def make(name, preview_t_star, changes):
    """Run ``configs/NAME.yaml`` and leave its movie and a preview frame in media/."""
    folder = ROOT / "runs" / "media" / name
    command = [sys.executable, "-m", "tisph", "run", str(ROOT / "configs" / f"{name}.yaml"), "--out", str(folder)]
    subprocess.run([*command, "--overwrite", *(word for text in changes for word in ("--set", text))], check=True)
    shutil.copyfile(folder / "movie.mp4", MEDIA / f"{name}.mp4")
    if name == MOVING:
        write_gif(folder / "movie.mp4", MEDIA / f"{name}.gif", SECONDS)
    scene = scenes.of(config.load(folder / "config.resolved.yaml"))
    times = [frame.t / scene.time_scale for frame in read_frames(folder / "frames.h5")]
    reel = imageio_ffmpeg.read_frames(str(folder / "movie.mp4"))
    size = next(reel)["size"]
    preview = next(frame for frame, t_star in zip(reel, times, strict=True) if t_star >= preview_t_star)
    Image.frombytes("RGB", size, preview).save(MEDIA / f"{name}.png", optimize=True)
    store(name)


def settings(name):
    """Return dotted key -> value of all that a movie shows: config with defaults, preview, layout and colours."""
    preview_t_star, changes = MOVIES[name]
    loaded = config.load(ROOT / "configs" / f"{name}.yaml", changes)
    scene, video = scenes.of(loaded), loaded.output.video
    layout = json.dumps(asdict(arrange(displayed(scene), video.width, video.height, style.THEMES[video.theme])))
    drawing = {"preview t*": preview_t_star, "heading": loaded.heading}
    drawing["layout and colours"] = hashlib.sha256(layout.encode()).hexdigest()[:16]
    return json.loads(json.dumps(drawing | flat(loaded.resolved())))


def flat(data, above=""):
    """Return dotted key -> value of nested mappings."""
    found = {}
    for key, value in data.items():
        found |= flat(value, f"{above}{key}.") if isinstance(value, dict) else {f"{above}{key}": value}
    return found


def store(name):
    """Write the settings of a movie into media/settings.json, a line a movie."""
    stored = json.loads(SETTINGS.read_text(encoding="utf-8")) | {name: settings(name)}
    lines = [f"{json.dumps(each)}: {json.dumps(stored[each])}" for each in MOVIES if each in stored]
    SETTINGS.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def outdated():
    """Return a line for each movie whose settings differ from the stored ones: the keys, and the command to make it.

    A key that was not stored is new in the program; it counts if the config does not have its default.
    """
    stored, lines = json.loads(SETTINGS.read_text(encoding="utf-8")), []
    for name, (_, changes) in MOVIES.items():
        was, now = stored.get(name, {}), settings(name)
        given = flat(config.load(ROOT / "configs" / f"{name}.yaml", changes).model_dump(exclude_defaults=True))
        added = given.keys() & now.keys() - was.keys()
        changed = [key for key in was if now.get(key) != was[key]] + sorted(added)
        said = "; ".join(f"{key} was {was.get(key)}, is {now.get(key)}" for key in changed) if was else "new"
        if said:
            lines.append(f"media/{name}.png, .mp4: {said}. Make it again: python media/make.py {name}")
    return lines


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        sys.exit("\n".join(outdated()) or None)
    chosen = sys.argv[1:] or list(MOVIES)
    if not sys.argv[1:]:
        walls.draw(MEDIA / "walls.png")
        film.make()
    for name in chosen:
        make(name, *MOVIES[name])
