"""Profiles at the samples: particles against exact curves, of the velocity, its error and the polymer's stresses."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from tisph.report import style
from tisph.report.error_label import velocity_error_label
from tisph.report.labels import MINUS, axis_exponent, axis_label, number, stress_unit, tick_text, velocity_unit
from tisph.report.room import make_room
from tisph.snapshot import Snapshot

_DOTS = 400  # particles drawn a sample: more only hide each other
_CURVE_POINTS = 400
_LEGEND_ENTRIES = 12
_MARKERS = "osD^v"
_SMALLEST, _LARGEST = 3.5, 8.0  # markers: later samples have smaller ones, so that both show where curves coincide


def plot_profiles(path: Path | str, channel, snapshots: Sequence[Snapshot]) -> None:
    """Write a PNG of u(y) at every snapshot with the exact curves, and of (u - u_exact) / reference velocity.

    With polymer also of its shear stress S_xy and first normal stress difference N1 = S_xx - S_yy. ``channel`` is
    the scene, which knows exact solution and units. Of more than twelve snapshots the legend names twelve, evenly
    chosen.
    """
    with style.plot_style():
        figure = style.plot_figure(rows=2 if channel.polymer else 1)
        grid = figure.subplots(2 if channel.polymer else 1, 2, sharey=True, squeeze=False)
        axes = grid.ravel()
        named = style.evenly_chosen(len(snapshots), _LEGEND_ENTRIES)
        error_label = velocity_error_label(channel)
        looks = _looks(len(snapshots))
        for index, snapshot in enumerate(snapshots):
            dots = _plot_velocity(axes[:2], channel, snapshot, looks[index])
            if channel.polymer:
                _plot_stresses(axes[2:], channel, snapshot, looks[index])
            if index in named:
                t_star = number(snapshot.t / channel.viscous_time, 3)
                time = f"t = {number(snapshot.t)} {channel.units.time},  t* = {t_star}"
                dots.set_label(f"{time},  {error_label(snapshot)}")
        _label_axes(axes, channel)
        axes[0].plot([], [], "-", color=style.TEXT, linewidth=0.9, label="exact")
        legend = figure.legend(loc="lower center", ncols=3, frameon=False, fontsize=10)
        make_room(figure, grid, legend, below=True)
        style.save(figure, path)


def _looks(count: int) -> list[dict]:
    """Return colour, shape and size of every sample's markers."""
    sizes = np.linspace(min(_LARGEST, _SMALLEST + 1.5 * count - 0.5), _SMALLEST, count)
    return [
        {"color": colour, "marker": _MARKERS[index % len(_MARKERS)], "markersize": size, "markeredgewidth": 0.0}
        for index, (colour, size) in enumerate(zip(style.colours(count, 0.85), sizes, strict=True))
    ]


def _plot_velocity(axes: Sequence[Axes], channel, snapshot: Snapshot, look: dict) -> Line2D:
    """Draw velocity and error of one sample; return the dots of the velocity for the legend."""
    chosen = _chosen(snapshot)
    y, u = snapshot.y[chosen], snapshot.u[chosen]
    heights = np.linspace(0.0, channel.gap, _CURVE_POINTS)
    dots = _plot_dots_and_curve(axes[0], (u, y), (channel.exact_velocity(heights, snapshot.t), heights), look)
    error = (u - channel.exact_velocity(y, snapshot.t)) / channel.reference_velocity
    axes[1].plot(error, y, linestyle="", alpha=0.8, **{**look, "markersize": 0.7 * look["markersize"]})
    return dots


def _plot_stresses(axes: Sequence[Axes], channel, snapshot: Snapshot, look: dict) -> None:
    """Draw shear stress and first normal stress difference of one sample."""
    chosen = _chosen(snapshot)
    y = snapshot.y[chosen]
    heights = np.linspace(0.0, channel.gap, _CURVE_POINTS)
    normal_exact, shear_exact = channel.exact_polymer_stress(heights, snapshot.t)
    normal = snapshot.stress_xx[chosen] - snapshot.stress_yy[chosen]
    _plot_dots_and_curve(axes[0], (snapshot.stress_xy[chosen], y), (shear_exact, heights), look)
    _plot_dots_and_curve(axes[1], (normal, y), (normal_exact, heights), look)


def _chosen(snapshot: Snapshot) -> np.ndarray:
    """Return the indices of the particles to draw, from bottom to top."""
    order = np.argsort(snapshot.y, kind="stable")
    return order[style.evenly_chosen(len(order), _DOTS)]


def _plot_dots_and_curve(axes: Axes, dots: tuple, curve: tuple, look: dict) -> Line2D:
    """Draw (values, heights) of particles and of the exact curve; return the particles' dots."""
    drawn = axes.plot(*dots, linestyle="", **look)[0]
    axes.plot(*curve, "-", color=style.TEXT, linewidth=0.9)
    return drawn


def _label_axes(axes: Sequence[Axes], channel) -> None:
    speed, stress = velocity_unit(channel.units), stress_unit(channel.units)
    names = [("u", speed), (f"(u {MINUS} u exact) / reference velocity U", "")]
    names += [("polymer shear stress Sxy", stress), (f"first normal stress difference N1 = Sxx {MINUS} Syy", stress)]
    for panel, (name, unit) in zip(axes, names, strict=False):
        exponent = axis_exponent(float(np.max(np.abs(panel.dataLim.intervalx))))
        panel.set_xlabel(axis_label(name, unit, exponent), parse_math=False)
        _format(panel.xaxis, exponent)
        panel.grid(True)
        panel.locator_params(axis="x", nbins=7)
    length_exponent = axis_exponent(channel.gap)
    for panel in axes[::2]:
        panel.set_ylabel(axis_label("y", channel.units.length, length_exponent), parse_math=False)
        _format(panel.yaxis, length_exponent)
    axes[0].set_ylim(0.0, channel.gap)
    axes[1].axvline(0.0, color=style.MUTED, linewidth=0.8)


def _format(axis, exponent: int) -> None:
    axis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value, exponent)))
