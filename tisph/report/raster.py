"""Anti-aliased discs, lines and areas, drawn into arrays by NumPy alone.

Positions are (columns, rows) in pixels from the top-left corner of a panel of ``shape`` (rows, columns); the
centre of the first pixel is at (0.5, 0.5). The coverage of a pixel whose centre is at distance d from the
centre of a disc of radius r is clip(r + 1/2 - d, 0, 1): a rim one pixel wide, and an area of pi (r^2 + 1/12).
A disc is drawn at the nearest of 16 x 16 places in its pixel, and coverages are whole parts of 255.
"""

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

Points = tuple[np.ndarray, np.ndarray]
Part = tuple[slice, np.ndarray, np.ndarray]

PLACES = 16  # of a disc in a pixel, along each direction
LEVELS = 255  # of coverage
STRIPS = 16  # of a pixel row; an area covers a strip up to the point where its outline crosses the middle line
SHARES = 4095  # levels of the value under a disc
VALUE_BITS = 22  # coverages and values times coverage are added up in one number: above and below this bit
_SUM_BITS = 32  # of that number, or less: room for four discs on each other
_SHADE_BITS = 20  # the highest of these bits, the index of the table of shades
_COARSEST = 7  # times that coverages may be halved
_CHUNK = 65536  # pixels touched at a time: work arrays that stay in the cache, about three times faster
_BAND = 32  # pixel rows at a time, likewise


