"""One movie frame from one snapshot: discs, live profile and labels over a background drawn once."""

import numpy as np
from PIL import Image, ImageDraw

from tisph.report import style
from tisph.report.error_label import error_label
from tisph.report.labels import time_label
from tisph.report.layout import Rect, arrange
from tisph.report.raster import blend, cover, dense_line, paint_discs
from tisph.report.stage import draw_background
from tisph.snapshot import Snapshot

_SMALLEST_DIAMETER = 1.5  # pixels: below it discs would fade away
_CURVE_POINTS = 600  # about two a pixel row at the usual size
_BAND = 32  # pixel rows coloured at a time: work arrays that stay in the cache, about four times faster
_PROFILE_MARGIN = 0.08  # of the velocity range, at both ends: overshoot stays in sight


class FramePainter:
    """Draws the frames of one run, each uint8 of shape (height, width, 3).

    ``channel`` is the scene (``tisph.scenes.channel.Channel``), ``title`` the name of the run.
    """

    def __init__(self, channel, width: int, height: int, title: str = ""):
        self.channel = channel
        self.layout = arrange(channel.length, channel.gap, width, height)
        self.velocity_range = _velocity_range(channel)
        self._background = draw_background(channel, self.layout, self.velocity_range, title)
        self._frame = np.empty_like(self._background)
        self._table = _colour_table()
        self._time_label = time_label(channel.viscous_time, channel.units.time)
        self._heights = np.linspace(0.0, channel.gap, _CURVE_POINTS)

    @property
    def disc_radius(self) -> float:
        """Radius of a particle's disc in pixels: neighbours on a lattice touch."""
        return max(_SMALLEST_DIAMETER, self.channel.spacing * self.layout.pixels_per_length) / 2.0

    def paint(self, snapshot: Snapshot) -> np.ndarray:
        """Return the picture of ``snapshot``, in an array that the next call reuses (a new one costs 3 ms)."""
        frame = self._frame
        np.copyto(frame, self._background)
        self._paint_channel(frame, snapshot)
        self._paint_profile(frame, snapshot)
        time, error = self._time_label(snapshot.t), error_label(self.channel, snapshot)
        _paint_text(frame, self.layout.time_label, time, self.layout.pixels(18), "left")
        _paint_text(frame, self.layout.error_label, error, self.layout.pixels(14), "right")
        return frame

    def _paint_channel(self, frame: np.ndarray, snapshot: Snapshot) -> None:
        rect, scale = self.layout.channel, self.layout.pixels_per_length
        points = snapshot.x * scale, (self.channel.gap - snapshot.y) * scale
        speed = np.hypot(snapshot.u, snapshot.v) / self.channel.reference_velocity
        speed = np.nan_to_num(speed, nan=1.0, posinf=1.0)  # a run that went wrong still gets its picture
        coverage, mean_speed = paint_discs(
            points,
            speed,
            radius=self.disc_radius,
            shape=(rect.height, rect.width),
            periodic=self.layout.shown_length == self.channel.length,
        )
        panel = frame[rect.slices]
        for top in range(0, rect.height, _BAND):
            band = slice(top, top + _BAND)
            colour = np.minimum(mean_speed[band] * 255.0 + 0.5, 255.0).astype(np.uint16)
            entry = (coverage[band] * 255.0 + 0.5).astype(np.uint16) * 256 + colour
            panel[band] = np.take(self._table, entry, axis=0)

    def _paint_profile(self, frame: np.ndarray, snapshot: Snapshot) -> None:
        rect = self.layout.profile
        panel = frame[rect.slices][1:-1, 1:-1]  # the axes' lines are on the border
        shape = panel.shape[:2]
        dots = self._profile_pixels(snapshot.u, snapshot.y)
        blend(panel, cover(dots, self.layout.scale * 3.0, shape), style.rgb(style.PARTICLES))
        exact = self.channel.exact_velocity(self._heights, snapshot.t)
        line = dense_line(self._profile_pixels(exact, self._heights))
        blend(panel, cover(line, max(0.5, self.layout.scale * 0.9), shape), style.rgb(style.EXACT))

    def _profile_pixels(self, u: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return columns and rows inside the profile panel, whose first pixel is on the axes' lines."""
        rect, (lowest, highest) = self.layout.profile, self.velocity_range
        column = (u - lowest) / (highest - lowest) * rect.width - 1.0
        return column, (1.0 - y / self.channel.gap) * rect.height - 1.0


def _velocity_range(channel) -> tuple[float, float]:
    ends = (0.0, channel.bottom_velocity, channel.top_velocity)
    margin = _PROFILE_MARGIN * (max(ends) - min(ends))
    return min(ends) - margin, max(ends) + margin


def _colour_table() -> np.ndarray:
    """Return RGB for every coverage (of white) and speed, shape (65536, 3): a look-up instead of blending."""
    coverage = np.linspace(0.0, 1.0, 256)[:, None, None]
    table = 255.0 * (1.0 - coverage * (1.0 - style.colours(256)[None, :, :]))
    return (table + 0.5).astype(np.uint8).reshape(-1, 3)


def _paint_text(frame: np.ndarray, box: Rect, text: str, size: int, side: str) -> None:
    """Write one line into ``box``, at its left or right side, over what is there."""
    image = Image.fromarray(frame[box.slices])
    place, anchor = ((0, box.height / 2), "lm") if side == "left" else ((box.width, box.height / 2), "rm")
    ImageDraw.Draw(image).text(place, text, fill=style.TEXT, font=style.text_font(size), anchor=anchor)
    frame[box.slices] = np.asarray(image)
