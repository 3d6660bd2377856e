"""The MP4 of a run, and single frames of it as PNG.

A frame shows one snapshot: the fluid, a live profile, numbers over time and labels over a background that stays.
Axisymmetric flow is drawn in the whole plane through the axis: the half-plane and its mirror image.
"""

import contextlib
import pickle
import tempfile
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from PIL import Image

from tisph.errors import TisphError
from tisph.geometry.line import Line
from tisph.geometry.polygon import Polygon
from tisph.report import style
from tisph.report.background import draw_background
from tisph.report.encoder import Encoder
from tisph.report.field import Dye, FluidPainter
from tisph.report.labels import error_label, time_label
from tisph.report.layout import Layout, arrange
from tisph.report.overlays import BodyTracks, Solids, Streamlines, Tracks, Vectors
from tisph.report.panels import ProfilePanel, TimePanel, exact_values, measured
from tisph.report.quantities import Extremes, Quantity, quantity
from tisph.report.text import DriveLabel, paint_text, wall_labels
from tisph.snapshot import Snapshot

_OVERLAYS = {"vectors": Vectors, "streamlines": Streamlines, "tracks": Tracks}


@dataclass(frozen=True)
class Measured:
    """A snapshot, and what a frame shows of it.

    ``colours`` and ``profile`` (particles,) are the quantities of the field and of the profile panel, ``series`` the
    numbers over time.
    """

    snapshot: Snapshot
    colours: np.ndarray
    profile: np.ndarray
    series: np.ndarray


class FrameRenderer:
    """Draws the frames of one run, each uint8 of shape (height, width, 3).

    ``scene`` is a ``tisph.scenes._scene.Scene``, ``layout`` its frame, ``video`` the config's ``output.video``,
    ``title`` the name of the run; ``quantity`` and ``time_panel`` have the ranges of the run. ``frame`` is the last one
    with an idle byte after each RGB, (height, width, 4): what can be filled and encoded the quickest.
    """

    def __init__(self, scene, layout: Layout, video, title: str, quantity: Quantity, time_panel: TimePanel):
        self.scene, self.layout, self.quantity, self._time_panel = scene, layout, quantity, time_panel
        labels = wall_labels(scene, layout)
        self._background = draw_background(scene, layout, title, quantity, time_panel)
        picture = self._background[:, :, :3]
        DriveLabel(scene, layout).paint(picture)
        for label in labels:
            if not label.animated:
                label.paint(picture, scene.start_time)
        self._changing_labels = [label for label in labels if label.animated]
        self._changing_boxes = [layout.profile, layout.series, layout.time_label, layout.error_label]
        self._changing_boxes += [box for label in self._changing_labels for box in label.boxes]
        self.frame = self._background.copy()
        self._time_label = time_label(scene.time_scale, scene.units.time, scene.time_formula)
        self._error_label = error_label(scene, quantity.error)
        self._fluid = FluidPainter(scene, layout, quantity, video)
        self._profile_panel = ProfilePanel(scene, layout, quantity, self._fluid.grid)
        self._overlays = [overlay(scene, layout) for overlay in _overlays(scene, video.overlay)]

    def render(self, measured: Measured) -> np.ndarray:
        """Return the picture of ``measured``, which the next call draws over (a new array costs 3 ms)."""
        frame, picture, snapshot = self.frame, self.frame[:, :, :3], measured.snapshot
        for box in self._changing_boxes:
            frame[box.slices] = self._background[box.slices]
        box, shown, values = self.layout.box, snapshot, (measured.colours, measured.profile)
        if self.scene.axisymmetric:
            shown, values = self.scene.mirrored(snapshot), [np.concatenate([each, each]) for each in values]
        self._fluid.paint(frame[box.slices], shown, *values)
        for overlay in self._overlays:
            overlay.paint(picture[box.slices], shown)
        self._profile_panel.paint(picture, snapshot, measured.profile)
        self._time_panel.paint(picture, snapshot.t, measured.series)
        for label in self._changing_labels:
            label.paint(picture, snapshot.t)
        time, error, ink = self._time_label(snapshot.t), self._error_label(snapshot), self.layout.theme.text
        paint_text(picture, self.layout.time_label, time, self.layout.pixels(18), "left", ink)
        paint_text(picture, self.layout.error_label, error, self.layout.pixels(14), "right", ink)
        return picture


