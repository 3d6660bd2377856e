"""One movie frame from one snapshot: discs, live profile and labels over a background drawn once."""

import numpy as np

from tisph.report import style
from tisph.report.background import draw_background
from tisph.report.drive_labels import DriveLabel, wall_labels
from tisph.report.error_label import error_label
from tisph.report.labels import time_label
from tisph.report.layout import arrange
from tisph.report.quantities import quantity
from tisph.report.raster import Discs, Shades, blend, dense_line
from tisph.report.solids import Solids
from tisph.report.streamlines import Streamlines
from tisph.report.text import paint_text
from tisph.report.vectors import Vectors
from tisph.snapshot import Snapshot

_SMALLEST_DIAMETER = 1.5  # pixels: below it discs would fade away
_CURVE_POINTS = 600  # about two a pixel row at the usual size
_OVERLAYS = {"vectors": Vectors, "streamlines": Streamlines}


class FrameRenderer:
    """Draws the frames of one run, each uint8 of shape (height, width, 3).

    ``scene`` is a ``tisph.scenes._scene.Scene``, ``video`` the config's ``output.video`` (width, height, color_by,
    overlay), ``title`` the name of the run. All axes and colours fit what the exact solution does until ``end``, the
    time at which the run ends. ``frame`` is the last one with an idle byte after each RGB, (height, width, 4): what
    can be filled and encoded the quickest.
    """

    def __init__(self, scene, video, title: str, end: float):
        self.scene = scene
        self.layout = arrange(scene, video.width, video.height)
        self.quantity = quantity(video.color_by, scene, end)
        labels = wall_labels(scene, self.layout)
        self._background = draw_background(scene, self.layout, self.quantity, title)
        picture = self._background[:, :, :3]
        DriveLabel(scene, self.layout).paint(picture)
        for label in labels:
            if not label.animated:
                label.paint(picture, scene.start_time)
        self._changing_labels = [label for label in labels if label.animated]
        self._changing_boxes = [self.layout.profile, self.layout.time_label, self.layout.error_label]
        self._changing_boxes += [box for label in self._changing_labels for box in label.boxes]
        self.frame = self._background.copy()
        self._shades = Shades(style.colours(256, colour_map=self.quantity.colour_map))
        self._time_label = time_label(scene.time_scale, scene.units.time, scene.time_formula)
        self._error_label = error_label(scene, self.quantity.error)
        self._coordinates = self.quantity.profile.line.coordinates(_CURVE_POINTS)
        panel, scale = self.layout.profile, self.layout.scale
        inside = panel.height - 2, panel.width - 2  # the axes' lines are on the border
        self._discs = Discs(self.disc_radius, (self.layout.box.height, self.layout.box.width))
        overlays = [_OVERLAYS[video.overlay]] if video.overlay in _OVERLAYS else []
        overlays += [Solids] if scene.bodies else []
        self._overlays = [overlay(scene, self.layout) for overlay in overlays]
        self._dots, self._line = Discs(3.0 * scale, inside), Discs(max(0.5, 0.9 * scale), inside)

    @property
    def disc_radius(self) -> float:
        """Radius of a particle's disc in pixels: neighbours on a lattice touch."""
        return max(_SMALLEST_DIAMETER, self.scene.spacing * self.layout.pixels_per_length) / 2.0

    def render(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, which the next call draws over (a new array costs 3 ms)."""
        frame, picture = self.frame, self.frame[:, :, :3]
        for box in self._changing_boxes:
            frame[box.slices] = self._background[box.slices]
        self._shades.fill(frame[self.layout.box.slices], *self._sums(snapshot))
        for overlay in self._overlays:
            overlay.paint(picture[self.layout.box.slices], snapshot)
        self._draw_profile(picture, snapshot)
        for label in self._changing_labels:
            label.paint(picture, snapshot.t)
        time, error = self._time_label(snapshot.t), self._error_label(snapshot)
        paint_text(picture, self.layout.time_label, time, self.layout.pixels(18), "left")
        paint_text(picture, self.layout.error_label, error, self.layout.pixels(14), "right")
        return picture

    def _sums(self, snapshot: Snapshot) -> tuple[np.ndarray, int]:
        points = self.layout.pixel_positions(snapshot.x, snapshot.y)
        lowest, highest = self.quantity.colour_range
        share = (self.quantity.of_discs(snapshot) - lowest) / (highest - lowest)
        share = np.clip(np.nan_to_num(share, nan=1.0), 0.0, 1.0)  # a run that went wrong still gets its picture
        periodic = self.layout.shown_length == self.scene.extent[0] and self.scene.periodic[0], self.scene.periodic[1]
        return self._discs.sums(points, share, periodic=periodic)

    def _draw_profile(self, picture: np.ndarray, snapshot: Snapshot) -> None:
        panel = picture[self.layout.profile.slices][1:-1, 1:-1]
        profile = self.quantity.profile
        near = profile.line.near(snapshot)
        dots = self._profile_pixels(profile.of(snapshot)[near], profile.line.of(snapshot)[near])
        blend(panel, self._dots.cover(dots), style.rgb(style.PARTICLES))
        if profile.exact:
            exact = profile.exact(*profile.line.points(self._coordinates), snapshot.t)
            line = dense_line(self._profile_pixels(exact, self._coordinates))
            blend(panel, self._line.cover(line), style.rgb(style.EXACT))

    def _profile_pixels(self, values: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return columns and rows inside the profile panel, whose first pixel is on the axes' lines."""
        rect, (lowest, highest) = self.layout.profile, self.quantity.profile_range
        first, last = self.quantity.profile.line.ends
        column = (values - lowest) / (highest - lowest) * rect.width - 1.0
        column = np.clip(column, -rect.width, 2 * rect.width)  # an exact curve may go to infinity
        return column, (1.0 - (along - first) / (last - first)) * rect.height - 1.0
