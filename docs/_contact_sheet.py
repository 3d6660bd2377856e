"""All movies and plots of the gallery in one picture: ``python docs/_contact_sheet.py``, for whoever changes a drawing.

Makes the runs that are not there yet. A row a flow: its movie at three times, profiles, history.
"""

import sys

from _gallery import RUNS, make, stills
from PIL import Image, ImageDraw

TILE = (480, 264)
TITLE = 16
TIMES = (0.1, 0.5, 1.0)
"""Parts of the movie's length at which a frame is taken."""


def row(name):
    """Return the pictures of a flow."""
    plots = (RUNS / name / f"{kind}.png" for kind in ("profiles", "history"))
    drawn = (Image.open(path).convert("RGB") for path in plots if path.is_file())
    return [*stills(RUNS / name / "movie.mp4", TIMES), *drawn]


def sheet(names):
    """Return the contact sheet of some flows."""
    picture = Image.new("RGB", (TILE[0] * (len(TIMES) + 2), (TILE[1] + TITLE) * len(names)), "white")
    draw = ImageDraw.Draw(picture)
    for line, name in enumerate(names):
        top = line * (TILE[1] + TITLE)
        draw.text((4, top + 2), name, fill="black")
        for column, tile in enumerate(row(name)):
            tile.thumbnail(TILE, Image.Resampling.LANCZOS)
            picture.paste(tile, (column * TILE[0], top + TITLE))
    return picture


if __name__ == "__main__":
    target = RUNS / "contact_sheet.png"
    sheet(list(make(sys.argv[1:]))).save(target)
    print(target)
