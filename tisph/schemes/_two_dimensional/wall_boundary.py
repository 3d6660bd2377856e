"""Walls in a step: their positions and velocities at its end, vorticity and loads of earlier levels.

The boundary condition of the pressure at walls is its normal derivative at the points on them,

    n . grad p = n . (u^ - gamma_0 U) / dt + n . f - nu n . curl omega,

the momentum equation at the wall, in whose last term the divergence of the velocities has no part (G. E. Karniadakis,
M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, eq. 17). The vorticity omega is first the one
extrapolated to the end of the step, and then that of the velocities found with it.

The forces on bodies scatter from step to step, and with them the drag of a sample. Where particles close to a body come
to lie in layers its operators, and so its drag, jump for a few steps. Each force is compared with the cubic in time
through the two before and the two after it, which a drag that varies smoothly follows.
"""

import math
from functools import cached_property

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._two_dimensional.corner_singularities import CornerSingularities
from tisph.schemes._two_dimensional.free_bodies import FreeBodies
from tisph.schemes._two_dimensional.time_levels import VELOCITIES
from tisph.schemes._two_dimensional.wall_points import POINT_SUPPORT
from tisph.snapshot import Bodies

LOAD_STEPS = 12
"""Last steps whose forces count."""

CUBIC_NEIGHBOURS = -2, -1, 1, 2
"""Steps, from one of them, through whose forces the cubic goes."""

MEAN_RADIUS = 2.5
"""Radius, in particle spacings, of the mean with which the pressure is continued into a gap that closes."""

CURL_LEVELS = 2
"""Levels from which the curl of the vorticity at walls is extrapolated: from three it is unstable."""

STRAIGHT = 1e-12
"""Part of its speed below which a wall does not move into the fluid."""

LEVEL_LISTS = ("normal_curls", "loads", "load_times", "normal_stresses")

CONTINUED = 1.0, 0.5
"""Distances from a wall to the other one, in particle spacings, between which the pressure becomes one that is
continued from around the gap, as bodies approach."""

NARROW = 2.0
"""Width of a gap, in particle spacings, below which divergence in it is left as it is. There its removal lets it grow:
the gradient of a pressure that is to remove it has the opposite divergence."""

LOAD_LEVELS = 3
"""Levels of forces, torques and normal stresses, for values within a step."""


def scatter(times, forces):
    """Return the largest scatter of a body's force, relative to its size, and the number of that body; None if unknown.

    ``times`` (steps,), newest first, ``forces`` (steps, bodies, 2). It is the root mean square over the steps of the
    difference from the cubic, without the part that the forces on the cubic have in it, over that of the largest force.
    """
    if len(times) <= len(CUBIC_NEIGHBOURS):
        return None
    middles, squares = np.arange(2, len(times) - 2), 0.0
    for middle in middles:
        others = times[[middle + offset for offset in CUBIC_NEIGHBOURS]] - times[middle]
        weights = np.array([math.prod(b / (b - a) for b in others if b != a) for a in others])
        cubic = np.einsum("s,sbi->bi", weights, forces[[middle + offset for offset in CUBIC_NEIGHBOURS]])
        squares = squares + ((forces[middle] - cubic) ** 2).sum(axis=1) / (1.0 + weights @ weights)
    size = np.sqrt((forces[middles] ** 2).sum(axis=2).mean(axis=0).max())
    worst = int(np.argmax(squares))
    return (math.sqrt(squares[worst] / len(middles)) / size, worst) if size > 0.0 else None


