"""Text and arrows that change from frame to frame, laid over an RGB picture (rows, columns, 3) of uint8."""

from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw

from tisph.report import style
from tisph.report.layout import Rect
from tisph.report.raster import blend, filled

_SMALLEST = 6  # pixels: the smallest font that a text may shrink to


def text_width(text: str, size: int) -> float:
    """Return the width of ``text`` in pixels at font ``size`` in pixels."""
    return style.text_font(size).getlength(text)


def fitting_size(text: str, size: int, width: float) -> int:
    """Return the largest font size up to ``size`` at which ``text`` is at most ``width`` pixels wide."""
    while size > _SMALLEST and text_width(text, size) > width:
        size -= 1
    return size


def paint_text(frame: np.ndarray, box: Rect, text: str, size: int, side: str, colour: str) -> None:
    """Write one line into ``box``, at its ``left`` or ``right`` side or its ``middle``, over what is there."""
    image = Image.fromarray(frame[box.slices])
    place, anchor = {"left": (0, "lm"), "right": (box.width, "rm"), "middle": (box.width / 2, "mm")}[side]
    draw = ImageDraw.Draw(image)
    draw.text((place, box.height / 2), text, fill=colour, font=style.text_font(size), anchor=anchor)
    frame[box.slices] = np.asarray(image)


def paint_arrow(frame: np.ndarray, box: Rect, share: float, colour: str) -> None:
    """Draw a horizontal arrow in the middle of ``box``, over |share| <= 1 of its width, to the left if negative.

    Its head is as high as ``box``, its shaft a quarter of that. Below a tenth of the width there is none: a
    few pixels of a head show no direction.
    """
    if abs(share) < 0.1:
        return
    coverage = _arrow_coverage(box.width, box.height, abs(share) * box.width)
    blend(frame[box.slices], coverage if share > 0 else coverage[:, ::-1], style.rgb(colour))


@lru_cache(maxsize=4)  # all arrows of a wall are alike
def _arrow_coverage(width: int, height: int, length: float) -> np.ndarray:
    """Return how much (0 to 255) of every pixel of a box an arrow of ``length`` pixels to the right covers."""
    head = min(height, length)  # as long as it is high
    neck, tip = (width + length) / 2 - head, (width + length) / 2
    column = np.array([tip - length, neck, neck, tip, neck, neck, tip - length])
    aside = np.array([1 / 8, 1 / 8, head / height / 2, 0.0, -head / height / 2, -1 / 8, -1 / 8])
    return filled((column, (0.5 + aside) * height), (height, width))
