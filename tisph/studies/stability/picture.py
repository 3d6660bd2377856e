"""The map as a picture: a panel for each sub-matrix, a field for each cell, its colour the verdict."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from tisph.report.style import plot_style
from tisph.studies.stability.judge import SILENT_FAILURE, VERDICTS
from tisph.studies.stability.maps import by_axis, layout

COLOURS = {
    "stable": "#56b4e9",
    "inaccurate": "#f0e442",
    "stopped": "#999999",
    "refused": "#dddddd",
    SILENT_FAILURE: "#d55e00",
}
"""Okabe and Ito's, which colour-blind eyes tell apart too; every field says in words what it is."""

FIELD, BAR, HEADER = 0.32, 0.2, 0.75
"""Height of a field, of a bar, and of what else a panel has [inches]."""


def plot_maps(path, parts, rows):
    """Draw the maps of the sub-matrices ``parts`` from ``rows`` by cell into ``path``."""
    stacks = _stacks(parts, rows)
    tallest = max(sum(height for _, height in stack) for stack in stacks)
    with plot_style():
        figure = Figure((14.0, tallest + 0.4), dpi=110, layout="constrained")
        FigureCanvasAgg(figure)
        for stack, half in zip(stacks, figure.subfigures(1, len(stacks), squeeze=False)[0], strict=True):
            heights = [height for _, height in stack]
            empty = [tallest - sum(heights)] if sum(heights) < tallest else []
            panels = half.subplots(len(heights + empty), 1, squeeze=False, height_ratios=heights + empty)[:, 0]
            for (part, _), panel in zip(stack, panels, strict=False):
                panel.set_title(part.title, fontsize=11)
                (_draw_map if part.columns else _draw_counts)(panel, part, rows)
            for panel in panels[len(stack) :]:
                panel.axis("off")
        handles = [Patch(facecolor=COLOURS[verdict], edgecolor="0.4", label=verdict) for verdict in VERDICTS]
        handles.append(
            Patch(facecolor="none", edgecolor="black", linewidth=2.0, label="required to be stable, or to finish")
        )
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
        figure.savefig(path)


def _stacks(parts, rows):
    """Two columns of pairs of a part and the height of its panel, each put where there is more room."""
    stacks = ([], [])
    for part in parts:
        shorter = min(stacks, key=lambda stack: sum(height for _, height in stack))
        shorter.append((part, _height(part, rows) + HEADER))
    return [stack for stack in stacks if stack]


def _height(part, rows):
    """Height of a panel without its title and labels [inches]."""
    return FIELD * len(layout(part)[1]) if part.columns else BAR * len(by_axis(part, rows))


def _draw_map(panel, part, rows):
    columns, names, positions = layout(part)
    for (name, column), cell in positions.items():
        x, y = columns.index(column), names.index(name)
        row = rows[cell]
        colour = COLOURS[row.judgement.verdict]
        panel.add_patch(Rectangle((x, y), 1, 1, facecolor=colour, edgecolor="white", linewidth=1.0))
        if cell.required:
            panel.add_patch(Rectangle((x + 0.03, y + 0.06), 0.94, 0.88, fill=False, edgecolor="black", linewidth=1.4))
        text = row.short.replace(" ", "\n")
        panel.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=7, linespacing=0.9)
    panel.set(xlim=(0, len(columns)), ylim=(len(names), 0))
    panel.set_xticks([place + 0.5 for place in range(len(columns))], columns, fontsize=8)
    panel.set_yticks([place + 0.5 for place in range(len(names))], names, fontsize=8)
    _plain(panel)


def _draw_counts(panel, part, rows):
    """Bars of the numbers of cells with each value of each axis."""
    counts = by_axis(part, rows)
    for place, numbers in enumerate(counts.values()):
        left = 0
        for verdict, number in zip(VERDICTS, numbers, strict=True):
            panel.barh(place + 0.5, number, left=left, height=0.8, color=COLOURS[verdict], edgecolor="white")
            if number:
                panel.text(left + number / 2, place + 0.5, str(number), ha="center", va="center", fontsize=8)
            left += number
    panel.set(ylim=(len(counts), 0))
    panel.set_xticks([])
    panel.set_yticks([place + 0.5 for place in range(len(counts))], [value for _, value in counts], fontsize=8)
    _plain(panel)


def _plain(panel):
    panel.tick_params(length=0)
    panel.grid(False)
    for spine in panel.spines.values():
        spine.set_visible(False)
