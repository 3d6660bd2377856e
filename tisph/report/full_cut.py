"""Axisymmetric flow as it is drawn: the whole plane through the axis, the half-plane and its mirror image."""

from dataclasses import fields, replace

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.polygon import Polygon

_BEYOND = 10.0  # lengths of the box that an inner cylinder is drawn beyond it
_EDGE = 0.1  # radius of its corners there over its own

_ODD = ("y", "v", "stress_xy")


class FullCut:
    """An axisymmetric ``scene`` with the box and the ``bodies`` of the whole plane, and else as it is."""

    def __init__(self, scene):
        self._scene, radius = scene, scene.outer_radius
        self.origin, self.extent = (0.0, -radius), (scene.extent[0], 2.0 * radius)
        pairs = [pair for each in enumerate(scene.bodies) for pair in _images(each, scene)]
        self._sources, self.bodies = zip(*pairs, strict=True)

    def __getattr__(self, name):
        return getattr(self._scene, name)

    def seen(self, snapshot):
        """See ``Scene.seen``."""
        return FullCut(self._scene.seen(snapshot)) if self.has_free_bodies else self

    def mirrored(self, snapshot):
        """``snapshot`` with the mirror image of each particle after all of them, and its bodies with theirs."""
        values = {each.name: getattr(snapshot, each.name) for each in fields(snapshot)}
        double = {
            name: np.concatenate([array, -array if name in _ODD else array])
            for name, array in values.items()
            if isinstance(array, np.ndarray)
        }
        given, sides = snapshot.bodies, np.array([side for _, side in self._sources])
        chosen = [source for source, _ in self._sources]
        ways = np.stack([np.ones_like(sides), sides], axis=1)
        moved = {name: getattr(given, name)[chosen] * ways for name in ("centre", "velocity")}
        turned = {name: getattr(given, name)[chosen] * sides for name in ("angle", "angular_velocity")}
        return replace(snapshot, **double, reference=None, bodies=replace(given, **moved, **turned))


def _images(pair, scene):
    """Pairs of a body's number and side, 1 or -1 in the mirror, and what is drawn of it there."""
    index, body = pair
    if body.shape.area:
        return [((index, 1.0), body)]
    height = body.shape.point[1]
    if height > scene.inner_radius:
        image = Body(Line((0.0, -height), (1.0, 0.0), body.shape.length), motion=body.motion)
        return [((index, 1.0), body), ((index, -1.0), image)]
    ends = -_BEYOND * scene.extent[0], (1.0 + _BEYOND) * scene.extent[0]
    corners = (ends[0], -height), (ends[1], -height), (ends[1], height), (ends[0], height)
    return [((index, 1.0), Body(Polygon(corners, _EDGE * height)))]
