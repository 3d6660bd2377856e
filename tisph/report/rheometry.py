"""The picture of what a rheologist reads: curves of a run beside theory and reference."""

import numpy as np
from matplotlib.ticker import FuncFormatter

from tisph.report import style
from tisph.report.labels import axis_label, number, unit_label

RUN = {"color": style.PARTICLES}
STYLES = {
    ".": {**RUN, "marker": "o", "linewidth": 2.5, "markersize": 5, "markevery": 0.06},
    **{mark: {**RUN, "marker": mark, "linestyle": "none"} for mark in "xo"},
    **{mark: {"color": style.TEXT, "marker": mark, "linestyle": "none"} for mark in "+s"},
    "-": {"color": style.EXACT, "linewidth": 1.3},
    "--": {"color": style.MUTED, "linestyle": "--"},
    ":": {"color": style.TEXT, "linestyle": ":"},
}
"""By the kind of a curve: run over many times, or at one frequency; reference; theories."""

DEPTH = 1e-4
"""Of the largest value, the smallest that logarithmic axes show: where a stress changes its sign they have no end."""


def _between(value):
    """The text of a tick between powers of ten: of 2 and 5 times one."""
    return number(value, 1) if f"{value:.0e}"[0] in "25" else ""


def plot_reading(path, name, reading, units):
    """Write a PNG of the curves of a ``measures.rheometry.Reading``, a row of axes for each of its ``Axes``.

    ``units`` are those of the config.
    """
    rows = list(dict.fromkeys(curve[0] for curve in reading.curves))
    with style.plot_style():
        figure = style.plot_figure(len(rows))
        for row, labels in enumerate(rows):
            axes = figure.add_subplot(len(rows), 1, row + 1)
            own = [curve[1:] for curve in reading.curves if curve[0] == labels]
            for label, x, y, kind in own:
                axes.plot(x, y, label=label, **STYLES[kind])
            if labels.logarithmic:
                axes.set(xscale="log", yscale="log")
                largest = max(np.nanmax(y) for _, _, y, _ in own)
                axes.set_ylim(bottom=max(axes.get_ylim()[0], DEPTH * largest))
                for axis in (axes.xaxis, axes.yaxis):
                    axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 1)))
                    axis.set_minor_formatter(FuncFormatter(lambda value, _: _between(value)))
            x, y = (
                axis_label(text, unit_label(kind, units)) for text, kind in zip(labels[:2], labels.units, strict=True)
            )
            axes.set_xlabel(x)
            axes.set_ylabel(y)
            axes.grid(True)
            axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4 if len(own) < 5 else 3)
        figure.suptitle(f"{name}: {reading.title}")
        figure.tight_layout()
        figure.save(path)
