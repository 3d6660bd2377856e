"""Where particles go past corners whose flow U is known: U is met at every place on the way, w is interpolated."""

import numpy as np

from tisph.exact.sliding_corner import DEGREE
from tisph.runtime import holding, integer, real, ti, view
from tisph.schemes._splitting._series import VELOCITIES

PARTS = 2
"""Of a step, in each of which the way of a particle is found by the classical Runge-Kutta method."""

MOMENTS = 2 * PARTS + 1
"""At which w is asked for, from the start of a step to its end, evenly."""

NEAREST = 1e-30
"""Distance from a corner that stands for none."""


@ti.data_oriented
class CornerPaths:
    """Ways of the particles of ``history`` in the sum of the flows in the ``corners``, places being from ``origin``.

    ``there`` (particles): where they are a time after, or before, the end of the last step.
    """

    def __init__(self, corners, origin, history):
        self.history, self.points, self.number = history, history.points, integer(len(corners))
        vector, matrix = ti.types.vector(2, real()), ti.types.matrix(2, 2, real())
        field = lambda kind, values: holding(ti.field(kind, len(values)), values)  # noqa: E731
        self.place = field(vector, [np.subtract(corner.place, origin) for corner in corners])
        self.frame = field(matrix, [[corner.along, corner.inward] for corner in corners])
        self.slow = field(ti.types.vector(4, real()), [corner.slow_numbers for corner in corners])
        self.inertial = field(vector, np.concatenate([corner.inertial_numbers[:, :2] for corner in corners]))
        self.angle, self.viscosity, self.reach = (
            field(real(), [getattr(corner, name) for corner in corners])
            for name in ("angle", "kinematic_viscosity", "reach")
        )
        self.weights = holding(ti.field(ti.types.vector(VELOCITIES, real()), MOMENTS), 0.0)
        self.there = self.points.field(vector)

    def find(self, weights, length):
        """Return the places (n, 2) a time ``length`` after those of the particles, or before, as they lie in memory.

        ``weights`` (ages,) give w at the part of that time that they are given, from 0 to 1.
        """
        view(self.weights)[...] = [weights(moment / (MOMENTS - 1)) for moment in range(MOMENTS)]
        self.go(length / PARTS)
        return view(self.there)[: int(view(self.points.n_fluid))].astype(float)

    @ti.kernel
    def go(self, step: float):
        """Find all ways, in parts of a length of ``step``."""
        ti.loop_config(serialize=self.points.serial)
        for i in range(self.points.n_fluid[None]):
            start = self.history.position[i]
            place, total = start, ti.Vector([0.0, 0.0])
            for stage in range(4 * PARTS):
                turn = stage % 4
                rate = self.velocity(place) + self.rest(stage // 4 * 2 + (turn + 1) // 2, i)
                inner = turn == 1 or turn == 2
                total += ti.select(inner, 2.0, 1.0) * rate
                place = start + ti.select(turn < 2, 0.5, 1.0) * step * rate
                if turn == 3:
                    start += step / 6.0 * total
                    place, total = start, ti.Vector([0.0, 0.0])
            self.there[i] = start

    @ti.func
    def rest(self, moment, i):
        """Return w of a particle at a moment."""
        weights, rest = self.weights[moment], ti.Vector([0.0, 0.0])
        for age in ti.static(range(VELOCITIES)):
            rest += weights[age] * self.history.velocity(age, i)
        return rest

    @ti.func
    def velocity(self, place):
        """Return U at a place; ``SlidingCorner.velocity`` has the formula."""
        velocity = ti.Vector([0.0, 0.0])
        for corner in range(self.number[None]):
            frame = self.frame[corner]
            away = frame @ (place - self.place[corner])
            radius, theta = ti.max(away.norm(), NEAREST), ti.atan2(away.y, away.x)
            cosine, sine = away.x / radius, away.y / radius
            a, b, c, d = self.slow[corner]
            waves = ti.Vector([c * cosine + d * sine, d * cosine - c * sine])
            f = a * cosine + b * sine + theta * waves[0]
            slope = b * cosine - a * sine + waves[0] + theta * waves[1]
            inertial, part = ti.Vector([0.0, 0.0]), 2.0 * theta / self.angle[corner] - 1.0
            for power in range(DEGREE + 1):
                inertial = part * inertial + self.inertial[corner * (DEGREE + 1) + power]
            square = (radius / self.reach[corner]) ** 2
            scale = radius / self.viscosity[corner] * ti.exp(-square)
            radial, turning = slope + scale * inertial[1], -f - scale * (2.0 - 2.0 * square) * inertial[0]
            way = ti.Vector([radial * cosine - turning * sine, radial * sine + turning * cosine])
            velocity += frame.transpose() @ way
        return velocity
