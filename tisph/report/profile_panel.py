"""The live profile of a movie frame, and the line in the fluid along which it is taken."""

import numpy as np

from tisph.report import style
from tisph.report.field import FieldGrid
from tisph.report.layout import Layout
from tisph.report.quantities import Quantity
from tisph.report.raster import Discs, blend, dense_line
from tisph.snapshot import Snapshot

_CURVE_POINTS = 600  # about two a pixel row at the usual size
_FIELD_POINTS = 200
_DASH = 7.0  # pixels in a frame of 1280 x 640, and as long a gap


class ProfilePanel:
    """The profile of ``quantity``: particles as dots or, on the ``grid`` of a field, a line; and the exact curve."""

    def __init__(self, scene, layout: Layout, quantity: Quantity, grid: FieldGrid | None):
        self._scene, self._layout, self._quantity, self._grid = scene, layout, quantity, grid
        line, scale, rect = quantity.profile.line, layout.scale, layout.profile
        inside = rect.height - 2, rect.width - 2  # the axes' lines are on the border
        self._dots, self._line = Discs(3.0 * scale, inside), Discs(max(0.5, 0.9 * scale), inside)
        self._thick = Discs(max(1.0, 2.2 * scale), inside)
        self._coordinates = line.coordinates(_CURVE_POINTS)
        self._places = [np.broadcast_to(place, _FIELD_POINTS) for place in line.points(line.coordinates(_FIELD_POINTS))]
        self._mark = self._mark_of(line) if grid else None

    def paint(self, picture: np.ndarray, snapshot: Snapshot, values: np.ndarray) -> None:
        """Draw the profile of ``values`` (particles,) and, in the fluid, its place."""
        panel, profile = picture[self._layout.profile.slices][1:-1, 1:-1], self._quantity.profile
        theme = self._layout.theme
        if self._grid:
            blend(panel, self._thick.cover(self._field_line(snapshot, values)), style.rgb(theme.particles))
            for cover, ink in self._mark:
                blend(picture[self._layout.box.slices], cover, style.rgb(ink))
        else:
            near = profile.line.near(snapshot)
            dots = self._pixels(values[near], profile.line.of(snapshot)[near])
            blend(panel, self._dots.cover(dots), style.rgb(theme.particles))
        if profile.exact:
            exact = profile.exact(*profile.line.points(self._coordinates), snapshot.t)
            curve = self._curve(exact, self._coordinates, snapshot.t)
            blend(panel, self._line.cover(curve), style.rgb(theme.exact))

    def _field_line(self, snapshot, values):
        """Return points of the line of the field."""
        self._grid.fit(snapshot.x, snapshot.y, values)
        return self._curve(
            self._grid.at(*self._places), self._quantity.profile.line.coordinates(_FIELD_POINTS), snapshot.t
        )

    def _curve(self, values, coordinates, t):
        """Return points in the panel close to each other along a curve, which has gaps where bodies are."""
        wet = self._quantity.profile.line.in_fluid(self._scene, coordinates, t)
        index = np.flatnonzero(wet & np.isfinite(values))
        pieces = np.split(index, np.flatnonzero(np.diff(index) > 1) + 1)
        lines = [dense_line(self._pixels(values[piece], coordinates[piece])) for piece in pieces if len(piece)]
        return tuple(np.concatenate(part) for part in zip(*lines, strict=True)) if lines else (np.empty(0), np.empty(0))

    def _pixels(self, values: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return columns and rows inside the panel, whose first pixel is on the axes' lines."""
        rect, (lowest, highest) = self._layout.profile, self._quantity.profile_range
        first, last = self._quantity.profile.line.ends
        column = (values - lowest) / (highest - lowest) * rect.width - 1.0
        column = np.clip(column, -rect.width, 2 * rect.width)  # an exact curve may go to infinity
        return column, (1.0 - (along - first) / (last - first)) * rect.height - 1.0

    def _mark_of(self, line):
        """Return coverages and colours of a dashed line where the profile is taken."""
        shape, scale = (self._layout.box.height, self._layout.box.width), self._layout.scale
        ends = [np.broadcast_to(place, 2) for place in line.points(np.array(line.ends))]
        column, row = dense_line(self._layout.pixel_positions(*ends))
        along = 0.5 * np.arange(len(column))
        dashes = along % (2 * _DASH * scale) < _DASH * scale
        inks = (1.8, "#ffffff"), (0.9, style.TEXT)
        return [(Discs(wide * scale, shape).cover((column[dashes], row[dashes])), ink) for wide, ink in inks]
