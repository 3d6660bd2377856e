"""What a scene follows in time, against the exact history."""

import numpy as np

from tisph.measures.resolution import resolution
from tisph.report import style
from tisph.report.labels import axis_exponent, axis_label, number, unit_label
from tisph.report.margins import set_margins

_MARKERS = 40  # a number
_MARKERS_A_PERIOD = 12  # at least, where a wall oscillates: with fewer the eye sees another oscillation
_CURVE_POINTS = 300
_CURVE_POINTS_A_PERIOD = 40
_MOST_CURVE_POINTS = 4000
_LEGEND_ENTRIES = 12
_MARGIN = 0.1  # of the axis, beyond what is resolved of a history that begins at infinity


def history_figure(scene, settings: dict, times: np.ndarray, values: np.ndarray) -> style.PlotFigure:
    """Return the numbers that ``scene`` follows in time, as markers on their exact history.

    ``settings`` are those of ``scene.time_series``; ``times`` (n,) and ``values`` (n, numbers) are in the units of the
    scene. Of more than twelve numbers the legend names twelve, evenly chosen. Times at which the flow is not resolved
    are shaded.
    """
    series = scene.time_series(**settings)
    values = values / np.array(series.sizes) if series.sizes else values
    with style.plot_style():
        figure = style.plot_figure()
        axes = figure.subplots()
        periods = series.angular_frequency * (times[-1] - times[0]) / (2.0 * np.pi)
        shown = style.evenly_chosen(len(times), max(_MARKERS, round(_MARKERS_A_PERIOD * periods)))
        count = values.shape[1]
        named = style.evenly_chosen(count, _LEGEND_ENTRIES)
        colours = style.colours(count, 0.9)
        size = 5 if len(shown) <= 2 * _MARKERS else 3
        exact_times = _curve_times(times[0], times[-1], periods)
        exact = series.exact(exact_times)
        for index in reversed(range(count)):  # the legend from top to bottom, as in a channel
            markers = axes.plot(times[shown], values[shown, index], "o", color=colours[index], markersize=size)[0]
            if exact is not None:
                axes.plot(exact_times, exact[:, index], "-", color=style.TEXT, linewidth=0.9)
            if index in named:
                markers.set_label(_label(*series.labels[index]))
        if exact is not None:
            axes.plot([], [], "-", color=style.TEXT, linewidth=0.9, label="exact")
            if not np.isfinite(exact).all():
                _fit_to_what_is_resolved(axes, scene, times, values)
        _mark_unresolved(axes, scene, times)
        _label_axes(axes, scene, series, float(np.max(np.abs(times))))
        legend = figure.legend(loc="center right", frameon=False, fontsize=10)
        set_margins(figure, np.array([[axes]]), legend, below=False)
    return figure


def _label(name: str, place: float | None) -> str:
    return name if place is None else f"{name} = {number(place, 3)}"


def _mark_unresolved(axes, scene, times: np.ndarray) -> None:
    """Shade the times up to the last at which the flow has a layer that is too thin for the particles."""
    early = [t for t in times if not resolution(scene, t)[0]]
    if early and early[-1] > times[0]:
        axes.axvspan(times[0], early[-1], color=style.MUTED, alpha=0.2, linewidth=0, label="not resolved")


def _fit_to_what_is_resolved(axes, scene, times: np.ndarray, values: np.ndarray) -> None:
    """Let the axis show the numbers at times at which the flow is resolved, in place of an infinite start."""
    resolved = [resolution(scene, t)[0] for t in times]
    values = values[resolved] if any(resolved) else values
    values = values[np.isfinite(values)]
    if values.size:
        margin = _MARGIN * (values.max() - values.min() or 1.0)
        axes.set_ylim(values.min() - margin, values.max() + margin)


def _curve_times(first: float, last: float, periods: float) -> np.ndarray:
    """Return times for the exact curve: more early on, where a start changes fastest, and enough in every period."""
    early = first + (last - first) * np.linspace(0.0, 1.0, _CURVE_POINTS) ** 2
    even = np.linspace(first, last, min(round(_CURVE_POINTS_A_PERIOD * periods), _MOST_CURVE_POINTS))
    return np.union1d(early, even)


def _label_axes(axes, scene, series, latest: float) -> None:
    time_exponent, exponent = axis_exponent(latest), axis_exponent(series.scale)
    axes.set_xlabel(axis_label("t", scene.units.time, time_exponent), parse_math=False)
    axes.set_ylabel(axis_label(series.name, unit_label(series.unit, scene.units), exponent), parse_math=False)
    style.format_ticks(axes.xaxis, time_exponent)
    style.format_ticks(axes.yaxis, exponent)
    axes.grid(True)
    axes.margins(x=0.02)
