"""What a scene follows in time, against the exact history."""

import numpy as np

from tisph.measures.resolution import resolution
from tisph.report import style
from tisph.report.labels import axis_exponent, axis_label, number, unit_label
from tisph.report.margins import set_margins

_MARKERS = 40  # a number, on its exact curve
_FEW = 8  # on a line of its own, where there is no exact one
_SHAPES = "osD^v"
_MARKERS_A_PERIOD = 12  # at least, where a wall oscillates: with fewer the eye sees another oscillation
_CURVE_POINTS = 300
_CURVE_POINTS_A_PERIOD = 40
_MOST_CURVE_POINTS = 4000
_LEGEND_ENTRIES = 12
_MARGIN = 0.1  # of the axis, beyond what is resolved
_SMALLEST = 1e-3  # half the height of the axes of a number, over its size: less than that is noise


def history_figure(
    scene, settings: dict, times: np.ndarray, values: np.ndarray, resolved: np.ndarray | None = None
) -> style.PlotFigure:
    """Return the numbers that ``scene`` follows in time: markers on their exact history, or lines where it has none.

    ``settings`` are those of ``scene.time_series``; ``times`` (n,) and ``values`` (n, numbers) are in the units of the
    scene. Each kind of number has axes of its own. Of more than twelve numbers the legend names twelve, evenly chosen.
    Times at which the flow is not ``resolved`` (n,) are shaded; None for what the scene knows of that.
    """
    series = scene.time_series(**settings)
    if resolved is None:
        resolved = np.array([resolution(scene, t)[0] for t in times])
    panels = list(series.panels or [(series.name, series.unit)] * values.shape[1])
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


def _exact_lines(axes, series, chosen, times, values, resolved):
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


def _lines(axes, series, chosen, times, values, resolved):
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
        kind = series.panels[chosen[0]][1]
        middle = 0.5 * (low + high) if kind in ("length", "angle") else 0.0
        ends = [0.0 if kind == "energy" else middle - least, middle + least, *(1.05 * level for level in known)]
        axes.set_ylim(min(low, *ends), max(high, *ends))


def _label(name: str, place: float | None) -> str:
    return name if place is None else f"{name} = {number(place, 3)}"


def _mark_unresolved(axes, times: np.ndarray, resolved: np.ndarray, label: str | None) -> None:
    """Shade the times between which the flow has a layer, or a gap, that is too thin for the particles."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], resolved, [True]])))
    for first, end in edges.reshape(-1, 2):
        if end - first > 1:
            axes.axvspan(times[first], times[end - 1], color=style.MUTED, alpha=0.2, linewidth=0, label=label)


def _fit_to_what_is_resolved(axes, resolved: np.ndarray, values: np.ndarray) -> None:
    """Let the axis show numbers at times at which the flow is resolved, and smaller ones, not an infinite start."""
    values = np.where(np.isfinite(values), values, np.nan)
    if any(resolved):
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


def _label_axes(axes, scene, kind: tuple[str, str], latest: float) -> None:
    name, unit = kind
    time_exponent, exponent = axis_exponent(latest), axis_exponent(max(map(abs, axes.get_ylim())))
    axes.set_xlabel(axis_label("t", scene.units.time, time_exponent), parse_math=False)
    axes.set_ylabel(axis_label(name, unit_label(unit, scene.units), exponent), parse_math=False)
    style.format_ticks(axes.xaxis, time_exponent)
    style.format_ticks(axes.yaxis, exponent)
    axes.grid(True)
    axes.margins(x=0.02)
