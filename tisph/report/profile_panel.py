"""The live profile of a movie frame, and the line in the fluid along which it is taken."""

import numpy as np

from tisph.report import style
from tisph.report.field import FieldGrid
from tisph.report.layout import Layout
from tisph.report.quantities import Quantity
from tisph.report.raster import Discs, blend, dense_line, dense_lines
from tisph.report.strokes import Strokes
from tisph.snapshot import Snapshot

_CURVE_POINTS = 600  # about two a pixel row at the usual size
_FIELD_POINTS = 200
_DASH = 7.0  # pixels in a frame of 1280 x 640, and as long a gap


class ProfilePanel:
    """The profile of ``quantity``: particles as dots or, on the ``grid`` of a field, a line; and the exact curve.

    The grid is fitted to the values of the profile (``report/fluid.py``).
    """

    def __init__(self, scene, layout: Layout, quantity: Quantity, grid: FieldGrid | None):
        self._scene, self._layout, self._quantity, self._grid = scene, layout, quantity, grid
        line, scale, inside = quantity.profile.line, layout.scale, layout.profile.inner.shape
        self._dots, self._line = Discs(3.0 * scale, inside), Discs(max(0.5, 0.9 * scale), inside)
        self._thick = Discs(max(1.0, 2.2 * scale), inside)
        self._coordinates = line.coordinates(_CURVE_POINTS)
        self._places = [np.broadcast_to(place, _FIELD_POINTS) for place in line.points(line.coordinates(_FIELD_POINTS))]
        self._strokes, self._mark = Strokes(scale, layout.box.shape), self._mark_of(line)

    def paint(self, picture: np.ndarray, snapshot: Snapshot, values: np.ndarray) -> None:
        """Draw the profile of ``values`` (particles,) and, in the fluid, its place."""
        panel, profile = picture[self._layout.profile.inner.slices], self._quantity.profile
        theme = self._layout.theme
        if self._grid:
            line = self._curve(self._grid.at(*self._places), profile.line.coordinates(_FIELD_POINTS), snapshot)
            blend(panel, self._thick.cover(line), style.rgb(theme.particles))
            self._strokes.paint(picture[self._layout.box.slices], self._mark)
        else:
            near = profile.line.near(snapshot)
            dots = self._pixels(values[near], profile.line.of(snapshot)[near])
            blend(panel, self._dots.cover(dots), style.rgb(theme.particles))
        if profile.exact:
            exact = profile.exact(*profile.line.points(self._coordinates), snapshot.t)
            curve = self._curve(exact, self._coordinates, snapshot)
            blend(panel, self._line.cover(curve), style.rgb(theme.exact))

    def _curve(self, values, coordinates, snapshot):
        """Return points in the panel close to each other along a curve, which has gaps where bodies are."""
        half = getattr(self._scene, "half", self._scene)
        wet = self._quantity.profile.line.in_fluid(half.seen(snapshot), coordinates, snapshot.t)
        index = np.flatnonzero(wet & np.isfinite(values))
        pieces = np.split(index, np.flatnonzero(np.diff(index) > 1) + 1)
        return dense_lines(self._pixels(values[piece], coordinates[piece]) for piece in pieces if len(piece))

    def _pixels(self, values: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return columns and rows inside the panel, whose first pixel is on the axes' lines."""
        rect, (lowest, highest) = self._layout.profile, self._quantity.profile_range
        first, last = self._quantity.profile.line.ends
        column = (values - lowest) / (highest - lowest) * rect.width - 1.0
        column = np.clip(column, -rect.width, 2 * rect.width)  # an exact curve may go to infinity
        return column, (1.0 - (along - first) / (last - first)) * rect.height - 1.0

    def _mark_of(self, line):
        """Return points of a dashed line where the profile is taken."""
        ends = [np.broadcast_to(place, 2) for place in line.points(np.array(line.ends))]
        column, row = dense_line(self._layout.pixel_positions(*ends))
        dash = _DASH * self._layout.scale
        dashes = 0.5 * np.arange(len(column)) % (2 * dash) < dash
        return column[dashes], row[dashes]