@ti.data_oriented
class PressureBoundaryCondition:
    """Equations at the points on ``walls``.

    ``normal`` into the fluid and ``weight`` of a point, the length of its part of the wall over the area of a
    particle: with it a constant pressure is left by the equations of particles and points alike.

    ``closing``: bodies may come so close that between them there is no particle, but points on both, whose equations
    are one and the same: what the pressure is there they leave open. ``continued`` is the part, 0 to 1, in which it is
    the mean of the pressures around instead, which continues it into the gap. ``narrow`` tells whether a particle is in
    a gap in which divergence is left as it is.
    """

    def __init__(self, levels, walls, spacing, closing=False):
        self.operators, self.points, self.coordinates = levels.operators, levels.points, levels.coordinates
        vector, capacity = ti.types.vector(2, real()), self.points.capacity
        self.normal = ti.field(vector, capacity)
        self.normal_curl, self.vorticity = (ti.field(real(), size) for size in (capacity, self.points.slots + 1))
        weight, self.slots = np.zeros(capacity), slice(self.points.fluid - walls.count, self.points.fluid)
        weight[self.slots] = walls.length / spacing**2
        self.weight = holding(ti.field(real(), capacity), weight)
        self.closing = closing
        if closing:
            self.continued = ti.field(real(), capacity)
            self.narrow = ti.field(ti.i32, capacity)
            self.per_spacing = scalar(1.0 / spacing)

    @ti.kernel
    def impose_neumann_rows(self):
        """Let the operators of the Laplacian be those of the normal derivative times the weight."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            normal, total = self.weight[i] * self.normal[i], 0.0
            normal.y *= self.coordinates.radius(i)
            for k in range(self.points.count[i]):
                weight = normal.x * self.operators.d_dx[i, k] + normal.y * self.operators.d_dy[i, k]
                if ti.static(self.closing):
                    weight += self.continued[i] * (self.nearness(i, k) - weight)
                self.operators.laplacian[i, k] = weight
                total += weight
            self.operators.diagonal[i] = -total

    @ti.func
    def nearness(self, i, k):
        """Return the weight of neighbour ``k`` of a point in the mean of its neighbours, over the spacing squared."""
        apart = self.points.separation(i, self.points.neighbours[i, k]) * self.per_spacing[None]
        return self.per_spacing[None] ** 2 * ti.max(0.0, 1.0 - apart.dot(apart) / MEAN_RADIUS**2) ** 2

    @ti.func
    def find_normal_curls(self):
        """Take up the normal part of the curl of the ``vorticity`` at the points."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            self.normal_curl[i] = self.curl(i)

    @ti.func
    def curl(self, i):
        """Return the normal part of the vorticity's curl at a point."""
        own, normal, radius = self.vorticity[i], self.normal[i], self.coordinates.radius(i)
        total = self.coordinates.hoop(normal.x * own)
        normal *= ti.Vector([radius * radius, radius])
        for k in range(self.points.count[i]):
            weight = normal.x * self.operators.d_dy[i, k] - normal.y * self.operators.d_dx[i, k]
            total += weight * (self.vorticity[self.points.neighbours[i, k]] - own)
        return total

    @property
    def normal_curls(self):
        """Normal parts of the vorticity's curl, (count,), in place."""
        return view(self.normal_curl)[self.slots]

    @ti.func
    def right_side(self, i, acceleration, viscosity):
        """Return the right side at a point where all but pressure and viscosity give an ``acceleration``."""
        along = self.normal[i].x * acceleration.x + self.coordinates.radius(i) * self.normal[i].y * acceleration.y
        result = -self.weight[i] * (along - viscosity * self.normal_curl[i])
        if ti.static(self.closing):
            result *= 1.0 - self.continued[i]
        return result


