"""Paths of particles past corners whose flow U is known: U is evaluated along the path, w is interpolated in time."""

import numpy as np

from tisph.exact.sliding_corner import DEGREE
from tisph.runtime import holding, integer, real, ti, view
from tisph.schemes._splitting._bdf import VELOCITIES

PARTS = 2
"""Of a step, in each of which the path of a particle is found by the classical Runge-Kutta method."""

N_TIMES = 2 * PARTS + 1
"""Number of times, evenly from the start of a step to its end, at which w is interpolated."""

NEAREST = 1e-30
"""Distance from a corner that stands for none."""


@ti.data_oriented
class SingularPaths:
    """Paths of the particles of ``levels`` in the sum of the flows in the ``corners``; positions count from ``origin``.

    ``positions`` (particles): at some time after, or before, the end of the last step.
    """

    def __init__(self, corners, origin, levels):
        self.levels, self.points, self.number = levels, levels.points, integer(len(corners))
        vector, matrix = ti.types.vector(2, real()), ti.types.matrix(2, 2, real())
        field = lambda kind, values: holding(ti.field(kind, len(values)), values)  # noqa: E731
        self.place = field(vector, [np.subtract(corner.place, origin) for corner in corners])
        self.frame = field(matrix, [[corner.along, corner.inward] for corner in corners])
        self.stokes = field(ti.types.vector(4, real()), [corner.stokes_coefficients for corner in corners])
        self.inertial = field(vector, np.concatenate([corner.inertial_coefficients[:, :2] for corner in corners]))
        self.angle, self.viscosity, self.decay_length = (
            field(real(), [getattr(corner, name) for corner in corners])
            for name in ("angle", "kinematic_viscosity", "decay_length")
        )
        self.weights = holding(ti.field(ti.types.vector(VELOCITIES, real()), N_TIMES), 0.0)
        self.positions = self.points.field(vector)

    def find(self, weights, dt):
        """Return the positions (n, 2) of the particles after a time ``dt``, maybe negative, as they lie in memory.

        ``weights(theta)`` (levels, n) give w at the fractions theta (n,) of that time.
        """
        view(self.weights)[...] = weights(np.linspace(0.0, 1.0, N_TIMES)).T
        self.integrate(dt / PARTS)
        return view(self.positions)[: int(view(self.points.n_fluid))].astype(float)

    @ti.kernel
    def integrate(self, step: float):
        """Find all paths, in parts of length ``step``."""
        ti.loop_config(serialize=self.points.serial)
        for i in range(self.points.n_fluid[None]):
            start = self.levels.position[i]
            position, total = start, ti.Vector([0.0, 0.0])
            for stage in range(4 * PARTS):
                k = stage % 4
                rate = self.velocity(position) + self.regular_velocity(stage // 4 * 2 + (k + 1) // 2, i)
                inner = k == 1 or k == 2
                total += ti.select(inner, 2.0, 1.0) * rate
                position = start + ti.select(k < 2, 0.5, 1.0) * step * rate
                if k == 3:
                    start += step / 6.0 * total
                    position, total = start, ti.Vector([0.0, 0.0])
            self.positions[i] = start

    @ti.func
    def regular_velocity(self, time, i):
        """Return w of a particle at one of the times."""
        weights, regular = self.weights[time], ti.Vector([0.0, 0.0])
        for level in ti.static(range(VELOCITIES)):
            regular += weights[level] * self.levels.velocity(level, i)
        return regular

    @ti.func
    def velocity(self, position):
        """Return U at a position; ``CornerSingularity.velocity`` has the formula."""
        velocity = ti.Vector([0.0, 0.0])
        for corner in range(self.number[None]):
            frame = self.frame[corner]
            away = frame @ (position - self.place[corner])
            radius, theta = ti.max(away.norm(), NEAREST), ti.atan2(away.y, away.x)
            cosine, sine = away.x / radius, away.y / radius
            a, b, c, d = self.stokes[corner]
            waves = ti.Vector([c * cosine + d * sine, d * cosine - c * sine])
            f = a * cosine + b * sine + theta * waves[0]
            derivative = b * cosine - a * sine + waves[0] + theta * waves[1]
            inertial, part = ti.Vector([0.0, 0.0]), 2.0 * theta / self.angle[corner] - 1.0
            for power in range(DEGREE + 1):
                inertial = part * inertial + self.inertial[corner * (DEGREE + 1) + power]
            square = (radius / self.decay_length[corner]) ** 2
            scale = radius / self.viscosity[corner] * ti.exp(-square)
            u_r, u_theta = derivative + scale * inertial[1], -f - scale * (2.0 - 2.0 * square) * inertial[0]
            local = ti.Vector([u_r * cosine - u_theta * sine, u_r * sine + u_theta * cosine])
            velocity += frame.transpose() @ local
        return velocity
