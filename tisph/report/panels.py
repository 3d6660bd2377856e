"""Panels of a movie frame: numbers of the run that grow with time, and the live profile with its line in the fluid."""

import math
from typing import Any

import numpy as np

from tisph.measures.steadiness import Followed, steadiness
from tisph.report import style
from tisph.report.field import GradedGrid
from tisph.report.labels import number
from tisph.report.layout import Layout, Rect
from tisph.report.overlays import Strokes
from tisph.report.quantities import Ends, Extremes, Quantity, with_margin
from tisph.report.raster import Discs, Points, blend, dense_line, dense_lines
from tisph.report.text import paint_text, text_width
from tisph.scenes._scene import Scene
from tisph.scenes._views import Line, TimeSeries
from tisph.snapshot import Snapshot

NUMBERS = 3  # that are drawn: as many as have colours
_EXACT_TIMES = 200


class TimePanel:
    """The first numbers of ``series`` over a run to time ``end``, as lines that end at the time of each frame.

    ``ends`` is their range in the frames, None where the exact values give it. ``levels`` (numbers,): values in the
    steady state, used where no exact values are known; NaN where unknown. ``settled`` (numbers,): values at the end of
    a run that is steady then, where no others are known; ``known``: which numbers have values in the run, see ``know``.
    The first time of the series' ``event`` is marked.
    """

    def __init__(self, scene: Scene, layout: Layout, series: TimeSeries, end: float, ends: Ends | None = None):
        self.series, self.times = series, (scene.start_time, end)
        self.colours = layout.theme.series[: len(series.columns)]
        self.exact_times = np.linspace(*self.times, _EXACT_TIMES)
        exact = exact_values(series, self.exact_times)
        self.exact = None if exact is None else exact[:, :NUMBERS]
        levels = np.ravel(series.levels if exact is None else ())[:NUMBERS]
        self.levels = _scaled(series, levels) if len(levels) else levels
        self.settled, self.known = np.empty(0), np.ones(len(series.columns[:NUMBERS]), dtype=bool)
        self._scene = scene
        shown = [*(ends or ()), *(() if exact is None and ends else self._exact_ends())]
        within = [*shown, *self.levels[np.isfinite(self.levels)]]
        if series.unit in ("energy", "velocity", "planar_flow_rate"):  # sizes are the content, not changes alone
            within.append(0.0)
        low, high = min(within), max(within)
        least = scene.spacing if series.unit == "length" else 0.0  # less is no motion that can be seen
        wider = max(0.0, 0.5 * (least - (high - low)))
        self.range = with_margin((low - wider, high + wider), 1.0)
        self._layout = layout
        self._seen: dict[float, np.ndarray] = {}
        self._pen = Discs(max(0.6, 1.3 * layout.scale), layout.series.inner.shape)

    def know(self, times: np.ndarray, values: np.ndarray) -> None:
        """Take the numbers (n, numbers) at the ``times`` (n,) of all frames, before the first is painted."""
        self.known = np.isfinite(values).any(axis=0)
        if self.exact is None and not np.isfinite(self.levels).any() and self.steady(times, values):
            self.settled = values[-1]

    def steady(self, times: np.ndarray, values: np.ndarray) -> bool:
        """Return whether the flow is steady at the last of ``times`` (n,), by numbers (n, numbers) that are judged."""
        sizes, names = self._scene.time_series().judged_sizes, self.series.columns[:NUMBERS]
        judged = set(names) <= set(sizes)
        record = Followed(times, values, {name: sizes[name] for name in names}) if judged else None
        return steadiness(self._scene, float(times[-1]), record).steady

    @property
    def labels(self) -> list[str]:
        """Names of the numbers."""
        pairs: Any = self.series.labels[:NUMBERS]
        return [name if place is None else f"{name} = {number(place, 3)}" for name, place in pairs]

    def paint(self, picture: np.ndarray, t: float, values: np.ndarray) -> None:
        """Draw the lines up to time ``t``, at which the numbers are ``values``."""
        self._seen[t] = values[:NUMBERS]
        times, seen = self.history(t)
        panel = picture[self._layout.series.inner.slices]
        self._mark_event(picture, times, seen)
        if self.exact is None and not np.isfinite(seen).any():
            paint_text(
                picture, self._layout.series, "none yet", self._layout.pixels(14), "middle", self._layout.theme.muted
            )
        for values, colour in zip(seen.T, self.colours, strict=True):
            known = np.isfinite(values)
            if known.any():
                line = dense_line(self._pixels(times[known], values[known]))
                blend(panel, self._pen.cover(line), style.rgb(colour))

    def _mark_event(self, picture: np.ndarray, times: np.ndarray, seen: np.ndarray) -> None:
        """Draw a line and words at the first of ``times`` (n,) whose numbers ``seen`` (n, numbers) show the event."""
        found = [t for t, values in zip(times, seen, strict=True) if self.series.event and self.series.event[1](values)]
        if not found or not self.series.event:
            return
        rect, px = self._layout.series.inner, self._layout.pixels
        column = rect.left + int(self._pixels(np.array(found[:1]), np.zeros(1))[0][0])
        line = picture[rect.top : rect.bottom, column : column + px(1)]
        line[:] = style.rgb(self._layout.theme.muted)
        words, left = f"{self.series.event[0]}: t = {number(found[0], 3)} {self._scene.units.time}", column + px(6)
        width = math.ceil(text_width(words, px(13)))
        left = left if left + width < rect.right else column - px(6) - width
        paint_text(picture, Rect(left, rect.top + px(4), width, px(18)), words, px(13), "left", self._layout.theme.text)

    def history(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return times (n,) and numbers (n, numbers) of the frames up to time ``t``."""
        times = np.array(sorted(time for time in self._seen if time <= t))
        return times, np.array([self._seen[time] for time in times])

    def _pixels(self, times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (first, last), (low, high), rect = self.times, self.range, self._layout.series
        row = (high - values) / (high - low) * rect.height - 1.0
        return (times - first) / (last - first) * rect.width - 1.0, np.clip(row, -rect.height, 2 * rect.height)

    def _exact_ends(self) -> Ends:
        extremes = Extremes()
        for values in () if self.exact is None else self.exact:
            extremes.add(values)
        return extremes.ends


def exact_values(series: TimeSeries, times: np.ndarray) -> np.ndarray | None:
    """Return the references (times, numbers) as they are drawn, None without any."""
    exact = series.exact(times)
    return None if exact is None else _scaled(series, exact)


def measured(series: TimeSeries, snapshot: Snapshot) -> np.ndarray:
    """Return the numbers of a snapshot as they are drawn."""
    return _scaled(series, series.measure(snapshot))


def _scaled(series: TimeSeries, values: np.ndarray) -> np.ndarray:
    return values / np.array(series.sizes)[: np.shape(values)[-1]] if series.sizes else values


_CURVE_POINTS = 600  # about two a pixel row at the usual size
_FIELD_POINTS = 200
_DASH = 7.0  # pixels in a frame of 1280 x 640, and as long a gap
_DOTS = 400  # particles drawn: more only hide each other
_WALL_DOT = 4.5  # pixels in a frame of 1280 x 640: radius of the dot at the velocity of a wall
_PALE = 0.35  # cover of the particles behind their profile


class ProfilePanel:
    """The profile of ``quantity``: a line, the particles as pale dots behind it, and the exact curve.

    The ``grid`` is fitted to the values of the profile (``report/field.py``). Walls along which the fluid slips have a
    dot at their velocity. In the fluid a dashed line is where the profile is taken, if ``marked``.
    """

    def __init__(self, scene: Scene, layout: Layout, quantity: Quantity, grid: GradedGrid, marked: bool):
        self._scene, self._layout, self._quantity, self._grid = scene, layout, quantity, grid
        self._marked, self._wall_dot = marked, Discs(_WALL_DOT * layout.scale, layout.profile.inner.shape)
        line, scale, inside = quantity.profile.line, layout.scale, layout.profile.inner.shape
        self._dots, self._line = Discs(3.0 * scale, inside), Discs(max(0.5, 0.9 * scale), inside)
        self._thick = Discs(max(1.0, 2.2 * scale), inside)
        self._coordinates = line.coordinates(_CURVE_POINTS)
        self._places = [np.broadcast_to(place, _FIELD_POINTS) for place in line.points(line.coordinates(_FIELD_POINTS))]
        self._strokes, self._mark = Strokes(scale, layout.box.shape), self._mark_of(line)

    def paint(self, picture: np.ndarray, snapshot: Snapshot, values: np.ndarray, has_reference: bool) -> None:
        """Draw the profile of ``values`` (particles,), its reference if it has one now and, in the fluid, its place."""
        panel, profile = picture[self._layout.profile.inner.slices], self._quantity.profile
        theme = self._layout.theme
        near = np.arange(len(values))[profile.line.near(snapshot)]
        near = near[style.evenly_chosen(len(near), _DOTS)]
        dots = self._pixels(values[near], profile.line.of(snapshot)[near])
        blend(panel, self._dots.cover(dots) * np.float32(_PALE), style.rgb(theme.particles))
        line = self._curve(self._values(snapshot), profile.line.coordinates(_FIELD_POINTS), snapshot)
        blend(panel, self._thick.cover(line), style.rgb(theme.particles))
        if self._marked:
            self._strokes.paint(picture[self._layout.box.slices], self._mark)
        if profile.exact and has_reference:
            exact = profile.exact(*profile.line.points(self._coordinates), snapshot.t)
            curve = self._curve(exact, self._coordinates, snapshot)
            blend(panel, self._line.cover(curve), style.rgb(theme.exact))
        column, row = self._pixels(*profile.of_slip_walls(self._scene.slip_wall_velocity, snapshot.t))
        row = np.clip(row, _WALL_DOT * self._layout.scale, panel.shape[0] - _WALL_DOT * self._layout.scale)
        blend(panel, self._wall_dot.cover((column, row)), style.rgb(theme.wall_moving))

    def _values(self, snapshot: Snapshot) -> np.ndarray:
        """Return the quantity (n,) along the line: by the field, or by fits if the line is not in the shown part."""
        line, low, high = self._quantity.profile.line, self._layout.low[0], self._layout.high[0]
        if low <= min(line.points(line.ends[0])[0], line.points(line.ends[1])[0]) <= high:
            return self._grid.at(*self._places)
        return self._quantity.profile.interpolated(self._scene, snapshot, line.coordinates(_FIELD_POINTS))

    def _curve(self, values: np.ndarray, coordinates: np.ndarray, snapshot: Snapshot) -> Points:
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

    def _mark_of(self, line: Line) -> Points:
        """Return points of a dashed line where the profile is taken."""
        ends = [np.broadcast_to(place, 2) for place in line.points(np.array(line.ends))]
        column, row = dense_line(self._layout.pixel_positions(*ends))
        dash = _DASH * self._layout.scale
        dashes = 0.5 * np.arange(len(column)) % (2 * dash) < dash
        return column[dashes], row[dashes]
