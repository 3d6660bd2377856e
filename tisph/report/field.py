"""The fluid of a movie frame: a continuous field, particles as discs, or both; dye.

The field comes from local linear fits on a grid, blended from node to node.

At each node X of a grid about one particle spacing wide, a + b . (x - X) is fitted to the values of the particles
around it by weighted least squares; the field at a point is the mean of the fits of the nodes around it. Both weights
are products of B-splines, cubic for the particles (the 4 x 4 nodes nearest to each) and quadratic for the blend. Where
the values are linear, so is the field, wherever the particles are and up to a wall; else its error falls with the
square of the spacing. Nodes without particles have no part in it: walls and bodies need not be known.

Where the spacing varies there are several grids, each with half the pitch of the one before. From grid to grid the
field goes over where particles are as wide as between one and two pitches of the finer one.

Source: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; blended as partition of unity, J. M. Melenk and
I. Babuska, Comput. Methods Appl. Mech. Engrg. 139 (1996) 289-314.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tisph.report import style
from tisph.report.layout import Layout, open_ends
from tisph.report.quantities import Ends, Quantity
from tisph.report.raster import Discs, Shades, blend
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot

_STRIPES = 8  # along x
_SQUARES = 6  # along the shorter side
_BLOB = 0.25, 0.5, 0.15  # where the middle of a blob is in the box, and its radius over the shorter side


class Dye:
    """The ``pattern`` of a movie of ``scene``: stripes across x, a checkerboard, or a round blob.

    Fluid that enters through an inlet is in bands across it, or behind a blob in one band: streaklines. Where the
    spacing varies, particles are also put in between others: those that are too far from open ends to come from there.
    """

    def __init__(self, scene: Scene, pattern: str):
        self._low, self._size = np.array(scene.origin), np.array(scene.extent, dtype=float)
        self._pattern, self._share = pattern, getattr(self, f"_{pattern}")
        self._scene, self._time = scene, 0.0
        self._colours: np.ndarray | None = None
        self._passages: np.ndarray | None = None

    def of(self, snapshot: Snapshot) -> np.ndarray:
        """Return 0 or 1 for each particle, by where it was in the first snapshot for which this was called.

        A particle that has entered since an earlier call gets its colour by its height in this snapshot, or from the
        nearest other one if it was put in between.
        """
        places = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        places = np.where(np.isfinite(places), places, 0.0) - self._low
        if self._colours is None:
            self._colours = self._share(places)
        elif snapshot.passages is not None and self._passages is not None:
            entered, known = np.ones(len(places), dtype=bool), min(len(places), len(self._passages))
            entered[:known] = snapshot.passages[:known] != self._passages[:known]
            colours = self._band(places[:, 1])
            colours[~entered] = self._colours[: len(places)][~entered[:known]]
            if snapshot.area is not None and not entered.all():
                from scipy.spatial import cKDTree

                between = entered & ~self._at_ends(np.stack([snapshot.x, snapshot.y], axis=1), snapshot.t)
                colours[between] = colours[~entered][cKDTree(places[~entered]).query(places[between])[1]]
            self._colours = colours
        self._passages, self._time = snapshot.passages, snapshot.t
        return self._colours

    def _at_ends(self, places: np.ndarray, t: float) -> np.ndarray:
        """Return whether fluid at ``places`` (n, 2) may have come through an open end since the last call."""
        near, scene = np.zeros(len(places), dtype=bool), self._scene
        for end in (body for body in scene.bodies if not body.solid):
            near |= end.nearest(places, t).distance < scene.spacing + scene.peak_velocity * (t - self._time)
        return near

    def _stripes(self, places: np.ndarray) -> np.ndarray:
        return np.floor(_STRIPES * places[:, 0] / self._size[0]) % 2

    def _checkerboard(self, places: np.ndarray) -> np.ndarray:
        return np.floor(_SQUARES * places / self._size.min()).sum(axis=1) % 2

    def _blob(self, places: np.ndarray) -> np.ndarray:
        aim = np.array(_BLOB[:2]) * self._size
        middle = places[np.argmin(np.linalg.norm(places - aim, axis=1))]  # in the fluid, wherever bodies are
        return (np.linalg.norm(places - middle, axis=1) < _BLOB[2] * self._size.min()).astype(float)

    def _band(self, height: np.ndarray) -> np.ndarray:
        if self._pattern == "blob":
            return (np.abs(height - _BLOB[1] * self._size[1]) < _BLOB[2] * self._size.min()).astype(float)
        return np.floor(_SQUARES * height / self._size.min()) % 2


_MOST = 40_000  # nodes
_MARGIN = 4  # nodes beyond each side
_BEYOND = 3.0  # nodes beyond each side up to which particles count
_LEAST = 0.02  # sum of weights of a node, 1 where particles are everywhere: below it there is nothing to fit
_EVEN = 5e-4  # added to the second moments, which are 1/3: a few particles on a line leave no slope undetermined


class FieldGrid:
    """A grid of one picture: ``fit`` takes values, then ``image`` has the field of the first, ``at`` of the last.

    ``low`` and ``high`` are corners of the shown part of the box, ``shape`` (rows, columns) its pixels, the first row
    at the top.
    Along ``periodic`` axes, all of whose period is shown, particles near one side count at the other, too.
    """

    def __init__(
        self,
        low: Sequence[float],
        high: Sequence[float],
        shape: tuple[int, int],
        spacing: float,
        periodic: tuple[bool, bool],
    ):
        from scipy.sparse import csr_array

        self._low, self._periodic = np.asarray(low, dtype=float), periodic
        self._size = np.subtract(high, low)
        pitch = max(spacing, np.sqrt(np.prod(self._size) / _MOST))
        self._count = np.maximum(1, np.rint(self._size / pitch)).astype(int) + 1 + 2 * _MARGIN  # nodes along x and y
        self._pitch, self.pitch = self._size / (self._count - 1 - 2 * _MARGIN), pitch
        rows, columns = shape
        places = (np.arange(columns) + 0.5) / columns, 1.0 - (np.arange(rows) + 0.5) / rows
        self._spread = []
        for axis, place in enumerate(places):
            first, weight, offset = _blend(self._nodes(self._low[axis] + place * self._size[axis], axis))
            index = first[:, None] + np.arange(3)
            ends = np.arange(0, index.size + 1, 3)
            self._spread.append(
                [
                    csr_array((values.ravel().astype(np.float32), index.ravel(), ends), (len(place), self._count[axis]))
                    for values in (weight, weight * offset)
                ]
            )

    def fit(self, x: np.ndarray, y: np.ndarray, *values: np.ndarray) -> None:
        """Fit to each of ``values`` (particles,) at ``x`` and ``y``; particles with NaN or inf do not count."""
        x, y, *copied = self._copied(x, y, *values)
        (first_x, near_x, away_x), (first_y, near_y, away_y) = (
            _splines(self._nodes(place, axis)) for axis, place in enumerate((x, y))
        )
        index = (first_y[:, :, None] * self._count[0] + first_x[:, None, :]).ravel()
        weight = (near_y[:, :, None] * near_x[:, None, :]).reshape(len(x), -1)
        along = np.broadcast_to(away_x[:, None, :], (len(x), 4, 4)).reshape(len(x), -1)
        across = np.broadcast_to(away_y[:, :, None], (len(x), 4, 4)).reshape(len(x), -1)

        def total(terms: np.ndarray) -> np.ndarray:
            return np.bincount(index, terms.ravel(), minlength=int(np.prod(self._count)))

        wx, wy = weight * along, weight * across
        m, mx, my, mxx, mxy, myy = map(total, (weight, wx, wy, wx * along, wx * across, wy * across))
        self._known = m > _LEAST
        m = np.where(self._known, m, 1.0)
        mx, my, mxx, mxy, myy = (one / m for one in (mx, my, mxx, mxy, myy))
        xx, xy, yy = mxx - mx * mx + _EVEN, mxy - mx * my, myy - my * my + _EVEN
        self._fits = []
        for one in copied:
            v, vx, vy = (total(each * one[:, None]) / m for each in (weight, wx, wy))
            vx, vy = vx - mx * v, vy - my * v
            slopes = (vx * yy - vy * xy) / (xx * yy - xy * xy), (vy * xx - vx * xy) / (xx * yy - xy * xy)
            fit = v - slopes[0] * mx - slopes[1] * my, *slopes, np.ones_like(v)
            self._fits.append([self._on_grid(terms) for terms in fit])

    def _on_grid(self, terms: np.ndarray) -> np.ndarray:
        return np.where(self._known, terms, 0.0).reshape(self._count[::-1]).astype(np.float32)

    def image(self) -> np.ndarray:
        """Return the field at the middles of the pixels, float32 (rows, columns); NaN where there are no particles."""
        (x, x_away), (y, y_away) = self._spread
        constant, slope_x, slope_y, known = self._fits[0]
        value = (y @ constant + y_away @ slope_y) @ x.T + (y @ slope_x) @ x_away.T
        with np.errstate(invalid="ignore", divide="ignore"):
            return value / ((y @ known) @ x.T)

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the field at the places ``x`` and ``y`` (n,); NaN where there are no particles."""
        (row, weight_y, away_y), (column, weight_x, away_x) = (
            _blend(self._nodes(place, axis)) for axis, place in ((1, y), (0, x))
        )
        index = row[:, None, None] + np.arange(3)[:, None], column[:, None, None] + np.arange(3)
        constant, slope_x, slope_y, known = (one[index] for one in self._fits[-1])
        weight = weight_y[:, :, None] * weight_x[:, None, :]
        value = weight * (constant + slope_x * away_x[:, None, :] + slope_y * away_y[:, :, None])
        with np.errstate(invalid="ignore", divide="ignore"):
            return value.sum(axis=(1, 2)) / (weight * known).sum(axis=(1, 2))

    def _nodes(self, place: np.ndarray, axis: int) -> np.ndarray:
        """Return places along an axis in steps from node to node."""
        return (place - self._low[axis]) / self._pitch[axis] + _MARGIN

    def _copied(self, *given: np.ndarray) -> np.ndarray:
        """Return those particles that are seen, and copies of those near periodic sides, as arrays of floats."""
        fields = np.array(given, dtype=float)
        fields = fields[:, np.isfinite(fields).all(axis=0)]
        for axis, periodic in enumerate(self._periodic):
            low, size, beyond = self._low[axis], self._size[axis], _BEYOND * self._pitch[axis]
            if periodic:
                fields[axis] = low + (fields[axis] - low) % size
                sides = [fields[:, fields[axis] < low + beyond], fields[:, fields[axis] > low + size - beyond]]
                for side, period in zip(sides, (size, -size), strict=True):
                    side[axis] += period
                fields = np.concatenate([fields, *sides], axis=1)
            inside = (fields[axis] > low - beyond) & (fields[axis] < low + size + beyond)
            fields = fields[:, inside]
        return fields


