"""Streamlines of the velocities at one time, laid over the particles of a movie frame.

They are lines of equal stream function psi, u = dpsi/dy and v = -dpsi/dx: between any two next to each other as much
fluid flows. On a grid, psi is what has the differences between neighbouring nodes that are nearest, by least squares,
to the flow between them. Grid and sums end at the sides of the box and within bodies, where no flow needs to be known:
so psi may grow from one side of a periodic box to the other, as it does where fluid flows through it. In axisymmetric
flow it is that of Stokes, r u = dpsi/dr and r v = -dpsi/dx.
"""

import numpy as np

from tisph.measures.fits import with_walls
from tisph.report.layout import Layout
from tisph.report.raster import dense_lines
from tisph.report.strokes import Strokes
from tisph.report.vectors import mean_velocity
from tisph.snapshot import Snapshot

_LINES = 10  # between the least and the largest stream function
_FINEST = 0.5  # spacings between nodes: pieces of lines that look smooth
_MOST = 8000  # nodes: some 50 ms of factorising, once where bodies stand still
_BEYOND = 1.5  # pitches of the grid: so far lines go on under the picture of a body
_RESTING = 1e-4  # of reference velocity and shorter side: a range of psi that only errors make


class Streamlines:
    """Paints lines into the box of ``scene``, of even width."""

    def __init__(self, scene, layout: Layout):
        self._scene, self._layout = scene, layout
        self._strokes = Strokes(layout.scale, layout.box.shape)
        low, high = np.array(layout.low), np.array(layout.high)
        pitch = max(_FINEST * scene.spacing, np.sqrt(np.prod(high - low) / _MOST))
        self._axes = [np.linspace(*ends, 2 + int(np.diff(ends)[0] / pitch)) for ends in zip(low, high, strict=True)]
        self._nodes = np.stack(np.meshgrid(*self._axes), axis=2)  # (rows, columns, 2)
        self._pitch = np.array([axis[1] - axis[0] for axis in self._axes])
        self._wet = self._difference = self._factors = None

    def paint(self, panel: np.ndarray, snapshot: Snapshot) -> None:
        """Lay the lines of ``snapshot`` over the ``panel`` of the box, RGB of uint8 (rows, columns, 3)."""
        lines = [self._layout.pixel_positions(*line.T) for line in self.lines(snapshot)]
        self._strokes.paint(panel, dense_lines(lines))

    def lines(self, snapshot: Snapshot) -> list[np.ndarray]:
        """Return the lines, places (n, 2) each; none where the fluid rests, or where a run went wrong."""
        from contourpy import LineType, contour_generator

        places, velocity = with_walls(self._scene, snapshot)
        if not (np.isfinite(velocity).all() and np.isfinite(places).all()):
            return []
        depth = self._depth(snapshot)
        self._prepare(depth > -_BEYOND * self._pitch.max())
        flow = np.zeros(self._nodes.shape)
        flow[self._wet] = mean_velocity(self._scene, places, velocity, self._nodes[self._wet])[0]
        if self._scene.axisymmetric:
            flow *= np.abs(self._nodes[:, :, 1:])
        psi = self._stream_function(flow)
        least, most = psi[depth >= 0.0].min(), psi[depth >= 0.0].max()
        if most - least < _RESTING * self._scene.reference_velocity * min(self._scene.extent):
            return []
        contours = contour_generator(*self._axes, np.ma.array(psi, mask=~self._wet), line_type=LineType.Separate)
        levels = least + (np.arange(_LINES) + 0.5) / _LINES * (most - least)
        return [line for level in levels for line in contours.lines(level)]

    def _depth(self, snapshot):
        """Return how far each node is in the fluid, (rows, columns), below 0 within bodies."""
        depth, scene = np.full(self._nodes.shape[:2], np.inf), self._scene.seen(snapshot)
        for body, side in zip(scene.bodies, getattr(scene, "sides", [0.0] * len(scene.bodies)), strict=True):
            distance = body.nearest(self._nodes.reshape(-1, 2), snapshot.t).distance.reshape(depth.shape)
            depth = np.minimum(depth, np.where(side * self._nodes[:, :, 1] < 0.0, np.inf, distance))
        return depth

    def _prepare(self, wet):
        """Factorise the sums of squares between the nodes that are ``wet``, unless they are the last ones."""
        from scipy.sparse import coo_matrix, identity
        from scipy.sparse.linalg import splu

        if self._wet is not None and np.array_equal(wet, self._wet):
            return
        self._wet, count = wet, int(wet.sum())
        number = np.cumsum(wet.ravel()).reshape(wet.shape) - 1
        ends = []
        for first, second in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
            both = wet[first] & wet[second]
            ends.append((number[first][both], number[second][both]))
        first, second = (np.concatenate(part) for part in zip(*ends, strict=True))
        edge, one = np.arange(len(first)), np.ones(len(first))
        ways = np.concatenate([edge, edge]), np.concatenate([second, first])
        self._difference = coo_matrix((np.concatenate([one, -one]), ways), (len(first), count)).tocsr()
        # a constant of each part of the fluid is free: the little that is added takes the one of mean 0
        sums = self._difference.T @ self._difference + 1e-9 * identity(count)
        self._factors = splu(sums.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def _stream_function(self, flow):
        """Return psi (rows, columns) of velocities (rows, columns, 2), 0 at nodes that are dry."""
        wet, (along, across) = self._wet, self._pitch
        right = -0.5 * along * (flow[:, :-1, 1] + flow[:, 1:, 1])[wet[:, :-1] & wet[:, 1:]]
        up = 0.5 * across * (flow[:-1, :, 0] + flow[1:, :, 0])[wet[:-1] & wet[1:]]
        psi = np.zeros(wet.shape)
        psi[wet] = self._factors.solve(self._difference.T @ np.concatenate([right, up]))
        return psi
