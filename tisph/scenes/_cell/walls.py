"""The walls of a cell: two planes as bodies, and how fast bodies and walls are."""

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion


def plane_walls(length, gap, walls):
    """Bodies by name, ``bottom`` and ``top``, of walls at y = 0 and y = ``gap`` with the motions that ``walls`` gives.

    ``walls``: a config section with ``bottom`` and ``top``, motions along x.
    """
    lines = {"bottom": Line((0.0, 0.0), (1.0, 0.0), length), "top": Line((length, gap), (-1.0, 0.0), length)}
    motions = {name: RigidMotion(WallMotion.from_config(getattr(walls, name))) for name in lines}
    return {name: Body(line, motion=motions[name]) for name, line in lines.items()}


def planes(walls):
    """Pairs (side, motion) of walls from ``plane_walls``, from top to bottom, as ``Scene.walls`` has them."""
    return tuple((name, walls[name].motion.x) for name in ("top", "bottom"))


def farthest(shape):
    """Largest distance of points of a ``shape`` from the centre of its body; 0 of a line."""
    return float(np.linalg.norm(shape.boundary_points(shape.length / 1000).point, axis=1).max()) if shape.area else 0.0


def largest_speed(body):
    """Largest speed that a point of a ``body`` may have, or a bound of it."""
    return body.motion.largest_speed(farthest(body.shape))