def _overlays(scene, name: str) -> list:
    """Return what is painted over the fluid, in this order: the overlay of that ``name``, if any, and bodies."""
    overlays = [_OVERLAYS[name]] if name in _OVERLAYS else []
    overlays += [Solids] if scene.bodies else []
    return [*overlays, BodyTracks] if name == "tracks" and scene.has_free_bodies else overlays


_BEYOND = 10.0  # lengths of the box that an inner cylinder is drawn beyond it

_POINTS = 400  # on the mirror image of a closed body

_ODD = ("y", "v", "stress_xy")


class FullCut:
    """An axisymmetric ``scene`` with the box and the ``bodies`` of the whole plane, and else as it is.

    ``half`` is the scene, ``sides``: of a body that is in one half alone 1 or -1, the sign of y there, else 0.
    """

    def __init__(self, scene):
        self.half, radius = scene, scene.outer_radius
        self.origin, self.extent = (scene.origin[0], -radius), (scene.extent[0], 2.0 * radius)
        found = []  # number, side and body
        for index, body in enumerate(scene.bodies):
            whole = body.crosses_axis
            found += [(index, 0.0, body)] if whole else [(index, 1.0, body), (index, -1.0, _mirrored(body))]
        self._sources, self.sides, self.bodies = zip(*found, strict=True)

    def __getattr__(self, name):
        return getattr(self.half, name)

    def seen(self, snapshot):
        """See ``Scene.seen``."""
        return FullCut(self.half.seen(snapshot)) if self.has_free_bodies else self

    def mirrored(self, snapshot):
        """``snapshot`` with the mirror image of each particle after all of them, and its bodies with theirs."""
        values = {each.name: getattr(snapshot, each.name) for each in fields(snapshot)}
        double = {
            name: np.concatenate([array, -array if name in _ODD else array])
            for name, array in values.items()
            if isinstance(array, np.ndarray)
        }
        given, chosen, sides = snapshot.bodies, list(self._sources), np.where(np.array(self.sides) < 0.0, -1.0, 1.0)
        ways = np.stack([np.ones_like(sides), sides], axis=1)
        moved = {name: getattr(given, name)[chosen] * ways for name in ("centre", "velocity")}
        turned = {name: getattr(given, name)[chosen] * sides for name in ("angle", "angular_velocity")}
        return replace(snapshot, **double, reference=None, bodies=replace(given, **moved, **turned))


def _mirrored(body):
    """The mirror image of a ``body``: of a closed one by a polygon through points on it."""
    across, shape = np.array([1.0, -1.0]), body.shape
    if shape.area:
        outline = shape.boundary_points(shape.length / _POINTS).point * across
        image = Polygon(outline.tolist(), fluid_side=shape.fluid_side)
    else:
        start = np.add(shape.point, shape.length * np.array(shape.tangent)) * across
        image = Line(start.tolist(), (-across * shape.tangent).tolist(), shape.length)
    return replace(body, shape=image, centre=(across * body.centre).tolist(), angle=-body.angle)


