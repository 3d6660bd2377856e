"""Walls in a step: their points at its end, the pressure equations there, and the loads on bodies.

The boundary condition of the pressure at walls is its normal derivative at the points on them,

    n . grad p = n . (u^ - gamma_0 U) / dt + n . f - nu n . curl omega,

the momentum equation at the wall, in whose last term the divergence of the velocities has no part (G. E. Karniadakis,
M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, eq. 17; equation (8) of docs/theory/two-dimensional.md).
The vorticity omega is first extrapolated to the end of the step, and then computed from the velocities found with it.

The forces on bodies scatter from step to step, and with them the drag of a sample. Where particles close to a body come
to lie in layers its operators, and so its drag, jump for a few steps. Each force is compared with the cubic in time
through the two before and the two after it, which a drag that varies smoothly follows. Jumps are many steps apart.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tisph.measures.resolution import CUBIC_NEIGHBOURS, scatter_in_time
from tisph.numerics.point_cloud import active
from tisph.numerics.stokes import WallRows
from tisph.runtime import real, ti, view
from tisph.schemes.implicit.planar.corner_singularities import Corners, CornerSingularities
from tisph.schemes.implicit.planar.equations import Equations
from tisph.schemes.implicit.planar.parts import Boundary, BoundaryPart, ExtraStress
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import TimeLevels, TimeWeights
from tisph.schemes.implicit.planar.wall_points import POINT_SUPPORT
from tisph.snapshot import Bodies

LOAD_STEPS, FEWEST_LOAD_STEPS = 48, 12
"""Last steps whose forces count: half of the steps since the walls jumped, whose first ones are short, within these
numbers. In a constriction the force jumps in every tenth step, for one or two steps, by up to five times the scatter:
of the last 12 steps alone a third at Re = 100 said 1 % where the scatter was 2.4 %."""

CURL_LEVELS = 2
"""Levels from which the curl of the vorticity at walls is extrapolated: from three it is unstable."""

STRAIGHT = 1e-12
"""Part of its speed below which a wall does not move into the fluid."""

LOAD_LEVELS = 3
"""Levels of forces, torques and normal stresses, for values within a step."""


def scatter(times: np.ndarray, forces: np.ndarray, turning: np.ndarray) -> tuple[float, int] | None:
    """Return the largest scatter of a body's force, relative to its load, and the number of that body; None if unknown.

    ``times`` (steps,), newest first, ``forces`` (steps, bodies, 2), ``turning`` (steps, bodies): torques over the
    radii of the bodies, which are the load where the force is 0 by symmetry. The scatter is ``scatter_in_time`` of
    both components, over the largest root mean square force, or torque over radius.
    """
    if len(times) <= len(CUBIC_NEIGHBOURS):
        return None
    squares, middles = (scatter_in_time(times, forces) ** 2).sum(axis=1), slice(2, -2)
    squared_loads = (forces[middles] ** 2).sum(axis=2), turning[middles] ** 2
    size = np.sqrt(max(each.mean(axis=0).max() for each in squared_loads))
    worst = int(np.argmax(squares))
    return (math.sqrt(squares[worst]) / size, worst) if size > 0.0 else None


def scatter_of_each(times: np.ndarray, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return ``load_scatter`` and ``load_size`` of ``Bodies`` (bodies, 3) from ``loads`` (steps, bodies, 3).

    ``times`` (steps,), newest first.
    """
    if len(times) <= len(CUBIC_NEIGHBOURS):
        return np.full(loads.shape[1:], np.nan), np.full(loads.shape[1:], np.nan)
    return scatter_in_time(times, loads), np.sqrt(np.square(loads).mean(axis=0))