class Discs:
    """Discs of one ``radius`` in a panel of ``shape``, with a margin all around for those that stick out.

    For discs of several sizes ``radius`` is an array (sizes,).
    """

    def __init__(self, radius: float | np.ndarray, shape: tuple[int, int]):
        reach = np.reshape(radius, (-1, 1, 1)) + 0.5
        radius = float(np.max(radius))
        self.panel, self._reach = shape, radius + 0.5
        self._side = math.ceil(2.0 * radius + 1.0) + 1  # pixels that a disc may touch along each direction
        self._margined = (shape[0] + 2 * self._side, shape[1] + 2 * self._side)
        self._before = math.ceil(radius + 0.5)  # pixels from the first touched pixel to the pixel of the centre
        places = (np.arange(PLACES) + 0.5) / PLACES + self._before
        distance = np.square(np.arange(self._side) + 0.5 - places[:, None])
        distance = np.sqrt(distance[:, None, :, None] + distance[None, :, None, :]).reshape(PLACES**2, -1)
        coverage = np.rint(LEVELS * np.clip(reach - distance, 0.0, 1.0)).reshape(-1, self._side**2)
        touched = coverage.any(axis=0)
        step = np.arange(self._side)
        self._offsets = (step[:, None] * self._margined[1] + step[None, :]).ravel()[touched]
        self._stamps = coverage[:, touched].astype(np.int64)
        self._count = max(1, _CHUNK // len(self._offsets))

    def sums(
        self, points: Points, value: np.ndarray, size: np.ndarray, *, periodic: tuple[bool, bool]
    ) -> tuple[np.ndarray, int]:
        """Return a whole number for every pixel of the panel, and the ``full`` coverage of one that a disc covers.

        ``value`` (discs,) from 0 to 1, ``size`` (discs,): indices of radii. The number is 2^VALUE_BITS * (sum of
        coverages) + (sum of coverages * values in SHARES). The mean value does not depend on the order of the discs.
        Full coverage is LEVELS; where too many discs meet for the bits of the sum, all coverages of the picture are
        coarser, and sums of many hundreds of discs are cut off. Along ``periodic`` directions (columns, rows) discs
        that leave the panel at one side enter at the other; else they are cut off.
        """
        touching = self._touching(points)
        kept, stamp = (points[0][touching], points[1][touching]), PLACES**2 * size[touching]
        weight = np.rint(SHARES * value[touching]).astype(np.int64)
        weight += 1 << VALUE_BITS
        total = self._added(kept, stamp, weight, self._stamps, periodic)
        coarser = min(int(total.max() >> _SUM_BITS).bit_length(), _COARSEST)
        if coarser:
            total = self._added(kept, stamp, weight, (self._stamps + (1 << coarser - 1)) >> coarser, periodic)
            np.minimum(total, (1 << _SUM_BITS) - 1, out=total)
        return total, (LEVELS + (1 << coarser >> 1)) >> coarser

    def _added(
        self, points: Points, first: np.ndarray, weight: np.ndarray, stamps: np.ndarray, periodic: tuple[bool, bool]
    ) -> np.ndarray:
        """Return the sum of ``stamps`` times ``weight`` in every pixel of the panel, int64."""
        flat = np.zeros(self._margined[0] * self._margined[1], dtype=np.int64)
        for part, index, coverage in self._pixels(points, stamps, first):
            coverage *= weight[part, None]
            np.add.at(flat, index.ravel(), coverage.ravel())
        panel = flat.reshape(self._margined)
        for along, wide, wraps in zip((panel, panel.T), reversed(self.panel), periodic, strict=True):
            if wraps:
                _wrap_margins(along, self._side, wide)
        return self._inner(flat)

    def cover(self, points: Points) -> np.ndarray:
        """Return the largest coverage (0 to 255) by any disc in every pixel, uint8: for dots of a single colour."""
        kept = self._touching(points)
        flat = np.zeros(self._margined[0] * self._margined[1], dtype=np.uint8)
        for _, index, coverage in self._pixels((points[0][kept], points[1][kept]), self._stamps, once=True):
            np.maximum.at(flat, index.ravel(), coverage.astype(np.uint8).ravel())
        return self._inner(flat)

    def _touching(self, points: Points) -> np.ndarray:
        """Return which discs touch the panel; those at NaN or inf do not (comparisons with NaN are false)."""
        (column, row), reach, (rows, columns) = points, self._reach, self.panel
        return (column > -reach) & (column < columns + reach) & (row > -reach) & (row < rows + reach)

    def _pixels(self, points: Points, stamps: np.ndarray, first: Any = 0, once: bool = False) -> Iterator[Part]:
        """Yield, for a slice of the discs at a time, flat pixel indices and coverages (discs, pixels of a disc).

        ``first`` (discs,): the first of the ``stamps`` of their sizes. With ``once`` discs of one size at the same
        place count as one.
        """
        column, row = (np.floor(PLACES * values).astype(np.intp) for values in points)
        place = row % PLACES * PLACES + column % PLACES + first
        corner = (row // PLACES + self._side - self._before) * self._margined[1]
        corner += column // PLACES + self._side - self._before
        if once:
            both = np.sort(corner * PLACES**2 + place)  # ``np.unique`` of NumPy 2.4 takes fourteen times as long
            corner, place = np.divmod(both[np.diff(both, prepend=-1) > 0], PLACES**2)
        for start in range(0, len(corner), self._count):
            part = slice(start, start + self._count)
            yield part, corner[part, None] + self._offsets, np.take(stamps, place[part], axis=0)

    def _inner(self, flat: np.ndarray) -> np.ndarray:
        """Return the panel without its margin, as a view."""
        cut = slice(self._side, -self._side)
        return flat.reshape(self._margined)[cut, cut]


class Shades:
    """Colours of pixels with discs of ``colours``, RGB (values, 3) from 0 to 1, on a ``ground`` (3,)."""

    def __init__(self, colours: np.ndarray, ground: np.ndarray):
        self._colours, self._ground = np.asarray(colours), np.asarray(ground)
        self._table = lru_cache(maxsize=2)(self._of_sums)

    def fill(self, panel: np.ndarray, total: np.ndarray, full: int) -> None:
        """Write the colours of ``Discs.sums`` into ``panel`` (rows, columns, 4): a look-up instead of blending."""
        table, pixels = self._table(full), panel.view(np.uint32)[:, :, 0]
        for top in range(0, len(panel), _BAND):
            rows = slice(top, top + _BAND)
            pixels[rows] = np.take(table, total[rows] >> (_SUM_BITS - _SHADE_BITS))

    def _of_sums(self, full: int) -> np.ndarray:
        """Return RGB and an idle byte for the highest bits of sums, all four as one number, (2^_SHADE_BITS,)."""
        cover = np.linspace(0.0, 1.0, full + 1)[:, None, None]
        mixed = np.full((full + 1, len(self._colours), 4), 255, dtype=np.uint8)
        mixed[:, :, :3] = np.rint(255.0 * (self._ground + cover * (self._colours - self._ground)))
        bits = VALUE_BITS - (_SUM_BITS - _SHADE_BITS)
        coverage = np.arange(1 << _SHADE_BITS - bits)
        most = np.float32(len(self._colours) - 1)
        scale = most * np.float32(2.0 ** (VALUE_BITS - bits) / SHARES) / np.maximum(coverage, 1).astype(np.float32)
        entry = np.minimum(np.outer(scale, np.arange(1 << bits, dtype=np.float32) + np.float32(0.5)), most)
        entry = np.rint(entry).astype(np.intp) + len(self._colours) * np.minimum(coverage, full)[:, None]
        return np.take(mixed.view(np.uint32).ravel(), entry.ravel())


def _wrap_margins(padded: np.ndarray, margin: int, width: int) -> None:
    """Add both side margins to the columns one panel width away, in place."""
    overlap = min(margin, width)  # discs wider than the panel: only the nearest period is drawn
    padded[:, margin + width - overlap : margin + width] += padded[:, margin - overlap : margin]
    padded[:, margin : margin + overlap] += padded[:, margin + width : margin + width + overlap]


def dense_line(points: Points, step: float = 0.5) -> Points:
    """Return points every ``step`` pixels along a polyline: discs on them draw it with even thickness."""
    column, row = points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(column), np.diff(row)))])
    places = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / step) + 1))
    return np.interp(places, along, column), np.interp(places, along, row)


