"""Corners where the velocities of two walls differ: the scheme computes what the known flow there leaves.

With the flow U of ``exact/sliding_corner.py``, and P its pressure over the density, the rest w = u - U, q = p - P obeys

    dw/dt = -grad q + nu lap w - F,    F = u . grad U - (nu lap U - grad P),

along the paths of the particles, and is small and smooth near the corners, where u, its acceleration and p are not. The
particles carry w; where they go U is met at every place on the way.
"""

import numpy as np

PARTS = 2
"""Of a step, in each of which the way of a particle is found by the classical Runge-Kutta method."""

STEEPEST = 0.5
"""Gradient of U times a step beyond which w . grad U fades."""


class Corners:
    """The sum of the flows in the ``corners``, steady, at places (n, 2) that count from ``origin``."""

    def __init__(self, corners, origin):
        self.corners, self.origin = corners, np.array(origin)

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
        slopes = self._sum("gradient", place)
        steep = length * np.linalg.norm(slopes, axis=(1, 2)) / STEEPEST
        force = np.einsum("ni,nij->nj", self.velocity(place) + rest, slopes) - self._sum("acceleration", place)
        return force / (1.0 + steep**4)[:, None]

    def traction(self, place, normal, viscosity):
        """Parts (2, n, 2) of viscosity and pressure of the force per area and density along ``normal`` (n, 2)."""
        slopes = self._sum("gradient", place)
        viscous = viscosity * np.einsum("nij,nj->ni", slopes + slopes.transpose(0, 2, 1), normal)
        return np.stack([viscous, -self.pressure(place)[:, None] * normal])

    def gone(self, place, rests, weights, length):
        """Places (n, 2) a time ``length`` after ``place``, or before it.

        ``rests`` (n, ages, 2) are w at some times, which the ``weights`` (ages,) interpolate at the part of the time
        that they are given, from 0 at the start to 1.
        """
        part = 1.0 / PARTS

        def rate(place, when):
            return self.velocity(place) + np.einsum("a,nac->nc", weights(when), rests)

        for turn in range(PARTS):
            start, step = turn * part, part * length
            first = rate(place, start)
            second = rate(place + 0.5 * step * first, start + 0.5 * part)
            third = rate(place + 0.5 * step * second, start + 0.5 * part)
            fourth = rate(place + step * third, start + part)
            place = place + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        return place
