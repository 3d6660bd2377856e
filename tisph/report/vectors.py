"""Velocities as arrows on an even grid, laid over the particles of a movie frame."""

import numpy as np

from tisph.measures.fits import periodic_tree
from tisph.report import style
from tisph.report.layout import Layout
from tisph.report.raster import Discs, blend, dense_lines, filled
from tisph.report.strokes import INK, RIM
from tisph.snapshot import Snapshot

_PITCH = 40.0  # pixels in a frame of 1280 x 640: distance of arrows
_UNIT = 1.5  # pitches: length of an arrow of the reference velocity
_LONGEST = 1.8  # pitches
_SHORTEST = 0.25  # pitches: below it a head shows no direction
_NEAR = 6  # particles whose velocities are averaged
_BESIDE = 1.2  # spacings: where no particle is so near there is no fluid
_SHAFT, _HEAD = 0.04, 0.14  # half widths of an arrow, in pitches
_RIM = 1.4  # half width in a frame of 1280 x 640 of the light rim of an arrow: seen on any colour
_TIP = 0.34  # pitches: length of the head of a long arrow


class Vectors:
    """Paints arrows into the box of ``scene``; the longest is nearly twice as long as their distance."""

    def __init__(self, scene, layout: Layout):
        self._scene, self._layout = scene, layout
        self._pitch = max(1.0, _PITCH * layout.scale)
        self._rim = Discs(max(0.5, _RIM * layout.scale), layout.box.shape)
        sides = layout.box.width, layout.box.height
        counts = [max(1, int(side / self._pitch)) for side in sides]
        columns, rows = ((np.arange(count) + 0.5) / count * side for count, side in zip(counts, sides, strict=True))
        self._feet = np.stack(np.meshgrid(columns, rows), axis=2).reshape(-1, 2)
        low, high = np.array(layout.low), np.array(layout.high)
        self._places = np.array([low[0], high[1]]) + self._feet * [1.0, -1.0] / layout.pixels_per_length
        self._places = np.clip(self._places, low, high)

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the arrows of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        velocity = np.stack([snapshot.u, snapshot.v], axis=1).astype(float)
        places = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        if not (np.isfinite(velocity).all() and np.isfinite(places).all()):
            return  # a run that went wrong still gets its picture
        mean, nearest = mean_velocity(self._scene, places, velocity, self._places)
        arrows = _UNIT * mean / self._scene.reference_velocity * [1.0, -1.0]  # rows count downwards
        size = np.linalg.norm(arrows, axis=1)
        shown = (nearest < _BESIDE * self._scene.spacing) & (size > _SHORTEST)
        arrows, size = arrows[shown], size[shown]
        arrows *= np.minimum(1.0, _LONGEST / size)[:, None]
        corners = self._feet[shown, None] + self._pitch * _outlines(arrows)
        rim = dense_lines(tuple(np.concatenate([arrow, arrow[:1]]).T) for arrow in corners)
        blend(panel, self._rim.cover(rim), style.rgb(RIM))
        blend(panel, filled((corners[:, :, 0], corners[:, :, 1]), panel.shape[:2]), style.rgb(INK))


def mean_velocity(scene, places, velocity, points):
    """Return the mean of ``velocity`` (n, 2) at the nearest of ``places`` (n, 2) around ``points`` (m, 2).

    And the distance (m,) of the very nearest. The nearer, the more one counts.
    """
    tree, _ = periodic_tree(scene, places)
    distance, nearest = tree.query(points, min(_NEAR, len(places)))
    weight = 1.0 / (distance + 1e-3 * scene.spacing) ** 2
    mean = np.einsum("ij,ijk->ik", weight, velocity[nearest]) / weight.sum(axis=1)[:, None]
    return mean, distance[:, 0]


def _outlines(arrows: np.ndarray) -> np.ndarray:
    """Return the corners (n, 7, 2) of ``arrows`` (n, 2), all run through the same way, around their middles."""
    size = np.linalg.norm(arrows, axis=1)[:, None]
    ahead = arrows / size
    aside = ahead[:, ::-1] * [-1.0, 1.0]
    neck = size - np.minimum(_TIP, 0.6 * size)
    thin = np.minimum(1.0, size / _TIP)  # short ones are narrow, too
    along = [0.0 * size, neck, neck, size, neck, neck, 0.0 * size]
    across = [_SHAFT, _SHAFT, _HEAD, 0.0, -_HEAD, -_SHAFT, -_SHAFT]
    return np.stack(
        [(one - 0.5 * size) * ahead + other * thin * aside for one, other in zip(along, across, strict=True)], axis=1
    )
