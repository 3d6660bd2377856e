"""Dye: particles keep the colour of the place where they were in the first frame."""

import numpy as np

_STRIPES = 8  # along x
_SQUARES = 6  # along the shorter side
_BLOB = 0.25, 0.5, 0.15  # where the middle of a blob is in the box, and its radius over the shorter side


class Dye:
    """The ``pattern`` of a movie of ``scene``: stripes across x, a checkerboard, or a round blob."""

    def __init__(self, scene, pattern: str):
        self._low, self._size = np.array(scene.origin), np.array(scene.extent, dtype=float)
        self._share = getattr(self, f"_{pattern}")
        self._first = None

    def of(self, snapshot) -> np.ndarray:
        """Return 0 or 1 for each particle, by where it was in the first snapshot for which this was called."""
        if self._first is None:
            places = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
            self._first = self._share(np.where(np.isfinite(places), places, 0.0) - self._low)
        return self._first

    def _stripes(self, places):
        return np.floor(_STRIPES * places[:, 0] / self._size[0]) % 2

    def _checkerboard(self, places):
        return np.floor(_SQUARES * places / self._size.min()).sum(axis=1) % 2

    def _blob(self, places):
        aim = np.array(_BLOB[:2]) * self._size
        middle = places[np.argmin(np.linalg.norm(places - aim, axis=1))]  # in the fluid, wherever bodies are
        return (np.linalg.norm(places - middle, axis=1) < _BLOB[2] * self._size.min()).astype(float)
