"""Lines over the fluid of a movie frame: dark ones with a light rim, which are seen on any colour."""

import numpy as np

from tisph.report import style
from tisph.report.raster import Discs, Points, blend

INK, RIM = style.TEXT, "#ffffff"
_HALF_WIDTHS = (1.8, RIM), (1.0, INK)  # pixels in a frame of 1280 x 640


class Strokes:
    """Draws lines into panels of ``shape``, in a frame of that ``scale``."""

    def __init__(self, scale: float, shape: tuple[int, int]):
        self._pens = [(Discs(max(0.5, wide * scale), shape), style.rgb(ink)) for wide, ink in _HALF_WIDTHS]

    def paint(self, panel: np.ndarray, points: Points) -> None:
        """Lay the line of ``points`` that are close to each other over ``panel``, RGB of uint8 (rows, columns, 3)."""
        for pen, ink in self._pens:
            blend(panel, pen.cover(points), ink)
