"""The picture of the comparison of wall treatments: error against resolution, a panel for each flow and Laplacian."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tisph.report.style import MUTED, plot_style
from tisph.studies.sweep import draw_lines
from tisph.studies.walls_cases import ARRANGEMENTS
from tisph.studies.walls_laplacian import ROUND_OFF
from tisph.studies.walls_table import MEASURES

# Okabe and Ito's colours, which colour-blind eyes tell apart too; the markers tell the same without colour.
LOOKS = (("#d55e00", "v"), ("#009e73", "s"), ("#56b4e9", "o"), ("#000000", "x"), ("#cc79a7", "D"), ("#e69f00", "P"))
STYLES = ("-", "--", ":")
COLUMNS = 3


def plot_walls(path, rows, laplacians):
    """Write the picture of ``rows`` (``walls_cases.Row``) to ``path``; runs that stopped leave gaps.

    ``laplacians`` (``walls_laplacian.Laplacian``): those with the usual kernel are drawn, next to the wall.
    """
    titles = list(dict.fromkeys(row.case.title for row in rows))
    usual = [each for each in laplacians if (each.kernel, each.ratio) == ("quintic_spline", 1.0)]
    profiles = list(dict.fromkeys(each.profile for each in usual))
    treatments = list(dict.fromkeys(row.case.treatment for row in rows))
    looks = {name: LOOKS[place % len(LOOKS)] for place, name in enumerate(treatments)}
    arrangements = dict.fromkeys(row.case.arrangement for row in rows)
    styles = {name: style for name, style in zip(ARRANGEMENTS, STYLES, strict=False) if name in arrangements}
    with plot_style():
        lines = -(-(len(titles) + len(profiles)) // COLUMNS)
        figure = Figure((12.0, 3.9 * lines + 0.9), dpi=120, layout="constrained")
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
        FigureCanvasAgg(figure)
        panels = figure.subplots(lines, COLUMNS, squeeze=False).ravel()
        for panel, title in zip(panels, titles, strict=False):
            _draw(panel, title, [row for row in rows if row.case.title == title], looks, styles)
        for panel, profile in zip(panels[len(titles) :], profiles, strict=False):
            _draw_laplacians(panel, profile, [each for each in usual if each.profile == profile], looks, styles)
        for panel in panels[len(titles) + len(profiles) :]:
            panel.axis("off")
        figure.legend(handles=_legend(looks, styles), loc="outside lower center", ncols=4, frameon=False)
        figure.savefig(path)


def _draw(panel, title, rows, looks, styles):
    lines = [_line(row.errors, looks[row.case.treatment], styles[row.case.arrangement]) for row in rows]
    lines += _second_order(rows)
    draw_lines(panel, lines, f"{MEASURES[rows[0].case.measure]} error", "particles across the gap")
    times = ", ".join(f"{time:g}" for time in rows[0].case.times)
    panel.set_title(f"{title}, t* = {times}", fontsize=11)


def _draw_laplacians(panel, profile, laplacians, looks, styles):
    lines = []
    for each in laplacians:
        near = {number: error for number, (error, _) in each.errors.items() if error > ROUND_OFF}
        if near and each.arrangement in styles:
            lines.append(_line(near, looks[each.treatment], styles[each.arrangement]))
    draw_lines(panel, lines, "error of the Laplacian over $u_{yy}$", "particles across the gap")
    panel.set_title(f"Laplacian next to the wall, profile {profile} there", fontsize=11)


def _line(errors, look, style):
    options = {"color": look[0], "marker": look[1], "linestyle": style}
    return errors.items(), {**options, "markerfacecolor": "none", "linewidth": 1.4, "markersize": 7}


def _second_order(rows):
    """A line of slope -2 below all others, to compare slopes with."""
    scaled = [error * number**2 for row in rows for number, error in row.errors.items() if error > 0]
    points = [(number, 0.6 * min(scaled) / number**2) for number in rows[0].errors] if scaled else []
    return [(points, {"color": MUTED, "linewidth": 0.8})] if points else []


def _legend(looks, styles):
    treatments = [
        Line2D([], [], color=colour, marker=marker, markerfacecolor="none", markersize=7, label=name)
        for name, (colour, marker) in looks.items()
    ]
    arrangements = [Line2D([], [], color="#000000", linestyle=style, label=name) for name, style in styles.items()]
    return [*treatments, *arrangements, Line2D([], [], color=MUTED, linewidth=0.8, label="second order")]
