"""Colours, fonts and matplotlib settings that all pictures share."""

import io
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from PIL import ImageFont

from tisph.report.labels import tick_text

COLOUR_MAP = "viridis"  # perceptually uniform, readable in grey and by colour-blind eyes
DIVERGING_MAP = "coolwarm"  # blue to red through grey, readable by colour-blind eyes; its middle shows on white
TEXT = "#22262e"
MUTED = "#6b7280"
GRID = "#e3e6ea"
WALL_MOVING = "#3d4451"
WALL_RESTING = "#eef0f3"
SOLID = "#d3d7dd"
SOLID_EDGE = WALL_MOVING
PARTICLES = "#8fa3c4"
EXACT = "#d1362f"

_SETTINGS = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same text widths on every machine
    "text.color": TEXT,
    "axes.labelcolor": TEXT,
    "axes.edgecolor": MUTED,
    "axes.unicode_minus": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "hatch.linewidth": 0.8,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": TEXT,
    "ytick.labelcolor": TEXT,
}


def plot_style() -> AbstractContextManager:
    """Return a context in which matplotlib has this project's settings, whatever the user's own file says."""
    return matplotlib.style.context(["default", _SETTINGS])


class PlotFigure(Figure):
    """A figure in this project's style, which a notebook shows, whatever it does with those of pyplot."""

    def save(self, path) -> None:
        """Write it as PNG to a path or an open file: quickly, a quarter larger than it could be."""
        with plot_style():
            self.savefig(path, format="png", pil_kwargs={"compress_level": 2})

    def png(self) -> bytes:
        """Return it as PNG."""
        picture = io.BytesIO()
        self.save(picture)
        return picture.getvalue()

    _repr_png_ = png


def plot_figure(rows: int = 1) -> PlotFigure:
    """Return an empty figure for a plot, 1320 pixels wide, with room for labels and outside legends.

    It is 720 pixels high for one row of axes, and 540 more for each further one.
    """
    figure = PlotFigure((11.0, 1.5 + 4.5 * rows), dpi=120)
    FigureCanvasAgg(figure)
    return figure


def format_ticks(axis: Axis, exponent: int) -> None:
    """Let the tick labels of ``axis`` be numbers in units of ``10^exponent``."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value, exponent)))


def rgb(colour: str) -> np.ndarray:
    """Return a ``#rrggbb`` colour as three floats from 0 to 255."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=np.float32)


def colours(count: int, brightest: float = 1.0, colour_map: str = COLOUR_MAP) -> np.ndarray:
    """Return ``count`` RGB colours along a colour map of matplotlib, shape (count, 3), from 0 to 1.

    ``brightest`` below 1 leaves out the pale end, which a thin line on white would lose.
    """
    return matplotlib.colormaps[colour_map](np.linspace(0.0, brightest, count))[:, :3]


def evenly_chosen(count: int, most: int) -> np.ndarray:
    """Return at most ``most`` indices out of ``count``, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


@lru_cache
def text_font(size: int) -> ImageFont.FreeTypeFont:
    """Return the font of the labels that change every frame; ``size`` in pixels."""
    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(str(path), size)
