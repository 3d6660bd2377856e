"""Ellipse around the origin of its body, its axes along x and y.

Nearest points are where F(t) = (a x/(t + a^2))^2 + (b y/(t + b^2))^2 = 1 for the largest t (D. Eberly, "Distance from a
Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid", Geometric Tools, 2013): place (x, y) and nearest point (X, Y)
differ by t (X/a^2, Y/b^2). F is convex and falls with t: Newton's method from a value above 1 never overshoots.
"""

import math
from dataclasses import dataclass

import numpy as np

from tisph.geometry.shape import ClosedCurve, ClosestPoint, Side, check_side, evenly

NEWTON_STEPS, ROUNDING = 60, 1e-15
"""Most iterations for the angles of arc lengths, and their error over the longer half axis.

5 iterations suffice for axes of 2 to 1, 9 for 100 to 1 and more.
"""


@dataclass(frozen=True)
class Ellipse(ClosedCurve):
    """Ellipse around (0, 0) with ``half_axes`` (a, b) [length] along x and y, either of them the longer one.

    Of two closest points to a place on the longer axis, the one with positive y, or x, is returned. ValueError for half
    axes that are not positive.
    """

    half_axes: tuple[float, float]
    fluid_side: Side = "outside"

    def __post_init__(self) -> None:
        check_side(self.fluid_side)
        if not all(0 < half_axis < math.inf for half_axis in self.half_axes):
            raise ValueError(f"an ellipse needs two half axes above 0, not {list(self.half_axes)}")

    @property
    def length(self) -> float:
        """Perimeter, by the complete elliptic integral of the second kind."""
        from scipy.special import ellipe

        return 4 * max(self.half_axes) * float(ellipe(self._eccentricity_squared))

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around the ellipse."""
        return np.outer([-1.0, 1.0], self.half_axes)

    @property
    def smallest_radius(self) -> float:
        """Radius of curvature at the ends of the longer axis."""
        return min(self.half_axes) ** 2 / max(self.half_axes)

    @property
    def area(self) -> float:
        """Enclosed area."""
        return math.pi * self.half_axes[0] * self.half_axes[1]

    @property
    def _long(self) -> int:
        """Index of the longer axis: 0 for x, 1 for y."""
        return 0 if self.half_axes[0] > self.half_axes[1] else 1

    @property
    def _eccentricity_squared(self) -> float:
        short, long = sorted(self.half_axes)
        return (long - short) * (long + short) / long**2

    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        unit = np.copysign(self._nearest_units(np.abs(points)), points)
        point, normal, curvature = self._at(unit)
        return ClosestPoint(point, normal, curvature, np.sum((points - point) * normal, axis=1))

    def _nearest_units(self, points: np.ndarray) -> np.ndarray:
        """Nearest points (n, 2) over the half axes, of ``points`` (n, 2) whose coordinates are 0 or more.

        With u = 1 + t/b^2, b the shorter half axis: F = (along/(u + excess))^2 + (across/u)^2, u > 0.
        """
        short, long = sorted(self.half_axes)
        excess = (long - short) * (long + short) / short**2
        along = points[:, self._long] / short * (long / short)
        across = points[:, 1 - self._long] / short
        root = _largest_root(along, across, excess)
        # It is 0 on the longer axis, up to the centre of curvature of its end.
        middle, share = root == 0.0, along / (excess or 1.0)
        positive = np.where(middle, 1.0, root)
        on_long = np.where(middle, share, along / (positive + excess))
        on_short = np.where(middle, np.sqrt(np.maximum((1 - share) * (1 + share), 0.0)), across / positive)
        size = np.hypot(on_long, on_short)
        return self._ordered(on_long / size, on_short / size)

    def _ordered(self, on_long: np.ndarray, on_short: np.ndarray) -> np.ndarray:
        """Return components (n,) along the longer and the shorter axis as (x, y) (n, 2)."""
        return np.stack([on_long, on_short] if self._long == 0 else [on_short, on_long], axis=1)

    def _at(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points, normals for fluid outside, and curvatures at points ``unit`` (n, 2) over the half axes."""
        a, b = self.half_axes
        steep = unit * [b, a]
        size = np.hypot(steep[:, 0], steep[:, 1])
        return unit * [a, b], steep / size[:, None], a * b / size**3

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        length = self.length
        along = evenly(length, spacing, least=3)
        quarter = np.minimum(np.floor(along / (0.25 * length)), 3.0)
        rest = along - quarter * (0.25 * length)
        from_short_axis = (quarter % 2 == 0) == (self._long == 1)
        angle = self._angle(np.where(from_short_axis, rest, 0.25 * length - rest))
        signs = np.stack(
            [np.where((quarter == 0) | (quarter == 3), 1.0, -1.0), np.where(quarter < 2, 1.0, -1.0)], axis=1
        )
        return *self._at(signs * self._ordered(np.sin(angle), np.cos(angle))), np.full(len(along), length / len(along))

    def _angle(self, along: np.ndarray) -> np.ndarray:
        """Return the eccentric angles (n,) from the end of the shorter axis at arc lengths ``along`` (n,) from there.

        Newton's method from the end does not overshoot, since the arc length is concave up to a right angle.
        """
        from scipy.special import ellipeinc

        short, long = sorted(self.half_axes)
        angle = np.zeros(len(along))
        for _ in range(NEWTON_STEPS):
            speed = np.hypot(long * np.cos(angle), short * np.sin(angle))
            missing = along - long * ellipeinc(angle, self._eccentricity_squared)
            angle = np.minimum(angle + missing / speed, 0.5 * math.pi)
            if np.abs(missing).max() <= ROUNDING * long:
                break
        return angle


def _largest_root(along: np.ndarray, across: np.ndarray, excess: float) -> np.ndarray:
    """Return the largest u >= 0 (n,) at which F = (along/(u + excess))^2 + (across/u)^2 is 1, from below.

    The iteration ends where a step no longer increases u; then F is 1 to round-off.
    """
    root = np.maximum(across, along - excess)  # one of the two squares is 1
    left = np.flatnonzero(root > 0)
    while len(left):
        here, far = root[left], along[left]
        ratio, square = far / (here + excess), (across[left] / here) ** 2
        above = square - (here + (excess - far)) / (here + excess) * (1 + ratio)
        there = here + 0.5 * here * above / (ratio**2 * here / (here + excess) + square)
        rising = there > here
        root[left[rising]] = there[rising]
        left = left[rising]
    return root
