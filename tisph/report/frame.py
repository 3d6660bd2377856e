"""One movie frame from one snapshot: the fluid, a live profile, numbers over time and labels over what stays."""

from dataclasses import dataclass

import numpy as np

from tisph.report.background import draw_background
from tisph.report.drive_labels import DriveLabel, wall_labels
from tisph.report.error_label import error_label
from tisph.report.fluid import FluidPainter
from tisph.report.labels import time_label
from tisph.report.layout import Layout
from tisph.report.profile_panel import ProfilePanel
from tisph.report.quantities import Quantity
from tisph.report.solids import Solids
from tisph.report.streamlines import Streamlines
from tisph.report.text import paint_text
from tisph.report.time_panel import TimePanel
from tisph.report.tracks import BodyTracks, Tracks
from tisph.report.vectors import Vectors
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