def dense_lines(lines: Iterable[Points]) -> Points:
    """Return the points of ``dense_line`` along several polylines; none without any."""
    dense = [dense_line(line) for line in lines]
    if not dense:
        return np.empty(0), np.empty(0)
    return np.concatenate([column for column, _ in dense]), np.concatenate([row for _, row in dense])


def filled(points: Points, shape: tuple[int, int]) -> np.ndarray:
    """Return the coverage (0 to 255) of every pixel by the area within a polygon that does not cross itself, uint8.

    Its corners are ``points``, in order; the panel is of ``shape`` (rows, columns), and the polygon may go beyond it.
    Of many polygons (polygons, corners) all are covered, if they are run through the same way.
    """
    area = np.zeros(shape, dtype=np.uint8)
    left, right, top, bottom = (  # the pixels around it
        int(np.clip(end, 0, size))
        for axis, size in ((points[0], shape[1]), (points[1], shape[0]))
        for end in (np.floor(axis.min(initial=size)), np.ceil(axis.max(initial=0)))
    )
    rows, columns = bottom - top, right - left
    if rows <= 0 or columns <= 0:
        return area
    x, y = points[0], STRIPS * points[1] - 0.5  # strip k has its middle at y = k
    x, y, ahead_x, ahead_y = (part.ravel() for part in (x, y, np.roll(x, -1, axis=-1), np.roll(y, -1, axis=-1)))
    ends = np.minimum(y, ahead_y), np.maximum(y, ahead_y)
    first, last = (np.clip(np.ceil(end), STRIPS * top, STRIPS * bottom).astype(np.intp) for end in ends)
    count = last - first
    edge = np.repeat(np.arange(len(x)), count)
    strip = np.arange(len(edge)) + np.repeat(first - np.cumsum(count) + count, count)
    slope = (ahead_x[edge] - x[edge]) / (ahead_y[edge] - y[edge])
    column = np.clip(x[edge] + slope * (strip - y[edge]), left, right)
    pixel = np.floor(column).astype(np.intp)
    flat = (strip // STRIPS - top) * (columns + 2) + pixel - left  # two more columns take the part beyond the last one
    side, part = np.where(ahead_y > y, 1.0, -1.0)[edge], column - pixel
    steps = (
        np.bincount(flat + k, side * weight, minlength=rows * (columns + 2))
        for k, weight in enumerate((1 - part, part))
    )
    covered = np.abs(np.cumsum(np.asarray(sum(steps)).reshape(rows, columns + 2), axis=1))[:, :columns]
    area[top:bottom, left:right] = np.rint(LEVELS / STRIPS * np.minimum(covered, STRIPS))
    return area


def blend(panel: np.ndarray, coverage: np.ndarray, colour: np.ndarray) -> None:
    """Lay ``colour`` (3,), 0 to 255, over an RGB ``panel`` (rows, columns, 3) of uint8, by ``coverage`` of 0 to 255."""
    touched = np.flatnonzero(coverage > 0)  # a line or dots touch few pixels: leave the others alone
    rows, columns = np.divmod(touched, coverage.shape[1])  # ``nonzero`` in two dimensions takes eight times as long
    weight = coverage[rows, columns, None] * np.float32(1.0 / LEVELS)
    below = panel[rows, columns]
    panel[rows, columns] = (below + weight * (colour - below) + np.float32(0.5)).astype(np.uint8)
