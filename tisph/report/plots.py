"""Plots of a run: numbers over time, profiles at the samples with their errors, and curves of a rheometer.

The room for labels and legend is computed here: matplotlib's constrained layout takes five times the time. That engine
measures everything twice, and matplotlib prepares all ticks again for each measurement.
"""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from tisph.measures.resolution import resolution
from tisph.report import style
from tisph.report.labels import (
    MINUS,
    axis_exponent,
    axis_label,
    coordinate_name,
    cut_name,
    error_label,
    number,
    unit_label,
)
from tisph.scenes._scene import Scene
from tisph.scenes._views import Profile, TimeSeries
from tisph.snapshot import Snapshot

_MARKERS = 40  # a number, on its exact curve
_FEW = 8  # on a line of its own, where there is no exact one
_SHAPES = "osD^v"
_MARKERS_A_PERIOD = 12  # at least, where a wall oscillates: with fewer the eye sees another oscillation
_CURVE_POINTS = 300
_CURVE_POINTS_A_PERIOD = 40
_MOST_CURVE_POINTS = 4000
_LEGEND_ENTRIES = 12
_OFTEN = 0.25  # of the times
_MARGIN = 0.1  # of the range of the resolved values, at both ends of the axis
_SMALLEST = 1e-3  # half the height of the axes of a number, over its size: less than that is noise


