"""Colours, fonts and matplotlib settings that all pictures share."""

import io
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from PIL import ImageFont

from tisph.report.labels import tick_text

COLOUR_MAP = "viridis"  # perceptually uniform, readable in grey and by colour-blind eyes
DIVERGING_MAP = "coolwarm"  # blue to red through grey, readable by colour-blind eyes; its middle shows on white
DYES = "#2166ac", "#fdb863"
"""The two colours of a dye, apart in brightness and for colour-blind eyes."""
DYE_MAP = LinearSegmentedColormap.from_list("dye", DYES)


@dataclass(frozen=True)
class Theme:
    """Colours of a movie: ``series`` for numbers over time, ``exact`` for all references."""

    background: str = "#ffffff"
    text: str = "#22262e"
    muted: str = "#6b7280"
    grid: str = "#e3e6ea"
    wall_moving: str = "#3d4451"
    on_wall_moving: str = "#ffffff"
    wall_resting: str = "#eef0f3"
    solid: str = "#d3d7dd"
    solid_edge: str = "#3d4451"
    particles: str = "#8fa3c4"
    exact: str = "#d1362f"
    series: tuple[str, ...] = ("#0072b2", "#b35900", "#4d4d4d")


LIGHT = Theme()
DARK = Theme(
    background="#14171c",
    text="#e8eaee",
    muted="#9aa3b0",
    grid="#2c323b",
    wall_moving="#c3c9d4",
    on_wall_moving="#14171c",
    wall_resting="#2c323b",
    solid="#3a414d",
    solid_edge="#aab3c2",
    particles="#7f93b8",
    exact="#ff7a70",
    series=("#56b4e9", "#e69f00", "#f0f0f0"),
)
THEMES = {"light": LIGHT, "dark": DARK}

TEXT, MUTED, PARTICLES, EXACT = LIGHT.text, LIGHT.muted, LIGHT.particles, LIGHT.exact


def _settings(theme: Theme) -> dict:
    return {
        "font.family": "DejaVu Sans",  # comes with matplotlib: the same text widths on every machine
        "figure.facecolor": theme.background,
        "axes.facecolor": theme.background,
        "text.color": theme.text,
        "axes.labelcolor": theme.text,
        "axes.edgecolor": theme.muted,
        "axes.unicode_minus": True,
        "axes.axisbelow": True,
        "grid.color": theme.grid,
        "hatch.linewidth": 0.8,
        "xtick.color": theme.muted,
        "ytick.color": theme.muted,
        "xtick.labelcolor": theme.text,
        "ytick.labelcolor": theme.text,
    }


def plot_style(theme: Theme = LIGHT) -> AbstractContextManager:
    """Return a context in which matplotlib has this project's settings, whatever the user's own file says."""
    return matplotlib.style.context(["default", _settings(theme)])


class PlotFigure(Figure):
    """A figure in this project's style, which a notebook shows as PNG without pyplot."""

    def save(self, path: Any) -> None:
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


def constrained_figure(size: tuple[float, float], dpi: int) -> Figure:
    """Return an empty figure of ``size`` [inches] for many panels, in which matplotlib makes room for labels."""
    figure = Figure(size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def format_ticks(axis: Axis, exponent: int) -> None:
    """Let the tick labels of ``axis`` be numbers in units of ``10^exponent``."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value, exponent)))


def rgb(colour: str) -> np.ndarray:
    """Return a ``#rrggbb`` colour as three floats from 0 to 255."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=np.float32)


def colours(count: int, brightest: float = 1.0, colour_map: str | Colormap = COLOUR_MAP) -> np.ndarray:
    """Return ``count`` RGB colours along a colour map of matplotlib, shape (count, 3), from 0 to 1.

    ``brightest`` below 1 leaves out the pale end, which a thin line on white would lose.
    """
    return matplotlib.colormaps.get_cmap(colour_map)(np.linspace(0.0, brightest, count))[:, :3]


def evenly_chosen(count: int, most: int) -> np.ndarray:
    """Return at most ``most`` indices out of ``count``, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


@lru_cache
def text_font(size: int) -> ImageFont.FreeTypeFont:
    """Return the font of the labels that change every frame; ``size`` in pixels."""
    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(str(path), size)