class GradedGrid:
    """The ``FieldGrid`` of a picture, and finer ones where the spacing varies from ``largest`` to ``smallest``."""

    def __init__(self, scene: Scene, layout: Layout, periodic: tuple[bool, bool]):
        wanted, area = scene.wanted_spacing, np.prod(np.subtract(layout.high, layout.low))
        finest = min(wanted.largest, max(wanted.smallest, math.sqrt(area / _MOST)))
        finer = math.ceil(math.log2(wanted.largest / finest))
        box = layout.low, layout.high, layout.box.shape
        self._largest, self._widths = wanted.largest, FieldGrid(*box, wanted.largest, periodic) if finer else None
        self._grids = [FieldGrid(*box, wanted.largest / 2**k, periodic) for k in range(finer + 1)]

    def fit(self, snapshot: Snapshot, *values: np.ndarray) -> None:
        """Fit to each of ``values`` (particles,) of a snapshot, as ``FieldGrid.fit``."""
        for grid in self._grids:
            grid.fit(snapshot.x, snapshot.y, *values)
        if self._widths:
            self._widths.fit(snapshot.x, snapshot.y, snapshot.widths(self._largest))

    def image(self) -> np.ndarray:
        """See ``FieldGrid.image``."""
        return self._blended(FieldGrid.image)

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """See ``FieldGrid.at``."""
        return self._blended(lambda grid: grid.at(x, y))

    def _blended(self, read: Callable[[FieldGrid], np.ndarray]) -> np.ndarray:
        """Return the fields that ``read`` returns of each grid, each with its share by the width of the particles."""
        found, *finer = map(read, self._grids)
        if self._widths:
            width = read(self._widths)
            for grid, values in zip(self._grids[1:], finer, strict=True):
                share = np.clip(2.0 - width / grid.pitch, 0.0, 1.0)
                found = np.where((share > 0.0) & np.isfinite(values), found + share * (values - found), found)
        return found


