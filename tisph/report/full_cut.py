"""Axisymmetric flow as it is drawn: the whole plane through the axis, the half-plane and its mirror image."""

from dataclasses import fields, replace

import numpy as np

from tisph.geometry.line import Line
from tisph.geometry.polygon import Polygon

_BEYOND = 10.0  # lengths of the box that an inner cylinder is drawn beyond it

_POINTS = 400  # on the mirror image of a closed body

_ODD = ("y", "v", "stress_xy")


class FullCut:
    """An axisymmetric ``scene`` with the box and the ``bodies`` of the whole plane, and else as it is.

    ``half`` is the scene, ``sides``: of a body that is in one half alone 1 or -1, the sign of y there, else 0.
    """

    def __init__(self, scene):
        self.half, radius = scene, scene.outer_radius
        self.origin, self.extent = (scene.origin[0], -radius), (scene.extent[0], 2.0 * radius)
        found = []  # number, side and body
        for index, body in enumerate(scene.bodies):
            whole = body.crosses_axis
            found += [(index, 0.0, body)] if whole else [(index, 1.0, body), (index, -1.0, _mirrored(body))]
        self._sources, self.sides, self.bodies = zip(*found, strict=True)

    def __getattr__(self, name):
        return getattr(self.half, name)

    def seen(self, snapshot):
        """See ``Scene.seen``."""
        return FullCut(self.half.seen(snapshot)) if self.has_free_bodies else self

    def mirrored(self, snapshot):
        """``snapshot`` with the mirror image of each particle after all of them, and its bodies with theirs."""
        values = {each.name: getattr(snapshot, each.name) for each in fields(snapshot)}
        double = {
            name: np.concatenate([array, -array if name in _ODD else array])
            for name, array in values.items()
            if isinstance(array, np.ndarray)
        }
        given, chosen, sides = snapshot.bodies, list(self._sources), np.where(np.array(self.sides) < 0.0, -1.0, 1.0)
        ways = np.stack([np.ones_like(sides), sides], axis=1)
        moved = {name: getattr(given, name)[chosen] * ways for name in ("centre", "velocity")}
        turned = {name: getattr(given, name)[chosen] * sides for name in ("angle", "angular_velocity")}
        return replace(snapshot, **double, reference=None, bodies=replace(given, **moved, **turned))


def _mirrored(body):
    """The mirror image of a ``body``: of a closed one by a polygon through points on it."""
    across, shape = np.array([1.0, -1.0]), body.shape
    if shape.area:
        outline = shape.boundary_points(shape.length / _POINTS).point * across
        image = Polygon(outline.tolist(), fluid_side=shape.fluid_side)
    else:
        start = np.add(shape.point, shape.length * np.array(shape.tangent)) * across
        image = Line(start.tolist(), (-across * shape.tangent).tolist(), shape.length)
    return replace(body, shape=image, centre=(across * body.centre).tolist(), angle=-body.angle)
