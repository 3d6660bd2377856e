"""All movies and plots of the gallery in one picture: ``python docs/_contact_sheet.py``, for whoever changes a drawing.

Makes the runs that are not there yet. A row a flow: its movie at three times, profiles, history. With
``--before COMMIT`` each flow has two rows: the same run as that commit draws it, and as it is drawn now.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

from _gallery import ROOT, RUNS, make, stills
from PIL import Image, ImageDraw

TILE = (480, 264)
TITLE = 16
TIMES = (0.1, 0.5, 1.0)
"""Parts of the movie's length at which a frame is taken."""


def row(folder):
    """Return the pictures of a run."""
    plots = (folder / f"{kind}.png" for kind in ("profiles", "history"))
    drawn = (Image.open(path).convert("RGB") for path in plots if path.is_file())
    return [*stills(folder / "movie.mp4", TIMES), *drawn]


def sheet(rows):
    """Return the contact sheet of pairs (words, folder of a run)."""
    picture = Image.new("RGB", (TILE[0] * (len(TIMES) + 2), (TILE[1] + TITLE) * len(rows)), "white")
    draw = ImageDraw.Draw(picture)
    for line, (words, folder) in enumerate(rows):
        top = line * (TILE[1] + TITLE)
        draw.text((4, top + 2), words, fill="black")
        for column, tile in enumerate(row(folder)):
            tile.thumbnail(TILE, Image.Resampling.LANCZOS)
            picture.paste(tile, (column * TILE[0], top + TITLE))
    return picture


@contextmanager
def checkout(commit):
    """Check a commit out, into a folder that is there as long as the context."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["git", "worktree", "add", "--quiet", "--detach", folder, commit], cwd=ROOT, check=True)
        try:
            yield Path(folder)
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", folder], cwd=ROOT, check=True)


def drawn_by(package, name):
    """Return a copy of the run ``name``, whose movie and plots are drawn by the ``package`` in that folder."""
    copy = RUNS / "drawn_before" / name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(RUNS / name, copy)
    command = [sys.executable, "-m", "tisph", "render", str(copy)]
    subprocess.run(command, cwd=package, env={**os.environ, "PYTHONPATH": str(package)}, check=True)
    return copy


def main(words):
    """Write the contact sheet and return its path."""
    before = words[1] if words[:1] == ["--before"] else None
    names = list(make(words[2:] if before else words))
    rows = [(name, RUNS / name) for name in names]
    if before:
        with checkout(before) as package:
            earlier = {name: drawn_by(package, name) for name in names}
        rows = [one for name, now in rows for one in ((f"{name}, {before}", earlier[name]), (f"{name}, now", now))]
    target = RUNS / "contact_sheet.png"
    sheet(rows).save(target)
    return target


if __name__ == "__main__":
    print(main(sys.argv[1:]))
