"""Corners where the velocities of two walls differ: the scheme computes what the known flow there leaves.

With the flow U of ``exact/sliding_corner.py``, and P its pressure over the density, the rest w = u - U, q = p - P obeys

    dw/dt = -grad q + nu lap w - F,    F = u . grad U - (nu lap U - grad P),

along the paths of the particles, and is small and smooth near the corners, where u, its acceleration and p are not. The
particles carry w; where they go U is met at every place on the way.
"""

import numpy as np

from tisph.schemes._splitting._corner_paths import CornerPaths

STEEPEST = 0.5
"""Gradient of U times a step beyond which w . grad U fades."""


class Corners:
    """The sum of the flows in the ``corners``, steady, at places (n, 2) that count from ``origin``.

    ``paths`` of the particles of ``history``: see ``CornerPaths``.
    """

    def __init__(self, corners, origin, history):
        self.corners, self.origin = corners, np.array(origin)
        self.paths = CornerPaths(corners, origin, history)

    def _sum(self, name, place):
        return sum(getattr(corner, name)(place + self.origin) for corner in self.corners)

    def velocity(self, place):
        """U (n, 2)."""
        return self._sum("velocity", place)

    def pressure(self, place):
        """P (n,)."""
        return self._sum("pressure", place)

    def force(self, place, rest, length):
        """F (n, 2) where ``rest`` (n, 2) is w, for a step of this ``length``.

        It fades where an explicit step would be unstable with it: so near the corner w is next to nothing.
        """
        parts = zip(*(corner.fields(place + self.origin) for corner in self.corners), strict=True)
        velocity, slopes, acceleration = map(sum, parts)
        steep = length * np.linalg.norm(slopes, axis=(1, 2)) / STEEPEST
        force = np.einsum("ni,nij->nj", velocity + rest, slopes) - acceleration
        return force / (1.0 + steep**4)[:, None]

    def traction(self, place, normal, viscosity):
        """Parts (2, n, 2) of viscosity and pressure of the force per area and density along ``normal`` (n, 2)."""
        slopes = self._sum("gradient", place)
        viscous = viscosity * np.einsum("nij,nj->ni", slopes + slopes.transpose(0, 2, 1), normal)
        return np.stack([viscous, -self.pressure(place)[:, None] * normal])