class WallBoundary:
    """Sets the points on the walls of a ``BoundedProblem`` and the distances of particles from walls.

    ``normal_curls`` (points,), n . curl omega, and ``loads`` (2, bodies, 3), force and torque of all and of the
    pressure, are lists of levels, newest first; so are ``load_times``, since walls jumped last, and
    ``normal_stresses`` (bodies,), N1 of a polymer.
    """

    def __init__(self, problem, levels, shift, grid, support, skin):
        self.problem, self.walls, self.support, self.skin = problem, problem.walls, support, skin * problem.spacing
        self.levels, self.points, self.shift, self.grid = levels, levels.points, shift, grid
        self.pressure_boundary = PressureBoundaryCondition(
            levels, problem.walls, problem.spacing, problem.contact is not None
        )
        self.slots = slice(problem.n_fluid, problem.particles)
        self.corners = CornerSingularities(problem.corners, problem.origin, levels) if problem.corners else None
        self.normal_curls, self.loads, self.load_times, self.normal_stresses = [], [], [], []
        self.normal = self.velocity = self.grid_time = None
        self.free = FreeBodies(problem) if problem.contact else None

    def reset(self):
        """Go back to before the first step."""
        self.grid_time = None
        if self.free:
            self.free.reset(self.problem.start_time)

    def update_positions(self, time):
        """Set the positions of the points at ``time``, and the nearest walls of the particles."""
        positions = view(self.points.position)
        position, self.normal, self.velocity = self.walls.at(time)
        positions[self.slots] = position % [self.problem.length, self.problem.height]
        planes, distances, curvatures = self.walls.nearest_walls(positions[: self.problem.particles], time)
        if self.levels.operators.curved:
            view(self.levels.operators.polar_map)[: self.problem.particles] = self.walls.polar_map(
                positions[: self.problem.particles], planes, distances, curvatures
            )
        mirrors = self.walls.mirrors(positions[: self.problem.particles], planes, distances)
        view(self.shift.planes)[: self.problem.n_fluid] = mirrors[: self.problem.n_fluid]
        spacing = self.problem.spacing
        factor = self.walls.support_factor(distances, self.support)
        factor[self.slots] += POINT_SUPPORT / self.support
        view(self.levels.operators.support_factor)[: self.problem.particles] = factor
        view(self.points.radius)[: self.problem.particles] = self.support * factor * spacing + self.skin

        if self.free:
            nearness = (CONTINUED[0] - distances[self.slots, 1] / spacing) / (CONTINUED[0] - CONTINUED[1])
            view(self.pressure_boundary.continued)[self.slots] = np.clip(nearness, 0.0, 1.0)
            narrow = distances[: self.problem.n_fluid].sum(axis=1) < NARROW * spacing
            view(self.pressure_boundary.narrow)[: self.problem.n_fluid] = narrow
        inwards = np.abs(self.inwards(self.velocity)).max()
        if self.grid_time is None or inwards * abs(time - self.grid_time) > spacing:
            self.set_grid(time)

    def set_grid(self, time):
        """Let the ``grid`` of the pressure know where the walls are at ``time``: once, and when they have moved on."""
        self.grid.set_walls(lambda position: self.walls.distance(position, time))
        self.grid_time, self.grid_bodies = time, self.free.state() if self.free else None

    def impose_neumann_rows(self):
        """Replace the Laplacian at the points by the Neumann condition of the pressure."""
        view(self.pressure_boundary.normal)[self.slots] = self.normal
        self.pressure_boundary.impose_neumann_rows()

    def add_corner_force(self, splitting, times, dt):
        """Let the solvers of a step ``dt`` compute the regular part, without the known flow in the corners."""
        if self.corners:
            force = self.corners.force(dt, times.extrapolation(CURL_LEVELS))
            view(splitting.u_history)[: self.problem.particles] -= dt * force[: self.problem.particles]

    @property
    def positions(self):
        """Positions of particles and points (points, 2)."""
        return view(self.points.position)[: self.problem.particles].astype(float)

    @property
    def regular_velocities(self):
        """Velocities (points, levels, 2) of all, in place: less those of the known flow in the corners."""
        levels = self.levels
        velocities = active(levels.fields)[: self.problem.particles, : levels.first_pressure]
        return velocities.reshape(-1, VELOCITIES, levels.components)

    @cached_property
    def corner_velocity(self):
        """Velocities (count, 2) of the known flow at the points, which stay where they are beside such corners."""
        return self.corners.velocity(self.positions[self.slots])

    @cached_property
    def corner_traction(self):
        """Its tractions (2, count, 2) there."""
        return self.corners.traction(self.positions[self.slots], self.normal, self.problem.kinematic_viscosity)

    def predict(self, times, dt):
        """Set the positions of the particles after a step ``dt``, where there is a known flow in the corners."""
        if self.corners:
            position = self.corners.paths.find(lambda part: times.interpolation((1.0 - part) * dt, VELOCITIES), dt)
            view(self.points.position)[: self.problem.n_fluid] = position % [self.problem.length, self.problem.height]

    def jump(self, time):
        """Let the points have the velocities of the walls after ``time``, at which these jump."""
        if self.free:
            self.free.restart()
        self.load_times = []
        self.velocity = self.walls.at(math.nextafter(time, math.inf))[2]  # at the very time they have the old ones
        self.regular_velocities[self.slots, 0] = self.velocity

    def find_fastest(self):
        """Take up the largest velocity relative to the mean, with the known flow in the corners."""
        if self.corners:
            self.corners.paths.find_fastest()

    def begin(self, splitting, tolerance, more_impulse=None):
        """Let the points have the velocities of the walls at the start, and the pressure meet their acceleration.

        Return whether the system of the impulse was solved where walls move into the fluid. ``more_impulse`` applies a
        further impulse and returns whether its system was solved.
        """
        regular, started, against = self.regular_velocities, True, self.velocity - self.fluid_velocity
        if splitting.coupling:
            started = splitting.coupling.begin(tolerance)
        elif self.problem.has_own_start or np.abs(self.inwards(against)).max() > STRAIGHT * np.abs(against).max():
            started = self.find_impulse(splitting, tolerance)
            splitting.apply_impulse()
        if more_impulse:
            started = more_impulse() and started
        regular[self.slots, 0] = self.velocity
        if self.corners:
            regular[:, 0] -= self.corners.velocity(self.positions)
        view(splitting.velocity.x)[: self.problem.particles] = regular[:, 0]
        self.set_acceleration(splitting)
        splitting.find_normal_curls()
        self.store_normal_curls()
        return started

    @property
    def fluid_velocity(self):
        """Velocities (count, components) at the points of the fluid before the start, as unknowns."""
        start = self.problem.initial_velocity
        if not start:
            return np.zeros_like(self.velocity)
        return self.problem.unknowns_given(start, *(self.positions[self.slots] + self.problem.origin).T)

    def inwards(self, velocity):
        """Return the parts (count,) into the fluid of velocities (count, 2) at the points."""
        return self.walls.inwards(self.normal, velocity)

    def find_impulse(self, splitting, tolerance):
        """Find the impulse of a pressure with which the fluid starts as the walls do; return whether there is one."""
        view(splitting.velocity.x)[self.slots] = self.velocity - self.fluid_velocity
        return splitting.find_impulse(tolerance, self.problem.has_own_start)

    def set_acceleration(self, splitting):
        """Give the accelerations of the walls at the start to the solver of the pressure."""
        acceleration = -self.walls.acceleration(self.problem.start_time)
        if self.problem.body_force:
            places = (self.positions[self.slots] + self.problem.origin).T
            acceleration += self.problem.unknowns_given(self.problem.body_force, *places, self.problem.start_time)
        if self.corners:
            acceleration -= self.corners.force(0.0, (1.0, 0.0))[self.slots]
        view(splitting.u_history)[self.slots] = acceleration

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        lists = {name: [array.tolist() for array in getattr(self, name)] for name in LEVEL_LISTS}
        free = self.free.state() if self.free else None
        return {**lists, "grid_time": self.grid_time, "grid_bodies": self.grid_bodies, "free": free}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in LEVEL_LISTS:
            setattr(self, name, [np.array(values) for values in state[name]])
        if self.free:  # which are no more where they were when the grid was set
            self.free.restore(state["grid_bodies"])
        self.set_grid(state["grid_time"])
        if self.free:
            self.free.restore(state["free"])

    def measure(self, time, extra_stress=None):
        """Take up the force and torque on each body, from the fields at the points at the end of a step at ``time``."""
        extra = extra_stress.wall_stress() if extra_stress else 0.0
        if self.problem.carries_stress:
            (xx, xy, yy), (x, y) = extra[:3], self.normal.T
            difference = (yy - xx) * (x**2 - y**2) - 4.0 * xy * x * y  # N1 at the walls
            normals = self.problem.density * self.walls.means(difference)
            self.normal_stresses = [normals, *self.normal_stresses][:LOAD_LEVELS]
        pressure = active(self.levels.fields)[self.slots, self.levels.first_pressure].astype(float)
        loads = self.problem.density * self.walls.sums(self.tractions(pressure, self.strain(), extra), time)
        self.loads = [loads, *self.loads][:LOAD_STEPS]
        self.load_times = [np.array(time), *self.load_times][:LOAD_STEPS]

    @property
    def load_scatter(self):
        """Return the largest ``scatter`` of the forces on closed bodies, and the body's number; None if unknown."""
        closed = [number for number, body in enumerate(self.walls.bodies) if body.shape.area > 0.0]
        if self.free or not closed:
            return None
        forces = np.array([loads[0][closed, :2] for loads in self.loads[: len(self.load_times)]])
        found = scatter(np.array(self.load_times), forces)
        return found and (found[0], closed[found[1]])

    def strain(self):
        """Return 2 D (numbers, count), xx, xy and yy, at the points, of the velocities whose gradients are measured.

        In axisymmetric flow those around the axis follow: of x and that, and of y and that.
        """
        fields, components = (self.levels.d_dx, self.levels.d_dy), self.levels.components
        parts = (view(field)[self.slots, :components].T.astype(float) for field in fields)
        return self.walls.strain(self.velocity.T, *parts)

    def tractions(self, pressure, strain, extra):
        """Return the tractions (2, count, components) of all and of the pressure, per unit density."""
        stress, normal = self.problem.solvent_viscosity * strain + extra, self.normal.T
        rows = (stress[:2], stress[1:3], stress[3:])[: self.levels.components]
        viscous = np.stack([(row * normal).sum(axis=0) for row in rows])
        pushing = np.zeros_like(viscous)
        pushing[:2] = -pressure * normal
        tractions = np.stack([viscous.T, pushing.T])
        if self.corners:
            tractions += self.corner_traction
        viscous, pressure = tractions
        return np.stack([viscous + pressure, pressure])

    def bodies(self, time, times, offset):
        """Return the ``Bodies`` at ``time``, ``offset`` before the end of the last step, from which ``times`` count."""
        weights = times.interpolation(offset, min(LOAD_LEVELS, len(self.loads)))
        loads, normals = (
            sum(weight * each for weight, each in zip(weights, levels, strict=False)) if levels else None
            for levels in (self.loads, self.normal_stresses)
        )
        # it depends on where bodies are, and on nothing else: no levels of it are needed
        contact = self.free.contact.loads(time)[0] if self.free else None
        return Bodies.at(time, self.walls.bodies, loads, normals, contact)

    def contacts(self):
        """Return how many contacts free bodies have had, for how long, and the largest force; nothing without them."""
        if not self.free:
            return {}
        contact = self.free.contact
        return {"contacts": contact.count, "contact_time": contact.duration, "contact_force": contact.largest}

    def set_wall_velocities(self, splitting, times):
        """Give the velocities of the walls at the end of a step to its solvers, and the extrapolated curl."""
        self.impose_velocities(splitting)
        weights = times.extrapolation(min(CURL_LEVELS, max(1, len(self.normal_curls))))
        self.pressure_boundary.normal_curls[...] = sum(
            weight * curl for weight, curl in zip(weights, self.normal_curls, strict=False)
        )

    def impose_velocities(self, splitting):
        """Give the present velocities of the walls to the solvers."""
        regular = self.velocity
        if self.corners:
            regular = regular - self.corner_velocity
        view(splitting.velocity.x)[self.slots] = regular

    def store_normal_curls(self):
        """Keep the curl of the vorticity at the end of a step, which was found last."""
        self.normal_curls = [self.pressure_boundary.normal_curls.copy(), *self.normal_curls][:CURL_LEVELS]
