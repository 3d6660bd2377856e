"""Anti-aliased discs and lines, drawn into arrays by NumPy alone.

Positions are (columns, rows) in pixels from the top-left corner of a panel of ``shape`` (rows, columns); the
centre of the first pixel is at (0.5, 0.5). The coverage of a pixel whose centre is at distance d from the
centre of a disc of radius r is clip(r + 1/2 - d, 0, 1): a rim one pixel wide, and an area of pi (r^2 + 1/12).
"""

import math
from collections.abc import Iterator

import numpy as np

Points = tuple[np.ndarray, np.ndarray]

_CHUNK = 65536  # pixels touched at a time: work arrays that stay in the cache, about four times faster


class _Margined:
    """A panel of ``shape`` with a margin all around, wide enough for discs of ``radius`` that stick out."""

    def __init__(self, radius: float, shape: tuple[int, int]):
        self.radius, self.panel = radius, shape
        self.side = math.ceil(2.0 * radius + 1.0)  # pixels that a disc may touch along each direction
        self.shape = (shape[0] + 2 * self.side, shape[1] + 2 * self.side)

    def zeros(self) -> np.ndarray:
        """Return a flat array for ``stamps`` to add to."""
        return np.zeros(self.shape[0] * self.shape[1], dtype=np.float32)

    def inner(self, flat: np.ndarray) -> np.ndarray:
        """Return the panel without its margin, as a view."""
        cut = slice(self.side, -self.side)
        return flat.reshape(self.shape)[cut, cut]

    def touching(self, points: Points) -> np.ndarray:
        """Return which discs touch the panel; those at NaN or inf do not (comparisons with NaN are false)."""
        (column, row), reach, (rows, columns) = points, self.radius + 0.5, self.panel
        return (column > -reach) & (column < columns + reach) & (row > -reach) & (row < rows + reach)

    def stamps(self, points: Points) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Yield, for a slice of n ``points`` at a time, flat pixel indices and coverages (n, side, side)."""
        count = max(1, _CHUNK // self.side**2)
        for start in range(0, len(points[0]), count):
            part = slice(start, start + count)
            yield part, *self._stamp(points[0][part], points[1][part])

    def _stamp(self, column: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        step = np.arange(self.side)
        first_column, first_row = np.floor(column - self.radius), np.floor(row - self.radius)
        across = (first_column[:, None] + (step + 0.5) - column[:, None]).astype(np.float32)
        down = (first_row[:, None] + (step + 0.5) - row[:, None]).astype(np.float32)
        coverage = np.sqrt((down**2)[:, :, None] + (across**2)[:, None, :])
        np.subtract(np.float32(self.radius + 0.5), coverage, out=coverage)
        np.clip(coverage, 0.0, 1.0, out=coverage)
        corner = (first_row + self.side) * self.shape[1] + first_column + self.side
        offset = step[:, None] * self.shape[1] + step[None, :]
        return corner.astype(np.intp)[:, None, None] + offset, coverage


def paint_discs(
    points: Points, value: np.ndarray, *, radius: float, shape: tuple[int, int], periodic: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the coverage and the mean ``value`` of discs in every pixel, both float32 of ``shape``.

    Where discs meet, coverages add up to at most 1 and the value is the mean weighted by coverage, so the
    picture does not depend on which disc is drawn last. With ``periodic``, what leaves the panel at one
    side enters at the other; else it is cut off, as it always is at the top and bottom.
    """
    panel = _Margined(radius, shape)
    weight, total = panel.zeros(), panel.zeros()
    kept = panel.touching(points)
    value = value[kept].astype(np.float32)
    for part, index, coverage in panel.stamps((points[0][kept], points[1][kept])):
        np.add.at(weight, index.ravel(), coverage.ravel())
        coverage *= value[part, None, None]
        np.add.at(total, index.ravel(), coverage.ravel())
    if periodic:
        for flat in (weight, total):
            _wrap_margins(flat.reshape(panel.shape), panel.side, shape[1])
    weight, total = panel.inner(weight), panel.inner(total)
    return np.minimum(weight, 1.0), total / np.maximum(weight, np.float32(1e-12))


def _wrap_margins(padded: np.ndarray, margin: int, width: int) -> None:
    """Add both side margins to the columns one panel width away, in place."""
    overlap = min(margin, width)  # discs wider than the panel: only the nearest period is drawn
    padded[:, margin + width - overlap : margin + width] += padded[:, margin - overlap : margin]
    padded[:, margin : margin + overlap] += padded[:, margin + width : margin + width + overlap]


def cover(points: Points, radius: float, shape: tuple[int, int]) -> np.ndarray:
    """Return the largest coverage by any disc in every pixel, of ``shape``: for dots of a single colour."""
    panel = _Margined(radius, shape)
    mask = panel.zeros()
    kept = panel.touching(points)
    for _, index, coverage in panel.stamps((points[0][kept], points[1][kept])):
        np.maximum.at(mask, index.ravel(), coverage.ravel())
    return panel.inner(mask)


def dense_line(points: Points, step: float = 0.5) -> Points:
    """Return points every ``step`` pixels along a polyline: discs on them draw it with even thickness."""
    column, row = points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(column), np.diff(row)))])
    places = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / step) + 1))
    return np.interp(places, along, column), np.interp(places, along, row)


def blend(panel: np.ndarray, coverage: np.ndarray, colour: np.ndarray) -> None:
    """Lay ``colour`` (3,), 0 to 255, over an RGB ``panel`` (rows, columns, 3) of uint8, in place."""
    rows, columns = np.nonzero(coverage)  # a line or dots touch few pixels: leave the others alone
    weight = coverage[rows, columns, None]
    below = panel[rows, columns]
    panel[rows, columns] = (below + weight * (colour - below) + 0.5).astype(np.uint8)
