"""Polygon, its corners sharp or rounded."""

from typing import Literal

from tisph.bodies._body import Placed, Points
from tisph.config.base import NonNegative
from tisph.geometry.polygon import Polygon


class Parameters(Placed):
    """Corners [x, y] as seen from the centre, in either order, and the radius that rounds them [length]."""

    shaped_by = "corners"

    type: Literal["polygon"] = "polygon"
    corners: Points
    corner_radius: NonNegative = 0.0

    def shape(self) -> Polygon:
        """The polygon."""
        return Polygon(self.corners, self.corner_radius)
