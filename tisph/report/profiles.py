"""Profiles at the samples: particles against exact curves along the lines of a scene, and their errors."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from tisph.report import style
from tisph.report.error_label import error_label
from tisph.report.labels import MINUS, axis_exponent, axis_label, number, unit_label
from tisph.report.margins import set_margins
from tisph.scenes._views import Profile
from tisph.snapshot import Snapshot

_DOTS = 400  # particles drawn a sample: more only hide each other
_CURVE_POINTS = 400
_LEGEND_ENTRIES = 12
_MARKERS = "osD^v"
_SMALLEST, _LARGEST = 3.5, 8.0  # markers: later samples have smaller ones, so that both show where curves coincide

Panel = tuple[Profile, bool]
"""A profile, and whether its error over its scale is shown."""


def profile_figure(scene, snapshots: Sequence[Snapshot]) -> style.PlotFigure:
    """Return the profiles of ``scene`` at every snapshot with the exact curves, and their errors.

    There are two panels a row. Of more than twelve snapshots the legend names twelve, evenly chosen.
    """
    panels = [(profile, error) for profile in scene.profiles() for error in (False, True) if profile.scale or not error]
    rows = -(-len(panels) // 2)
    with style.plot_style():
        figure = style.plot_figure(rows=rows)
        grid = figure.subplots(rows, 2, squeeze=False)
        axes = grid.ravel()
        for left_over in axes[len(panels) :]:
            left_over.set_axis_off()
        named = style.evenly_chosen(len(snapshots), _LEGEND_ENTRIES)
        error_words = error_label(scene)
        looks = _looks(len(snapshots))
        for index, snapshot in enumerate(snapshots):
            drawn = [_plot(one, scene, panel, snapshot, looks[index]) for one, panel in zip(axes, panels, strict=False)]
            if index in named:
                t_star = number(snapshot.t / scene.time_scale, 3)
                time = f"t = {number(snapshot.t)} {scene.units.time},  t* = {t_star}"
                drawn[0].set_label(f"{time},  {error_words(snapshot)}".rstrip(", "))
        _label_axes(axes, panels, scene)
        references = dict.fromkeys(profile.reference for profile, _ in panels if profile.exact)
        if references:
            axes[0].plot([], [], "-", color=style.TEXT, linewidth=0.9, label=", ".join(references))
        legend = figure.legend(loc="lower center", ncols=3, frameon=False, fontsize=10)
        set_margins(figure, grid, legend, below=True)
    return figure


def _looks(count: int) -> list[dict]:
    """Return colour, shape and size of every sample's markers."""
    sizes = np.linspace(min(_LARGEST, _SMALLEST + 1.5 * count - 0.5), _SMALLEST, count)
    return [
        {"color": colour, "marker": _MARKERS[index % len(_MARKERS)], "markersize": size, "markeredgewidth": 0.0}
        for index, (colour, size) in enumerate(zip(style.colours(count, 0.85), sizes, strict=True))
    ]


def _plot(axes: Axes, scene, panel: Panel, snapshot: Snapshot, look: dict) -> Line2D:
    """Draw one sample into one panel; return its dots."""
    profile, error = panel
    chosen = profile.line.particles(snapshot)
    chosen = chosen[style.evenly_chosen(len(chosen), _DOTS)]
    along, values = profile.line.of(snapshot)[chosen], profile.of(snapshot)[chosen]
    if error:
        exact = profile.exact(snapshot.x[chosen], snapshot.y[chosen], snapshot.t)
        look = {**look, "markersize": 0.7 * look["markersize"]}
        return axes.plot((values - exact) / profile.scale[0], along, linestyle="", alpha=0.8, **look)[0]
    dots = axes.plot(values, along, linestyle="", **look)[0]
    if profile.exact:
        coordinates = profile.line.coordinates(_CURVE_POINTS)
        exact = profile.exact(*profile.line.points(coordinates), snapshot.t)
        exact = np.where(profile.line.in_fluid(scene.seen(snapshot), coordinates, snapshot.t), exact, np.nan)
        axes.plot(exact, coordinates, "-", color=style.TEXT, linewidth=0.9)
    return dots


def _label_axes(axes: Sequence[Axes], panels: Sequence[Panel], scene) -> None:
    for index, (one, (profile, error)) in enumerate(zip(axes, panels, strict=False)):
        name, unit = profile.name, unit_label(profile.unit, scene.units)
        if error:
            name, unit = f"({name} {MINUS} {name} {profile.reference}) / {profile.scale[1]}", ""
            one.axvline(0.0, color=style.MUTED, linewidth=0.8)
        exponent = axis_exponent(float(np.max(np.abs(one.dataLim.intervalx))))
        one.set_xlabel(axis_label(name, unit, exponent), parse_math=False)
        style.format_ticks(one.xaxis, exponent)
        one.grid(True)
        one.locator_params(axis="x", nbins=7)
        line, left = profile.line, panels[index - index % 2][0].line
        exponent = axis_exponent(line.ends[1])
        style.format_ticks(one.yaxis, exponent)
        one.set_ylim(*line.ends)
        if index % 2 and (line.along, line.ends) == (left.along, left.ends):
            one.tick_params(labelleft=False)
        else:
            one.set_ylabel(axis_label(line.along, scene.units.length, exponent), parse_math=False)
