"""The picture of the comparison of wall treatments: error against resolution, a panel for each flow."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

from tisph.report.style import MUTED, plot_style
from tisph.studies.walls_cases import ARRANGEMENTS
from tisph.studies.walls_table import MEASURES

# Okabe and Ito's colours, which colour-blind eyes tell apart too; the markers tell the same without colour.
LOOKS = (("#d55e00", "v"), ("#009e73", "s"), ("#56b4e9", "o"), ("#000000", "x"), ("#cc79a7", "D"), ("#e69f00", "P"))
STYLES = ("-", "--", ":")
COLUMNS = 3


def plot_walls(path, rows):
    """Write the picture of ``rows`` (``verification.walls.Row``) to ``path``; runs that stopped leave gaps."""
    titles = list(dict.fromkeys(row.case.title for row in rows))
    treatments = list(dict.fromkeys(row.case.treatment for row in rows))
    looks = {name: LOOKS[place % len(LOOKS)] for place, name in enumerate(treatments)}
    arrangements = dict.fromkeys(row.case.arrangement for row in rows)
    styles = {name: style for name, style in zip(ARRANGEMENTS, STYLES, strict=False) if name in arrangements}
    with plot_style():
        lines = -(-len(titles) // COLUMNS)
        figure = Figure((12.0, 3.9 * lines + 0.9), dpi=120, layout="constrained")
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
        FigureCanvasAgg(figure)
        panels = figure.subplots(lines, COLUMNS, squeeze=False).ravel()
        for panel, title in zip(panels, titles, strict=False):
            _draw(panel, title, [row for row in rows if row.case.title == title], looks, styles)
        for panel in panels[len(titles) :]:
            panel.axis("off")
        for panel in panels[-COLUMNS:]:
            panel.set_xlabel("particles across the gap")
        figure.legend(handles=_legend(looks, styles), loc="outside lower center", ncols=4, frameon=False)
        figure.savefig(path)


def _draw(panel, title, rows, looks, styles):
    resolutions = list(rows[0].errors)
    for row in rows:
        colour, marker = looks[row.case.treatment]
        panel.loglog(
            resolutions,
            list(row.errors.values()),
            styles[row.case.arrangement],
            color=colour,
            marker=marker,
            markerfacecolor="none",
            linewidth=1.4,
            markersize=7,
        )
    _second_order(panel, resolutions, rows)
    panel.set_title(f"{title}, t* = {rows[0].case.t_star:g}", fontsize=11)
    panel.set_ylabel(f"{MEASURES[rows[0].case.measure]} error")
    panel.xaxis.set_major_locator(FixedLocator(resolutions))
    panel.xaxis.set_major_formatter(FixedFormatter([str(number) for number in resolutions]))
    panel.xaxis.set_minor_locator(NullLocator())
    panel.set_xlim(resolutions[0] / 1.2, resolutions[-1] * 1.2)
    panel.grid(True, which="major")


def _second_order(panel, resolutions, rows):
    """A line of slope -2 below all others, to compare slopes with."""
    errors = np.array([list(row.errors.values()) for row in rows])
    fall = np.array([(resolutions[0] / number) ** 2 for number in resolutions])
    known = np.isfinite(errors) & (errors > 0)
    if known.any():
        panel.loglog(resolutions, 0.6 * np.min((errors / fall)[known]) * fall, "-", color=MUTED, linewidth=0.8)


def _legend(looks, styles):
    treatments = [
        Line2D([], [], color=colour, marker=marker, markerfacecolor="none", markersize=7, label=name)
        for name, (colour, marker) in looks.items()
    ]
    arrangements = [Line2D([], [], color="#000000", linestyle=style, label=name) for name, style in styles.items()]
    return [*treatments, *arrangements, Line2D([], [], color=MUTED, linewidth=0.8, label="second order")]
