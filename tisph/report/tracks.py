"""Paths of some particles, and of bodies that the flow carries: where each was in the frames before.

Those of particles are laid over the fluid of a movie frame, those of bodies over these.
"""

import numpy as np

from tisph.report import style
from tisph.report.layout import Layout
from tisph.report.raster import Discs, blend, dense_lines
from tisph.report.strokes import INK, Strokes
from tisph.snapshot import Snapshot

_PARTICLES = 48
_FRAMES = 40
_HEAD = 3.2  # radius in a frame of 1280 x 640 of the dot where the particle is
_BODIES = 1.6  # times as wide are the lines of bodies, and their dots


class Tracks:
    """Paints the paths of evenly chosen particles over the last frames; a path ends at a periodic side."""

    width = 1.0  # of lines and dots

    def __init__(self, scene, layout: Layout):
        self._scene, self._layout, self._seen = scene, layout, {}
        self._strokes = Strokes(self.width * layout.scale, layout.box.shape)
        self._head = Discs(self.width * _HEAD * layout.scale, layout.box.shape)

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the paths up to ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        self._seen[snapshot.t] = self._places(snapshot)
        times = sorted(time for time in self._seen if time <= snapshot.t)[-_FRAMES:]
        paths = np.array([self._seen[time] for time in times])
        pieces = [piece for path in paths.transpose(1, 0, 2) for piece in self._pieces(path) if len(piece) > 1]
        self._strokes.paint(panel, dense_lines(self._layout.pixel_positions(*piece.T) for piece in pieces))
        blend(panel, self._head.cover(self._layout.pixel_positions(*paths[-1].T)), style.rgb(INK))

    def _places(self, snapshot):
        """Return where they are (n, 2), in the box."""
        chosen = style.evenly_chosen(len(snapshot.x), _PARTICLES)
        return np.stack([snapshot.x[chosen], snapshot.y[chosen]], axis=1).astype(float)

    def _pieces(self, path):
        """Return a path (frames, 2) in pieces between the sides through which it has left the box."""
        path = path[np.isfinite(path).all(axis=1)]
        jumps = np.abs(np.diff(path, axis=0)) > 0.5 * np.array(self._scene.extent)
        return np.split(path, np.flatnonzero(jumps.any(axis=1)) + 1)


class BodyTracks(Tracks):
    """Paints the paths of the centres of all bodies that the flow carries, likewise."""

    width = _BODIES

    def __init__(self, scene, layout: Layout):
        super().__init__(scene, layout)
        self._free = [index for index, body in enumerate(scene.bodies) if body.free]

    def _places(self, snapshot):
        """Return where their centres are (n, 2), in the box."""
        centre, low = snapshot.bodies.centre[self._free], np.array(self._scene.origin)
        return np.where(self._scene.periodic, low + (centre - low) % self._scene.extent, centre)
