"""The MP4 of a run, and single frames of it as PNG.

A frame shows one snapshot: the fluid, a live profile, numbers over time and labels over a background that stays.
Axisymmetric flow is drawn in the whole plane through the axis: the half-plane and its mirror image. Around an inner
cylinder it is drawn in the half-plane.
"""

import contextlib
import pickle
import tempfile
from dataclasses import dataclass, fields, replace
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from PIL import Image

from tisph.errors import TisphError
from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.outline import SmoothOutline
from tisph.geometry.polygon import Polygon
from tisph.report import style
from tisph.report.encoder import Encoder
from tisph.report.field import Dye, FluidPainter
from tisph.report.labels import (
    TIMES,
    axis_exponent,
    axis_label,
    coordinate_name,
    cut_name,
    error_label,
    number,
    time_label,
    unit_label,
)
from tisph.report.layout import Layout, Rect, arrange
from tisph.report.overlays import (
    INK,
    LIGHT,
    BodyTracks,
    Solids,
    StreamFunction,
    Streamlines,
    Tracks,
    Turning,
    Vectors,
    paint_marks,
)
from tisph.report.panels import NUMBERS, ProfilePanel, TimePanel, exact_values, measured
from tisph.report.quantities import Ends, Extremes, Quantity, Spread, quantity
from tisph.report.text import SCALE_ROOM, SCALE_TICKS, DriveLabel, ScaleLabel, paint_text, wall_labels
from tisph.scenes._scene import Scene
from tisph.scenes._views import SHOWN, MovieView
from tisph.snapshot import Snapshot

_SMALLEST_TITLE = 15  # pixels in a frame of 1280 x 640
_PIXELS_PER_INCH = 72  # then matplotlib's points are pixels, and every size below is in pixels