class WallLoads:
    """Tractions of the fluid at the points on walls, and the forces and torques on bodies of the last steps.

    Lists of levels, newest first: ``loads`` (2, bodies, 4), force, torque and stresslet of all stresses and of the
    pressure; ``times`` since walls jumped last; ``normal_stresses`` (bodies,), mean N1 of a polymer at each wall.
    """

    def __init__(self, problem: Problem, levels: TimeLevels, corners: Corners) -> None:
        assert problem.walls is not None
        self.problem, self.walls, self.levels, self.corners = problem, problem.walls, levels, corners
        self.loads: list[np.ndarray] = []
        self.times: list[np.ndarray] = []
        self.normal_stresses: list[np.ndarray] = []

    def measure(self, time: float, normal: np.ndarray, velocity: np.ndarray, extra: Any) -> None:
        """Store the loads at ``time``, of the newest fields.

        ``normal`` (count, 2), ``velocity`` (count, components) and ``extra`` stress (numbers, count) of the points.
        """
        if self.problem.carries_stress:
            (xx, xy, yy), (x, y) = extra[:3], normal.T
            difference = (yy - xx) * (x**2 - y**2) - 4.0 * xy * x * y  # N1 at the walls
            normals = self.problem.density * self.walls.means(difference)
            self.normal_stresses = [normals, *self.normal_stresses][:LOAD_LEVELS]
        pressure = active(self.levels.fields)[self.levels.points.on_walls, self.levels.first_pressure].astype(float)
        tractions = self.tractions(pressure, normal, self.strain(velocity), extra)
        loads = self.problem.density * self.walls.sums(tractions, time)
        self.loads = [loads, *self.loads][:LOAD_STEPS]
        self.times = [np.array(time), *self.times][: 2 * LOAD_STEPS]

    def forget(self) -> None:
        """Forget the loads of earlier times."""
        self.times = []

    def state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        levels = {"loads": self.loads, "load_times": self.times, "normal_stresses": self.normal_stresses}
        return {name: [array.tolist() for array in arrays] for name, arrays in levels.items()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``state``."""
        self.loads, self.times, self.normal_stresses = (
            [np.array(values) for values in state[name]] for name in ("loads", "load_times", "normal_stresses")
        )

    def strain(self, velocity: np.ndarray) -> np.ndarray:
        """Return 2 D (numbers, count), xx, xy, yy, of a wall ``velocity`` and the measured gradients at the points.

        In axisymmetric flow the components of x and y with the direction around the axis follow.
        """
        fields, components = (self.levels.d_dx, self.levels.d_dy), self.levels.components
        parts = (view(field)[self.levels.points.on_walls, :components].T.astype(float) for field in fields)
        return self.walls.strain(velocity.T, *parts)

    def tractions(self, pressure: np.ndarray, normal: np.ndarray, strain: np.ndarray, extra: Any) -> np.ndarray:
        """Return the tractions (2, count, components) of all stresses and of the ``pressure``, per unit density."""
        stress, normal = self.problem.solvent_viscosity * strain + extra, normal.T
        rows = (stress[:2], stress[1:3], stress[3:])[: self.levels.components]
        viscous = np.stack([(row * normal).sum(axis=0) for row in rows])
        pushing = np.zeros_like(viscous)
        pushing[:2] = -pressure * normal
        viscous, pushing = self.corners.add_traction(np.stack([viscous.T, pushing.T]), normal.T)
        return np.stack([viscous + pushing, pushing])

    def at(self, time: float, weights: TimeWeights, offset: float, contact: Any) -> Bodies:
        """Return the ``Bodies`` at ``time``, an ``offset`` before the end of the last step."""
        level_weights = weights.interpolation(offset, min(LOAD_LEVELS, len(self.loads)))
        loads, normals = (
            sum(weight * each for weight, each in zip(level_weights, levels, strict=False)) if levels else None
            for levels in (self.loads, self.normal_stresses)
        )
        found, sizes = scatter_of_each(*self.recent)
        return replace(Bodies.at(time, self.walls.bodies, loads, normals, contact), load_scatter=found, load_size=sizes)

    @property
    def recent(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (steps,) and loads (steps, bodies, 3) of the steps whose loads are compared: forces and torques."""
        count = min(len(self.times), max(FEWEST_LOAD_STEPS, len(self.times) // 2))
        loads = np.reshape([each[0][:, :3] for each in self.loads[:count]], (-1, len(self.walls.bodies), 3))
        return np.array(self.times[:count]), loads

    def scatter(self, numbers: Sequence[int]) -> tuple[float, int] | None:
        """Return the largest ``scatter`` of the forces on bodies with these ``numbers``, and the number of the body.

        None if the scatter is unknown.
        """
        if not numbers:
            return None
        times, loads = self.recent
        loads = loads[:, numbers]
        shapes = [self.walls.bodies[number].shape for number in numbers]
        # the pressure at an inlet is its load, no torque around some point
        radii = np.array([math.sqrt(shape.area / math.pi) or math.inf for shape in shapes])
        found = scatter(times, loads[:, :, :2], loads[:, :, 2] / radii)
        return found and (found[0], numbers[found[1]])


@ti.data_oriented
class WallBoundary(Boundary):
    """The ``Boundary`` of a problem with walls: walls of given motion, and ``parts`` with conditions of their own.

    ``normal`` into the fluid and ``weight`` of a point, the length of its part of the wall over the area of a particle:
    with this weight a constant pressure is left by the equations of particles and points alike. ``normal_curls``:
    levels of n . curl omega (count,), newest first. ``loads``: ``WallLoads``.
    """

    bounded = True

    def __init__(
        self, problem: Problem, levels: TimeLevels, shift: Any, grid: Any, extra_stress: ExtraStress, support: float
    ) -> None:
        super().__init__(problem, levels, support)
        assert problem.walls is not None
        self.walls, self.points = problem.walls, levels.points
        self.shift, self.grid = shift, grid
        self.operators, self.coordinates, self.extra_stress = levels.operators, levels.coordinates, extra_stress
        if problem.corners:
            self.corners = CornerSingularities(problem, levels)
        self.loads = WallLoads(problem, levels, self.corners)
        self.normal_curls: list[np.ndarray] = []
        self.normals, self.velocity = np.empty((0, 2)), np.empty((0, 2))
        self.grid_time: float | None = None
        capacity = self.points.capacity
        self.normal = ti.field(ti.types.vector(2, real()), capacity)
        self.normal_curl, self.vorticity = (ti.field(real(), size) for size in (capacity, self.points.slots + 1))
        self.weight = ti.field(real(), capacity)
        self.grid_places: list[Any] = []

    def add(self, part: BoundaryPart) -> None:
        """Let a ``part`` take part in all that follows."""
        self.parts = [*self.parts, part]
        self.outlet = self.outlet or part.outlet
        self.pressure_gradient = max(self.pressure_gradient, part.pressure_gradient)

    @ti.func
    def divergence_to_keep(self, i, kept, gamma0):
        """Return the divergence that a step leaves at a particle, times gamma_0: ``kept`` = k gamma_0 of the newest."""
        factor, divergence = kept, self.levels.divergence[i]
        for part in ti.static(self.parts):
            factor = part.kept_part(i, factor, gamma0)
            divergence = part.divergence_before(i, divergence)
        return factor * divergence

    @ti.func
    def error_weight(self, i):
        """Return the weight of a particle in the error of a step."""
        weight = 1.0
        for part in ti.static(self.parts):
            weight = part.error_weight(i, weight)
        return weight

    def reset(self) -> None:
        """Return to the state before the first step."""
        self.grid_time = None
        for part in self.parts:
            part.reset(self.problem.start_time)

    def reject(self) -> None:
        """Take back the changes of an attempt that was rejected."""
        for part in self.parts:
            part.reject()

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Predict bodies, ends, and particles in singular corners; return whether no bodies overlap."""
        if not all(part.predict(weights, dt, time) for part in self.parts):
            return False
        self.corners.predict(weights, dt)
        return True

    def move(self, time: float) -> None:
        """Set the points at ``time``, and planes, supports and radii of all points by their nearest walls."""
        positions, n_fluid = view(self.points.position), self.points.in_fluid
        _, self.normals = self.walls.at(time)
        self.update_velocity(time)
        positions[self.slots] = self.places_on_walls(time)
        positions = positions[: self.points.fluid]
        planes, distances, curvatures = self.walls.nearest_walls(positions, time)
        relative = self.set_spacing(positions, time)
        if self.operators.curved:
            spacing = self.problem.spacing * relative
            polar = self.walls.polar_map(positions, planes, distances, curvatures, spacing)
            view(self.operators.polar_map)[: self.points.fluid] = polar
        view(self.shift.planes)[:n_fluid] = self.walls.mirrors(positions, planes, distances)[:n_fluid]
        in_spacings = distances / relative[:, None]
        self.set_supports(self.support_factors(positions, in_spacings), relative)
        for part in self.parts:
            part.approach(in_spacings)
        inwards = np.abs(self.walls.inwards(self.normals, self.velocity)[self.walls.solid]).max()
        if self.grid_time is None or inwards * abs(time - self.grid_time) > self.problem.wanted_spacing.smallest:
            self.set_grid(time)

    def renew_points(self, time: float) -> Any:
        """Place points on walls anew; see ``WallPoints.renew``."""
        splines = self.walls.renew(time)
        if splines is not None:
            self.normal_curls = [splines @ curls for curls in self.normal_curls]
        return splines

    def places_on_walls(self, time: float) -> np.ndarray:
        """Return the positions (count, 2) of the points at ``time``, in the box."""
        return self.walls.at(time)[0] % [self.problem.length, self.problem.height]

    def update_velocity(self, time: float) -> None:
        """Set the velocities of the points at ``time``, with what the parts know of them at present."""
        velocity = self.walls.velocities(time)
        for part in self.parts:
            velocity = part.velocity(velocity)
        self.velocity = velocity

    def support_factors(self, positions: np.ndarray, distances: np.ndarray) -> np.ndarray:
        """Return the factors (points,) of the supports at ``positions`` with these ``distances`` from walls.

        Distances are over the relative spacing of a point.
        """
        factor = self.walls.support_factor(distances, self.support)
        factor[self.slots] += POINT_SUPPORT / self.support
        for part in self.parts:
            factor = part.supports(factor, positions)
        return factor

    def set_grid(self, time: float) -> None:
        """Set the walls of the preconditioner's ``grid`` to ``time``: at first, and when they have moved a spacing.

        On it the pressure is 0 at an outlet.
        """
        walls = (partial(self.walls.distance, time=time, of=each) for each in self.walls.kinds if each)
        self.grid.set_walls(*walls, time=time)
        self.grid_time, self.grid_places = time, [part.places() for part in self.parts]

    def set_rows(self) -> None:
        """Replace the Laplacian at the points by the normal derivative, but for rows that parts have."""
        view(self.normal)[self.slots] = self.normals
        view(self.weight)[self.slots] = self.walls.length / self.problem.spacing**2
        self.set_neumann_rows()
        for part in self.parts:
            part.set_rows()

    @property
    def positions(self) -> np.ndarray:
        """Positions of particles and points (points, 2)."""
        return view(self.points.position)[: self.points.fluid].astype(float)

    @property
    def carried_fields(self) -> tuple[Any, ...]:
        """Fields that particles, and the fluid at the points, carry from step to step."""
        return (self.levels.fields, *self.levels.others)

    @property
    def newest_velocities(self) -> np.ndarray:
        """Newest velocities (points, components) of particles and points, in place, without the flow in corners."""
        return active(self.levels.fields)[:, : self.levels.components]

    @property
    def fluid_velocity(self) -> np.ndarray:
        """Velocities (count, components) of the fluid at the points before the start."""
        if not self.problem.initial_velocity:
            return np.zeros_like(self.velocity)
        return self.problem.unknowns_given(self.problem.initial_velocity, *self.places.T)

    @property
    def places(self) -> np.ndarray:
        """Positions (count, 2) of the points in the frame of the scene."""
        return self.positions[self.slots] + self.problem.origin

    def apply_impulse(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse of walls that start to move into the fluid; return whether its system was solved."""
        self.measure_own_start()
        view(equations.pressure.x)[...] = 0.0
        if any(part.finds_impulse for part in self.parts):
            return True
        against = self.velocity - self.fluid_velocity
        into = np.abs(self.walls.inwards(self.normals, against)).max() > STRAIGHT * np.abs(against).max()
        if not (self.problem.has_own_start or into):
            return True
        solved = self.find_impulse(equations, tolerance)
        self.levels.subtract_gradient(equations.pressure.x)
        return solved

    def measure_own_start(self) -> None:
        """Measure the divergence of given initial velocities, which the points have as well."""
        if self.problem.has_own_start:
            self.newest_velocities[self.slots] = self.fluid_velocity
            self.levels.measure()

    def find_impulse(self, equations: "Equations", tolerance: float) -> bool:
        """Solve for the impulse of the velocity of walls against the fluid; return whether it was solved."""
        view(equations.velocity.x)[self.slots] = self.velocity - self.fluid_velocity
        return equations.find_impulse(tolerance, self.problem.has_own_start)

    def begin(self, equations: "Equations") -> None:
        """Give the points their velocities after the start, and the equations the accelerations of the walls."""
        for part in self.parts:
            part.end_impulse(equations)
        self.update_velocity(self.problem.start_time)
        newest = self.newest_velocities
        newest[self.slots] = self.velocity
        self.corners.remove_from(newest, self.positions)
        view(equations.velocity.x)[: self.points.fluid] = newest
        self.set_accelerations(equations)
        self.update_normal_curls(equations.velocity.x)
        self.store_normal_curls()
        for part in self.parts:
            part.begin()

    def set_accelerations(self, equations: "Equations") -> None:
        """Set the forcing at the points to minus the acceleration of the walls, at the start."""
        start = self.problem.start_time
        acceleration = self.walls.acceleration(start)
        for part in self.parts:
            acceleration = part.acceleration(acceleration)
        view(equations.forcing)[self.slots] = self.corners.add_start_force(-acceleration, self.slots)

    def begin_without_inertia(self, time: float) -> None:
        """Begin at ``time``, with a flow that no earlier one alters."""
        for part in self.parts:
            part.reset(time)
        self.move(time)
        self.store_normal_curls()

    def forget(self) -> None:
        """Forget earlier times, at which the motion was another one."""
        self.loads.forget()
        for part in self.parts:
            part.forget()

    def jump(self, time: float) -> None:
        """Give the points the velocities of the walls after ``time``, at which these jump."""
        self.forget()
        self.update_velocity(math.nextafter(time, math.inf))  # at the very time they have the old ones
        self.newest_velocities[self.slots] = self.velocity

    def begin_step(self, weights: TimeWeights) -> None:
        """Extrapolate the curl of the vorticity to the end of a step."""
        level_weights = weights.extrapolation(min(CURL_LEVELS, max(1, len(self.normal_curls))))
        levels = zip(level_weights, self.normal_curls, strict=False)
        self.present_curls[...] = sum(weight * curl for weight, curl in levels)
        for part in self.parts:
            part.begin_step()

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x, which acts on free bodies as well."""
        for part in self.parts:
            part.accelerate(acceleration)

    def solver_velocity(self) -> np.ndarray:
        """Return the velocities (count, components) of the points without the known flow in corners."""
        return self.corners.at_walls_without(self.velocity)

    @property
    def present_curls(self) -> np.ndarray:
        """Values n . curl omega (count,) of the pressure's equation at the points, in place."""
        return view(self.normal_curl)[self.slots]

    def add_normal_momentum(self, equations: "Equations", dt: float, gamma0: float, viscosity: float) -> None:
        """Set the right-hand side of the pressure at the points, equation (8), for the present forcing and velocity."""
        fields = equations.pressure.b, equations.forcing, equations.velocity.x, equations.acceleration
        self.set_normal_momentum(*fields, dt, gamma0, viscosity)
        for part in self.parts:
            part.set_values(equations, gamma0, viscosity)

    def stokes_rows(self) -> WallRows:
        """Return the equations of velocity and pressure at the points, of the ``StokesSolver``."""
        weight, fluid = view(self.weight)[self.slots].astype(float), np.ones(self.points.in_fluid)
        rows = WallRows(self.normals, weight, np.ones(len(weight)), fluid, self.walls.strain)
        for part in self.parts:
            rows = part.stokes_rows(rows)
        return rows

    def outlet_pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Return p - nu du/dx (points,) at outlets for a ``velocity`` (points, components) of all points."""
        return np.concatenate([np.zeros(0), *(part.outlet_pressure(velocity) for part in self.parts)])

    def entered(self, position: np.ndarray) -> np.ndarray:
        """Return positions (n, 2) at a time within the last step, of particles that have all entered by then."""
        for part in self.parts:
            position = part.entered(position)
        return position

    def store_normal_curls(self) -> None:
        """Store the curl of the vorticity at the points as the newest level."""
        self.normal_curls = [self.present_curls.copy(), *self.normal_curls][:CURL_LEVELS]

    def accept(self, time: float) -> None:
        """Store the curl of the vorticity and the loads of the newest fields, at ``time``."""
        for part in self.parts:
            part.accept(time)
            self.velocity = part.velocity(self.velocity)
        self.measure_normal_curls()
        self.store_normal_curls()
        self.measure_loads(time)

    def known_tractions(self) -> np.ndarray:
        """Return the tractions (count, components) at the points in a step in which fluid and walls are at rest."""
        rest = 0.0 * self.loads.strain(self.velocity)
        stress = self.extra_stress.implicit_wall_stress(rest)
        return self.loads.tractions(np.zeros(len(self.normals)), self.normals, rest, stress)[0]

    def measure_loads(self, time: float) -> None:
        """Store the loads of the newest fields, at ``time``."""
        self.loads.measure(time, self.normals, self.velocity, self.extra_stress.wall_stress())

    def seen(self, time: float, weights: TimeWeights, offset: float) -> Mapping[str, Any]:
        """Return bodies and ends in a ``Snapshot`` at ``time``, an ``offset`` before the end of the last step."""
        contacts = [loads for part in self.parts if (loads := part.contact_loads(time)) is not None]
        numbers = {"bodies": self.loads.at(time, weights, offset, contacts[0] if contacts else None)}
        for part in self.parts:
            numbers |= part.seen(time, weights, offset)
        return numbers | {"load_scatter": self.load_scatter}

    @property
    def load_scatter(self) -> tuple[float, int] | None:
        """Largest scatter of the force on a body from step to step, and the number of the body; None if unknown."""
        groups = [[number for number, body in enumerate(self.walls.bodies) if body.shape.area > 0.0]]
        for part in self.parts:
            groups = part.compared(groups)
        return max((found for group in groups if (found := self.loads.scatter(group))), default=None)

    def residual(self, least: float) -> float:
        """Return the largest divergence over the gradient of the velocities, or the ``least`` one, of all parts."""
        return max(super().residual(least), *(part.residual(least) for part in self.parts), 0.0)

    def numbers(self) -> Mapping[str, Any]:
        """Return the numbers of the boundary for ``summary.json``."""
        return {name: value for part in self.parts for name, value in part.numbers().items()}

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        curls = [curls.tolist() for curls in self.normal_curls]
        grid = [self.grid_time, self.grid_places]
        state = {"normal_curls": curls, **self.loads.state(), "grid": grid, "points": self.walls.state()}
        for part in self.parts:
            state |= part.host_state()
        return state

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``; bodies have moved on since the grid was set."""
        self.normal_curls = [np.array(curls) for curls in state["normal_curls"]]
        self.loads.restore(state)
        time, places = state["grid"]
        for part, its in zip(self.parts, places, strict=True):
            part.restore_host_state(state, its)
        self.set_grid(time)
        for part in self.parts:
            part.restore_host_state(state)

    @ti.kernel
    def set_neumann_rows(self):
        """Set the operators of the Laplacian at the points to the normal derivative times the weight."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            normal, total = self.weight[i] * self.normal[i], 0.0
            normal.y *= self.coordinates.radius(i)
            for k in range(self.points.begin[i], self.points.end[i]):
                slope = normal.x * self.operators.d_dx[k] + normal.y * self.operators.d_dy[k]
                weight = slope
                for part in ti.static(self.parts):
                    weight = part.row_weight(i, k, weight)
                self.operators.laplacian[k] = weight
                total += weight
            self.operators.diagonal[i] = -total

    @ti.kernel
    def set_normal_momentum(
        self,
        right: ti.template(),
        forcing: ti.template(),
        velocity: ti.template(),
        body: ti.template(),
        dt: float,
        gamma0: float,
        viscosity: float,
    ):
        """Set the right-hand side of the pressure's equation at walls, where the velocities are prescribed."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            acceleration = (forcing[i] - gamma0 * velocity[i]) / dt + body[None]
            local = self.extra_stress.local_viscosity(i, viscosity)
            right[i] = self.normal_momentum(i, acceleration, local)

    @ti.func
    def normal_momentum(self, i, acceleration, viscosity):
        """Return the right-hand side at a point for an ``acceleration`` without pressure and viscosity."""
        along = self.normal[i].x * acceleration.x + self.coordinates.radius(i) * self.normal[i].y * acceleration.y
        value = -self.weight[i] * (along - viscosity * self.normal_curl[i])
        for part in ti.static(self.parts):
            value = part.open_part(i, value)
        return value

    @ti.kernel
    def add_impulse_momentum(self, right: ti.template(), velocity: ti.template()):
        """Set the right-hand side of the impulse's equation at walls that start to move at ``velocity``."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            right[i] = self.normal_momentum(i, -velocity[i], 0.0)

    @ti.kernel
    def update_normal_curls(self, velocity: ti.template()):
        """Compute n . curl omega at the points from a ``velocity`` field."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own, total = velocity[i], 0.0
            for k in range(self.points.begin[i], self.points.end[i]):
                apart = velocity[self.points.neighbours[k]] - own
                total += self.operators.d_dx[k] * apart.y - self.operators.d_dy[k] * apart.x
            self.vorticity[i] = total
        self.take_normal_curls()

    @ti.kernel
    def measure_normal_curls(self):
        """Compute n . curl omega at the points, of the newest level, whose gradients are measured."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.vorticity[i] = self.levels.d_dx[i][1] - self.levels.d_dy[i][0]
        self.take_normal_curls()

    @ti.func
    def take_normal_curls(self):
        """Compute n . curl of the ``vorticity`` at the points."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            own, normal, radius = self.vorticity[i], self.normal[i], self.coordinates.radius(i)
            total = self.coordinates.hoop(normal.x * own)
            normal *= ti.Vector([radius * radius, radius])
            for k in range(self.points.begin[i], self.points.end[i]):
                weight = normal.x * self.operators.d_dy[k] - normal.y * self.operators.d_dx[k]
                total += weight * (self.vorticity[self.points.neighbours[k]] - own)
            self.normal_curl[i] = total
