"""The picture of run time against error: one panel a flow, both axes logarithmic, the Pareto front as a line."""

from dataclasses import dataclass

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tisph.report.style import MUTED, plot_style
from tisph.studies.frontier.cases import BENCHMARKS, l2
from tisph.studies.frontier.pareto import OURS

# Okabe and Ito's colours, which colour-blind eyes tell apart too; the marks tell the same without colour.
FAMILIES = {
    "explicit": ("#0072b2", "os<^"),
    "implicit": ("#d55e00", "v>DpP"),
    "LAMMPS": ("#009e73", "X"),
    "PySPH TVF": ("#cc79a7", "*d"),
    "PySPH EDAC": ("#56b4e9", "hX"),
    "": ("#000000", "s^o"),
}
"""Colour and marks of the methods, by how their names begin: the first that fits."""

PEERS, QUOTED = "peers, same machine", "quoted, measured elsewhere"
LEGENDS = {OURS: "outside lower left", PEERS: "outside lower center", QUOTED: "outside lower right"}
"""Place of the legend of each group of methods, by its title."""


@dataclass(frozen=True)
class Style:
    """How the points of a method are drawn, and the title of the legend that names it."""

    group: str
    colour: str
    mark: str

    @property
    def options(self):
        """Options of a matplotlib line: joined thinly, large for a peer, hollow if measured elsewhere."""
        face, edge = ("none", self.colour) if self.group == QUOTED else (self.colour, "white")
        return {
            "color": self.colour,
            "marker": self.mark,
            "markersize": 7 if self.group == OURS else 11,
            "markerfacecolor": face,
            "markeredgecolor": edge,
            "markeredgewidth": 1.4 if face == "none" else 0.6,
            "linewidth": 0.6,
        }


def plot_frontier(path, rows, fronts):
    """Draw ``rows`` (``Measured``) and the Pareto front of each flow into ``path``."""
    with plot_style():
        figure_of(rows, fronts).savefig(path)


def figure_of(rows, fronts):
    """Return the picture as a matplotlib figure."""
    flows = [flow for flow in BENCHMARKS if any(row.flow == flow for row in rows)]
    styles = styles_of(rows)
    figure = Figure((max(3.7 * len(flows), 10.0), 6.2), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(flows), squeeze=False)[0]
    for panel, flow in zip(panels, flows, strict=True):
        _draw(panel, flow, [row for row in rows if row.flow == flow], fronts[flow], styles)
    panels[0].set_ylabel("L2 error of the velocity" if BENCHMARKS[flows[0]].error is l2 else "relative error")
    for title, place in LEGENDS.items():
        handles = [
            Line2D([], [], label=name, **style.options) for name, style in styles.items() if style.group == title
        ]
        if title == OURS:
            handles.append(Line2D([], [], color=MUTED, linewidth=3, alpha=0.4, label="front"))
        if handles:
            columns = 2 if len(handles) > 5 else 1
            figure.legend(handles=handles, title=title, loc=place, ncols=columns, fontsize=9, frameon=False)
    return figure


def styles_of(rows):
    """``Style`` of every method in ``rows``."""
    styles = {}
    for row in rows:
        colour, marks = next(style for start, style in FAMILIES.items() if row.method.startswith(start))
        group = OURS if row.ours else QUOTED if row.quoted else PEERS
        before = sum(style.colour == colour for method, style in styles.items() if method != row.method)
        styles.setdefault(row.method, Style(group, colour, marks[before % len(marks)]))
    return styles


def _draw(panel, flow, rows, front, styles):
    line = sorted(front, key=lambda row: row.loop)
    panel.plot([row.loop for row in line], [row.l2 for row in line], color=MUTED, linewidth=3, alpha=0.4, zorder=0)
    for method in dict.fromkeys(row.method for row in rows):
        own = sorted((row for row in rows if row.method == method), key=lambda row: row.across)
        panel.plot([row.loop for row in own], [row.l2 for row in own], **styles[method].options)
    panel.set(xscale="log", yscale="log", title=BENCHMARKS[flow].title, xlabel="time loop [s]")
    panel.grid(True, which="major")
