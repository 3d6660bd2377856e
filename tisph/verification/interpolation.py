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

    ``x`` and ``y`` of shape (points,), inside the channel, which is periodic in x.
    """

    def __init__(self, channel, x, y):
        self.x = np.asarray(x, dtype=float)
        self.y = np.asarray(y, dtype=float)
        self._length = channel.length
        self._radius = RADIUS * channel.spacing
        self._centre = 0.5 * (self.x.min() + self.x.max())
        self._half_width = 0.5 * np.ptp(self.x) + self._radius

    def velocity(self, snapshot):
        """Velocity along x at the points, shape (points,); NaN where no particle is within the radius."""
        near = self._near(snapshot)
        across = (snapshot.y[near] - self.y[:, None]) / self._radius
        along = self._periodic(snapshot.x[near] - self.x[:, None]) / self._radius
        distance = np.minimum(np.sqrt(along * along + across * across), 1.0)
        square = (1 - distance) * (1 - distance)
        weight = square * square * (1 + 4 * distance)
        ones = np.ones_like(along)
        basis = np.stack([ones, along, across, along * along, along * across, across * across], axis=1)
        weighted = basis * weight[:, None, :]
        moments, sums = weighted @ basis.transpose(0, 2, 1), (weighted @ snapshot.u[near])[..., None]
        try:
            values = np.linalg.solve(moments, sums)[:, 0, 0]
        except np.linalg.LinAlgError:  # a hole in a flow that goes wrong shall give a value and not an exception
            values = (np.linalg.pinv(moments, rcond=1e-12, hermitian=True) @ sums)[:, 0, 0]
        return np.where(weight.any(axis=1), values, np.nan)

    def _near(self, snapshot):
        """Indices of the particles in the smallest box around all points and their radius."""
        inside = np.abs(self._periodic(snapshot.x - self._centre)) < self._half_width
        inside &= snapshot.y > self.y.min() - self._radius
        inside &= snapshot.y < self.y.max() + self._radius
        return np.flatnonzero(inside)

    def _periodic(self, difference):
        """Differences in x to the nearest periodic copy."""
        return difference - self._length * np.round(difference / self._length)


def interpolate(snapshot, channel, x, y):
    """Velocity along x at the points (``x``, ``y``), arrays of one shape (points,). See ``Probes``."""
    return Probes(channel, x, y).velocity(snapshot)
