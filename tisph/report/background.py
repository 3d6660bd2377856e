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
from tisph.report.quantities import Quantity

_PIXELS_PER_INCH = 72  # then matplotlib's points are pixels, and every size below is in pixels


def draw_background(scene, layout: Layout, quantity: Quantity, title: str) -> np.ndarray:
    """Return the frame without particles and without labels on walls, uint8 of shape (height, width, 4).

    ``quantity`` is what colours the particles and fills the profile panel.
    """
    with style.plot_style():
        figure = build_figure(scene, layout, quantity, title)
        figure.canvas.draw()
        return np.asarray(figure.canvas.buffer_rgba()).copy()


def build_figure(scene, layout: Layout, quantity: Quantity, title: str) -> Figure:
    """Return the background as a matplotlib figure, not drawn yet; arguments as for ``draw_background``."""
    figure = Figure((layout.width / _PIXELS_PER_INCH, layout.height / _PIXELS_PER_INCH), dpi=_PIXELS_PER_INCH)
    FigureCanvasAgg(figure)
    stage = _Stage(figure, scene, layout)
    stage.box_axes()
    stage.walls()
    stage.colour_bar(quantity)
    stage.profile_axes(quantity)
    stage.legend(quantity)
    stage.titles(title)
    return figure


class _Stage:
    """The figure being drawn; ``overlay`` covers it all, in pixels from the top-left corner."""

    def __init__(self, figure: Figure, scene, layout: Layout):
        self.figure, self.scene, self.layout = figure, scene, layout
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
                axes.spines[side].set(linestyle=(0, (4, 3)), color=style.MUTED)
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
                self._bar(bar, facecolor=style.WALL_MOVING, linewidth=0)
            else:
                self._bar(bar, facecolor=style.WALL_RESTING, edgecolor=style.MUTED, hatch="///", linewidth=0)

    def colour_bar(self, quantity: Quantity) -> None:
        """Horizontal bar over the range of colours, with its unit."""
        exponent = axis_exponent(quantity.colour_range[1])
        axes = self._axes(self.layout.colour_bar, quantity.colour_range, (0.0, 1.0))
        colours = style.colours(256, colour_map=quantity.colour_map)[None, :, :]
        axes.imshow(colours, extent=(*quantity.colour_range, 0.0, 1.0), aspect="auto", interpolation="nearest")
        self._ticks(axes, self.layout.colour_bar, exponent, None)
        self._label(axes, axis_label(quantity.colour_name, quantity.unit, exponent), None)

    def profile_axes(self, quantity: Quantity) -> None:
        """Axes of the live profile: the quantity along, the coordinate of its line upwards."""
        exponent, profile = axis_exponent(quantity.colour_range[1]), quantity.profile
        axes = self._axes(self.layout.profile, quantity.profile_range, profile.line.ends)
        axes.grid(True, linewidth=self.layout.pixels(1))
        self._ticks(axes, self.layout.profile, exponent, self.length_exponent)
        self._label(
            axes,
            axis_label(profile.name, quantity.unit, exponent),
            axis_label(profile.line.along, self.scene.units.length, self.length_exponent),
        )

    def legend(self, quantity: Quantity) -> None:
        """Key to the profile, above it: data can be anywhere inside."""
        px, label = self.layout.pixels, self.layout.error_label
        left, row = self.layout.profile.left, label.top + label.height / 2
        self.overlay.plot([left + px(6)], [row], "o", color=style.PARTICLES, markersize=px(6))
        particles = self._text(left + px(15), row, "particles", size=14, va="center")
        if quantity.profile.exact is None:
            return
        start = self._right_end(particles) + px(16)
        self.overlay.plot([start, start + px(20)], [row, row], "-", color=style.EXACT, linewidth=px(2))
        self._text(start + px(26), row, quantity.profile.reference, size=14, va="center")

    def titles(self, title: str) -> None:
        """Name of the run at the left, what it is at the right."""
        px, layout = self.layout.pixels, self.layout
        facts = "     ".join(self._facts())
        right = self._text(layout.width - px(26), px(36), facts, size=14, ha="right", color=style.MUTED)
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
        axes = self.figure.add_axes(place, xlim=x_range, ylim=y_range, facecolor="white")
        for spine in axes.spines.values():
            spine.set_linewidth(self.layout.pixels(1))
        return axes

    def _ticks(self, axes: Axes, rect: Rect, x_exponent: int, y_exponent: int | None) -> None:
        """Ticks no closer than their labels are long; with ``y_exponent`` None the y axis has none."""
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

    def _label(self, axes: Axes, x_text: str, y_text: str | None) -> None:
        """Name the axes; a name along x that is longer than its axis and two margins is written smaller."""
        size, pad = self.layout.pixels(14), self.layout.pixels(4)
        label = axes.set_xlabel(x_text, fontsize=size, labelpad=pad, parse_math=False)
        room = axes.get_window_extent().width + self.layout.pixels(40)
        while label.get_window_extent().width > room:
            label.set_fontsize(0.95 * label.get_fontsize())
        if y_text is not None:
            axes.set_ylabel(y_text, fontsize=size, labelpad=pad, parse_math=False)

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
