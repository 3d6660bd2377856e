"""Smooth closed curve through given points."""

from typing import Literal

from tisph.bodies._body import Placed, Points
from tisph.geometry.spline import Spline


class Parameters(Placed):
    """Points [x, y] as seen from the centre, along the curve in either direction, the first not repeated."""

    shaped_by = "points"

    type: Literal["curve"] = "curve"
    points: Points

    def shape(self) -> Spline:
        """The curve."""
        return Spline(self.points)
