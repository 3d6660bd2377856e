"""Scenes with bodies: their particles fill what these leave of the box."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from tisph.geometry.motion import RigidMotion, WallMotion
from tisph.geometry.packing import pack
from tisph.geometry.region import Region
from tisph.scenes._scene import Scene
from tisph.snapshot import STRESSES

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