def _splines(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the four nodes (n, 4) around each place that are on the grid, cubic weights, and how far they are away."""
    node = np.floor(place).astype(int)
    f = (place - node)[:, None]
    weight = np.concatenate([(1 - f) ** 3, 3 * f**3 - 6 * f**2 + 4, 3 * f * (1 + f - f * f) + 1, f**3], axis=1) / 6.0
    return node[:, None] + np.arange(-1, 3), weight, f + np.arange(1, -3, -1)


def _blend(place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the first of three nodes (n,) around each place, quadratic weights (n, 3), and how far they are away."""
    node = np.floor(place + 0.5).astype(int)
    f = (place - node)[:, None]
    weight = np.concatenate([0.5 * (0.5 - f) ** 2, 0.75 - f * f, 0.5 * (0.5 + f) ** 2], axis=1)
    return node - 1, weight, f + np.arange(1, -2, -1)


_SMALLEST_DIAMETER = 1.5  # pixels: below it discs would fade away
_MOST_ROWS = 40  # of discs: of more, the gaps between them make a moire
_SIZE_STEP = 1.2  # ratio of the radii of discs of two sizes
_SHADES = 256
_DOT, _DOT_COVER = 1.4, 0.55  # radius in a frame of 1280 x 640, and cover, of particles over a field


class FluidPainter:
    """Paints the fluid of ``scene`` into its box of ``layout``, coloured as ``quantity`` and ``video`` say."""

    def __init__(self, scene: Scene, layout: Layout, quantity: Quantity, video: Any):
        few = scene.extent[1] / scene.spacing <= _MOST_ROWS
        self.style = ("particles" if scene.parallel and few else "field") if video.style == "auto" else video.style
        self._layout, shape = layout, layout.box.shape
        whole = layout.shown_length == scene.extent[0] and scene.periodic[0]
        self._periodic = whole, scene.periodic[1]
        colours = style.colours(_SHADES, colour_map=quantity.colour_map)
        ground = style.rgb(layout.theme.background) / 255.0
        self.disc_radius = self._radius(scene.spacing)
        ratio = self.disc_radius / self._radius(scene.wanted_spacing.smallest)
        steps = math.ceil(math.log(ratio) / math.log(_SIZE_STEP))
        self._spacing, self._radii = scene.spacing, self.disc_radius * _SIZE_STEP ** -np.arange(steps + 1.0)
        self.grid = GradedGrid(scene, layout, self._periodic)
        if self.style == "particles":
            self._discs, self._shades = Discs(self._radii, shape), Shades(colours, ground)
            return
        palette = np.full((_SHADES + 1, 4), 255, dtype=np.uint8)
        palette[:, :3] = np.rint(255.0 * np.vstack([colours, ground]))
        self._palette = palette.view(np.uint32).ravel()
        self._dots = Discs(max(0.5, _DOT * layout.scale), shape)
        (first, last), column = layout.pixel_positions(open_ends(scene), 0.0)[0], np.arange(shape[1]) + 0.5
        self._beyond = (column < first) | (column > last)

    def paint(
        self, panel: np.ndarray, snapshot: Snapshot, values: np.ndarray, profile: np.ndarray, limits: Ends
    ) -> None:
        """Fill the ``panel`` of the box, RGB and an idle byte (rows, columns, 4), with ``values`` (particles,).

        The colours end at ``limits``. The last fit of the grid is ``profile``, the values of the profile panel.
        """
        if self.style == "particles":
            self.grid.fit(snapshot, profile)
            share = np.clip(np.nan_to_num(_share(values, limits), nan=1.0), 0.0, 1.0)  # a run that went wrong, too
            points = self._layout.pixel_positions(snapshot.x, snapshot.y)
            off = np.log(self._radius(snapshot.widths(self._spacing))[:, None] / self._radii)
            size = np.abs(off).argmin(axis=1)
            self._shades.fill(panel, *self._discs.sums(points, share, size, periodic=self._periodic))
            return
        self.grid.fit(snapshot, values, *([] if profile is values else [profile]))
        shade = _share(self.grid.image(), limits) * np.float32(_SHADES - 1) + np.float32(0.5)
        shade = np.clip(shade, 0.0, _SHADES - 1)
        shade[np.isnan(shade) | self._beyond] = _SHADES  # no particles, or beyond an open end: the ground
        panel.view(np.uint32)[:, :, 0] = self._palette[shade.astype(np.uint16)]
        if self.style == "both":
            dots = self._dots.cover(self._layout.pixel_positions(snapshot.x, snapshot.y))
            blend(panel[:, :, :3], dots * np.float32(_DOT_COVER), style.rgb(style.TEXT))

    def _radius(self, width: Any) -> Any:
        """Return the radius of discs of particles of this ``width``, in pixels."""
        return np.maximum(_SMALLEST_DIAMETER, width * self._layout.pixels_per_length) / 2.0


def _share(values: np.ndarray, limits: Ends) -> np.ndarray:
    lowest, highest = limits
    return (values - np.float32(lowest)) * np.float32(1.0 / (highest - lowest))
