"""The panel of a movie frame in which numbers of the run grow with time: velocities, forces, torques, energy."""

import numpy as np

from tisph.report import style
from tisph.report.labels import number
from tisph.report.layout import Layout
from tisph.report.quantities import Ends, Extremes, with_margin
from tisph.report.raster import Discs, blend, dense_line
from tisph.scenes._views import TimeSeries

_NUMBERS = 3  # that are drawn: as many as have colours
_EXACT_TIMES = 200


class TimePanel:
    """The first numbers of ``series`` over a run to time ``end``, as lines that end at the time of each frame.

    ``ends`` is their range in the frames, None where the exact values give it. ``levels`` (numbers,): what they come to
    in the steady state, where no exact values are known and those are; NaN for those that are not.
    """

    def __init__(self, scene, layout: Layout, series: TimeSeries, end: float, ends: Ends | None = None):
        self.series, self.times = series, (scene.start_time, end)
        self.colours = layout.theme.series[: len(series.columns)]
        self.exact_times = np.linspace(*self.times, _EXACT_TIMES)
        exact = exact_values(series, self.exact_times)
        self.exact = None if exact is None else exact[:, :_NUMBERS]
        levels = np.ravel(series.levels if exact is None else ())[:_NUMBERS]
        self.levels = _scaled(series, levels) if len(levels) else levels
        within = [*(ends or self._exact_ends()), *self.levels[np.isfinite(self.levels)]]
        self.range = with_margin((min(within), max(within)), 1.0)
        self._layout, self._seen = layout, {}
        self._pen = Discs(max(0.6, 1.3 * layout.scale), layout.series.inner.shape)

    @property
    def labels(self) -> list[str]:
        """Names of the numbers."""
        pairs = self.series.labels[:_NUMBERS]
        return [name if place is None else f"{name} = {number(place, 3)}" for name, place in pairs]

    def paint(self, picture: np.ndarray, t: float, values: np.ndarray) -> None:
        """Draw the lines up to time ``t``, at which the numbers are ``values``."""
        self._seen[t] = values[:_NUMBERS]
        times = np.array(sorted(time for time in self._seen if time <= t))
        seen = np.array([self._seen[time] for time in times])
        panel = picture[self._layout.series.inner.slices]
        for values, colour in zip(seen.T, self.colours, strict=True):
            known = np.isfinite(values)
            if known.any():
                line = dense_line(self._pixels(times[known], values[known]))
                blend(panel, self._pen.cover(line), style.rgb(colour))

    def _pixels(self, times, values):
        (first, last), (low, high), rect = self.times, self.range, self._layout.series
        row = (high - values) / (high - low) * rect.height - 1.0
        return (times - first) / (last - first) * rect.width - 1.0, np.clip(row, -rect.height, 2 * rect.height)

    def _exact_ends(self):
        extremes = Extremes(whole=True)
        for values in self.exact:
            extremes.add(values)
        return extremes.ends


def exact_values(series: TimeSeries, times: np.ndarray) -> np.ndarray | None:
    """Return the references (times, numbers) as they are drawn, None without any."""
    exact = series.exact(times)
    return None if exact is None else _scaled(series, exact)


def measured(series: TimeSeries, snapshot) -> np.ndarray:
    """Return the numbers of a snapshot as they are drawn."""
    return _scaled(series, series.measure(snapshot))


def _scaled(series, values):
    return values / np.array(series.sizes)[: np.shape(values)[-1]] if series.sizes else values