def history_figure(
    scene: Scene, settings: dict, times: np.ndarray, values: np.ndarray, resolved: np.ndarray | None = None
) -> style.PlotFigure:
    """Return the numbers that ``scene`` follows in time: markers on their exact history, or lines where it has none.

    ``settings``: arguments of ``scene.time_series``; ``times`` (n,) and ``values`` (n, numbers) are in the units of the
    scene. Each kind of number has axes of its own. Of more than twelve numbers the legend names twelve, evenly chosen.
    Times at which the flow is not ``resolved`` (n,) are shaded; if None, the scene decides where it is resolved.
    """
    series = scene.time_series(**settings)
    if resolved is None:
        resolved = np.array([resolution(scene, t)[0] for t in times])
    panels: list[Any] = list(series.panels or [(series.name, series.unit)] * values.shape[1])
    kinds = [kind for kind in dict.fromkeys(panels) if kind]
    columns = 2 if len(kinds) > 3 else 1
    rows = -(-len(kinds) // columns)
    with style.plot_style():
        figure = style.plot_figure(min(rows, 2))
        grid = figure.subplots(rows, columns, squeeze=False)
        drawn = _lines if series.exact(times[:1]) is None else _exact_lines
        for kind, axes in zip(kinds, grid.flat, strict=False):
            chosen = [index for index, panel in enumerate(panels) if panel == kind]
            drawn(axes, series, chosen, times, values, resolved)
            _mark_unresolved(axes, times, resolved, "not resolved" if kind == kinds[-1] else None)
            _label_axes(axes, scene, kind, float(np.max(np.abs(times))))
        named: dict = {}
        for axes in figure.axes:
            named |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        legend = figure.legend(named.values(), named, loc="center right", frameon=False, fontsize=10)
        set_margins(figure, grid, legend, below=False)
        for axes in grid.flat[len(kinds) :]:
            axes.remove()
    return figure


def _exact_lines(
    axes: Axes, series: TimeSeries, chosen: list[int], times: np.ndarray, values: np.ndarray, resolved: np.ndarray
) -> None:
    """Draw the numbers ``chosen`` as markers on their exact curves, the legend from top to bottom, as in a channel."""
    periods = series.angular_frequency * (times[-1] - times[0]) / (2.0 * np.pi)
    shown = style.evenly_chosen(len(times), max(_MARKERS, round(_MARKERS_A_PERIOD * periods)))
    named = style.evenly_chosen(len(chosen), _LEGEND_ENTRIES)
    colours = style.colours(len(chosen), 0.9)
    size = 5 if len(shown) <= 2 * _MARKERS else 3
    exact_times = _curve_times(times[0], times[-1], periods)
    exact = series.exact(exact_times)
    for place, index in reversed(list(enumerate(chosen))):
        markers = axes.plot(times[shown], values[shown, index], "o", color=colours[place], markersize=size)[0]
        axes.plot(exact_times, exact[:, index], "-", color=style.TEXT, linewidth=0.9)
        if place in named:
            markers.set_label(_label(*series.labels[index]))
    axes.plot([], [], "-", color=style.TEXT, linewidth=0.9, label="exact")
    if not np.isfinite(exact).all():
        _fit_to_what_is_resolved(axes, resolved, values[:, chosen])


def _lines(
    axes: Axes, series: TimeSeries, chosen: list[int], times: np.ndarray, values: np.ndarray, resolved: np.ndarray
) -> None:
    """Draw the numbers ``chosen`` as lines; those that lie on each other have their few markers at different times."""
    panels = series.panels or series.labels
    texts = list(dict.fromkeys(_label(*label) for label, panel in zip(series.labels, panels, strict=True) if panel))
    colours, step = style.colours(len(texts), 0.85), max(1, len(times) // _FEW)
    for place, index in enumerate(chosen):
        text = _label(*series.labels[index])
        look = {"color": colours[texts.index(text)], "marker": _SHAPES[texts.index(text) % len(_SHAPES)], "ms": 5}
        some = step * place // len(chosen), step
        label = text if texts.index(text) in style.evenly_chosen(len(texts), _LEGEND_ENTRIES) else None
        axes.plot(times, values[:, index], lw=max(1.0, 2.5 - 0.5 * place), markevery=some, label=label, **look)
    known = [series.levels[index] for index in chosen if series.levels and np.isfinite(series.levels[index])]
    for level in known:
        axes.axhline(level, color=style.EXACT, linestyle="--", linewidth=1.0, label=series.level_name)
    _fit_to_what_is_resolved(axes, resolved, values[:, chosen])
    if series.panels:  # of a force one wants to see how far it is from none, of a place how it changes
        least = _SMALLEST * max(series.sizes[index] for index in chosen)
        low, high = axes.get_ylim()
        panel: Any = series.panels[chosen[0]]
        kind = panel[1]
        middle, beyond = (0.5 * (low + high), 1.0) if kind in ("length", "angle") else (0.0, 1.05)
        ends = [0.0 if kind == "energy" else middle - least, middle + least, *(1.05 * level for level in known)]
        ends += [beyond * low, beyond * high]  # a constant number is not on the frame
        axes.set_ylim(min(low, *ends), max(high, *ends))


def _label(name: str, place: float | None) -> str:
    return name if place is None else f"{name} = {number(place, 3)}"


def _mark_unresolved(axes: Axes, times: np.ndarray, resolved: np.ndarray, label: str | None) -> None:
    """Shade the times between which the flow has a layer, or a gap, that is too thin for the particles."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], resolved, [True]])))
    for first, end in edges.reshape(-1, 2):
        if end - first > 1:
            axes.axvspan(times[first], times[end - 1], color=style.MUTED, alpha=0.2, linewidth=0, label=label)


def _fit_to_what_is_resolved(axes: Axes, resolved: np.ndarray, values: np.ndarray) -> None:
    """Let the axis show numbers at times at which the flow is resolved, and smaller ones, not an infinite start.

    Of a flow that is rarely resolved all numbers are shown.
    """
    values = np.where(np.isfinite(values), values, np.nan)
    if np.mean(resolved) > _OFTEN:
        values = values[resolved[:, None] | (np.abs(values) <= np.nanmax(np.abs(values[resolved]), initial=0.0))]
    values = values[np.isfinite(values)]
    if values.size:
        margin = _MARGIN * (values.max() - values.min() or 1.0)
        axes.set_ylim(values.min() - margin, values.max() + margin)


def _curve_times(first: float, last: float, periods: float) -> np.ndarray:
    """Return times for the exact curve: more early on, where a start changes fastest, and enough in every period."""
    early = first + (last - first) * np.linspace(0.0, 1.0, _CURVE_POINTS) ** 2
    even = np.linspace(first, last, min(round(_CURVE_POINTS_A_PERIOD * periods), _MOST_CURVE_POINTS))
    return np.union1d(early, even)


def _label_axes(axes: Axes, scene: Scene, kind: tuple[str, str], latest: float) -> None:
    name, unit = kind
    time_exponent, exponent = axis_exponent(latest), axis_exponent(max(map(abs, axes.get_ylim())))
    axes.set_xlabel(axis_label("t", scene.units.time, time_exponent), parse_math=False)
    axes.set_ylabel(axis_label(name, unit_label(unit, scene.units), exponent), parse_math=False)
    style.format_ticks(axes.xaxis, time_exponent)
    style.format_ticks(axes.yaxis, exponent)
    axes.grid(True)
    axes.margins(x=0.02)


_DOTS = 400  # particles drawn a sample: more only hide each other
_PALE = 0.25  # opacity of the particles behind their interpolated profile
_PROFILE_POINTS = 200
_THIN, _WIDER = 1.6, 1.2  # points: line of the last sample; so much wider are earlier ones, which show beneath it

Panel = tuple[Profile, bool]
"""A profile, and whether its error over its scale is shown."""


def profile_figure(scene: Scene, snapshots: Sequence[Snapshot]) -> style.PlotFigure:
    """Return the profiles of ``scene`` at every snapshot with the exact curves, and their errors.

    There are two panels a row. Of more than twelve snapshots the legend names twelve, evenly chosen.
    """
    profiles = scene.all_profiles()
    panels = [(profile, error) for profile in profiles for error in (False, True) if profile.scale or not error]
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
            coordinates = [profile.line.coordinates(_PROFILE_POINTS) for profile in profiles]
            found = [each.interpolated(scene, snapshot, at) for each, at in zip(profiles, coordinates, strict=True)]
            curves = [(coordinates[k], found[k]) for k in (profiles.index(profile) for profile, _ in panels)]
            shown = zip(axes, panels, curves, strict=False)
            drawn = [_plot(one, panel, snapshot, curve, looks[index]) for one, panel, curve in shown]
            if index in named:
                t_star = number(snapshot.t / scene.time_scale, 3)
                time = f"t = {number(snapshot.t)} {scene.units.time},  t* = {t_star}"
                drawn[0].set_label(f"{time},  {error_words(snapshot)}".rstrip(", "))
        _label_profile_axes(axes, panels, scene)
        references = dict.fromkeys(profile.reference for profile, _ in panels if profile.exact)
        if references:
            axes[0].plot([], [], "-", color=style.TEXT, linewidth=0.9, label=", ".join(references))
        legend = figure.legend(
            loc="lower center", ncols=3, frameon=False, fontsize=10, handlelength=1.2, columnspacing=1.2
        )
        set_margins(figure, grid, legend, below=True)
    return figure


def _looks(count: int) -> list[dict]:
    """Return colour and width of the line of every sample: where lines coincide, earlier ones show beneath."""
    widths = np.linspace(_THIN + min(5.0, _WIDER * (count - 1)), _THIN, count)
    return [{"color": colour, "lw": width} for colour, width in zip(style.colours(count, 0.85), widths, strict=True)]


def _plot(axes: Axes, panel: Panel, snapshot: Snapshot, curve: tuple[np.ndarray, np.ndarray], look: dict) -> Line2D:
    """Draw one sample into one panel: particles pale behind the ``curve`` (coordinates, values); return its line."""
    profile, error = panel
    chosen = profile.line.particles(snapshot)
    chosen = chosen[style.evenly_chosen(len(chosen), _DOTS)]
    along, values = profile.line.of(snapshot)[chosen], profile.of(snapshot)[chosen]
    coordinates, between = curve
    exact = profile.exact(*profile.line.points(coordinates), snapshot.t) if profile.exact else None
    if error:
        assert profile.exact
        assert profile.scale
        values = (values - profile.exact(snapshot.x[chosen], snapshot.y[chosen], snapshot.t)) / profile.scale[0]
        between, exact = (between - exact) / profile.scale[0], None
    alpha = _PALE if np.isfinite(between).any() else 1.0
    axes.plot(values, along, "o", color=look["color"], markersize=3.5, markeredgewidth=0.0, alpha=alpha)
    line = axes.plot(between, coordinates, "-", **look)[0]
    if exact is not None:
        wet = np.isfinite(between) | ~np.isfinite(between).any()
        axes.plot(np.where(wet, exact, np.nan), coordinates, "-", color=style.TEXT, linewidth=0.9)
    return line


def _label_profile_axes(axes: Iterable[Axes], panels: Sequence[Panel], scene: Scene) -> None:
    shown: Any = zip(axes, panels, strict=False)
    for index, (one, (profile, error)) in enumerate(shown):
        name, unit = cut_name(profile, scene), unit_label(profile.unit, scene.units)
        if error:
            name, unit = f"({profile.name} {MINUS} {profile.name} {profile.reference}) / {profile.scale[1]}", ""
            one.axvline(0.0, color=style.MUTED, linewidth=0.8)
        reach = float(np.max(np.abs(one.dataLim.intervalx)))
        exponent = axis_exponent(reach if math.isfinite(reach) else 0.0)  # no finite number, of data of other codes
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
            one.set_ylabel(
                axis_label(coordinate_name(scene, line.along), scene.units.length, exponent), parse_math=False
            )


RUN: dict[str, Any] = {"color": style.PARTICLES}
STYLES: dict[str, dict[str, Any]] = {
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


def _between(value: float) -> str:
    """The text of a tick between powers of ten: of 2 and 5 times one."""
    return number(value, 1) if f"{value:.0e}"[0] in "25" else ""


def plot_reading(path: Path, name: str, reading: Any, units: Any) -> None:
    """Write a PNG of the curves of a ``rheometry.viscometers.Reading``, a row of axes for each of its ``Axes``.

    ``units``: labels of the units of the config.
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


_PAD = 0.12  # inches, around axes with their labels


def set_margins(figure: Figure, axes: np.ndarray, legend: Legend, *, below: bool) -> None:
    """Give all ``axes`` (rows, columns) of ``figure`` the same size, as large as their labels and the legend leave it.

    The legend is at the right, or ``below``. Axes of a column, and of a row, have the same room around them.
    """
    pad, (width, height) = _PAD * figure.dpi, figure.bbox.size
    canvas: Any = figure.canvas
    renderer = canvas.get_renderer()
    around = (
        np.array([[_room_for_labels(one, renderer) for one in row] for row in axes]) + pad
    )  # left, bottom, right, top
    left, right = around[:, :, 0].max(axis=0), around[:, :, 2].max(axis=0)
    bottom, top = around[:, :, 1].max(axis=1), around[:, :, 3].max(axis=1)
    box = legend.get_window_extent(renderer)
    right[-1] += 0.0 if below else width - box.x0
    bottom[-1] += box.y1 if below else 0.0
    across = (width - left.sum() - right.sum()) / axes.shape[1]
    down = (height - bottom.sum() - top.sum()) / axes.shape[0]
    for row, column in np.ndindex(axes.shape):
        x = left[: column + 1].sum() + right[:column].sum() + column * across
        y = height - top[: row + 1].sum() - bottom[:row].sum() - (row + 1) * down
        axes[row, column].set_position((x / width, y / height, across / width, down / height))


def _room_for_labels(axes: Axes, renderer: Any) -> tuple[float, float, float, float]:
    """Return how far ticks and labels stand out of ``axes`` at the left, bottom, right and top, in pixels."""
    inner, tight = axes.bbox, [axis.get_tightbbox(renderer) for axis in (axes.xaxis, axes.yaxis)]
    boxes = [inner, *(box for box in tight if box)]
    return (
        inner.x0 - min(box.x0 for box in boxes),
        inner.y0 - min(box.y0 for box in boxes),
        max(box.x1 for box in boxes) - inner.x1,
        max(box.y1 for box in boxes) - inner.y1,
    )
