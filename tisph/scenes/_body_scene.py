"""Scenes with bodies: their particles fill the fluid between bodies and walls, of which plane ones are bodies, too."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line
from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.packing import pack
from tisph.geometry.region import Region
from tisph.scenes._scene import Scene
from tisph.snapshot import STRESSES


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


LEAST_JITTER = 0.05
"""Where particles are on a lattice at first, far from walls, the flow would stretch it, or tear it along the diagonals:
pushes cancel there."""


class BodyScene(Scene):
    """A scene with ``bodies``: fluid around them, and within them where the box is not ``periodic``."""

    def initial(self, x, y):
        """Rest, without stress."""
        return {name: np.zeros(np.shape(x)) for name in ("u", "v", *(STRESSES if self.polymer else ()))}

    @cached_property
    def region(self):
        """The fluid's region at t = 0."""
        return Region(self.bodies, self.origin, tuple(np.add(self.origin, self.extent)), self.periodic)

    @cached_property
    def particles(self):
        """Number of fluid particles."""
        return round(self.region.area / self.spacing**2)

    def jittered(self, seed, jitter):
        """Particles that fill the region; see ``tisph/geometry/packing.py``."""
        return tuple(pack(self.region, self.spacing, max(jitter, LEAST_JITTER), seed).T)

    def seen(self, snapshot):
        """See ``Scene.seen``."""
        if not self.has_free_bodies:
            return self
        return replace(self, bodies=tuple(_as_in(snapshot, *pair) for pair in enumerate(self.bodies)))

    def contains(self, points, time=0.0):
        """Whether each of the ``points`` (n, 2) is in the fluid at ``time``."""
        return self.distance(points, time) >= 0.0

    def distance(self, points, time):
        """Distances (n,) of ``points`` (n, 2) from the nearest wall at ``time``, negative outside the fluid."""
        return np.min([body.nearest(points, time).distance for body in self.bodies], axis=0)


def _as_in(snapshot, index, body):
    """Return a ``body`` as it is in ``snapshot``, where it is number ``index``."""
    if not body.free:
        return body
    found = snapshot.bodies
    velocity, rotation = found.velocity[index], float(found.angular_velocity[index])
    motion = RigidMotion(*(WallMotion(float(part)) for part in (*velocity, rotation)))
    centre = tuple((found.centre[index] - snapshot.t * velocity).tolist())
    return replace(body, centre=centre, angle=float(found.angle[index]) - snapshot.t * rotation, motion=motion)
