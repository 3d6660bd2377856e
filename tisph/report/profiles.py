"""Velocity profiles at the samples: particles against the exact curve, and the error beside them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from tisph.report import style
from tisph.report.error_label import error_label
from tisph.report.labels import MINUS, axis_exponent, axis_label, number, tick_text, velocity_unit
from tisph.snapshot import Snapshot

_DOTS = 400  # particles drawn a sample: more only hide each other
_CURVE_POINTS = 400
_LEGEND_ENTRIES = 12


def plot_profiles(path: Path | str, channel, snapshots: Sequence[Snapshot]) -> None:
    """Write a PNG of u(y) at every snapshot with the exact curves, and of (u - u_exact) / reference velocity.

    ``channel`` is the scene, which knows exact solution and units. Of more than twelve snapshots the legend
    names twelve, evenly chosen.
    """
    with style.plot_style():
        figure = style.plot_figure()
        velocity_axes, error_axes = figure.subplots(1, 2, sharey=True)
        named = style.evenly_chosen(len(snapshots), _LEGEND_ENTRIES)
        colours = style.colours(len(snapshots), 0.85)
        for index, snapshot in enumerate(snapshots):
            dots = _plot_sample(velocity_axes, error_axes, channel, snapshot, colours[index])
            if index in named:
                dots.set_label(_sample_label(channel, snapshot))
        _label_axes(velocity_axes, error_axes, channel)
        velocity_axes.plot([], [], "-", color=style.TEXT, linewidth=0.9, label="exact")
        figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=10)
        figure.savefig(path, format="png")


def _plot_sample(velocity_axes: Axes, error_axes: Axes, channel, snapshot: Snapshot, colour):
    """Draw one sample into both axes; return its dots for the legend."""
    order = np.argsort(snapshot.y, kind="stable")
    chosen = order[style.evenly_chosen(len(order), _DOTS)]
    y, u = snapshot.y[chosen], snapshot.u[chosen]
    heights = np.linspace(0.0, channel.gap, _CURVE_POINTS)
    exact = channel.exact_velocity(heights, snapshot.t)
    dots = velocity_axes.plot(u, y, "o", color=colour, markersize=5, markeredgewidth=0.0)[0]
    velocity_axes.plot(exact, heights, "-", color=style.TEXT, linewidth=0.9)
    error = (u - channel.exact_velocity(y, snapshot.t)) / channel.reference_velocity
    error_axes.plot(error, y, "o", color=colour, markersize=3, alpha=0.7, markeredgewidth=0.0)
    return dots


def _sample_label(channel, snapshot: Snapshot) -> str:
    t_star = number(snapshot.t / channel.viscous_time, 3)
    return f"t = {number(snapshot.t)} {channel.units.time},  t* = {t_star},  {error_label(channel, snapshot)}"


def _label_axes(velocity_axes: Axes, error_axes: Axes, channel) -> None:
    speed_exponent, length_exponent = axis_exponent(channel.reference_velocity), axis_exponent(channel.gap)
    velocity_axes.set_xlabel(axis_label("u", velocity_unit(channel.units), speed_exponent), parse_math=False)
    velocity_axes.set_ylabel(axis_label("y", channel.units.length, length_exponent), parse_math=False)
    velocity_axes.set_ylim(0.0, channel.gap)
    error_exponent = axis_exponent(float(np.max(np.abs(error_axes.dataLim.intervalx))))
    error_axes.set_xlabel(axis_label(f"(u {MINUS} u exact) / reference velocity", "", error_exponent))
    error_axes.axvline(0.0, color=style.MUTED, linewidth=0.8)
    for axis, exponent in (
        (velocity_axes.xaxis, speed_exponent),
        (velocity_axes.yaxis, length_exponent),
        (error_axes.xaxis, error_exponent),
    ):
        axis.set_major_formatter(FuncFormatter(lambda value, _, e=exponent: tick_text(value, e)))
    for axes in (velocity_axes, error_axes):
        axes.grid(True)
        axes.locator_params(axis="x", nbins=7)
