"""Circle around the origin of its body: a cylinder in the fluid, or a cylinder around it."""

import math
from dataclasses import dataclass

import numpy as np

from tisph.geometry.shape import ClosedCurve, ClosestPoint, Side, check_side, evenly


@dataclass(frozen=True)
class Circle(ClosedCurve):
    """Circle of ``radius`` [length] around (0, 0). ValueError for a radius that is not positive."""

    radius: float
    fluid_side: Side = "outside"

    def __post_init__(self) -> None:
        check_side(self.fluid_side)
        if not 0 < self.radius < math.inf:
            raise ValueError(f"a circle needs a radius above 0, not {self.radius}")

    @property
    def length(self) -> float:
        """Circumference."""
        return 2 * math.pi * self.radius

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around the circle."""
        return self.radius * np.array([[-1.0, -1.0], [1.0, 1.0]])

    @property
    def smallest_radius(self) -> float:
        """The radius."""
        return self.radius

    @property
    def area(self) -> float:
        """Enclosed area."""
        return math.pi * self.radius**2

    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        away = np.sqrt(np.einsum("ni,ni->n", points, points))
        centre = away == 0.0
        normal = points / np.where(centre, 1.0, away)[:, None]
        normal[centre] = 1.0, 0.0  # every point is nearest to the centre: take one
        return ClosestPoint(self.radius * normal, normal, np.full(len(points), 1 / self.radius), away - self.radius)

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        angle = evenly(self.length, spacing, least=3) / self.radius
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        count = len(angle)
        return self.radius * normal, normal, np.full(count, 1 / self.radius), np.full(count, self.length / count)
