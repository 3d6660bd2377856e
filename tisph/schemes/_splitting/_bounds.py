"""What a step has to know of the walls: where they are at its end, how fast, and what was so before."""

import numpy as np

from tisph.neighbours.points import used
from tisph.runtime import view
from tisph.schemes._splitting._closure import Closure
from tisph.schemes._splitting._history import VELOCITIES
from tisph.schemes._splitting._walls import FARTHEST

KEPT = 2
"""Times at which the curl of the vorticity at walls is kept, to be extrapolated: from three it is unstable."""


class Bounds:
    """Sets the points on the walls of a ``BoundedFlow`` and what particles know of walls; ``twists`` are newest first."""

    def __init__(self, flow, history, shift, support, skin):
        self.flow, self.walls, self.support, self.skin = flow, flow.walls, support, skin * flow.spacing
        self.history, self.points, self.shift = history, history.points, shift
        self.closure = Closure(history.rows, flow.walls, flow.spacing)
        self.slots = slice(flow.liquid, flow.particles)
        self.twists = []
        self.normal = self.velocity = None

    def place(self, time):
        """Put the points where they are at ``time``, and let the particles see the walls."""
        places = view(self.points.place)
        place, self.normal, self.velocity = self.walls.at(time)
        places[self.slots] = place % [self.flow.length, self.flow.gap]
        planes, distances = self.walls.seen(places[: self.flow.liquid], time)
        view(self.shift.planes)[: self.flow.liquid] = planes
        _, apart = self.walls.seen(places[self.slots], time)
        spacing = self.flow.spacing
        stretch = self.walls.stretch(np.concatenate([distances, apart]), self.support)
        stretch[self.slots] += FARTHEST / self.support
        view(self.history.rows.stretch)[: self.flow.particles] = stretch
        view(self.points.radius)[: self.flow.particles] = self.support * stretch * spacing + self.skin

    def close(self):
        """Turn the rows at the points to what the pressure needs."""
        self.closure.place(self.normal)

    def singular(self):
        """Return the velocities (points, 2) that the flow in the corners has where the points are."""
        place = view(self.points.place)[: self.flow.particles] + self.flow.origin
        return sum(corner.velocity(place) for corner in self.flow.corners)

    def part_off(self, split, leading):
        """Let the solvers of a step look for what the flow in the corners does not have."""
        if self.flow.corners:
            singular = self.singular()
            for field, factor in ((split.known, leading), (split.expected, 1.0), (split.velocity.x, 1.0)):
                view(field)[: self.flow.particles] -= factor * singular

    def carry(self, sign):
        """Add the flow in the corners to the velocities carried, or take it off by a ``sign`` of -1."""
        if self.flow.corners:
            carried = used(self.history.carried)[:, : 2 * VELOCITIES].reshape(-1, VELOCITIES, 2)
            carried += sign * self.singular()[:, None]
            if sign > 0:
                velocity = carried[: self.flow.liquid, 0]
                view(self.history.fastest)[()] = np.linalg.norm(velocity - velocity.mean(axis=0), axis=1).max()

    def begin(self, split):
        """Let the points have the velocities of the walls at the start, and the pressure meet their acceleration."""
        used(self.history.carried)[self.slots, :2] = self.velocity
        self.carry(-1)
        view(split.velocity.x)[: self.flow.particles] = used(self.history.carried)[:, :2]
        view(split.known)[self.slots] = -self.walls.acceleration(self.flow.start_time)
        self.conclude(split.velocity.x)

    def drive(self, split, times):
        """Give the velocities of the walls at the end of a step to its solvers, and the curl expected there."""
        view(split.velocity.x)[self.slots] = self.velocity
        weights = times.ahead(min(KEPT, max(1, len(self.twists))))
        self.closure.twists[...] = sum(weight * twist for weight, twist in zip(weights, self.twists, strict=False))

    def conclude(self, velocity):
        """Keep the curl of the vorticity of the ``velocity`` at the end of a step, a field."""
        self.closure.spin(velocity)
        self.twists = [self.closure.twists.copy(), *self.twists][:KEPT]
        if self.flow.corners:
            carried = used(self.history.carried)[:, 2 : 2 * VELOCITIES].reshape(-1, VELOCITIES - 1, 2)
            carried -= self.singular()[:, None]
