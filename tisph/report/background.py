"""What does not change from frame to frame, drawn once by matplotlib into an RGB array."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from tisph.report import style
from tisph.report.labels import TIMES, axis_exponent, axis_label, number, unit_label
from tisph.report.layout import Layout, Rect
from tisph.report.panels import TimePanel
from tisph.report.quantities import Quantity

_PIXELS_PER_INCH = 72  # then matplotlib's points are pixels, and every size below is in pixels


def draw_background(scene, layout: Layout, title: str, *contents) -> np.ndarray:
    """Return the frame without the fluid and without labels on walls, uint8 of shape (height, width, 4).

    ``contents``: arguments of ``build_figure`` after those.
    """
    with style.plot_style(layout.theme):
        figure = build_figure(scene, layout, title, *contents)
        figure.canvas.draw()
        return np.asarray(figure.canvas.buffer_rgba()).copy()


def build_figure(scene, layout: Layout, title: str, quantity: Quantity, time_panel: TimePanel) -> Figure:
    """Return the background as a matplotlib figure, not drawn yet.

    ``quantity`` is what colours the fluid and fills the profile panel.
    """
    figure = Figure((layout.width / _PIXELS_PER_INCH, layout.height / _PIXELS_PER_INCH), dpi=_PIXELS_PER_INCH)
    FigureCanvasAgg(figure)
    stage = _Stage(figure, scene, layout)
    stage.box_axes()
    stage.walls()
    if quantity.colour_name:
        stage.colour_bar(quantity)
    stage.profile_axes(quantity)
    stage.series_axes(time_panel)
    stage.legend(quantity)
    stage.series_legend(time_panel)
    stage.titles(title)
    return figure


class _Stage:
    """The figure being drawn; ``overlay`` covers it all, in pixels from the top-left corner."""

    def __init__(self, figure: Figure, scene, layout: Layout):
        self.figure, self.scene, self.layout, self.theme = figure, scene, layout, layout.theme
        self.overlay = figure.add_axes((0, 0, 1, 1), xlim=(0, layout.width), ylim=(layout.height, 0))
        self.overlay.set_axis_off()
        self.length_exponent = axis_exponent(float(np.abs((layout.low, layout.high)).max()))

    def box_axes(self) -> None:
        """Axes of the box: x below it, y at the left."""
        layout, unit = self.layout, self.scene.units.length
        width = self.scene.extent[0]
        axes = self._axes(layout.box, *zip(layout.low, layout.high, strict=True))
        beside = layout.pixels(1)  # the discs, not below them
        for sides, periodic, walls in zip(
            (("left", "right"), ("top", "bottom")), self.scene.periodic, (0, layout.wall_thickness), strict=True
        ):
            for side in sides:
                axes.spines[side].set_visible(periodic)
                axes.spines[side].set(linestyle=(0, (4, 3)), color=self.theme.muted)
                axes.spines[side].set_position(("outward", beside if periodic else walls))
        self._ticks(axes, layout.box, self.length_exponent, self.length_exponent)
        label = axis_label("x", unit, self.length_exponent)
        if layout.shown_length < width:
            label += f"     (shown: {number(layout.shown_length, 3)} of {number(width, 3)} {unit})"
        self._label(axes, label, axis_label("y", unit, self.length_exponent))

    def walls(self) -> None:
        """Bars beside the box: hatched at rest, dark where they move."""
        for side, motion in self.scene.walls:
            bar = self.layout.wall(side)
            if motion.cosine or motion.sine:
                self._bar(bar, facecolor=self.theme.wall_moving, linewidth=0)
            else:
                self._bar(bar, facecolor=self.theme.wall_resting, edgecolor=self.theme.muted, hatch="///", linewidth=0)

    def colour_bar(self, quantity: Quantity) -> None:
        """Vertical bar over the range of colours, with its unit."""
        low, high = quantity.colour_range
        exponent = axis_exponent(max(abs(low), abs(high)))
        axes = self._axes(self.layout.colour_bar, (0.0, 1.0), (low, high))
        colours = style.colours(256, colour_map=quantity.colour_map)[::-1, None, :]
        axes.imshow(colours, extent=(0.0, 1.0, low, high), aspect="auto", interpolation="nearest")
        axes.yaxis.tick_right()
        axes.yaxis.set_label_position("right")
        self._ticks(axes, self.layout.colour_bar, None, exponent)
        self._label(axes, None, axis_label(quantity.colour_name, quantity.unit, exponent))

    def profile_axes(self, quantity: Quantity) -> None:
        """Axes of the live profile: the quantity along, the coordinate of its line upwards."""
        profile, (low, high) = quantity.profile, quantity.profile_range
        exponent = axis_exponent(max(abs(low), abs(high)))
        axes = self._axes(self.layout.profile, quantity.profile_range, profile.line.ends)
        axes.grid(True, linewidth=self.layout.pixels(1))
        self._ticks(axes, self.layout.profile, exponent, self.length_exponent)
        unit = self.scene.units.length
        place = "" if profile.line.half_width == np.inf else f" at {self._place(profile.line)} {unit}"
        self._label(
            axes,
            axis_label(profile.name + place, quantity.unit, exponent),
            axis_label(profile.line.along, unit, self.length_exponent),
        )

    def _place(self, line) -> str:
        return f"{'x' if line.along == 'y' else 'y'} = {number(line.place, 3)}"

    def series_axes(self, panel: TimePanel) -> None:
        """Axes of the numbers over time, with their exact values."""
        rect, series = self.layout.series, panel.series
        exponents = [axis_exponent(max(map(abs, ends))) for ends in (panel.times, panel.range)]
        axes = self._axes(rect, panel.times, panel.range)
        axes.grid(True, linewidth=self.layout.pixels(1))
        if panel.exact is not None:
            axes.plot(panel.exact_times, panel.exact, "-", color=self.theme.exact, linewidth=self.layout.pixels(1))
        for level in panel.levels:
            axes.axhline(level, color=self.theme.exact, linewidth=self.layout.pixels(1))
        self._ticks(axes, rect, *exponents)
        units = self.scene.units.time, unit_label(series.unit, self.scene.units)
        self._label(axes, axis_label("t", units[0], exponents[0]), axis_label(series.name, units[1], exponents[1]))

    def series_legend(self, panel: TimePanel) -> None:
        """Names of the numbers in their colours, above their panel."""
        px, rect = self.layout.pixels, self.layout.series
        left, row = rect.left, rect.top - px(14)
        for name, colour in zip(panel.labels, panel.colours, strict=True):
            left = px(16) + self._right_end(self._text(left, row, name, size=14, va="center", color=colour))
        if np.isfinite(panel.levels).any():
            self._key_line(left, row, panel.series.level_name)

    def legend(self, quantity: Quantity) -> None:
        """Key to the profile, above it: data can be anywhere inside."""
        px, label = self.layout.pixels, self.layout.error_label
        left, row = self.layout.profile.left, label.top + label.height / 2
        self.overlay.plot([left + px(6)], [row], "o", color=self.theme.particles, markersize=px(6))
        particles = self._text(left + px(15), row, "tisph", size=14, va="center")
        if quantity.profile.exact is None:
            return
        self._key_line(self._right_end(particles) + px(16), row, quantity.profile.reference)

    def _key_line(self, start: float, row: float, name: str) -> None:
        """Key to the thin line of what is known, from ``start`` on."""
        px = self.layout.pixels
        self.overlay.plot([start, start + px(20)], [row, row], "-", color=self.theme.exact, linewidth=px(2))
        self._text(start + px(26), row, name, size=14, va="center")

    def titles(self, title: str) -> None:
        """Name of the run at the left, what it is at the right."""
        px, layout = self.layout.pixels, self.layout
        facts = "     ".join(self._facts())
        right = self._text(layout.width - px(26), px(36), facts, size=14, ha="right", color=self.theme.muted)
        name = self._text(px(24), px(36), title, size=20, weight="bold")
        limit = right.get_window_extent().x0 - px(30)
        while self._right_end(name) > limit and len(title) > 1:
            title = title[:-1]
            name.set_text(title + "…")

    def _facts(self) -> list[str]:
        scene = self.scene
        facts = [f"Re = {number(scene.reynolds)}", _count(scene)]
        if scene.polymer:
            facts.insert(1, f"Wi = {number(scene.weissenberg)}")
        if scene.vanishing_scale:  # then errors are given as multiples of it
            facts.insert(0, f"U = {number(scene.reference_velocity)} {unit_label('velocity', scene.units)}")
        return facts

    def _axes(self, rect: Rect, x_range: tuple[float, float], y_range: tuple[float, float]) -> Axes:
        width, height = self.layout.width, self.layout.height
        place = (rect.left / width, 1.0 - rect.bottom / height, rect.width / width, rect.height / height)
        axes = self.figure.add_axes(place, xlim=x_range, ylim=y_range)
        for spine in axes.spines.values():
            spine.set_linewidth(self.layout.pixels(1))
        return axes

    def _ticks(self, axes: Axes, rect: Rect, x_exponent: int | None, y_exponent: int | None) -> None:
        """Ticks no closer than their labels are long; an axis whose exponent is None has none."""
        px = self.layout.pixels
        axes.tick_params(labelsize=px(13), length=px(4), width=px(1), pad=px(3))
        for axis, count, exponent in (
            (axes.xaxis, rect.width // px(58), x_exponent),
            (axes.yaxis, rect.height // px(36), y_exponent),
        ):
            if exponent is None:
                axis.set_ticks([])
                continue
            axis.set_major_locator(MaxNLocator(nbins=int(np.clip(count, 1, 7)), steps=[1, 2, 2.5, 5, 10]))
            style.format_ticks(axis, exponent)

    def _label(self, axes: Axes, x_text: str | None, y_text: str | None) -> None:
        """Name the axes; a name that is longer than its axis, and two margins at the side, is written smaller."""
        size, pad, box = self.layout.pixels(14), self.layout.pixels(4), axes.get_window_extent()
        for text, write, side, room in (
            (x_text, axes.set_xlabel, "width", box.width + self.layout.pixels(40)),
            (y_text, axes.set_ylabel, "height", box.height),
        ):
            if text is not None:
                label = write(text, fontsize=size, labelpad=pad, parse_math=False)
                while getattr(label.get_window_extent(), side) > room:
                    label.set_fontsize(0.95 * label.get_fontsize())

    def _text(self, x: float, y: float, text: str, *, size: int, **settings) -> Text:
        return self.overlay.text(x, y, text, fontsize=self.layout.pixels(size), parse_math=False, **settings)

    def _right_end(self, text: Text) -> float:
        return text.get_window_extent().x1

    def _bar(self, bar: Rect, **settings) -> None:
        self.overlay.add_patch(Rectangle((bar.left, bar.top), bar.width, bar.height, **settings))


def _count(scene):
    """Return how many particles there are, in words."""
    lattice = f"{scene.columns} {TIMES} {scene.rows}" if not scene.bodies else str(scene.particles)
    return f"{lattice} particles"