def build_figure(
    scene: Scene, layout: Layout, title: str, quantity: Quantity, time_panel: TimePanel, lines: str = ""
) -> Figure:
    """Return the background as a matplotlib figure, not drawn yet.

    ``quantity`` is the quantity of the colours and of the profile panel, ``lines`` the name of the lines in the fluid.
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
    stage.lines_legend(lines)
    stage.titles(title)
    return figure


class _Stage:
    """The figure being drawn; ``overlay`` covers it all, in pixels from the top-left corner."""

    def __init__(self, figure: Figure, scene: Scene, layout: Layout):
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
        names = [coordinate_name(self.scene, axis) for axis in "xy"]
        label = axis_label(names[0], unit, self.length_exponent)
        if layout.shown_length < width:
            label += f"     (shown: {number(layout.shown_length, 3)} of {number(width, 3)} {unit})"
        self._label(axes, label, axis_label(names[1], unit, self.length_exponent))

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
        dyed = quantity.colour_map is style.DYE_MAP
        name = axis_label(quantity.colour_name, "" if dyed else quantity.unit, 0 if quantity.of_frame else exponent)
        if quantity.of_frame:  # the numbers are those of each frame
            axes.set_xticks([])
            axes.set_yticks(low + (high - low) * SCALE_TICKS, [SCALE_ROOM] * len(SCALE_TICKS))
            axes.tick_params(labelsize=self.layout.pixels(13), length=self.layout.pixels(4), labelcolor="none")
            name = f"{name}, scale of this moment"
        else:
            self._ticks(axes, self.layout.colour_bar, None, None if dyed else exponent)
        self._label(axes, None, name)

    def profile_axes(self, quantity: Quantity) -> None:
        """Axes of the live profile: the quantity along, the coordinate of its line upwards."""
        profile, (low, high) = quantity.profile, quantity.profile_range
        exponent = axis_exponent(max(abs(low), abs(high)))
        axes = self._axes(self.layout.profile, quantity.profile_range, profile.line.ends)
        axes.grid(True, linewidth=self.layout.pixels(1))
        self._ticks(axes, self.layout.profile, exponent, self.length_exponent)
        along = coordinate_name(self.scene, profile.line.along)
        self._label(
            axes,
            axis_label(cut_name(profile, self.scene), quantity.unit, exponent),
            axis_label(along, self.scene.units.length, self.length_exponent),
        )

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
        for level in panel.settled:
            axes.axhline(level, color=self.theme.muted, linewidth=self.layout.pixels(1), linestyle=(0, (5, 3)))
        self._ticks(axes, rect, *exponents)
        units = self.scene.units.time, unit_label(series.unit, self.scene.units)
        self._label(axes, axis_label("t", units[0], exponents[0]), axis_label(series.name, units[1], exponents[1]))

    def series_legend(self, panel: TimePanel) -> None:
        """Names of the numbers in their colours, above their panel."""
        px, rect = self.layout.pixels, self.layout.series
        left, row = float(rect.left), rect.top - px(14)
        for name, colour, known in zip(panel.labels, panel.colours, panel.known, strict=True):
            if not known:
                continue
            left = px(16) + self._right_end(self._text(left, row, name, size=14, va="center", color=colour))
        name = panel.series.level_name if np.isfinite(panel.levels).any() else panel.series.reference
        if name:
            self._key_line(left, row, name)
        if len(panel.settled):
            self._key_line(left, row, "steady value", color=self.theme.muted, linestyle=(0, (2.5, 1.5)))

    def lines_legend(self, name: str) -> None:
        """Key to the lines over the fluid, above the right end of the box."""
        px, box = self.layout.pixels, self.layout.box
        if name:
            row, right = self.layout.wall("top").top - px(10), min(box.right, self.layout.width - px(180))
            text = self._text(right, row, name, size=13, va="center", ha="right", color=self.theme.muted)
            start = text.get_window_extent().x0 - px(26)
            for width, ink in ((px(4), LIGHT), (px(2), INK)):
                self.overlay.plot([start, start + px(20)], [row, row], "-", color=ink, linewidth=width)

    def legend(self, quantity: Quantity) -> None:
        """Key to the profile, above it: data can be anywhere inside."""
        px, left, row = self.layout.pixels, self.layout.profile.left, self.layout.profile.top - self.layout.pixels(14)
        self.overlay.plot([left, left + px(20)], [row, row], "-", color=self.theme.particles, linewidth=px(4))
        particles = self._text(left + px(26), row, "tisph", size=14, va="center")
        end = self._right_end(particles) + px(16)
        if len(quantity.profile.of_slip_walls(self.scene.slip_wall_velocity, self.scene.start_time)[0]):
            self.overlay.plot([end + px(6)], [row], "o", color=self.theme.wall_moving, markersize=px(9))
            end = px(16) + self._right_end(self._text(end + px(15), row, "wall", size=14, va="center"))
        if quantity.profile.exact is None:
            return
        steady = ", drawn when the flow is" if quantity.profile.steady else ""
        self._key_line(end, row, quantity.profile.reference + steady)

    def _key_line(self, start: float, row: float, name: str, **look: Any) -> None:
        """Draw the key to the thin line of exact or steady values, from ``start`` on."""
        px = self.layout.pixels
        look = {"color": self.theme.exact, "linestyle": "-", "linewidth": px(2), **look}
        self.overlay.plot([start, start + px(20)], [row, row], **look)
        self._text(start + px(26), row, name, size=14, va="center")

    def titles(self, title: str) -> None:
        """Write the name of the run at the left, its numbers at the right."""
        px, layout = self.layout.pixels, self.layout
        facts = "     ".join(self._facts())
        right = self._text(layout.width - px(26), px(36), facts, size=14, ha="right", color=self.theme.muted)
        size, name = px(20), self._text(px(24), px(36), title, size=20, weight="bold")
        limit = right.get_window_extent().x0 - px(30)
        while self._right_end(name) > limit and size > px(_SMALLEST_TITLE):
            size -= 1
            name.set_fontsize(size)
        while self._right_end(name) > limit and len(title) > 1:
            title = title[:-1]
            name.set_text(title + "…")

    def _facts(self) -> list[str]:
        scene = self.scene
        strength = f"Re = {number(scene.reynolds)}" if scene.inertia else "no inertia"
        facts = [strength, *([] if scene.wanted_spacing.varies else [_count(scene)])]
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
        """Name the axes. A name that is longer than its axis, and two margins at the side, is written smaller.

        The unit of an upright one is first written below it.
        """
        size, pad, box = self.layout.pixels(14), self.layout.pixels(4), axes.get_window_extent()
        for text, write, side, room in (
            (x_text, axes.set_xlabel, "width", box.width + self.layout.pixels(40)),
            (y_text, axes.set_ylabel, "height", box.height),
        ):
            if text is not None:
                label: Any = write(text, fontsize=size, labelpad=pad, parse_math=False)
                if side == "height" and label.get_window_extent().height > room:
                    label.set_text(text.replace(" [", "\n["))
                while getattr(label.get_window_extent(), side) > room:
                    label.set_fontsize(0.95 * label.get_fontsize())

    def _text(self, x: float, y: float, text: str, *, size: int, **settings: Any) -> Text:
        return self.overlay.text(x, y, text, fontsize=self.layout.pixels(size), parse_math=False, **settings)

    def _right_end(self, text: Text) -> float:
        return text.get_window_extent().x1

    def _bar(self, bar: Rect, **settings: Any) -> None:
        self.overlay.add_patch(Rectangle((bar.left, bar.top), bar.width, bar.height, **settings))


def _count(scene: Scene) -> str:
    """Return how many particles there are, in words, where the spacing does not vary."""
    return f"{scene.particles if scene.bodies else f'{scene.columns} {TIMES} {scene.rows}'} particles"


_OVERLAYS = {"vectors": Vectors, "tracks": Tracks}
_LINES = {"streamlines": "streamlines", "tracks": "paths of particles", "vectors": "velocity"}


@dataclass(frozen=True)
class Measured:
    """A snapshot, and the quantities that a frame shows.

    ``colours`` and ``profile`` (particles,) are the quantities of the field and of the profile panel, ``series`` the
    numbers over time, ``ends`` the limits of the colours, ``stream`` the stream function where streamlines are drawn.
    """

    snapshot: Snapshot
    colours: np.ndarray
    profile: np.ndarray
    series: np.ndarray
    ends: Ends
    stream: StreamFunction | None = None


class FrameRenderer:
    """Draws the frames of one run, each uint8 of shape (height, width, 3).

    ``scene`` is a ``tisph.scenes._scene.Scene``, ``layout`` its frame, ``video`` the config's ``output.video``,
    ``title`` the name of the run; ``quantity`` and ``time_panel`` have the ranges of the run, ``streams`` its
    streamlines, if any. ``frame`` is the last frame with an idle byte after each RGB, (height, width, 4), which is the
    fastest to fill and to encode.
    """

    def __init__(
        self,
        scene: Scene,
        layout: Layout,
        video: Any,
        title: str,
        quantity: Quantity,
        time_panel: TimePanel,
        streams: Streamlines | None = None,
    ):
        self.scene, self.layout, self.quantity, self._time_panel = scene, layout, quantity, time_panel
        self._streams = streams
        labels: list[Any] = [DriveLabel(scene, layout), *wall_labels(scene, layout)]
        with style.plot_style(layout.theme):
            figure: Any = build_figure(scene, layout, title, quantity, time_panel, _LINES.get(video.overlay, ""))
            figure.canvas.draw()
            self._background = np.asarray(figure.canvas.buffer_rgba()).copy()
        picture = self._background[:, :, :3]
        for label in labels:
            if not label.animated:
                label.paint(picture, scene.start_time)
        self._changing_labels = [label for label in labels if label.animated]
        self._changing_boxes = [layout.profile, layout.series, layout.time_label, layout.error_label]
        self._changing_boxes += [box for label in self._changing_labels for box in label.boxes]
        self._scale = ScaleLabel(layout) if quantity.of_frame else None
        self._changing_boxes += self._scale.boxes if self._scale else []
        self.frame = self._background.copy()
        self._time_label = time_label(scene.time_scale, scene.units.time, scene.time_formula)
        self._error_label = error_label(scene, quantity.error)
        self._fluid = FluidPainter(scene, layout, quantity, video)
        self._profile_panel = ProfilePanel(scene, layout, quantity, self._fluid.grid, self._fluid.style != "particles")
        self._overlays = [overlay(scene, layout) for overlay in _overlays(scene, video.overlay)]

    def render(self, measured: Measured) -> np.ndarray:
        """Return the picture of ``measured``, which the next call draws over (a new array costs 3 ms)."""
        frame, picture, snapshot = self.frame, self.frame[:, :, :3], measured.snapshot
        for box in self._changing_boxes:
            frame[box.slices] = self._background[box.slices]
        box, shown = self.layout.box, _whole(self.scene, snapshot)
        colours, profile = measured.colours, measured.profile
        if shown is not snapshot:
            colours, profile = (np.concatenate([each, each]) for each in (colours, profile))
        limits = self.quantity.colour_range
        if self._scale and self.quantity.of_frame:
            limits = self.quantity.of_frame(measured.ends)
            self._scale.paint(picture, limits)
        self._fluid.paint(frame[box.slices], shown, colours, profile, limits)
        if self._streams and measured.stream:
            self._streams.paint(picture[box.slices], measured.stream)
        for overlay in self._overlays:
            overlay.paint(picture[box.slices], shown)
        paint_marks(picture[box.slices], self.layout, self.scene.movie_marks(snapshot))
        self._time_panel.paint(picture, snapshot.t, measured.series)
        self._profile_panel.paint(picture, snapshot, measured.profile, self._has_reference(snapshot.t))
        for label in self._changing_labels:
            label.paint(picture, snapshot.t)
        time, error, ink = self._time_label(snapshot.t), self._error_label(snapshot), self.layout.theme.text
        if self.scene.wanted_spacing.varies:  # particles come and go
            time += f"     {len(snapshot.x)} particles"
        paint_text(picture, self.layout.time_label, time, self.layout.pixels(18), "left", ink)
        paint_text(picture, self.layout.error_label, error, self.layout.pixels(18), "right", ink)
        return picture

    def _has_reference(self, t: float) -> bool:
        """Return whether the reference of the profile is one of time ``t``: a steady one is not before the flow is."""
        if not self.quantity.profile.steady:
            return True
        return self._time_panel.steady(*self._time_panel.history(t))


def _overlays(scene: Scene, name: str) -> list:
    """Return the classes of the overlays, in the order of painting: overlay ``name``, if any, then bodies.

    Paths of few free bodies are always drawn.
    """
    overlays = [_OVERLAYS[name]] if name in _OVERLAYS else []
    overlays += [Solids] if scene.bodies else []
    overlays += [Turning] if scene.axisymmetric and any(body.spin.largest_speed for body in scene.bodies) else []
    shown = scene.has_free_bodies and (name == "tracks" or len(BodyTracks.free(scene)) <= SHOWN)
    return [*overlays, BodyTracks] if shown else overlays


_BEYOND = 10.0  # lengths of the box that an inner cylinder is drawn beyond it

_POINTS = 400  # on the mirror image of a closed body

_ODD = ("y", "v", "stress_xy")


class FullCut:
    """An axisymmetric ``scene`` with the box and the ``bodies`` of the whole plane, and else as it is.

    ``half`` is the scene, ``sides``: of a body that is in one half alone 1 or -1, the sign of y there, else 0.
    """

    def __init__(self, scene: Scene):
        self.half, radius = scene, scene.extent[1]
        self.origin, self.extent = (scene.origin[0], -radius), (scene.extent[0], 2.0 * radius)
        found = []  # number, side and body
        for index, body in enumerate(scene.bodies):
            whole = body.crosses_axis
            found += [(index, 0.0, body)] if whole else [(index, 1.0, body), (index, -1.0, _mirrored(body))]
        self._sources, self.sides, self.bodies = zip(*found, strict=True)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.half, name)

    def seen(self, snapshot: Snapshot) -> "FullCut":
        """See ``Scene.seen``."""
        return FullCut(self.half.seen(snapshot)) if self.has_free_bodies else self

    def mirrored(self, snapshot: Snapshot) -> Snapshot:
        """``snapshot`` with the mirror image of each particle after all of them, and its bodies with theirs."""
        values = {each.name: getattr(snapshot, each.name) for each in fields(snapshot)}
        double: dict[str, Any] = {
            name: np.concatenate([array, -array if name in _ODD else array])
            for name, array in values.items()
            if isinstance(array, np.ndarray)
        }
        given: Any = snapshot.bodies
        chosen, sides = list(self._sources), np.where(np.array(self.sides) < 0.0, -1.0, 1.0)
        ways = np.stack([np.ones_like(sides), sides], axis=1)
        moved = {name: getattr(given, name)[chosen] * ways for name in ("centre", "velocity")}
        turned = {name: getattr(given, name)[chosen] * sides for name in ("angle", "angular_velocity")}
        return replace(snapshot, **double, reference=None, bodies=replace(given, **moved, **turned))


def displayed(scene: Scene) -> Any:
    """Return the scene that a frame shows: a ``FullCut`` where axisymmetric flow reaches the axis."""
    return FullCut(scene) if scene.axisymmetric and scene.origin[1] == 0.0 else scene


def _whole(scene: Scene, snapshot: Snapshot) -> Snapshot:
    """Return a snapshot as ``scene`` shows it: with its mirror image in a ``FullCut``."""
    return scene.mirrored(snapshot) if isinstance(scene, FullCut) else snapshot


def _mirrored(body: Body) -> Body:
    """The mirror image of a ``body``: of a closed one by a polygon through points on it."""
    across = np.array([1.0, -1.0])
    shape: Any = body.shape
    image: Any
    if shape.area:
        outline = shape.boundary_points(shape.length / _POINTS).point * across
        image = Polygon(outline.tolist(), fluid_side=shape.fluid_side)
    elif not isinstance(shape, Line):
        key = "points" if isinstance(shape, SmoothOutline) else "corners"
        image = replace(shape, **{key: (np.array(getattr(shape, key))[::-1] * across).tolist()})
    else:
        start = np.add(shape.point, shape.length * np.array(shape.tangent)) * across
        image = Line(start.tolist(), (-across * shape.tangent).tolist(), shape.length)
    return replace(body, shape=image, centre=(across * body.centre).tolist(), angle=-body.angle)


_PATTERNS = {"stripes": "stripes", "checkerboard": "squares", "blob": "a blob"}


class Movie:
    """A movie of ``scene`` at ``path``, drawn and encoded a frame at a time.

    ``video`` is the config's ``output.video``, ``title`` the name of the run and ``end`` the time at which it ends.
    Where exact values tell the ranges of axes and colours, a frame is drawn when it is added. Else, and where there are
    streamlines, its snapshot waits in a temporary file until the movie is closed and all ranges are known. The movie's
    own file is opened by the first frame that is drawn, so a Movie that only serves ``save_frame`` writes none. As a
    context manager it closes the file also after an error: the frames up to then can be played.
    Raises TisphError if ffmpeg cannot start or stops early.
    """

    def __init__(self, path: Path | str, scene: Scene, video: Any, title: str, end: float):
        self.path = Path(path)
        self._scene, self._video, self._title, self._end = scene, video, title, end
        self._shown: Any = displayed(scene)
        self._layout = arrange(self._shown, video.width, video.height, style.THEMES[video.theme])
        self._streams = Streamlines(self._shown, self._layout) if video.overlay == "streamlines" else None
        self._dyed = video.color_by == "dye" and "dye" not in scene.substance_colours
        self._series = scene.movie_series()
        self._view = scene.movie_view("speed" if self._dyed else video.color_by, end)
        if self._dyed:
            self._view = replace(
                self._view, name=f"dye, at first in {_PATTERNS[video.dye]}", of=Dye(scene, video.dye).of
            )
        self._waiting: Any = None
        self._ranges: _Ranges | None = None
        self._renderer: FrameRenderer | None = None
        self._encoder: Encoder | None = None
        self._known = bool(self._view.ends) and exact_values(self._series, np.array([end])) is not None
        if self._known and not self._streams:
            self._renderer = self._new_renderer(None)

    def frame(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, uint8 (height, width, 3), with the ranges of the frames or its own."""
        measured = self._measured(snapshot)
        renderer = self._renderer
        if renderer is None:
            ranges = self._ranges or _Ranges(self._view)
            if self._ranges is None:
                ranges.add(measured)
            renderer = self._new_renderer(ranges)
        return renderer.render(measured).copy()

    def save_frame(self, path: Path | str | BytesIO, snapshot: Snapshot) -> None:
        """Write the picture of ``snapshot`` as PNG to a path or an open file."""
        Image.fromarray(self.frame(snapshot)).save(path, format="PNG", optimize=True)

    def add(self, snapshot: Snapshot) -> None:
        """Append the picture of ``snapshot`` to the movie."""
        measured = self._measured(snapshot)
        if self._renderer:
            self._draw(self._renderer, measured)
            return
        if self._ranges is None:
            self._waiting = tempfile.TemporaryFile()  # noqa: SIM115 (lives until ``close``)
            self._ranges = _Ranges(self._view)
        self._ranges.add(measured)
        pickle.dump(measured, self._waiting, pickle.HIGHEST_PROTOCOL)

    def close(self) -> None:
        """Draw the waiting snapshots and finish the file. A second call does nothing."""
        waiting, self._waiting = self._waiting, None
        try:
            if waiting and self._ranges:
                self._renderer = self._new_renderer(self._ranges)
                waiting.seek(0)
                for _ in range(self._ranges.count):
                    self._draw(self._renderer, pickle.load(waiting))
        finally:
            if waiting:
                waiting.close()
            if self._encoder is not None:
                self._encoder.close()

    def _measured(self, snapshot: Snapshot) -> Measured:
        view = self._view
        colours = view.of(snapshot)
        profile = colours if view.profile.of is view.of else view.profile.of(snapshot)
        stream = self._streams.measured(_whole(self._shown, snapshot)) if self._streams else None
        spread = _spread(view)
        spread.add(colours - view.base, snapshot.weight)
        return Measured(snapshot, colours, profile, measured(self._series, snapshot), spread.ends, stream)

    def _new_renderer(self, ranges: "_Ranges | None") -> FrameRenderer:
        ranges = None if self._known else ranges
        found = (ranges.colours.ends, ranges.profile.ends) if ranges else None
        shown = quantity(self._view, self._scene, (0.0, 1.0) if self._dyed else self._video.limits, found)
        shown = replace(shown, colour_map=style.DYE_MAP) if self._dyed else shown
        panel = TimePanel(self._shown, self._layout, self._series, self._end, ranges.series.ends if ranges else None)
        if ranges:
            panel.know(*ranges.record)
        return FrameRenderer(self._shown, self._layout, self._video, self._title, shown, panel, self._streams)

    def _draw(self, renderer: FrameRenderer, measured: Measured) -> None:
        if self._encoder is None:
            self._encoder = Encoder(self.path, self._video.width, self._video.height, self._video.fps)
        renderer.render(measured)
        self._encoder.write(renderer.frame)

    def __enter__(self) -> "Movie":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        # An error on its way out is the message to show: a broken movie must not hide it.
        with contextlib.suppress(TisphError) if kind else contextlib.nullcontext():
            self.close()


class _Ranges:
    """Ranges of colours, of the profile of a ``view`` along its line and of the series over frames, and their number.

    Velocities are bounded, and all of a profile is shown; stresses and gradients may be infinite at corners.
    """

    def __init__(self, view: MovieView):
        self.colours, self.series = _spread(view), Extremes()
        self.profile = Extremes() if view.profile.unit == "velocity" else Spread()
        self._line, self._base, self.count = view.profile.line, view.base, 0
        self._record: list[tuple[float, np.ndarray]] = []

    def add(self, measured: Measured) -> None:
        """Take a frame."""
        self.count += 1
        self.colours.add(measured.colours - self._base, measured.snapshot.weight)
        self.profile.add(measured.profile[self._line.near(measured.snapshot)] - self._base)
        self.series.add(measured.series[:NUMBERS])
        self._record.append((measured.snapshot.t, measured.series[:NUMBERS]))

    @property
    def record(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (n,) and numbers of the series (n, numbers) of the frames."""
        times, values = zip(*self._record, strict=True)
        return np.array(times), np.array(values)


def _spread(view: MovieView) -> Spread | Extremes:
    """Return the collector of the values of the colours of a ``view``."""
    return Spread() if view.from_zero else Extremes()