class Movie:
    """A movie of ``scene`` at ``path``, drawn and encoded a frame at a time.

    ``video`` is the config's ``output.video``, ``title`` the name of the run and ``end`` the time at which it ends.
    Where exact values tell the ranges of axes and colours, a frame is drawn when it is added; else its snapshot waits
    in a temporary file until the movie is closed and all ranges are known. The movie's own file is opened by the first
    frame that is drawn, so a Movie that only serves ``save_frame`` writes none. As a context manager it closes the file
    whatever happens: what was added by then can be played.
    Raises TisphError if ffmpeg cannot start or stops early.
    """

    def __init__(self, path: Path | str, scene, video, title: str, end: float):
        self.path = Path(path)
        self._scene, self._video, self._title, self._end = scene, video, title, end
        self._dyed = video.color_by == "dye"
        self._series = scene.movie_series()
        self._view = scene.movie_view("speed" if self._dyed else video.color_by, end)
        if self._dyed:
            self._view = replace(self._view, name="", of=Dye(scene, video.dye).of)
        self._waiting, self._ranges = None, None
        self._renderer: FrameRenderer | None = None
        self._encoder: Encoder | None = None
        if self._view.ends and exact_values(self._series, np.array([end])) is not None:
            self._renderer = self._new_renderer(None)

    def frame(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, uint8 (height, width, 3), with the ranges of the frames or its own."""
        measured = self._measured(snapshot)
        renderer = self._renderer
        if renderer is None:
            ranges = self._ranges or _Ranges(self._view.profile.line)
            if self._ranges is None:
                ranges.add(measured)
            renderer = self._new_renderer(ranges)
        return renderer.render(measured).copy()

    def save_frame(self, path: Path | str, snapshot: Snapshot) -> None:
        """Write the picture of ``snapshot`` as PNG."""
        Image.fromarray(self.frame(snapshot)).save(path, format="PNG", optimize=True)

    def add(self, snapshot: Snapshot) -> None:
        """Append the picture of ``snapshot`` to the movie."""
        measured = self._measured(snapshot)
        if self._renderer:
            self._draw(measured)
            return
        if self._waiting is None:
            line = self._view.profile.line
            self._waiting, self._ranges = tempfile.TemporaryFile(), _Ranges(line)  # noqa: SIM115 (lives until ``close``)
        self._ranges.add(measured)
        pickle.dump(measured, self._waiting, pickle.HIGHEST_PROTOCOL)

    def close(self) -> None:
        """Draw what waits and finish the file. May be called again, and does nothing then."""
        waiting, self._waiting = self._waiting, None
        try:
            if waiting:
                self._renderer = self._new_renderer(self._ranges)
                waiting.seek(0)
                for _ in range(self._ranges.count):
                    self._draw(pickle.load(waiting))
        finally:
            if waiting:
                waiting.close()
            if self._encoder is not None:
                self._encoder.close()

    def _measured(self, snapshot):
        view = self._view
        colours = view.of(snapshot)
        profile = colours if view.profile.of is view.of else view.profile.of(snapshot)
        return Measured(snapshot, colours, profile, measured(self._series, snapshot))

    def _new_renderer(self, ranges):
        scene = FullCut(self._scene) if self._scene.axisymmetric else self._scene
        layout = arrange(scene, self._video.width, self._video.height, style.THEMES[self._video.theme])
        ends = ranges and (ranges.colours.ends, ranges.profile.ends)
        shown = quantity(self._view, self._scene, (0.0, 1.0) if self._dyed else self._video.limits, ends)
        shown = replace(shown, colour_map=style.DYE_MAP) if self._dyed else shown
        panel = TimePanel(scene, layout, self._series, self._end, ranges and ranges.series.ends)
        return FrameRenderer(scene, layout, self._video, self._title, shown, panel)

    def _draw(self, measured):
        if self._encoder is None:
            self._encoder = Encoder(self.path, self._video.width, self._video.height, self._video.fps)
        self._renderer.render(measured)
        self._encoder.write(self._renderer.frame)

    def __enter__(self) -> "Movie":
        return self

    def __exit__(self, kind, error, trace) -> None:
        # An error on its way out is the message to show: a broken movie must not hide it.
        with contextlib.suppress(TisphError) if kind else contextlib.nullcontext():
            self.close()


class _Ranges:
    """Ranges of what frames show, the profile along ``line``, and how many frames there are."""

    def __init__(self, line):
        self.colours, self.profile, self.series = Extremes(), Extremes(whole=True), Extremes(whole=True)
        self._line, self.count = line, 0

    def add(self, measured):
        """Take a frame."""
        self.count += 1
        self.colours.add(measured.colours)
        self.profile.add(measured.profile[self._line.near(measured.snapshot)])
        self.series.add(measured.series)
