"""Positions, velocities and pressures of the particles at the last time levels, and their transfer with a shift.

``TimeWeights`` are the weights of the levels, for variable steps: backward differences (BDF), integrals, interpolation.
``PlanarCoordinates`` and ``AxisymmetricCoordinates`` are the factors by which the equations of the two flows differ.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.numerics.point_cloud import active
from tisph.runtime import holding, real, scalar, ti, view

VELOCITIES, PRESSURES = 4, 2
"""Number of time levels: at the end of the last step, and of those before."""

ORDER = 3
"""Order of the backward differences. Order 4 is unstable for oscillations, and measured no better."""


class TimeWeights:
    """Weights by the polynomials through the values at the ends of some steps.

    ``steps`` are the times between now, the newest value, the one before and so on, newest first: with a first one of 0
    the newest value is the present one. ``unit`` is the unit of time of the polynomials, ``offsets`` are the times
    before now in it. Weights come for as many values as are stored; of those that are not known yet they are 0.
    """

    def __init__(self, steps: Sequence[float], unit: float) -> None:
        self.steps, self.unit = steps, unit
        self.offsets = np.cumsum(steps) / unit

    def _weights(self, count: int, values: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Return the ``count`` weights of the newest values that give a functional.

        ``values`` (offsets, ...): of the functional for 1, t, t^2 ...
        """
        powers = np.arange(len(offsets))
        found = np.linalg.solve((-offsets) ** powers[:, None], values)
        return np.concatenate([found, np.zeros((count - len(offsets), *found.shape[1:]))])

    def interpolation(self, offset: Any, count: int) -> np.ndarray:
        """Return the weights of ``count`` values that give the value at the time ``offset`` before now.

        For offsets (n,) weights are (count, n).
        """
        offsets = self.offsets[:count]
        if isinstance(offset, float) and offset == offsets[0] == 0.0:
            return np.eye(1, count)[0]  # the newest value itself
        values = np.power.outer(-np.asarray(offset) / self.unit, np.arange(len(offsets)))
        return self._weights(count, np.moveaxis(values, -1, 0), offsets)

    def extrapolation(self, count: int) -> np.ndarray:
        """Return the weights of ``count`` values that extrapolate them to now."""
        return self.interpolation(0.0, count)

    def lower_extrapolation(self) -> np.ndarray:
        """Return the weights of all velocities but the oldest that extrapolate them to now."""
        return TimeWeights(self.steps[: VELOCITIES - 1], self.unit).interpolation(0.0, VELOCITIES)

    def integral(self, offset: float) -> np.ndarray:
        """Return the weights of the velocities in the displacement since the time ``offset`` before now."""
        offsets = self.offsets[:VELOCITIES]
        powers = np.arange(1, len(offsets) + 1)
        return self.unit * self._weights(VELOCITIES, -((-offset / self.unit) ** powers) / powers, offsets)

    def step_integral(self) -> np.ndarray:
        """Return the weights of the velocities in the displacement of the step from the newest of them to now."""
        return self.integral(self.steps[0])

    def bdf(self) -> tuple[float, np.ndarray]:
        """Return gamma_0 and the alpha_q of unit du/dt = gamma_0 u(now) - sum alpha_q u_q, by backward differences."""
        offsets = np.concatenate([[0.0], self.offsets[:ORDER]])
        gamma0, *alpha = self._weights(ORDER + 1, np.eye(1, len(offsets), 1)[0], offsets)
        weights = np.zeros(VELOCITIES)
        weights[: len(alpha)] = np.negative(alpha)
        return float(gamma0), weights

    def step_error(self, difference: float, gamma0: float, speed: float) -> tuple[float, int]:
        """Return the error of a step and its order from the ``difference`` to extrapolated velocities, equation (5).

        The difference is u^(m) prod offsets / m! for m values, and the error of backward differences of order m - 1 is
        the same derivative times prod offsets / (m! oldest offset gamma_0). Of a very first step only the relative
        change of the velocities is known, difference / speed: the error is taken to be half the square of that.
        """
        known = min(len(self.offsets), VELOCITIES)
        if known == 1:
            return 0.5 * difference**2 / speed, 1
        return difference / (float(self.offsets[known - 1]) * gamma0), known - 1


