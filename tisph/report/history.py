"""Velocity over time at the tracers, against the exact history."""

from pathlib import Path

import numpy as np
from matplotlib.ticker import FuncFormatter

from tisph.report import style
from tisph.report.labels import axis_exponent, axis_label, number, tick_text, velocity_unit
from tisph.report.room import make_room
from tisph.verification.resolution import resolution

_MARKERS = 40  # a tracer
_MARKERS_A_PERIOD = 12  # at least, where a wall oscillates: with fewer the eye sees another oscillation
_CURVE_POINTS = 300
_CURVE_POINTS_A_PERIOD = 40
_MOST_CURVE_POINTS = 4000
_LEGEND_ENTRIES = 12


def plot_history(path: Path | str, channel, times: np.ndarray, tracer_y: np.ndarray, tracer_u: np.ndarray) -> None:
    """Write a PNG of u(t) at every tracer, as markers on the exact history.

    ``times`` (n,) and ``tracer_u`` (n, tracers) are in the units of ``channel``, as are the heights
    ``tracer_y`` (tracers,). Of more than twelve tracers the legend names twelve, evenly chosen. Times at which the flow
    is not resolved are shaded.
    """
    with style.plot_style():
        figure = style.plot_figure()
        axes = figure.subplots()
        periods = _periods(channel, times[-1] - times[0])
        shown = style.evenly_chosen(len(times), max(_MARKERS, round(_MARKERS_A_PERIOD * periods)))
        named = style.evenly_chosen(len(tracer_y), _LEGEND_ENTRIES)
        colours = style.colours(len(tracer_y), 0.9)
        size = 5 if len(shown) <= 2 * _MARKERS else 3
        exact_times = _curve_times(times[0], times[-1], periods)
        for index in reversed(range(len(tracer_y))):  # the legend from top to bottom, as in the channel
            height, colour = tracer_y[index], colours[index]
            markers = axes.plot(times[shown], tracer_u[shown, index], "o", color=colour, markersize=size)[0]
            exact = channel.exact_velocity(height, exact_times)
            axes.plot(exact_times, exact, "-", color=style.TEXT, linewidth=0.9)
            if index in named:
                markers.set_label(f"y/H = {number(height / channel.gap, 3)}")
        axes.plot([], [], "-", color=style.TEXT, linewidth=0.9, label="exact")
        _mark_unresolved(axes, channel, times)
        _label_axes(axes, channel, float(np.max(np.abs(times))))
        legend = figure.legend(loc="center right", frameon=False, fontsize=10)
        make_room(figure, np.array([[axes]]), legend, below=False)
        style.save(figure, path)


def _mark_unresolved(axes, channel, times: np.ndarray) -> None:
    """Shade the times up to the last at which the flow has a layer that is too thin for the particles."""
    early = [t for t in times if not resolution(channel, t)[0]]
    if early and early[-1] > times[0]:
        axes.axvspan(times[0], early[-1], color=style.MUTED, alpha=0.2, linewidth=0, label="not resolved")


def _periods(channel, duration: float) -> float:
    """Return how many periods of the faster wall ``duration`` has; 0 where none oscillates."""
    return max(wall.angular_frequency for wall in (channel.bottom, channel.top)) * duration / (2.0 * np.pi)


def _curve_times(first: float, last: float, periods: float) -> np.ndarray:
    """Return times for the exact curve: more early on, where a start changes fastest, and enough in every period."""
    early = first + (last - first) * np.linspace(0.0, 1.0, _CURVE_POINTS) ** 2
    even = np.linspace(first, last, min(round(_CURVE_POINTS_A_PERIOD * periods), _MOST_CURVE_POINTS))
    return np.union1d(early, even)


def _label_axes(axes, channel, latest: float) -> None:
    time_exponent, speed_exponent = axis_exponent(latest), axis_exponent(channel.reference_velocity)
    axes.set_xlabel(axis_label("t", channel.units.time, time_exponent), parse_math=False)
    axes.set_ylabel(axis_label("u", velocity_unit(channel.units), speed_exponent), parse_math=False)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value, time_exponent)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value, speed_exponent)))
    axes.grid(True)
    axes.margins(x=0.02)
