"""Smooth closed curve through given points."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from tisph.bodies._body import Placed, Points
from tisph.bodies._files import FromFile
from tisph.geometry.spline import Spline


class Parameters(Placed, FromFile):
    """Points [x, y] as seen from the centre, along the curve in either direction, the first not repeated.

    Or a ``file`` with a closed path, whose centroid is at the ``centre``; without ``centre`` it stays in its place.
    """

    shaped_by = points_key = "points"
    unset_keys = (*Placed.unset_keys, "file")

    type: Literal["curve"] = "curve"
    points: Points

    def shape(self) -> Spline:
        """The curve."""
        return Spline(self.points)

    @classmethod
    def smooth_of(cls, data: Mapping[str, Any]) -> bool:
        """Return True."""
        return True

    @classmethod
    def shape_through(cls, points: np.ndarray, data: Mapping[str, Any], periodic: bool) -> Spline:
        """Return the curve through ``points``."""
        return Spline(tuple(map(tuple, points.tolist())))
