"""Velocity at points between the particles, by moving least squares with a quadratic basis.

At a point (X, Y) the coefficients c minimise sum_j w_j (c . b_j - u_j)^2 over the particles j within the
radius R, with b = (1, X', Y', X'^2, X'Y', Y'^2) of X' = (x_j - X)/R, Y' = (y_j - Y)/R and the Wendland
weight w = (1 - q)^4 (1 + 4 q), q = |(X', Y')|; the value is c_0. It is exact for velocity fields up to
quadratic, wherever the particles are and also next to a wall: a linear basis would leave an error of u_yy
R^2/29 in a curved profile, which is more than the error of the flow that it should measure.

Source: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396.
"""

import numpy as np

RADIUS = 3.0
"""Radius R in particle spacings: 28 particles, and 14 in three rows for a point on a wall; 6 are needed."""


class Probes:
    """Fixed points that read the velocity along x from the particles around them.

    ``x`` and ``y`` of shape (points,), inside the channel, which is periodic in x. Only particles within ``half_width``
    of ``centre`` along x count.
    """

    def __init__(self, channel, x, y):
        self.x = np.asarray(x, dtype=float)
        self.y = np.asarray(y, dtype=float)
        self._length = channel.length
        self._radius = RADIUS * channel.spacing
        self.centre = 0.5 * (self.x.min() + self.x.max())
        self.half_width = 0.5 * np.ptp(self.x) + self._radius

    def velocity(self, snapshot):
        """Velocity along x at the points, shape (points,); NaN where no particle is within the radius."""
        near = np.abs(self._periodic(snapshot.x - self.centre)) < self.half_width
        near &= snapshot.y > self.y.min() - self._radius
        near &= snapshot.y < self.y.max() + self._radius
        when = np.zeros(np.count_nonzero(near), dtype=int)
        return self.velocities(1, when, snapshot.x[near], snapshot.y[near], snapshot.u[near])[0]

    def velocities(self, times, when, x, y, u):
        """Velocities along x at the points at several ``times`` (their number), shape (times, points).

        ``x``, ``y`` and ``u``, flat, are particles around ``centre``, within ``half_width`` at least; ``when``
        (ascending) is the time at which each is seen.
        """
        particle, point = np.nonzero(np.abs(y[:, None] - self.y) < self._radius)
        along = self._periodic(x[particle] - self.x[point]) / self._radius
        across = (y[particle] - self.y[point]) / self._radius
        distance = np.sqrt(along * along + across * across)
        where = when[particle] * self.x.size + point
        order = np.flatnonzero(distance < 1.0)
        order = order[np.argsort(where[order], kind="stable")]
        along, across, distance, particle = along[order], across[order], distance[order], particle[order]
        found, first = np.unique(where[order], return_index=True)
        square = (1 - distance) * (1 - distance)
        weight = square * square * (1 + 4 * distance)
        ones = np.ones_like(along)
        basis = np.stack([ones, along, across, along * along, along * across, across * across], axis=1)
        weighted = basis * weight[:, None]
        values = np.full((times, self.x.size), np.nan)
        if found.size:
            moments = np.add.reduceat(weighted[:, :, None] * basis[:, None, :], first)
            values.flat[found] = _solved(moments, np.add.reduceat(weighted * u[particle, None], first))
        return values

    def _periodic(self, difference):
        """Differences in x to the nearest periodic copy."""
        return difference - self._length * np.round(difference / self._length)


def _solved(moments, sums):
    """First of the coefficients of each fit: of ``moments`` (fits, 6, 6) c = ``sums`` (fits, 6)."""
    try:
        return np.linalg.solve(moments, sums[..., None])[:, 0, 0]
    except np.linalg.LinAlgError:  # a void in a flow that goes wrong shall give a value and not an exception
        return (np.linalg.pinv(moments, rcond=1e-12, hermitian=True) @ sums[..., None])[:, 0, 0]


def interpolate(snapshot, channel, x, y):
    """Velocity along x at the points (``x``, ``y``), arrays of one shape (points,). See ``Probes``."""
    return Probes(channel, x, y).velocity(snapshot)
