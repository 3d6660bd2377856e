"""What the particles carry: places, velocities and pressures of the last steps, and how they follow a shift."""

import math

from tisph.neighbours.point_cloud import active
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._splitting._series import PRESSURES, VELOCITIES

CARRIED = 2 * VELOCITIES + PRESSURES


@ti.func
def slopes(operators: ti.template(), values: ti.template(), i):
    """Return the derivatives along and across of the ``values`` at a particle, by least-squares ``operators``."""
    own = values[i]
    along, across = 0.0 * own, 0.0 * own
    for k in range(operators.points.count[i]):
        difference = values[operators.points.neighbours[i, k]] - own
        along += operators.d_dx[i, k] * difference
        across += operators.d_dy[i, k] * difference
    return along, across


@ti.func
def change(operators: ti.template(), along: ti.template(), across: ti.template(), i, moved):
    """Return by how much fields with these slopes differ where a particle was ``moved`` to, to second order."""
    own = moved.x * along[i] + moved.y * across[i]
    result = own
    for k in range(operators.points.count[i]):
        j = operators.points.neighbours[i, k]
        weight = moved.x * operators.d_dx[i, k] + moved.y * operators.d_dy[i, k]
        result += 0.5 * weight * (moved.x * along[j] + moved.y * across[j] - own)
    return result


@ti.data_oriented
class History:
    """``position`` (fluid) and ``carried`` (fluid): velocities, newest first, then pressures over the density.

    All are those of one and the same liquid: where a particle is shifted, they become those of its new path, by the
    Taylor series to second order of fields that are smooth functions of the present place. ``divergence`` (fluid) is
    that of the newest velocities, ``along`` and ``across`` are the derivatives of all that is carried. ``number``
    (fluid) is that of a particle at the start: they change places in memory.
    """

    def __init__(self, operators, shift):
        self.operators, self.points, self.shift = operators, operators.points, shift
        kind = ti.types.vector(CARRIED, real())
        self.position = self.points.field(ti.types.vector(2, real()))
        self.carried = ti.field(kind, self.points.slots + 1)
        self.carried.used = slice(self.points.fluid)
        self.divergence = self.points.field(real())
        self.number = self.points.field(ti.i32)
        self.along, self.across = (ti.field(kind, self.points.slots + 1) for _ in range(2))
        self.along.used = self.across.used = None
        self.path = holding(ti.field(real(), VELOCITIES), 0.0)
        self.path.used = None
        self.divergence_squared, self.gradient_squared, self.steepest, self.fastest = (scalar(0.0) for _ in range(4))

    @ti.kernel
    def predict(self):
        """Put the points where the particles are at the end of a step, by the weights ``path`` of their velocities."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            place = self.position[i]
            for age in ti.static(range(VELOCITIES)):
                place += self.path[age] * self.velocity(age, i)
            self.points.position[i] = self.points.domain.wrap(place)

    @ti.func
    def velocity(self, age: ti.template(), i):
        """Return the velocity of a particle ``age`` steps ago."""
        return ti.Vector([self.carried[i][2 * age], self.carried[i][2 * age + 1]])

    @ti.func
    def renew(self, i, velocity, pressure):
        """Take up what a step has led to; everything else grows older."""
        carried = self.carried[i]
        aged = carried
        for age in ti.static(range(1, VELOCITIES)):
            for component in ti.static(range(2)):
                aged[2 * age + component] = carried[2 * age - 2 + component]
        for age in ti.static(range(1, PRESSURES)):
            aged[2 * VELOCITIES + age] = carried[2 * VELOCITIES + age - 1]
        aged[0], aged[1], aged[2 * VELOCITIES] = velocity.x, velocity.y, pressure
        self.carried[i] = aged

    @ti.kernel
    def measure(self):
        """Take up the slopes of all that is carried, and the divergence of the newest velocities."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial)
        for i in range(particles):
            along, across = slopes(self.operators, self.carried, i)
            self.along[i], self.across[i] = along, across
            self.divergence[i] = along[0] + across[1]
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.add_up(self.points.n_fluid[None])

    @ti.func
    def add_up(self, particles):
        """Sum the squares of divergence and gradient, in a fixed order; find the largest gradient and velocity.

        Velocities are those relative to their mean.
        """
        divergence, gradient, steepest, fastest = 0.0, 0.0, 0.0, 0.0
        mean = ti.Vector([0.0, 0.0])
        for i in range(particles):
            mean += self.velocity(0, i)
        mean /= particles
        for i in range(particles):
            along, across = self.along[i], self.across[i]
            square = along[0] ** 2 + along[1] ** 2 + across[0] ** 2 + across[1] ** 2
            divergence += self.divergence[i] ** 2
            gradient += square
            steepest = ti.max(steepest, square)
            velocity = self.velocity(0, i) - mean
            fastest = ti.max(fastest, velocity.dot(velocity))
        self.divergence_squared[None] = divergence
        self.gradient_squared[None] = gradient
        self.steepest[None] = ti.sqrt(steepest)
        self.fastest[None] = ti.sqrt(fastest)

    @ti.kernel
    def settle(self):
        """Take up the positions of the points, which have moved, and transfer all fields to them."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial)
        for i in range(particles):
            self.carried[i] += change(self.operators, self.along, self.across, i, self.shift.moved[i])
            self.position[i] = self.points.domain.wrap(self.points.position[i])

    def tidy(self, others):
        """Put the particles, and ``others`` of their fields, in the order of the cells of the last search."""
        liquid, order = int(view(self.points.n_fluid)), view(self.points.order)[: self.points.fluid]
        order = order[order < liquid]
        for field in (self.position, self.carried, self.divergence, self.number, *others):
            active(field)[:liquid] = active(field)[order]

    @property
    def divergence_scale(self):
        """Root mean square of the divergence of the newest velocities."""
        return math.sqrt(float(view(self.divergence_squared)) / int(view(self.points.n_fluid)))

    @property
    def residual(self):
        """Divergence over the gradient of the newest velocities, both as root mean squares: 0 where all are equal."""
        gradient = float(view(self.gradient_squared))
        return math.sqrt(float(view(self.divergence_squared)) / gradient) if gradient > 0.0 else 0.0
