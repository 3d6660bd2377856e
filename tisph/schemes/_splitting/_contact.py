"""Near contact of bodies that the flow carries: what keeps those apart between which there are no particles any more.

Down to about a spacing the fluid between two walls is resolved, lubrication with it. Nearer than the ``distance`` each
point of a body pushes a wall away, along the normal of that, with the pressure

    p = p_0 (distance/gap - 1)^2,      p_0 = rho U (U + nu/L),

of the velocity and the length of reference: it rises beyond all bounds as the gap closes, so no two bodies overlap. It
acts on both alike. It is a model, and no lubrication: how often, how long and how strong it acts is counted.
"""

import numpy as np

FINER = 4
"""Points of contact within a particle spacing."""

CLOSEST = 0.02
"""Part of the ``distance`` below which gaps count as that, for a finite force."""


class Contact:
    """Between the free bodies among ``bodies``, or those and the others; nearer than a ``distance`` they touch.

    ``touching``: the pairs that do at present. ``count`` of contacts so far, ``duration`` with at least one, and the
    ``largest`` force per length across the plane.
    """

    def __init__(self, bodies, distance, pressure, spacing):
        self.bodies, self.distance, self.pressure = bodies, distance, pressure
        self.outlines = [body.shape.boundary_points(spacing / FINER) if body.shape.area else None for body in bodies]
        self.pairs = [
            pair
            for first in range(len(bodies))
            for pair in ((first, second) for second in range(len(bodies)) if second != first)
            if self._acts(*pair)
        ]
        self.in_fluid = np.array([bool(body.shape.area) and body.shape.fluid_side == "outside" for body in bodies])
        self.radii = np.array(
            [body.bounding_radius if in_fluid else 0.0 for body, in_fluid in zip(bodies, self.in_fluid, strict=True)]
        )
        self.reset()

    def reset(self):
        """Forget all contacts."""
        self.touching, self.count, self.duration, self.largest = set(), 0, 0.0, 0.0

    def _acts(self, first, second):
        """Whether points of the ``first`` push against the ``second``: those of one of two bodies do, of a free one."""
        one, other = self.bodies[first], self.bodies[second]
        return one.free and one.shape.fluid_side == "outside" and (first < second or not other.free)

    def loads(self, time):
        """Return force, torque and stresslet (bodies, 4) at ``time``, and by pair the force and the smallest gap.

        Both stresslets of a pair add up to that of its force and of the vector between the centres, as those of
        ``WallPoints.sums`` are from these.
        """
        loads, forces, gaps = np.zeros((len(self.bodies), 4)), {}, {}
        for first, second in self._near_pairs(time):
            found = self._between(first, second, time)
            if found is None:
                continue
            gap, points, pushes = found
            forces[first, second], gaps[first, second] = float(np.hypot(*pushes.sum(axis=0))), gap
            for number, sign in ((first, 1.0), (second, -1.0)):
                away = points - self.bodies[number].at(time).centre
                arm = away - self.bodies[number].nearest_copy(away)
                loads[number, :2] += sign * pushes.sum(axis=0)
                along, across = np.sum(arm[:, 0] * pushes[:, 1]), np.sum(arm[:, 1] * pushes[:, 0])
                loads[number, 2:] += sign * np.array([along - across, 0.5 * (along + across)])
        return loads, forces, gaps

    def _near_pairs(self, time):
        """Return those of the pairs that may be within the distance: what is in the circles around bodies may be."""
        if not self.pairs:
            return []
        first, second = np.array(self.pairs).T
        centres = np.array([body.at(time).centre for body in self.bodies])
        apart = centres[second] - centres[first]
        away = np.hypot(*(apart - self.bodies[first[0]].nearest_copy(apart)).T)
        for number in set(second[~self.in_fluid[second]].tolist()):
            away = np.where(second == number, self.bodies[number].nearest(centres, time).distance[first], away)
        near = away <= self.radii[first] + self.radii[second] + self.distance
        return [pair for pair, may_touch in zip(self.pairs, near, strict=True) if may_touch]

    def _between(self, first, second, time):
        """Return the smallest gap, points and forces on them (n, 2) of the ``first`` body; None where it is far."""
        one, other = self.bodies[first], self.bodies[second]
        boundary = one.placed(self.outlines[first], time)
        foot = other.nearest(boundary.point, time)
        near = foot.distance < self.distance
        if not near.any():
            return None
        gaps = np.maximum(foot.distance[near], CLOSEST * self.distance)
        push = self.pressure * (self.distance / gaps - 1.0) ** 2 * boundary.length[near]
        return float(foot.distance.min()), boundary.point[near], push[:, None] * foot.normal[near]

    def accept(self, forces, dt):
        """Take note of a step ``dt`` in which pairs pushed with these ``forces``."""
        self.count += len(set(forces) - self.touching)
        self.touching = set(forces)
        self.duration += dt if forces else 0.0
        self.largest = max([self.largest, *forces.values()])

    def state(self):
        """What a resumed run needs."""
        return [sorted(map(list, self.touching)), self.count, self.duration, self.largest]

    def restore(self, state):
        """Take up what ``state`` returned."""
        touching, self.count, self.duration, self.largest = state
        self.touching = {tuple(pair) for pair in touching}
