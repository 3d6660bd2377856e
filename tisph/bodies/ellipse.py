"""Cylinder of elliptic cross-section, seen along its axis."""

from typing import Annotated, Literal

from pydantic import Field

from tisph.bodies._body import Placed, Point
from tisph.config.base import Positive
from tisph.geometry.ellipse import Ellipse


class Parameters(Placed):
    """Half axes [length] around the centre, the first one at ``angle`` to the x axis."""

    shaped_by = "half_axes"

    type: Literal["ellipse"] = "ellipse"
    centre: Point
    half_axes: Annotated[tuple[Positive, Positive], Field(strict=False)]

    def shape(self) -> Ellipse:
        """The ellipse."""
        return Ellipse(self.half_axes)
