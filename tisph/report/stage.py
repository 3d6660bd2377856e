"""What does not change from frame to frame, drawn once by matplotlib into an RGB array."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrow, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tisph.report import style
from tisph.report.labels import TIMES, axis_exponent, axis_label, number, tick_text, velocity_unit
from tisph.report.layout import Layout, Rect

_PIXELS_PER_INCH = 72  # then matplotlib's points are pixels, and every size below is in pixels


def draw_background(channel, layout: Layout, velocity_range: tuple[float, float], title: str) -> np.ndarray:
    """Return the frame without particles, uint8 of shape (height, width, 3).

    ``velocity_range`` (lowest, highest) is the velocity axis of the profile panel.
    """
    with style.plot_style():
        figure = build_figure(channel, layout, velocity_range, title)
        figure.canvas.draw()
        return np.ascontiguousarray(np.asarray(figure.canvas.buffer_rgba())[:, :, :3])


def build_figure(channel, layout: Layout, velocity_range: tuple[float, float], title: str) -> Figure:
    """Return the background as a matplotlib figure, not drawn yet; arguments as for ``draw_background``."""
    figure = Figure((layout.width / _PIXELS_PER_INCH, layout.height / _PIXELS_PER_INCH), dpi=_PIXELS_PER_INCH)
    FigureCanvasAgg(figure)
    stage = _Stage(figure, channel, layout)
    stage.channel_axes()
    stage.walls()
    stage.colour_bar()
    stage.profile_axes(velocity_range)
    stage.legend()
    stage.titles(title)
    return figure


class _Stage:
    """The figure being drawn; ``overlay`` covers it all, in pixels from the top-left corner."""

    def __init__(self, figure: Figure, channel, layout: Layout):
        self.figure, self.channel, self.layout = figure, channel, layout
        self.overlay = figure.add_axes((0, 0, 1, 1), xlim=(0, layout.width), ylim=(layout.height, 0))
        self.overlay.set_axis_off()
        self.length_exponent = axis_exponent(max(layout.shown_length, channel.gap))
        self.speed_exponent = axis_exponent(channel.reference_velocity)

    def channel_axes(self) -> None:
        """Axes of the channel: x below the lower wall, y at the left."""
        layout, unit = self.layout, self.channel.units.length
        axes = self._axes(layout.channel, (0.0, layout.shown_length), (0.0, self.channel.gap))
        for name in ("top", "bottom"):
            axes.spines[name].set_visible(False)
        for name in ("left", "right"):
            axes.spines[name].set(linestyle=(0, (4, 3)), color=style.MUTED)
            axes.spines[name].set_position(("outward", layout.pixels(1)))  # beside the discs, not below them
        axes.spines["bottom"].set_position(("outward", layout.wall_thickness))
        self._ticks(axes, layout.channel, self.length_exponent, self.length_exponent)
        label = axis_label("x", unit, self.length_exponent)
        if layout.shown_length < self.channel.length:
            shown, whole = number(layout.shown_length, 3), number(self.channel.length, 3)
            label += f"     (shown: {shown} of {whole} {unit})"
        self._label(axes, label, axis_label("y", unit, self.length_exponent))

    def walls(self) -> None:
        """Bars above and below the channel: hatched at rest, dark with arrows when moving."""
        channel, thickness = self.layout.channel, self.layout.wall_thickness
        for velocity, top in (
            (self.channel.top_velocity, channel.top - thickness),
            (self.channel.bottom_velocity, channel.bottom),
        ):
            bar = Rect(channel.left, top, channel.width, thickness)
            if velocity == 0.0:
                self._bar(bar, facecolor=style.WALL_RESTING, edgecolor=style.MUTED, hatch="///", linewidth=0)
            else:
                self._bar(bar, facecolor=style.WALL_MOVING, linewidth=0)
                self._wall_velocity(bar, velocity)

    def colour_bar(self) -> None:
        """Horizontal bar from 0 to the reference velocity, with its unit."""
        fastest = self.channel.reference_velocity
        axes = self._axes(self.layout.colour_bar, (0.0, fastest), (0.0, 1.0))
        colours = style.colours(256)[None, :, :]
        axes.imshow(colours, extent=(0.0, fastest, 0.0, 1.0), aspect="auto", interpolation="nearest")
        self._ticks(axes, self.layout.colour_bar, self.speed_exponent, None)
        self._label(axes, axis_label("speed", velocity_unit(self.channel.units), self.speed_exponent), None)

    def profile_axes(self, velocity_range: tuple[float, float]) -> None:
        """Axes of the live profile: velocity along, height across, as in the channel beside it."""
        axes = self._axes(self.layout.profile, velocity_range, (0.0, self.channel.gap))
        axes.grid(True, linewidth=self.layout.pixels(1))
        self._ticks(axes, self.layout.profile, self.speed_exponent, self.length_exponent)
        units = self.channel.units
        self._label(
            axes,
            axis_label("u", velocity_unit(units), self.speed_exponent),
            axis_label("y", units.length, self.length_exponent),
        )

    def legend(self) -> None:
        """Key to the profile, above it: data can be anywhere inside."""
        px, label = self.layout.pixels, self.layout.error_label
        left, row = self.layout.profile.left, label.top + label.height / 2
        self.overlay.plot([left + px(6)], [row], "o", color=style.PARTICLES, markersize=px(6))
        particles = self._text(left + px(15), row, "particles", size=14, va="center")
        start = self._right_end(particles) + px(16)
        self.overlay.plot([start, start + px(20)], [row, row], "-", color=style.EXACT, linewidth=px(2))
        self._text(start + px(26), row, "exact", size=14, va="center")

    def titles(self, title: str) -> None:
        """Name of the run at the left, what it is at the right."""
        px, layout, channel = self.layout.pixels, self.layout, self.channel
        facts = f"Re = {number(channel.reynolds)}     {channel.columns} {TIMES} {channel.rows} particles"
        right = self._text(layout.width - px(26), px(36), facts, size=14, ha="right", color=style.MUTED)
        name = self._text(px(24), px(36), title, size=20, weight="bold")
        limit = right.get_window_extent().x0 - px(30)
        while self._right_end(name) > limit and len(title) > 1:
            title = title[:-1]
            name.set_text(title + "…")

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
            axis.set_major_formatter(FuncFormatter(lambda value, _, e=exponent: tick_text(value, e)))

    def _label(self, axes: Axes, x_text: str, y_text: str | None) -> None:
        size, pad = self.layout.pixels(14), self.layout.pixels(4)
        axes.set_xlabel(x_text, fontsize=size, labelpad=pad, parse_math=False)
        if y_text is not None:
            axes.set_ylabel(y_text, fontsize=size, labelpad=pad, parse_math=False)

    def _text(self, x: float, y: float, text: str, *, size: int, **settings) -> Text:
        return self.overlay.text(x, y, text, fontsize=self.layout.pixels(size), parse_math=False, **settings)

    def _right_end(self, text: Text) -> float:
        return text.get_window_extent().x1

    def _bar(self, bar: Rect, **settings) -> None:
        self.overlay.add_patch(Rectangle((bar.left, bar.top), bar.width, bar.height, **settings))

    def _wall_velocity(self, bar: Rect, velocity: float) -> None:
        """Write the velocity in the middle of a wall, with arrows at both sides; beside it if it is short."""
        px = self.layout.pixels
        middle, row = bar.left + bar.width / 2, bar.top + bar.height / 2
        words = f"{number(velocity)} {velocity_unit(self.channel.units)}"
        text = self._text(middle, row, words, size=14, color="white", ha="center", va="center_baseline")
        half_text = text.get_window_extent().width / 2 + px(14)
        arrow, pitch = px(34), px(120)
        room = bar.width / 2 - half_text - px(8)
        if room < arrow:
            text.set(x=bar.right + px(8), ha="left", color=style.TEXT)
            space = 0.62 * self.layout.width - bar.right - px(16)
            text.set_fontsize(text.get_fontsize() * min(1.0, space / text.get_window_extent().width))
            self._arrow(middle, row, velocity, arrow)
            return
        for number_out in range(1 + int((room - arrow) // pitch)):
            offset = half_text + arrow / 2 + number_out * pitch
            self._arrow(middle + offset, row, velocity, arrow)
            self._arrow(middle - offset, row, velocity, arrow)

    def _arrow(self, middle: float, row: float, velocity: float, length: int) -> None:
        px, along = self.layout.pixels, float(np.copysign(length, velocity))
        head = px(11)
        self.overlay.add_patch(
            FancyArrow(
                middle - along / 2, row, along, 0.0, width=px(3), head_width=head, head_length=head,
                length_includes_head=True, color="white", linewidth=0,
            )
        )  # fmt: skip
