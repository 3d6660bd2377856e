"""Positions, velocities and pressures of the particles at the last time levels, and their transfer with a shift.

``TimeWeights`` are the weights of the levels, for variable steps: backward differences (BDF), integrals, interpolation.
"""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._two_dimensional.coordinates import Coordinates

VELOCITIES, PRESSURES = 4, 2
"""Number of time levels: at the end of the last step, and of those before."""

ORDER = 3
"""Of the backward differences. Those of order 4 are unstable for oscillations, and measured no better."""


class TimeWeights:
    """Weights by the polynomials through the values at the ends of some steps.

    ``steps`` are the times between now, the newest value, the one before and so on, newest first: with a first one of
    0 the newest value is that of now. ``unit`` is the unit of time of the polynomials, ``offsets`` are the times before
    now in it. Weights come for as many values as are stored; of those that are not known yet they are 0.
    """

    def __init__(self, steps, unit):
        self.steps, self.unit = steps, unit
        self.offsets = np.cumsum(steps) / unit

    def _weights(self, count, functional, offsets=None):
        """Return the weights of the newest values that give a functional, known by its values for 1, t, t^2 ..."""
        offsets = self.offsets[:count] if offsets is None else offsets
        powers = np.arange(len(offsets))
        found = np.linalg.solve((-offsets) ** powers[:, None], np.array([functional(power) for power in powers]))
        return np.concatenate([found, np.zeros((count - len(offsets), *found.shape[1:]))])

    def interpolation(self, offset, count):
        """Return the weights of ``count`` values that give the value at the time ``offset`` before now.

        For offsets (n,) weights are (count, n).
        """
        return self._weights(count, lambda power: (-offset / self.unit) ** power)

    def extrapolation(self, count):
        """Return the weights of ``count`` values that extrapolate them to now."""
        return self.interpolation(0.0, count)

    def integral(self, offset):
        """Return the weights of the velocities in the displacement since the time ``offset`` before now."""
        begin = -offset / self.unit
        return self.unit * self._weights(VELOCITIES, lambda power: -(begin ** (power + 1)) / (power + 1))

    def step_integral(self):
        """Return the weights of the velocities in the displacement of the step from the newest of them to now."""
        return self.integral(self.steps[0])

    def bdf(self):
        """Return gamma_0 and the alpha_q of unit du/dt = gamma_0 u(now) - sum alpha_q u_q, by backward differences."""
        offsets = np.concatenate([[0.0], self.offsets[:ORDER]])
        gamma0, *alpha = self._weights(ORDER + 1, lambda power: float(power == 1), offsets)
        weights = np.zeros(VELOCITIES)
        weights[: len(alpha)] = np.negative(alpha)
        return float(gamma0), weights

    def step_error(self, difference, gamma0, speed):
        """Return the error of a step, and of which order it is, from the ``difference`` to extrapolated velocities.

        That is u^(m) prod offsets / m! for m values, and the error of backward differences of order m - 1 is the same
        derivative times prod offsets / (m! oldest offset gamma_0). Of a very first step only the relative change of
        the velocities is known, difference / speed: the error is taken to be half the square of that.
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
    for k in range(operators.points.count[i]):
        difference = values[operators.points.neighbours[i, k]] - own
        d_dx += operators.d_dx[i, k] * difference
        d_dy += operators.d_dy[i, k] * difference
    return d_dx, d_dy


@ti.func
def transfer(operators: ti.template(), d_dx: ti.template(), d_dy: ti.template(), i, moved):
    """Return the change of fields with these gradients over a shift of a particle, ``moved``, to second order."""
    own = moved.x * d_dx[i] + moved.y * d_dy[i]
    result = own
    for k in range(operators.points.count[i]):
        j = operators.points.neighbours[i, k]
        weight = moved.x * operators.d_dx[i, k] + moved.y * operators.d_dy[i, k]
        result += 0.5 * weight * (moved.x * d_dx[j] + moved.y * d_dy[j] - own)
    return result


@ti.data_oriented
class TimeLevels:
    """``position`` (fluid) and ``fields`` (fluid): velocities, newest first, then pressures per unit density.

    Velocities have as many components, and those, as the ``coordinates`` say; pressures begin at ``first_pressure``.

    All levels belong to one and the same path: where a particle is shifted, they become those of its new path, by the
    Taylor series to second order of fields that are smooth functions of the present position. ``divergence`` (fluid) is
    that of the newest velocities, of which ``fastest`` is the largest that moves particles, relative to the mean, and
    ``largest`` the same with what is around the axis; ``d_dx`` and ``d_dy`` are the derivatives of all fields.
    ``number`` (fluid) is that of a particle at the start: their order in memory changes.
    """

    def __init__(self, operators, shift):
        self.operators, self.points, self.shift = operators, operators.points, shift
        self.coordinates = Coordinates(operators)
        self.components = self.coordinates.components
        self.first_pressure = self.components * VELOCITIES
        kind = ti.types.vector(self.first_pressure + PRESSURES, real())
        self.position = self.points.field(ti.types.vector(2, real()))
        self.fields = ti.field(kind, self.points.slots + 1)
        self.fields.used = slice(self.points.fluid)
        self.divergence = self.points.field(real())
        self.number = self.points.field(ti.i32)
        self.d_dx, self.d_dy = (ti.field(kind, self.points.slots + 1) for _ in range(2))
        self.d_dx.used = self.d_dy.used = None
        self.step_weights = holding(ti.field(real(), VELOCITIES), 0.0)
        self.step_weights.used = None
        self.divergence_squared, self.gradient_squared, self.largest_gradient, self.fastest = (
            scalar(0.0) for _ in range(4)
        )
        self.largest = scalar(0.0) if self.coordinates.axisymmetric else self.fastest

    @ti.kernel
    def predict(self):
        """Set the points where the particles are at the end of a step, by the ``step_weights`` of their velocities."""
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
        """Return the same as unknowns of where the particle is at the end of the step."""
        return self.coordinates.carried(self.velocity(level, i), self.position[i], i)

    @ti.func
    def advance_levels(self, i, velocity, pressure):
        """Store the result of a step as the newest level; the others move on by one."""
        fields = self.fields[i]
        moved_on = fields
        for level in ti.static(range(1, VELOCITIES)):
            earlier = self.carried(level - 1, i)
            for component in ti.static(range(self.components)):
                moved_on[self.components * level + component] = earlier[component]
        for level in ti.static(range(1, PRESSURES)):
            moved_on[self.first_pressure + level] = fields[self.first_pressure + level - 1]
        for component in ti.static(range(self.components)):
            moved_on[component] = velocity[component]
        moved_on[self.first_pressure] = pressure
        self.fields[i] = moved_on

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
        divergence, gradient, largest, fastest, around = 0.0, 0.0, 0.0, 0.0, 0.0
        mean = 0.0 * self.velocity(0, 0)
        for i in range(particles):
            mean += self.velocity(0, i)
        mean /= particles
        if ti.static(self.coordinates.axisymmetric):
            mean = ti.Vector([mean[0], 0.0, 0.0])  # the only one that a frame can have
        for i in range(particles):
            d_dx, d_dy = self.d_dx[i], self.d_dy[i]
            square = self.gradient_square(i, d_dx, d_dy)
            divergence += self.divergence[i] ** 2
            gradient += square
            largest = ti.max(largest, square)
            velocity = self.velocity(0, i) - mean
            around = ti.max(around, self.coordinates.squared(i, velocity))
            if ti.static(self.coordinates.axisymmetric):
                velocity.z = 0.0
            fastest = ti.max(fastest, self.coordinates.squared(i, velocity))
        self.divergence_squared[None] = divergence
        self.gradient_squared[None] = gradient
        self.largest_gradient[None] = ti.sqrt(largest)
        self.largest[None] = ti.sqrt(around)
        self.fastest[None] = ti.sqrt(fastest)

    @ti.func
    def gradient_square(self, i, d_dx, d_dy):
        """Return the sum of the squares of the velocity gradient with these derivatives of the fields."""
        radius, square = self.coordinates.radius(i), 0.0
        if ti.static(self.coordinates.axisymmetric):
            own, metric = self.fields[i], radius**2
            square = d_dx[0] ** 2 + metric * (d_dy[0] ** 2 + d_dx[1] ** 2 + d_dx[2] ** 2)
            square += (own[1] + metric * d_dy[1]) ** 2 + own[1] ** 2 + (own[2] + metric * d_dy[2]) ** 2 + own[2] ** 2
        else:
            square = d_dx[0] ** 2 + d_dx[1] ** 2 + d_dy[0] ** 2 + d_dy[1] ** 2
        return square

    @ti.kernel
    def remap(self):
        """Take up the positions of the points, which have moved, and transfer all fields to them."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial)
        for i in range(particles):
            moved = self.coordinates.shifted(i, self.shift.moved[i])
            self.fields[i] += transfer(self.operators, self.d_dx, self.d_dy, i, moved)
            self.position[i] = self.points.domain.wrap(self.coordinates.above_axis(self.points.position[i]))

    def reorder(self, others):
        """Put the particles, and ``others`` of their fields, in the order of the cells of the last search."""
        fluid, order = int(view(self.points.n_fluid)), view(self.points.order)[: self.points.fluid]
        order = order[order < fluid]
        for field in (self.position, self.fields, self.divergence, self.number, *others):
            active(field)[:fluid] = active(field)[order]

    @property
    def divergence_scale(self):
        """Root mean square of the divergence of the newest velocities."""
        return math.sqrt(float(view(self.divergence_squared)) / int(view(self.points.n_fluid)))

    def residual(self, least):
        """Divergence over the gradient of the newest velocities, or over the ``least`` one, as root mean squares."""
        gradient = math.sqrt(float(view(self.gradient_squared)) / int(view(self.points.n_fluid)))
        return self.divergence_scale / max(gradient, least)
