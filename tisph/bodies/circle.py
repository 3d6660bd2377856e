"""Cylinder of a radius, seen along its axis."""

from typing import Literal

from tisph.bodies._body import Placed, Point
from tisph.config.base import Positive
from tisph.geometry.circle import Circle


class Parameters(Placed):
    """Radius [length] around the centre."""

    shaped_by = "radius"

    type: Literal["circle"] = "circle"
    centre: Point
    radius: Positive

    def shape(self) -> Circle:
        """The circle."""
        return Circle(self.radius)
