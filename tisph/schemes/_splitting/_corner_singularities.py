"""Corners where the velocities of two walls differ: the known flow there is subtracted, the scheme computes the rest.

With the flow U of ``exact/sliding_corner.py``, and P its pressure per unit density, w = u - U and q = p - P obey

    dw/dt = -grad q + nu lap w - F,    F = u . grad U - (nu lap U - grad P),

along the paths of the particles, and are small and smooth near the corners, where u, its acceleration and p are not.
The particles carry w; along their paths U is evaluated everywhere.
"""

import numpy as np

from tisph.runtime import view
from tisph.schemes._splitting._singular_paths import SingularPaths


class CornerSingularities:
    """The sum of the flows in the ``corners``, steady, at positions (n, 2) that count from ``origin``.

    ``paths`` of the particles of ``levels``: see ``SingularPaths``.
    """

    def __init__(self, corners, origin, levels):
        self.corners, self.origin = corners, np.array(origin)
        self.paths = SingularPaths(corners, origin, levels)

    def _sum(self, name, position):
        return sum(getattr(corner, name)(position + self.origin) for corner in self.corners)

    def velocity(self, position):
        """U (n, 2)."""
        return self._sum("velocity", position)

    def pressure(self, position):
        """P (n,)."""
        return self._sum("pressure", position)

    def force(self, dt, weights):
        """F (points, 2) of all points, which ``paths`` keep, for a step ``dt``; w by ``weights`` (2,) of its levels."""
        self.paths.find_force(dt, *weights)
        return view(self.paths.found)

    def traction(self, position, normal, viscosity):
        """Parts (2, n, 2) of viscosity and pressure of the force per area and density along ``normal`` (n, 2)."""
        gradient = self._sum("gradient", position)
        viscous = viscosity * np.einsum("nij,nj->ni", gradient + gradient.transpose(0, 2, 1), normal)
        return np.stack([viscous, -self.pressure(position)[:, None] * normal])