@ti.func
def gradients(operators: ti.template(), values: ti.template(), i):
    """Return d/dx and d/dy of the ``values`` at a particle, by least-squares ``operators``."""
    own = values[i]
    d_dx, d_dy = 0.0 * own, 0.0 * own
    for k in range(operators.points.begin[i], operators.points.end[i]):
        difference = values[operators.points.neighbours[k]] - own
        d_dx += operators.d_dx[k] * difference
        d_dy += operators.d_dy[k] * difference
    return d_dx, d_dy


@ti.func
def transfer(operators: ti.template(), d_dx: ti.template(), d_dy: ti.template(), i, moved):
    """Return the change of fields with these gradients over a shift of a particle, ``moved``, to second order."""
    own = moved.x * d_dx[i] + moved.y * d_dy[i]
    result = own
    for k in range(operators.points.begin[i], operators.points.end[i]):
        j = operators.points.neighbours[k]
        weight = moved.x * operators.d_dx[k] + moved.y * operators.d_dy[k]
        result += 0.5 * weight * (moved.x * d_dx[j] + moved.y * d_dy[j] - own)
    return result


@ti.data_oriented
class PlanarCoordinates:
    """Planar flow: the unknowns of a point are u and v, and every factor of the radius is 1.

    It has the functions of ``AxisymmetricCoordinates``; compiled in, they cost nothing.

    """

    axisymmetric, components = False, 2

    def __init__(self, operators: Any) -> None:
        self.operators = operators

    def add_centripetal(self, velocity: np.ndarray, forcing: Any, dt: float) -> None:
        """Add nothing: planar flow has no centripetal term."""

    @ti.func
    def radius(self, i):
        """Return 1 in place of the radius."""
        return 1.0

    @ti.func
    def hoop(self, value):
        """Return 0: the divergence has its derivatives alone."""
        return 0.0

    @ti.func
    def divergence(self, i, stress: ti.template(), first: ti.template(), d_dx, d_dy):
        """Return the divergence of a stress from the derivatives of its components xx, xy, yy, from ``first`` on."""
        return ti.Vector([d_dx[first] + d_dy[first + 1], d_dx[first + 1] + d_dy[first + 2]])

    @ti.func
    def displacement(self, y, velocity):
        """Return the displacement per time at ``y`` for a velocity."""
        return ti.Vector([velocity[0], velocity[1]])

    @ti.func
    def above_axis(self, position):
        """Return a position as it is: there is no axis."""
        return position

    def carried_factors(self, before: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return the factors (n, components) of unknowns that are carried from radii ``before`` (n,) to ``radius``."""
        return np.ones((len(radius), self.components))

    @ti.func
    def carried(self, velocity, before, i):
        """Return the velocity that a particle has carried to its place."""
        return velocity

    @ti.func
    def gradient_product(self, i, velocity: ti.template(), d_dx, d_dy):
        """Return grad u : grad u = sum_ab (d_a u_b)(d_b u_a)."""
        result = d_dx[0] ** 2 + 2.0 * d_dy[0] * d_dx[1]
        result += d_dy[1] ** 2
        return result

    @ti.func
    def gradient_square(self, i, velocity: ti.template(), d_dx, d_dy):
        """Return the sum of the squares of the velocity gradient."""
        return d_dx[0] ** 2 + d_dx[1] ** 2 + d_dy[0] ** 2 + d_dy[1] ** 2

    @ti.func
    def moving(self, velocity):
        """Return the part of a velocity that moves particles: all of it."""
        return velocity

    @ti.func
    def frame(self, mean):
        """Return the velocity of the frame of a flow with this ``mean`` velocity."""
        return mean

    @ti.func
    def squared(self, i, velocity):
        """Return the square of a velocity."""
        return velocity.dot(velocity)

    @ti.func
    def shifted(self, i, moved):
        """Return the change of x and y of a particle that was shifted by ``moved``."""
        return moved


@ti.data_oriented
class AxisymmetricCoordinates:
    """Axisymmetric flow: x along the axis, y = r the distance from it; the unknowns of a point are

        u,   V = v/r,   W = w/r   and the pressure,

    with v along r and w around the axis. All of them are even in r, so that the operators of ``least_squares``, d/dx,
    d/ds with s = r^2/2, and the Laplacian d2/dx2 + d2/dr2 + (1/r) d/dr, hold for all, and nothing is divided by r:

        div u = du/dx + r^2 dV/ds + 2 V,      vorticity around the axis = r (dV/dx - du/ds),
        DV/Dt = W^2 - V^2 - dp/ds + nu (Lap V + 2 dV/ds),      DW/Dt = -2 V W + nu (Lap W + 2 dW/ds),

    Lap u and Lap p being the Laplacian alone. Along the path of a particle r V is a velocity and r^2 W the circulation;
    their derivatives have neither V^2 nor 2 V W. Backward differences are taken of these two, at the earlier r.

    """

    axisymmetric, components = True, 3

    def __init__(self, operators: Any) -> None:
        self.operators = operators

    @ti.kernel
    def add_centripetal(self, velocity: ti.template(), forcing: ti.template(), dt: float):
        """Add the centripetal term dt W^2 to the radial right-hand side."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.operators.points.particles[None]):
            forcing[i].y += dt * velocity[i].z ** 2

    @ti.func
    def radius(self, i):
        """Return the radius r of a point."""
        return self.operators.radius(i)

    @ti.func
    def hoop(self, value):
        """Return 2 V, the part of the divergence beside its derivatives, for V = ``value``."""
        return 2.0 * value

    @ti.func
    def divergence(self, i, stress: ti.template(), first: ti.template(), d_dx, d_dy):
        """Return the divergence of a stress from its components, from ``first`` on, and their derivatives.

        The components are xx, xr/r, rr, tt and, where there are as many, xt/r and rt/r^2; the last two components of
        the divergence are over r.

        """
        own, square = stress[i], self.radius(i) ** 2
        result = ti.Vector([0.0, 0.0, 0.0])
        result[1] = d_dx[first + 1] + d_dy[first + 2]
        result[0] = d_dx[first] + 2.0 * own[first + 1] + square * d_dy[first + 1]
        result[1] += (own[first + 2] - own[first + 3]) / square
        if ti.static(stress.n >= first + 6):
            result[2] = d_dx[first + 4] + 4.0 * own[first + 5] + square * d_dy[first + 5]
        return result

    @ti.func
    def displacement(self, y, velocity):
        """Return the displacement per time at ``y`` for a velocity."""
        return ti.Vector([velocity[0], velocity[1] * (y + self.operators.lowest_radius[None])])

    @ti.func
    def above_axis(self, position):
        """Return the mirror image of a position that has crossed the axis."""
        lowest = self.operators.lowest_radius[None]
        return ti.Vector([position.x, ti.abs(position.y + lowest) - lowest])

    def carried_factors(self, before: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Return the factors (n, components) of unknowns that are carried from radii ``before`` (n,) to ``radius``."""
        ratio = before / radius
        return np.stack([np.ones_like(ratio), ratio, ratio**2], axis=1)

    @ti.func
    def carried(self, velocity, before, i):
        """Return the unknowns at the present radius of a particle that carried ``velocity`` from ``before``."""
        ratio = (before.y + self.operators.lowest_radius[None]) / self.operators.radius(i)
        return ti.Vector([velocity.x, velocity.y * ratio, velocity.z * (ratio * ratio)])

    @ti.func
    def gradient_product(self, i, velocity: ti.template(), d_dx, d_dy):
        """Return grad u : grad u = sum_ab (d_a u_b)(d_b u_a)."""
        radius, across, around = self.radius(i), velocity[i][1], velocity[i][2]
        result = d_dx[0] ** 2 + 2.0 * radius**2 * d_dy[0] * d_dx[1]
        result += (across + radius**2 * d_dy[1]) ** 2 + across**2
        result -= 2.0 * around * (around + radius**2 * d_dy[2])
        return result

    @ti.func
    def gradient_square(self, i, velocity: ti.template(), d_dx, d_dy):
        """Return the sum of the squares of the velocity gradient."""
        own, metric = velocity[i], self.radius(i) ** 2
        square = d_dx[0] ** 2 + metric * (d_dy[0] ** 2 + d_dx[1] ** 2 + d_dx[2] ** 2)
        square += (own[1] + metric * d_dy[1]) ** 2 + own[1] ** 2 + (own[2] + metric * d_dy[2]) ** 2 + own[2] ** 2
        return square

    @ti.func
    def moving(self, velocity):
        """Return the part of a velocity that moves particles: W turns them in place."""
        return ti.Vector([velocity.x, velocity.y, 0.0])

    @ti.func
    def frame(self, mean):
        """Return the velocity of the frame of a flow with this ``mean``: a frame moves along the axis alone."""
        return ti.Vector([mean.x, 0.0, 0.0])

    @ti.func
    def squared(self, i, velocity):
        """Return u^2 + r^2 (V^2 + W^2)."""
        across = self.radius(i) * ti.Vector([velocity[1], velocity[2]])
        return velocity[0] ** 2 + across.dot(across)

    @ti.func
    def shifted(self, i, moved):
        """Return the change of x and s of a particle that was shifted by ``moved``."""
        return ti.Vector([moved.x, moved.y * (self.radius(i) - 0.5 * moved.y)])


@ti.data_oriented
class TimeLevels:
    """The last states of each particle: ``position`` (fluid) and ``fields`` (fluid).

    ``fields``: velocities of ``VELOCITIES`` levels, newest first, each with the unknowns of the ``coordinates``, then
    pressures per unit density of ``PRESSURES`` levels, from ``first_pressure`` on. All levels belong to one path: a
    particle that is shifted gets the levels of its new path by a Taylor series of second order.

    ``d_dx``, ``d_dy``: derivatives of all fields. ``divergence`` (fluid): divergence of the newest velocities.
    ``fastest``: largest newest velocity that moves a particle, relative to the mean where particles are
    ``carried_along``; ``largest``: the same with the velocity around the axis; ``fastest_relative``: the largest one
    over the relative spacing of its particle. ``number`` (fluid): number of a particle
    at the start, as their order in memory changes. ``passages`` (particles,): how often the fluid of a number has left,
    and other fluid has taken its place. ``others``: further fields that particles carry.

    """

    def __init__(self, operators: Any, shift: Any, carried_along: bool = True) -> None:
        self.operators, self.points, self.shift = operators, operators.points, shift
        self.carried_along = carried_along
        self.coordinates = (AxisymmetricCoordinates if operators.axisymmetric else PlanarCoordinates)(operators)
        self.components = self.coordinates.components
        self.first_pressure = self.components * VELOCITIES
        kind = ti.types.vector(self.first_pressure + PRESSURES, real())
        self.position = self.points.field(ti.types.vector(2, real()))
        self.fields = self.points.count(ti.field(kind, self.points.slots + 1))
        self.divergence = self.points.field(real())
        self.number = self.points.field(ti.i32)
        self.others: tuple[Any, ...] = ()
        self.passages = np.zeros(self.points.in_fluid, dtype=int)
        self.d_dx, self.d_dy = (ti.field(kind, self.points.slots + 1) for _ in range(2))
        self.d_dx.used = self.d_dy.used = None
        self.step_weights = holding(ti.field(real(), VELOCITIES), 0.0)
        self.step_weights.used = None
        self.divergence_squared, self.gradient_squared, self.largest_gradient, self.fastest = (
            scalar(0.0) for _ in range(4)
        )
        self.largest = scalar(0.0) if self.coordinates.axisymmetric else self.fastest
        self.fastest_relative = scalar(0.0) if self.points.graded else self.fastest

    def predict(self, weights: TimeWeights) -> None:
        """Move the points to the positions of the particles at the end of a step, by the polynomial of velocities."""
        view(self.step_weights)[...] = weights.step_integral()
        self.move_points()

    @ti.kernel
    def move_points(self):
        """Set the points to x + sum_q w_q u^(n+1-q), w being the ``step_weights``."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            position = self.position[i]
            for level in ti.static(range(VELOCITIES)):
                velocity = self.coordinates.displacement(self.position[i].y, self.velocity(level, i))
                position += self.step_weights[level] * velocity
            self.points.position[i] = self.points.domain.wrap(self.coordinates.above_axis(position))

    @ti.func
    def velocity(self, level: ti.template(), i):
        """Return the velocity of a particle ``level`` steps ago."""
        return ti.Vector([self.fields[i][self.components * level + part] for part in ti.static(range(self.components))])

    @ti.func
    def carried(self, level: ti.template(), i):
        """Return the velocity ``level`` steps ago as unknowns at the particle's position at the end of the step."""
        return self.coordinates.carried(self.velocity(level, i), self.position[i], i)

    @ti.kernel
    def store(self, velocity: ti.template(), pressure: ti.template()):
        """Store the solution of a step, two fields, as the newest level; the other levels move on by one."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            fields = self.fields[i]
            moved_on = fields
            for level in ti.static(range(1, VELOCITIES)):
                earlier = self.carried(level - 1, i)
                for component in ti.static(range(self.components)):
                    moved_on[self.components * level + component] = earlier[component]
            for level in ti.static(range(1, PRESSURES)):
                moved_on[self.first_pressure + level] = fields[self.first_pressure + level - 1]
            for component in ti.static(range(self.components)):
                moved_on[component] = velocity[i][component]
            moved_on[self.first_pressure] = pressure[i]
            self.fields[i] = moved_on

    @ti.kernel
    def store_pressure(self, pressure: ti.template()):
        """Store a field as the newest pressure."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.fields[i][self.first_pressure] = pressure[i]

    @ti.kernel
    def subtract_gradient(self, potential: ti.template()):
        """Subtract the gradient of a field from the newest velocities of the particles."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            d_dx, d_dy = gradients(self.operators, potential, i)
            self.fields[i][0] -= d_dx
            self.fields[i][1] -= d_dy

    @ti.kernel
    def measure_at_walls(self, velocity: ti.template()):
        """Compute the gradients of a velocity field at the points on walls, in place of the newest velocities."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, velocity, i)
            for component in ti.static(range(self.components)):
                self.d_dx[i][component] = d_dx[component]
                self.d_dy[i][component] = d_dy[component]

    @ti.kernel
    def measure(self):
        """Compute the gradients of all fields, and the divergence of the newest velocities."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial)
        for i in range(particles):
            d_dx, d_dy = gradients(self.operators, self.fields, i)
            self.d_dx[i], self.d_dy[i] = d_dx, d_dy
            metric = self.coordinates.radius(i) ** 2
            self.divergence[i] = d_dx[0] + metric * d_dy[1] + self.coordinates.hoop(self.fields[i][1])
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.sum_squares(self.points.n_fluid[None])

    @ti.func
    def sum_squares(self, particles):
        """Sum the squares of divergence and gradient, in a fixed order; find the largest gradient and velocity.

        Velocities are those relative to their mean.

        """
        divergence, gradient, largest, fastest, around, relative_square = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        mean = 0.0 * self.velocity(0, 0)
        for i in range(particles):
            mean += self.velocity(0, i)
        mean = self.coordinates.frame(mean / particles) if ti.static(self.carried_along) else 0.0 * mean
        for i in range(particles):
            d_dx, d_dy = self.d_dx[i], self.d_dy[i]
            square = self.coordinates.gradient_square(i, self.fields, d_dx, d_dy)
            relative = self.points.relative(i)
            divergence += (relative * self.divergence[i]) ** 2
            gradient += relative * relative * square
            largest = ti.max(largest, square)
            velocity = self.velocity(0, i) - mean
            around = ti.max(around, self.coordinates.squared(i, velocity))
            moving = self.coordinates.squared(i, self.coordinates.moving(velocity))
            fastest = ti.max(fastest, moving)
            relative_square = ti.max(relative_square, moving / relative**2)
        self.divergence_squared[None] = divergence
        self.gradient_squared[None] = gradient
        self.largest_gradient[None] = ti.sqrt(largest)
        self.largest[None] = ti.sqrt(around)
        self.fastest_relative[None] = ti.sqrt(relative_square)
        self.fastest[None] = ti.sqrt(fastest)

    @ti.kernel
    def remap(self):
        """Store the positions of the points after a shift, and transfer all fields to them."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial)
        for i in range(particles):
            moved = self.coordinates.shifted(i, self.shift.moved[i])
            self.fields[i] += transfer(self.operators, self.d_dx, self.d_dy, i, moved)
            self.position[i] = self.points.domain.wrap(self.coordinates.above_axis(self.points.position[i]))

    def reorder(self) -> None:
        """Put the particles, with all fields that they carry, in the order of the cells of the last search."""
        fluid, order = self.points.in_fluid, view(self.points.order)[: self.points.fluid]
        order = order[order < fluid]
        for field in (self.position, self.fields, self.divergence, self.number, *self.others):
            active(field)[:fluid] = active(field)[order]

    @property
    def divergence_scale(self) -> float:
        """Root mean square of the divergence of the newest velocities."""
        return math.sqrt(float(view(self.divergence_squared)) / self.points.area)

    def residual(self, least: float) -> float:
        """Divergence over the gradient of the newest velocities, or over the ``least`` one, as root mean squares."""
        gradient = math.sqrt(float(view(self.gradient_squared)) / self.points.area)
        return self.divergence_scale / max(gradient, least)
