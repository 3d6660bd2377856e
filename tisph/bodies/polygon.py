"""Polygon, its corners sharp or rounded."""

from typing import Annotated, Literal

from pydantic import Field

from tisph.bodies._body import Placed, Points
from tisph.config.base import LARGEST
from tisph.geometry.polygon import Polygon


class Parameters(Placed):
    """Corners [x, y] as seen from the centre, in either order, and the radius that rounds them [length]."""

    shaped_by = "corners"

    type: Literal["polygon"] = "polygon"
    corners: Points
    corner_radius: Annotated[float, Field(ge=0, le=LARGEST)] = 0.0

    def shape(self) -> Polygon:
        """The polygon."""
        return Polygon(self.corners, self.corner_radius)
