"""The picture of run time against error: one panel a flow, both axes logarithmic, the front as a line."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tisph.report.style import plot_style
from tisph.study.bench.cases import FLOWS

MARKS = "osD^v<>pPX*dH^s"


def plot_frontier(path, rows, fronts):
    """Draw ``rows`` (``Measured``) and the front of each flow into ``path``."""
    flows = [flow for flow in FLOWS if any(row.flow == flow for row in rows)]
    ways = list(dict.fromkeys(row.way for row in rows))
    marks = {way: MARKS[place % len(MARKS)] for place, way in enumerate(ways)}
    with plot_style():
        figure = Figure((5.2 * len(flows) + 3.0, 5.4), dpi=120, layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(1, len(flows), squeeze=False)[0]
        for panel, flow in zip(panels, flows, strict=True):
            _draw(panel, flow, [row for row in rows if row.flow == flow], fronts[flow], marks)
        handles = {}
        for panel in panels:
            drawn, labels = panel.get_legend_handles_labels()
            handles |= dict(zip(labels, drawn, strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside right center", fontsize="small")
        figure.savefig(path)


def _draw(panel, flow, rows, front, marks):
    for way in dict.fromkeys(row.way for row in rows):
        own = sorted((row for row in rows if row.way == way), key=lambda row: row.across)
        ours = way.startswith(("explicit", "implicit"))
        face = None if ours and not own[0].elsewhere else "none"
        panel.plot(
            [row.loop for row in own],
            [row.l2 for row in own],
            marks[way],
            label=way,
            color=_color(way),
            markerfacecolor=face or _color(way),
            markersize=6 if ours else 9,
        )
    line = sorted(front, key=lambda row: row.loop)
    panel.plot([row.loop for row in line], [row.l2 for row in line], "-", color="0.6", zorder=0, label="front")
    panel.set(xscale="log", yscale="log", title=FLOWS[flow][0], xlabel="time loop [s]", ylabel="L2 error")
    panel.grid(True, which="major", alpha=0.3)


def _color(way):
    """One colour for each scheme, and one for all peers."""
    for start, color in (("explicit", "tab:blue"), ("implicit", "tab:red")):
        if way.startswith(start):
            return color
    return "0.25"
