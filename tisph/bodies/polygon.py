"""Polygon, its corners sharp or rounded."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from tisph.bodies._body import Placed, Points
from tisph.bodies._files import FromFile
from tisph.config.base import NonNegative
from tisph.geometry.polygon import Polygon


class Parameters(Placed, FromFile):
    """Corners [x, y] as seen from the centre, in either order, and the radius that rounds them [length].

    Or a ``file`` with a closed path of straight sides, whose centroid is at the ``centre``; without ``centre`` it stays
    in its place.
    """

    shaped_by = points_key = "corners"
    unset_keys = (*Placed.unset_keys, "file")

    type: Literal["polygon"] = "polygon"
    corners: Points
    corner_radius: NonNegative = 0.0

    def shape(self) -> Polygon:
        """The polygon."""
        return Polygon(self.corners, self.corner_radius)

    @classmethod
    def smooth_of(cls, data: Mapping[str, Any]) -> bool:
        """Return False: it has corners."""
        return False

    @classmethod
    def shape_through(cls, points: np.ndarray, data: Mapping[str, Any], periodic: bool) -> Polygon:
        """Return the polygon with these corners."""
        return Polygon(tuple(map(tuple, points.tolist())), _radius(data))


def _radius(data: Mapping[str, Any]) -> float:
    """Return the radius of the corners in raw ``data``, 0 where it is no number."""
    given = data.get("corner_radius")
    return float(given) if isinstance(given, int | float) and given > 0 else 0.0
