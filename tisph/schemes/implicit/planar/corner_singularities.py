"""Corners where the velocities of two walls differ: the known flow there is subtracted, the scheme computes the rest.

With the flow U of ``exact/sliding_corner.py``, and P its pressure per unit density, w = u - U and q = p - P obey

    dw/dt = -grad q + nu lap w - F,    F = u . grad U - (nu lap U - grad P),

along the paths of the particles, and are small and smooth near the corners, where u, its acceleration and p are not.
The particles carry w; along their paths U is evaluated everywhere, and w is interpolated in time.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tisph.exact.sliding_corner import DEGREE
from tisph.runtime import holding, integer, real, ti, view
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, TimeLevels, TimeWeights

PARTS = 2
"""Parts of a step: in each the path of a particle is integrated by the classical Runge-Kutta method. Far from corners
there is one part."""

FAR = 10.0
"""Distance from a corner, over the way that its wall goes in a step, from which on a path is found in one part: its
error is some 1e-7 of the distance."""

N_TIMES = 2 * PARTS + 1
"""Number of times, evenly from the start of a step to its end, at which w is interpolated."""

STEEPEST = 0.5
"""Gradient of U times a step beyond which F fades: an explicit step would be unstable with it, and so close to the
corner w is negligible."""

NEAREST = 1e-30
"""Distance from a corner that stands for none."""


@ti.data_oriented
class SingularPaths:
    """Paths of the particles of ``levels`` in the sum of the flows in the ``corners``; positions count from ``origin``.

    ``positions`` (particles): at some time after, or before, the end of the last step. ``found``: F of the points.
    """

    def __init__(self, corners: Sequence[Any], origin: Any, levels: TimeLevels) -> None:
        self.levels, self.points, self.number = levels, levels.points, integer(len(corners))
        vector, matrix = ti.types.vector(2, real()), ti.types.matrix(2, 2, real())
        field = lambda kind, values: holding(ti.field(kind, len(values)), values)  # noqa: E731
        self.place = field(vector, [np.subtract(corner.place, origin) for corner in corners])
        self.frame = field(matrix, [[corner.along, corner.inward] for corner in corners])
        self.stokes = field(ti.types.vector(4, real()), [corner.stokes_coefficients for corner in corners])
        self.inertial = field(
            ti.types.vector(4, real()), np.concatenate([corner.inertial_coefficients for corner in corners])
        )
        self.speed, self.angle, self.viscosity, self.decay_length, self.log = (
            field(real(), [getattr(corner, name) for corner in corners])
            for name in ("speed", "angle", "kinematic_viscosity", "decay_length", "pressure_coefficient")
        )
        self.weights = holding(ti.field(ti.types.vector(VELOCITIES, real()), N_TIMES), 0.0)
        self.positions, self.found = self.points.field(vector), ti.field(vector, self.points.capacity)
        self.found.used = None

    def find(self, weights: Callable[[Any], np.ndarray], dt: float) -> np.ndarray:
        """Return the positions (n, 2) of the particles after a time ``dt``, maybe negative, as they lie in memory.

        ``weights(theta)`` (levels, n) give w at the fractions theta (n,) of that time.
        """
        view(self.weights)[...] = weights(np.linspace(0.0, 1.0, N_TIMES)).T
        self.integrate(dt)
        return view(self.positions)[: self.points.in_fluid].astype(float)

    @ti.kernel
    def integrate(self, whole: float):
        """Find all paths over the ``whole`` time."""
        ti.loop_config(serialize=self.points.serial)
        for i in range(self.points.n_fluid[None]):
            start = self.levels.position[i]
            position, total = start, ti.Vector([0.0, 0.0])
            parts = self.parts(start, whole)
            step = whole / parts
            for stage in range(4 * parts):
                k = stage % 4
                time = (stage // 4 * 2 + (k + 1) // 2) * (PARTS // parts)
                rate = self.velocity(position) + self.regular_velocity(time, i)
                inner = k == 1 or k == 2
                total += ti.select(inner, 2.0, 1.0) * rate
                position = start + ti.select(k < 2, 0.5, 1.0) * step * rate
                if k == 3:
                    start += step / 6.0 * total
                    position, total = start, ti.Vector([0.0, 0.0])
            self.positions[i] = start

    @ti.func
    def parts(self, position, whole):
        """Return in how many parts of the ``whole`` time to find a path that starts at a position."""
        parts = 1
        for corner in range(self.number[None]):
            if (position - self.place[corner]).norm() < FAR * ti.abs(self.speed[corner] * whole):
                parts = PARTS
        return parts

    @ti.func
    def regular_velocity(self, time, i):
        """Return w of a particle at one of the times."""
        weights, regular = self.weights[time], ti.Vector([0.0, 0.0])
        for level in ti.static(range(VELOCITIES)):
            regular += weights[level] * self.levels.velocity(level, i)
        return regular

    @ti.kernel
    def find_force(self, dt: float, newest: float, before: float):
        """Find F of all points for a step ``dt``; ``newest`` and ``before`` are the weights of w at the last levels."""
        ti.loop_config(serialize=self.points.serial)
        for i in range(self.points.particles[None]):
            regular = newest * self.levels.velocity(0, i) + before * self.levels.velocity(1, i)
            velocity, gradient, acceleration = self.fields(self.points.position[i])
            steep = dt * gradient.norm() / STEEPEST
            self.found[i] = (gradient @ (velocity + regular) - acceleration) / (1.0 + steep**4)

    @ti.kernel
    def find_fastest(self):
        """Find the largest velocity of a particle relative to their mean, with U."""
        ti.loop_config(serialize=self.points.serial)
        for i in range(self.points.n_fluid[None]):
            self.found[i] = self.levels.velocity(0, i) + self.velocity(self.points.position[i])
        ti.loop_config(serialize=True)
        for _ in range(1):
            mean, fastest = ti.Vector([0.0, 0.0]), 0.0
            for i in range(self.points.n_fluid[None]):
                mean += self.found[i]
            mean /= self.points.n_fluid[None]
            for i in range(self.points.n_fluid[None]):
                fastest = ti.max(fastest, (self.found[i] - mean).norm())
            self.levels.fastest[None] = fastest

    @ti.func
    def velocity(self, position):
        """Return U at a position; ``CornerSingularity.velocity`` has the formula."""
        velocity = ti.Vector([0.0, 0.0])
        for corner in range(self.number[None]):
            frame = self.frame[corner]
            radius, theta, cosine, sine = self.polar(corner, position)
            f, slope, _ = self.slow(corner, theta, cosine, sine)
            inertial, part = ti.Vector([0.0, 0.0]), 2.0 * theta / self.angle[corner] - 1.0
            for power in range(DEGREE + 1):
                coefficients = self.inertial[corner * (DEGREE + 1) + power]
                inertial = part * inertial + ti.Vector([coefficients[0], coefficients[1]])
            square = (radius / self.decay_length[corner]) ** 2
            scale = radius / self.viscosity[corner] * ti.exp(-square)
            u_r, u_theta = slope + scale * inertial[1], -f - scale * (2.0 - 2.0 * square) * inertial[0]
            local = ti.Vector([u_r * cosine - u_theta * sine, u_r * sine + u_theta * cosine])
            velocity += frame.transpose() @ local
        return velocity

    @ti.func
    def polar(self, corner, position):
        """Return the polar coordinates of a position from a corner, and the cosine and sine of the second one."""
        away = self.frame[corner] @ (position - self.place[corner])
        radius = ti.max(away.norm(), NEAREST)
        return radius, ti.atan2(away.y, away.x), away.x / radius, away.y / radius

    @ti.func
    def slow(self, corner, theta, cosine, sine):
        """Return f and its first two derivatives at an angle ``theta``."""
        a, b, c, d = self.stokes[corner]
        waves = ti.Vector([c * cosine + d * sine, d * cosine - c * sine])
        f = a * cosine + b * sine + theta * waves[0]
        return f, b * cosine - a * sine + waves[0] + theta * waves[1], 2.0 * waves[1] - f

    @ti.func
    def fields(self, position):
        """Return U, its gradient, of a component along its first axis, and the acceleration by its stresses.

        ``CornerSingularity`` has the formulas.
        """
        velocity, acceleration = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
        gradient = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
        for corner in range(self.number[None]):
            radius, theta, cosine, sine = self.polar(corner, position)
            f, slope, bend = self.slow(corner, theta, cosine, sine)
            h, part = ti.Vector([0.0, 0.0, 0.0, 0.0]), 2.0 * theta / self.angle[corner] - 1.0
            for power in range(DEGREE + 1):
                h = part * h + self.inertial[corner * (DEGREE + 1) + power]
            length, viscosity = self.decay_length[corner], self.viscosity[corner]
            square, k = (radius / length) ** 2, radius / length**2
            chi = ti.exp(-square)
            first, second = (2.0 - 2.0 * square) * chi, (2.0 - 10.0 * square + 4.0 * square**2) * chi
            third = k * (-24.0 + 36.0 * square - 8.0 * square**2) * chi
            ways = ti.Matrix([[cosine, sine], [-sine, cosine]]) @ self.frame[corner]
            scale, g = radius / viscosity, h / viscosity
            velocity += ways.transpose() @ ti.Vector([slope + scale * chi * h[1], -f - scale * first * h[0]])
            local = ti.Matrix(
                [
                    [(chi - 2.0 * square * chi) * g[1], (bend + f) / radius + chi * g[2] + first * g[0]],
                    [-second * g[0], (chi - first) * g[1]],
                ]
            )
            gradient += ways.transpose() @ local @ ways
            log = (chi / radius - 2.0 * k * chi * ti.log(radius / length)) * self.log[corner]
            radial = (second + first) * h[1] / radius + chi * h[3] / radius - log
            turning = -(third + k * (4.0 * square - 8.0) * chi) * h[0] + 2.0 * k * chi * h[2]
            acceleration += ways.transpose() @ ti.Vector([radial, turning])
        return velocity, gradient, acceleration


class Corners:
    """The known flow in singular corners of the walls; here none, so that u = w."""

    def predict(self, weights: TimeWeights, dt: float) -> None:
        """Leave the points at their predicted positions."""

    def add_force(self, forcing: Any, weights: TimeWeights, dt: float) -> None:
        """Add no force."""

    def add_start_force(self, acceleration: np.ndarray, slots: slice) -> np.ndarray:
        """Return the ``acceleration`` as it is."""
        return acceleration

    def remove_from(self, velocity: np.ndarray, position: np.ndarray) -> None:
        """Subtract nothing."""

    def at_walls_without(self, velocity: np.ndarray) -> np.ndarray:
        """Return the ``velocity`` as it is."""
        return velocity

    def add_traction(self, tractions: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Return the ``tractions`` as they are."""
        return tractions

    def find_fastest(self) -> None:
        """Leave the fastest velocity as it is."""

    def whole_flow(
        self,
        weights: TimeWeights,
        offset: float,
        position: np.ndarray,
        velocity: np.ndarray,
        pressure: np.ndarray,
        created: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and pressure as they are."""
        return position, velocity, pressure


class CornerSingularities(Corners):
    """The sum U, P of the steady flows in the corners of a ``problem``, and w = u - U of the particles of ``levels``.

    The walls beside such corners slide along themselves, so that the points on them stay where they are.
    """

    def __init__(self, problem: Problem, levels: TimeLevels) -> None:
        self.corners, self.origin, self.problem = problem.corners, np.array(problem.origin), problem
        self.points, self.paths = levels.points, SingularPaths(problem.corners, problem.origin, levels)
        self.wall_velocity: np.ndarray | None = None
        self.wall_traction: np.ndarray | None = None

    def velocity(self, position: np.ndarray) -> np.ndarray:
        """Return U (n, 2) at positions (n, 2) in the box."""
        return sum(corner.velocity(position + self.origin) for corner in self.corners)

    def traction(self, position: np.ndarray, normal: np.ndarray, viscosity: float) -> np.ndarray:
        """Return the parts (2, n, 2) of viscosity and pressure of the force per area and density along ``normal``."""
        place = position + self.origin
        gradient = sum(corner.gradient(place) for corner in self.corners)
        viscous = viscosity * np.einsum("nij,nj->ni", gradient + gradient.transpose(0, 2, 1), normal)
        return np.stack([viscous, -sum(corner.pressure(place) for corner in self.corners)[:, None] * normal])

    def predict(self, weights: TimeWeights, dt: float) -> None:
        """Move the points to the positions of the particles after a step ``dt``, along paths in u = w + U."""
        position = self.paths.find(lambda part: weights.interpolation((1.0 - part) * dt, VELOCITIES), dt)
        position %= [self.problem.length, self.problem.height]
        view(self.points.position)[: self.points.in_fluid] = position

    def force(self, dt: float, weights: Any) -> np.ndarray:
        """Return F (points, 2) for a step ``dt``, with w by ``weights`` (2,) of its newest levels."""
        self.paths.find_force(dt, *weights)
        return view(self.paths.found)[: self.points.fluid]

    def add_force(self, forcing: Any, weights: TimeWeights, dt: float) -> None:
        """Add -dt F to the ``forcing`` of a step ``dt``."""
        force = self.force(dt, weights.extrapolation(2))
        view(forcing)[: self.points.fluid] -= dt * force

    def add_start_force(self, acceleration: np.ndarray, slots: slice) -> np.ndarray:
        """Return an ``acceleration`` (count, 2) of the points ``slots`` minus F at the start."""
        return acceleration - self.force(0.0, (1.0, 0.0))[slots]

    def remove_from(self, velocity: np.ndarray, position: np.ndarray) -> None:
        """Subtract U from a ``velocity`` (n, 2) in place."""
        velocity -= self.velocity(position)

    def at_walls_without(self, velocity: np.ndarray) -> np.ndarray:
        """Return a ``velocity`` (count, 2) of the points on walls minus U."""
        if self.wall_velocity is None:
            self.wall_velocity = self.velocity(self._wall_position)
        return velocity - self.wall_velocity

    def add_traction(self, tractions: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Add the tractions of U and P to ``tractions`` (2, count, 2) at walls, in place, and return them."""
        if self.wall_traction is None:
            self.wall_traction = self.traction(self._wall_position, normal, self.problem.kinematic_viscosity)
        tractions += self.wall_traction
        return tractions

    @property
    def _wall_position(self) -> np.ndarray:
        return view(self.points.position)[self.points.on_walls].astype(float)

    def find_fastest(self) -> None:
        """Set the fastest velocity of the levels to the largest u = w + U."""
        self.paths.find_fastest()

    def whole_flow(
        self,
        weights: TimeWeights,
        offset: float,
        position: np.ndarray,
        velocity: np.ndarray,
        pressure: np.ndarray,
        created: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, u and p (n, ...) for w and q at an ``offset`` before the end of the last step.

        ``created`` (n,): indices that bring the particles, as they lie in memory, into the order of ``position``.
        """
        if offset:
            at = lambda part: weights.interpolation(part * offset, VELOCITIES)  # noqa: E731
            position = self.paths.find(at, -offset)[created]
        whole = pressure + sum(corner.pressure(position + self.origin) for corner in self.corners)
        return position, velocity + self.velocity(position), whole
