"""The fluid of a movie frame: a continuous field, particles as discs, or both, and where the profile is taken."""

import numpy as np

from tisph.report import style
from tisph.report.field import FieldGrid
from tisph.report.layout import Layout
from tisph.report.quantities import Quantity
from tisph.report.raster import Discs, Shades, blend
from tisph.snapshot import Snapshot

_SMALLEST_DIAMETER = 1.5  # pixels: below it discs would fade away
_SHADES = 256
_DOT, _DOT_COVER = 1.4, 0.55  # radius in a frame of 1280 x 640, and cover, of particles over a field


class FluidPainter:
    """Paints the fluid of ``scene`` into its box of ``layout``, coloured as ``quantity`` and ``video`` say."""

    def __init__(self, scene, layout: Layout, quantity: Quantity, video):
        self.style = ("particles" if scene.parallel else "field") if video.style == "auto" else video.style
        self._layout, self._range, shape = layout, quantity.colour_range, layout.box.shape
        whole = layout.shown_length == scene.extent[0] and scene.periodic[0]
        self._periodic = whole, scene.periodic[1]
        colours = style.colours(_SHADES, colour_map=quantity.colour_map)
        ground = style.rgb(layout.theme.background) / 255.0
        self.disc_radius = max(_SMALLEST_DIAMETER, scene.spacing * layout.pixels_per_length) / 2.0
        self.grid = None
        if self.style == "particles":
            self._discs, self._shades = Discs(self.disc_radius, shape), Shades(colours, ground)
            return
        self.grid = FieldGrid(layout.low, layout.high, shape, scene.spacing, self._periodic)
        palette = np.full((_SHADES + 1, 4), 255, dtype=np.uint8)
        palette[:, :3] = np.rint(255.0 * np.vstack([colours, ground]))
        self._palette = palette.view(np.uint32).ravel()
        self._dots = Discs(max(0.5, _DOT * layout.scale), shape)

    def paint(self, panel: np.ndarray, snapshot: Snapshot, values: np.ndarray, profile: np.ndarray) -> None:
        """Fill the ``panel`` of the box, RGB and an idle byte (rows, columns, 4), with ``values`` (particles,).

        The grid is left with ``profile``, what the profile panel shows.
        """
        if self.style == "particles":
            share = np.clip(np.nan_to_num(self._share(values), nan=1.0), 0.0, 1.0)  # a run that went wrong, too
            points = self._layout.pixel_positions(snapshot.x, snapshot.y)
            self._shades.fill(panel, *self._discs.sums(points, share, periodic=self._periodic))
            return
        self.grid.fit(snapshot.x, snapshot.y, values, *([] if profile is values else [profile]))
        shade = self._share(self.grid.image()) * np.float32(_SHADES - 1) + np.float32(0.5)
        shade = np.clip(shade, 0.0, _SHADES - 1)
        shade[np.isnan(shade)] = _SHADES  # no particles: the ground
        panel.view(np.uint32)[:, :, 0] = self._palette[shade.astype(np.uint16)]
        if self.style == "both":
            dots = self._dots.cover(self._layout.pixel_positions(snapshot.x, snapshot.y))
            blend(panel[:, :, :3], dots * np.float32(_DOT_COVER), style.rgb(style.TEXT))

    def _share(self, values):
        lowest, highest = self._range
        return (values - np.float32(lowest)) * np.float32(1.0 / (highest - lowest))
