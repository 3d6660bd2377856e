"""Picture of a fit: the data and the fitted curve with its band, beside the residuals over the noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph.report import style


@dataclass(frozen=True)
class FitPanel:
    """One measured quantity: labels of both axes, and arrays (values,) over the abscissae ``x``.

    ``lower`` and ``upper``: the band of the ``fitted`` values. ``residuals``: over the noise. ``group``: number of the
    curve to which a value belongs, of those with ``names``. ``curve``: whether values are connected.
    """

    labels: tuple[str, str]
    logarithmic: bool
    x: np.ndarray
    measured: np.ndarray
    fitted: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    residuals: np.ndarray
    group: np.ndarray
    names: tuple[str, ...]
    curve: bool = True


MOST_NAMED = 8
"""Largest number of curves with a name each."""


def draw(path: Path, title: str, panels: Sequence[FitPanel]) -> None:
    """Write a PNG of the ``panels``, a row each."""
    with style.plot_style():
        figure = style.plot_figure(rows=len(panels))
        for (left, right), panel in zip(figure.subplots(len(panels), 2, squeeze=False), panels, strict=True):
            for number, (name, colour) in enumerate(
                zip(panel.names, style.colours(len(panel.names), 0.85), strict=True)
            ):
                own = np.flatnonzero(panel.group == number)
                own = own[np.argsort(panel.x[own], kind="stable")]
                x, look = panel.x[own], {"color": colour}
                left.plot(x, panel.measured[own], "o", markersize=3, label=name, **look)
                right.plot(x, panel.residuals[own], "o", markersize=3, **look)
                if panel.curve:
                    left.plot(x, panel.fitted[own], linewidth=1.0, **look)
                    left.fill_between(x, panel.lower[own], panel.upper[own], alpha=0.25, linewidth=0, **look)
            if not panel.curve:
                ends = [float(panel.fitted.min()), float(panel.fitted.max())]
                left.plot(ends, ends, color=style.EXACT, linewidth=0.9)
            scale = "log" if panel.logarithmic else "linear"
            left.set(xscale=scale, yscale=scale, xlabel=panel.labels[0], ylabel=panel.labels[1])
            right.set(xscale=scale, xlabel=panel.labels[0], ylabel="residual / noise")
            right.axhline(0.0, color=style.MUTED, linewidth=0.8)
            for axes in (left, right):
                axes.grid(True)
            if 1 < len(panel.names) <= MOST_NAMED:
                left.legend(fontsize=7, frameon=False)
        figure.suptitle(title)
        figure.tight_layout()
        figure.save(path)
