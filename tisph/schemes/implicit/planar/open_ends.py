"""Open ends in a step: an inlet with a given velocity, an outlet without stress, and particles that leave and enter.

At the inlet velocities are given, and the pressure obeys the same equation as at walls. The outlet does nothing,
nu du/dn = p n. Along it, where the divergence is 0, the derivative of the velocity u along the normal is minus the
derivative of v along the outlet, of the last outer iteration,

    p = nu g + S_yy,    du/dx = g,    dv/dx = 0,    g = -dv/dy,

the pressure's values first, and the normal derivatives as equations of the velocities' system. S_yy, of a polymer, is
there since with p - S_yy constant across the outlet a developed flow leaves it as it came.

Two outlets with different pressures drive the fluid as well; p - nu g - S_yy is then the given pressure of each.

Around an axis, with the unknowns V = v/r and W = w/r of ``AxisymmetricCoordinates`` and s = r^2/2,

    p = nu g - integral of W^2 ds from s to the wall,    du/dx = g,    dV/dx = dW/dx = 0,    g = -2 V - r^2 dV/ds.

All of them are even in r: polynomials go through the mirror images of points beyond the axis as well.

The points of ends stay, the fluid passes them. Their time levels are those of the fluid that is at them at the end of a
step: at an outlet from the particles near it (where fluid enters, as if it had been parallel), at the inlet the given
velocities, and v of the fluid in front of it.

Particles that flow out leave ``LEAST_DISTANCE`` in front of an end. As the fluid is incompressible and its region does
not change, as much flows in, and each particle enters again: at the point of an end where the inflow since the last one
has come nearest to the area of a particle, or exceeds it most, and there where most room is. It has the time levels of
that place, a polynomial through those of the particles and points around it. So there are as many particles at all
times. Where a particle is overdue by the whole of its area, one that is about to leave is taken: a fast one, since a
slow one near a wall leaves a void behind it for long. Around an axis areas in the half-plane, which particles fill
evenly, are not conserved: the inflow is scaled to the number of particles that leaves.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tisph.geometry.ends import LEAST_DISTANCE, Inlet, OpenEnd, Outlet
from tisph.geometry.region import nearest_image
from tisph.numerics.stokes import WallRows
from tisph.runtime import integer, real, ti, view
from tisph.schemes.implicit.planar.equations import Equations
from tisph.schemes.implicit.planar.flow_rate import LEAST_REYNOLDS, FlowRateControl
from tisph.schemes.implicit.planar.parts import BoundaryPart, Coupling
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, TimeWeights
from tisph.schemes.implicit.planar.wall_boundary import LOAD_LEVELS, WallBoundary
from tisph.schemes.implicit.planar.wall_points import MAX_WALLS, POINT_SUPPORT, WALL_SUPPORT

AWAY, ALONG = (
    part.ravel() for part in np.meshgrid(LEAST_DISTANCE + np.arange(10) / 10, (np.arange(5) - 2) / 5, indexing="ij")
)
"""Places at which a particle may enter, from a point of an end: distances from the end and along it, in spacings."""

END_SUPPORT = 1.0
"""By how much supports are wider at an end, in particle spacings, in addition to what they are at walls: where a layer
of particles has passed it, the next is up to 1.3 spacings away, and too few layers would be left for derivatives."""

UNJUDGED = 5.0
"""Distance from an end, in particle spacings, up to which supports are wider and errors of steps do not count; and that
of particles from one that enters, up to which they matter to it."""

KEPT = "outlet_velocity", "v_slope", "due", "squares"
"""Arrays that a checkpoint keeps."""

DEGREE, OUTLET_DEGREE, AROUND = 4, 3, {4: 40, 3: 30}
"""Degree of the polynomials from which particles that enter take their time levels, and the outlet its own, and numbers
of points around them. With degree 4 the outlet, to which they extrapolate, would be unstable."""


PARALLEL = [(0, power) for power in range(6)]
"""Powers of x and y at an outlet through which fluid enters: upstream it has been parallel, as in front of an inlet.
With polynomials in x as well, start-up flow of an Oldroyd-B fluid between two pressures becomes unstable."""


def powers_up_to(degree: int) -> list[tuple[int, int]]:
    """Return the powers of x and y of all polynomials up to a ``degree``."""
    return [(a, b) for a in range(degree + 1) for b in range(degree + 1 - a)]


def first_coefficient(basis: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return factors (n, points) of values at points in the first coefficient of n least-squares fits.

    ``basis`` (n, functions, points), ``weight`` (n, points).
    """
    weighted = basis * weight[:, None]
    inverse = np.linalg.pinv(weighted @ basis.transpose(0, 2, 1), rcond=1e-12, hermitian=True)
    return (inverse[:, :1] @ weighted)[:, 0]


def nearest_fits(
    tree: Any, places: np.ndarray, powers: Sequence[tuple[int, int]], around: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return indices and weights (n, ``around``) of the points of a ``tree`` that give values at ``places`` (n, 2).

    ``powers`` of x and y in the polynomials through those ``around`` a place.
    """
    distance, nearest = tree.query(places, around)
    radius = distance[:, -1:]
    apart = tree.data[nearest] - places[:, None]
    if tree.boxsize is not None:
        apart = nearest_image(apart, tree.boxsize)
    x, y = (apart / radius[..., None]).transpose(2, 0, 1)
    basis = np.stack([x**a * y**b for a, b in powers], axis=1)
    return nearest, first_coefficient(basis, (1.0 - (distance / radius) ** 2) ** 2)


@ti.data_oriented
class OpenEnds(BoundaryPart):
    """The ``BoundaryPart`` of open ends, an inlet and an outlet or two outlets: the last bodies, in this order.

    ``of_outlet`` and ``of_inlets``: indices of their points among those on walls. ``divergence`` (fluid,): divergence
    of the newest velocities, by the operators at the end of the present step. ``passages`` (fluid,): how often a
    particle, by its number at the start, has left and entered. ``v_slope``: dv/dx at the inlets' points. ``squares``
    (parts, 3): sums of the squares of divergence and gradient, and numbers of particles, of parts of the channel that
    are as long as the inlet is wide.
    """

    def __init__(self, boundary: WallBoundary) -> None:
        self.boundary, self.problem, self.walls = boundary, boundary.problem, boundary.walls
        self.levels, self.points, self.operators = boundary.levels, boundary.points, boundary.operators
        self.extra_stress, self.shift, problem, walls = boundary.extra_stress, boundary.shift, self.problem, self.walls
        self.coordinates, self.axisymmetric = boundary.coordinates, problem.axisymmetric
        kinds = [(body, np.arange(part.start, part.stop)) for body, part in zip(walls.bodies, walls.parts, strict=True)]
        self.ends = [(body, part) for body, part in kinds if isinstance(body, OpenEnd)]
        self.outlets = [(body, part) for body, part in kinds if isinstance(body, Outlet)]
        inlets = [part for body, part in kinds if isinstance(body, Inlet)]
        self.of_outlet = np.concatenate([part for _, part in self.outlets])
        self.of_inlets = np.concatenate([np.empty(0, dtype=int), *inlets])
        pressures = [np.full(len(part), body.pressure / problem.density) for body, part in self.outlets]
        self.given_pressure = np.concatenate(pressures)
        self.pressure_gradient = float(np.ptp(self.given_pressure) / np.ptp(problem.open_ends))
        self.outlet = integer(0)
        self.outflows: list[list[float]] = []
        self.replaced: tuple[np.ndarray, list[np.ndarray], np.ndarray] | None = None
        self.solid = [body for body in walls.bodies if not isinstance(body, OpenEnd)]
        self.due = np.zeros(sum(len(part) for _, part in self.ends))
        self.divergence = self.points.field(real())

    @property
    def first(self) -> int:
        """First slot of the points of outlets, which are the last of all."""
        return self.points.in_fluid + int(self.of_outlet[0])

    def couplings(self, rounding: float, slow: bool) -> list[Coupling]:
        """Return the control of the flow rate, where an inlet gives that and the flow is not too viscous for it."""
        problem = self.problem
        swift = problem.reference_velocity * problem.spacing >= LEAST_REYNOLDS * problem.kinematic_viscosity
        known = len(self.outlets) < len(self.ends) and swift and not slow
        return [FlowRateControl(problem, self.boundary, self)] if known else []

    @property
    def stored_fields(self) -> tuple[Any, ...]:
        """Fields of a particle that change when it enters."""
        return (*self.boundary.carried_fields, self.levels.position)

    @ti.func
    def error_weight(self, i, weight):
        """Return the weight of a particle in the error of a step: 0 near an end."""
        result = weight
        for end in ti.static(range(2)):
            away = ti.abs(self.points.position[i].x - self.shift.ends[end]) * self.shift.per_spacing[None]
            result = ti.select(away > UNJUDGED, result, 0.0)
        return result

    def reset(self, time: float) -> None:
        """Return to the state before the start, at ``time``."""
        self.replaced = None
        self.due = np.full(len(self.due), 0.5)  # the first layer has come half a spacing from where it would enter
        self.outflows = []
        self.outlet_velocity = np.zeros((len(self.of_outlet), self.levels.components))
        self.v_slope = np.zeros(len(self.of_inlets))
        self.squares = np.zeros((1, 3))

    def velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Return the ``velocity`` (count, components) at the points, at the outlet the newest one."""
        velocity[self.of_outlet] = self.outlet_velocity
        return velocity

    def from_ends(self, positions: np.ndarray) -> np.ndarray:
        """Return the distances (points,) along x from the nearest end, in particle spacings."""
        away = np.min([np.abs(positions[:, 0] - end) for end in self.problem.open_ends], axis=0)
        return away / self.problem.spacing

    def supports(self, factor: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the factors (points,) of the supports, which are wider near ends than the ``factor`` near walls."""
        near = np.clip(1.0 - self.from_ends(positions) / UNJUDGED, 0.0, 1.0)
        widest = 1.0 + (MAX_WALLS * WALL_SUPPORT + POINT_SUPPORT) / self.boundary.support
        return np.minimum(factor + END_SUPPORT / self.boundary.support * near, widest)

    def approach(self, distances: np.ndarray) -> None:
        """Take note of the first slot of the points at outlets, which changes with the number of particles."""
        view(self.outlet)[()] = self.first

    def set_rows(self) -> None:
        """Set the rows of the points; at the outlet u = sum_k w_k (u_k - du/dx x_k), w being fits with that slope.

        The one-sided derivative itself has next to no part of u where no particle is near, and would not give it.
        """
        chosen = np.arange(self.first, self.points.fluid)
        entries, listed = self.points.rows_of(chosen)
        table = view(self.points.neighbours)[entries]
        place, spacing = view(self.points.position), self.problem.spacing
        support = self.boundary.support * spacing * view(self.operators.support_factor)[chosen]
        x, y = ((place[table] - place[chosen, None]) / support[:, None, None]).transpose(2, 0, 1)
        if self.axisymmetric:
            mirrored = ((self.mirrored(place)[table] - place[chosen, None]) / support[:, None, None])[..., 1]
            x, y, listed = np.hstack([x, x]), np.hstack([y, mirrored]), np.hstack([listed, listed])
        weight = listed * np.maximum(1.0 - x**2 - y**2, 0.0) ** 4
        powers = [power for power in powers_up_to(DEGREE) if power != (1, 0)]
        rows = first_coefficient(np.stack([x**a * y**b for a, b in powers], axis=1), weight)
        self.outlet_slope = support * (rows * x).sum(axis=1) / spacing**2
        if self.axisymmetric:
            rows, listed = np.add(*np.split(rows, 2, axis=1)), np.split(listed, 2, axis=1)[0]
        view(self.operators.laplacian)[entries[listed]] = rows[listed] / spacing**2
        view(self.operators.diagonal)[chosen] = -1.0 / spacing**2

    def mirrored(self, positions: np.ndarray) -> np.ndarray:
        """Return the mirror images (n, 2) of ``positions`` (n, 2) beyond the axis."""
        return positions * [1.0, -1.0] - [0.0, 2.0 * self.problem.origin[1]]

    def radii(self, chosen: Any) -> np.ndarray:
        """Return the distances (n,) of ``chosen`` points from the axis."""
        return view(self.points.position)[chosen, 1].astype(float) + self.problem.origin[1]

    def slopes(self, chosen: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return d/dx and d/dy (2, points, numbers) of ``values`` (all points, numbers) at ``chosen`` slots."""
        entries, listed = self.points.rows_of(chosen)
        apart = values[view(self.points.neighbours)[entries]] - values[chosen, None]
        rows = [np.where(listed, view(part)[entries], 0.0) for part in (self.operators.d_dx, self.operators.d_dy)]
        return np.stack([np.einsum("ik,ikn->in", row, apart) for row in rows])

    def end_impulse(self, equations: Equations) -> None:
        """Take note of the impulse of the start, whose potential is the present pressure: velocities at the outlet."""
        potential = view(equations.pressure.x).astype(float)[:, None]
        change = self.slopes(np.arange(self.first, self.points.fluid), potential)[:, :, 0].T
        self.outlet_velocity = self.boundary.fluid_velocity[self.of_outlet]
        self.outlet_velocity[:, :2] -= change

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Set the time levels at the ends for a step ``dt``; return True, since nothing overlaps."""
        elapsed, components = (weights.unit * weights.offsets)[:VELOCITIES], self.levels.components
        self.level_times = time - np.append(0.0, elapsed)
        inlets = view(self.levels.fields)[self.points.on_walls]
        for level, since in enumerate(elapsed):
            along = components * level
            inlets[self.of_inlets, along + 1] = -since * self.v_slope * inlets[self.of_inlets, along]
        place, points = self.boundary.positions[: self.points.in_fluid], self.walls.at(time)[0]
        for number, (_, part) in enumerate(self.outlets):
            enters = bool(self.outflows) and len(self.outlets) > 1 and self.outflows[0][number] < 0.0
            slots, powers = self.points.in_fluid + part, PARALLEL if enters else powers_up_to(OUTLET_DEGREE)
            self.take_levels(slots, points[part], np.arange(len(place)), place, powers, AROUND[OUTLET_DEGREE])
        self.exchange(dt, time)
        return True

    def set_values(self, equations: Equations, gamma0: float, viscosity: float) -> None:
        """Set the pressure at the outlet, and the right-hand side of its velocities, for the present velocity."""
        chosen, velocity = np.arange(self.first, self.points.fluid), view(equations.velocity.x).astype(float)
        change = -self.slopes(chosen, velocity[:, 1:2])[1, :, 0]
        if self.axisymmetric:
            change = self.radii(chosen) ** 2 * change - 2.0 * velocity[chosen, 1]
        viscosities = self.extra_stress.local_viscosities(viscosity, self.points.fluid)[chosen]
        view(equations.pressure.x)[chosen] = viscosities * change + self.outlet_pressure(velocity)
        rows = self.outlet_slope * (viscosities / viscosity if viscosity else 1.0)
        right = np.zeros((len(chosen), self.levels.components))
        right[:, 0] = -gamma0 * self.problem.spacing**2 * rows * change
        view(equations.velocity.b)[chosen] = right

    def begin_step(self) -> None:
        """Measure the divergence to be kept."""
        self.measure_kept_divergence()

    @ti.kernel
    def measure_kept_divergence(self):
        """Compute the divergence that the newest velocities had, by the operators at the end of the step.

        Particles have moved by s since then. With derivatives at their places at the end, the divergence at their
        places before is the trace of grad u (1 - grad s)^-1, with v/(r - s_r) around an axis. Operators of both places
        differ by truncation errors, and D u^ - k gamma_0 d^n is to have none of this difference: a part of the pressure
        that grows as 1/dt.
        """
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            own, moved = self.levels.carried(0, i), self.displacement(i)
            u_x, u_y, s_x, s_y = 0.0 * own, 0.0 * own, 0.0 * own, 0.0 * own
            for k in range(self.points.begin[i], self.points.end[i]):
                j = self.points.neighbours[k]
                velocity, displacement = self.levels.carried(0, j) - own, self.displacement(j) - moved
                u_x += self.operators.d_dx[k] * velocity
                u_y += self.operators.d_dy[k] * velocity
                s_x += self.operators.d_dx[k] * displacement
                s_y += self.operators.d_dy[k] * displacement
            if ti.static(self.axisymmetric):  # from derivatives of u, V by x, s to derivatives of u, v by x, r
                radius = self.coordinates.radius(i)
                u_x.y, s_x.y, u_y.x, s_y.x = radius * u_x.y, radius * s_x.y, radius * u_y.x, radius * s_y.x
                u_y.y, s_y.y = radius * radius * u_y.y + own.y, radius * radius * s_y.y + moved.y
            numerator = u_x.x * (1.0 - s_y.y) + u_y.x * s_x.y + u_x.y * s_y.x + u_y.y * (1.0 - s_x.x)
            self.divergence[i] = numerator / ((1.0 - s_x.x) * (1.0 - s_y.y) - s_y.x * s_x.y)
            if ti.static(self.axisymmetric):
                self.divergence[i] += own.y / (1.0 - moved.y)

    @ti.func
    def divergence_before(self, i, divergence):
        """Return the divergence of the newest velocities at a particle."""
        return self.divergence[i]

    @ti.func
    def displacement(self, i):
        """Return the displacement in the step of a particle, or of the fluid that is at a point of an end."""
        result = 0.0 * self.levels.carried(0, i)
        for level in ti.static(range(VELOCITIES)):
            result += self.levels.step_weights[level] * self.levels.carried(level, i)
        return result

    def outlet_pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Return p - nu du/dx (points,) at outlets: the given pressure, S_yy of a polymer, the pressure of swirl."""
        from scipy.interpolate import CubicSpline

        result = self.given_pressure
        if self.problem.carries_stress:
            result = result + self.extra_stress.present_wall_stress()[2, self.of_outlet]
        for outlet, part in self.outlets if self.problem.swirls else ():
            radius = self.radii(self.points.in_fluid + part)
            order, around = np.argsort(radius), velocity[self.points.in_fluid + part, 2]
            rising = CubicSpline(radius[order], (around**2 * radius)[order]).antiderivative()
            result = result.copy()
            result[part - self.of_outlet[0]] += rising(radius) - rising(outlet.shape.extent[1, 1])
        return result

    def stokes_rows(self, rows: WallRows) -> WallRows:
        """Return the ``rows`` of the points in a ``StokesSolver`` with those of the outlet."""
        return replace(rows, outlet=self.outlet_slope)

    def begin(self) -> None:
        """Begin with the velocities after the start, and with the places from which the points carry them."""
        view(self.levels.position)[self.boundary.slots] = self.boundary.positions[self.boundary.slots]
        self.store_ends()

    def accept(self, time: float) -> None:
        """Store the time levels at the ends, at ``time``."""
        self.outlet_velocity = self.boundary.newest_velocities[self.first :].astype(float)
        self.store_ends()
        self.measure_parts()
        if self.replaced:
            self.levels.passages[view(self.levels.number)[self.replaced[0]]] += 1
        self.replaced = None

    def compared(self, groups: list[list[int]]) -> list[list[int]]:
        """Return the ``groups`` of bodies whose forces are compared, and the inlet.

        The force on the inlet is the pressure there, and so the pressure drop, times the width.
        """
        inlets = [number for number, body in enumerate(self.walls.bodies) if isinstance(body, Inlet)]
        return [*groups, inlets] if inlets else groups

    def residual(self, least: float) -> float:
        """Return the largest residual of the parts of the channel: faults at an end count, however long the channel."""
        divergence, gradient, count = self.squares.T
        ratios = divergence / np.maximum(gradient, least**2 * np.maximum(count, 1))
        return math.sqrt(ratios.max(initial=0.0))

    def seen(self, time: float, weights: TimeWeights, offset: float) -> Mapping[str, Any]:
        """Return the numbers of a ``Snapshot`` about open ends, by name."""
        level_weights = weights.interpolation(offset, min(LOAD_LEVELS, len(self.outflows)))
        *outflows, backflow = level_weights @ np.array(self.outflows)
        inlets = [body for body, _ in self.ends if isinstance(body, Inlet)]
        inflows = [float(inlet.course.velocity(time)) * inlet.area for inlet in inlets]
        rates = np.array([*inflows, *np.negative(outflows)])
        return {"flow_rates": rates, "backflow": max(0.0, float(backflow))}

    def measure_outflow(self) -> None:
        """Store the flow rates out of the outlets, integrals of cubic splines, and the largest backflow.

        It is against the flow rate of an outlet.
        """
        from scipy.interpolate import CubicSpline

        flows, back, heights = [], -math.inf, self.boundary.positions[:, 1]
        for outlet, part in self.outlets:
            own = self.outlet_velocity[part - self.of_outlet[0]]
            speed, width = -(own[:, :2] @ outlet.shape.normal), outlet.shape.length
            along = np.cumsum(self.walls.length[part]) - 0.5 * self.walls.length[part]
            around = self.problem.circumferences(heights[self.points.in_fluid + part])
            curve = CubicSpline([0.0, *along, width], [0.0, *(speed * around), 0.0])  # walls beside it are at rest
            flows.append(float(curve.integrate(0.0, width)))
            back = max(back, float((-speed if flows[-1] >= 0.0 or len(self.outlets) == 1 else speed).max()))
        self.outflows = [[*flows, back], *self.outflows][:LOAD_LEVELS]

    def measure_parts(self) -> None:
        """Sum the squares of divergence and gradient in the parts of the channel."""
        levels, fluid = self.levels, slice(self.points.in_fluid)
        part = (
            np.abs(self.boundary.positions[fluid, 0] - self.problem.open_ends[0]) / self.ends[0][0].shape.length
        ).astype(int)
        slopes = [view(slope)[fluid, :2].astype(float) for slope in (levels.d_dx, levels.d_dy)]
        if self.axisymmetric:
            radius, across = self.radii(fluid), self.boundary.newest_velocities[fluid, 1]
            slopes[0][:, 1] *= radius
            slopes[1][:, 0] *= radius
            slopes[1][:, 1] = radius**2 * slopes[1][:, 1] + across
        gradient = sum((slope**2).sum(axis=1) for slope in slopes)
        areas = np.broadcast_to(self.points.areas, gradient.shape)
        squares = areas * view(levels.divergence)[fluid].astype(float) ** 2, areas * gradient, areas
        self.squares = np.stack([np.bincount(part, each) for each in squares], axis=1)

    def store_ends(self) -> None:
        """Store the outflow, and dv/dx at the inlets."""
        self.measure_outflow()
        values = view(self.levels.fields)[:, 1:2].astype(float)
        self.v_slope = self.slopes(self.points.in_fluid + self.of_inlets, values)[0, :, 0]

    # Particles that leave and enter -----------------------------------------------------------------------------------

    def exchange(self, dt: float, time: float) -> None:
        """Let each particle that has left by the end of a step ``dt``, at ``time``, enter."""
        spacing, fluid = self.problem.spacing, self.points.in_fluid
        place, velocity = self.boundary.positions, self.boundary.newest_velocities[:, :2].astype(float)
        place[self.boundary.slots], normal = self.walls.at(time)
        left, soon = np.full((2, fluid), np.inf)  # distance, in spacings, and time after which particles flow out
        near, leaving = np.flatnonzero(self.from_ends(place[:fluid]) < UNJUDGED), 0.0  # leaving: particles per time
        for body, _ in self.ends:
            distance = body.nearest(place[near] + self.walls.origin).distance / spacing
            speed = -velocity[near] @ body.shape.normal
            out = speed > 0.0
            outwards, distance = near[out], distance[out]
            left[outwards] = np.minimum(left[outwards], distance)
            soon[outwards] = np.minimum(soon[outwards], (distance - LEAST_DISTANCE) / speed[out])
            leaving += speed[out][distance < UNJUDGED].sum() / ((UNJUDGED - LEAST_DISTANCE) * spacing)
        points = fluid + np.concatenate([part for _, part in self.ends])
        normal = normal[points - fluid]
        inflow = np.maximum((velocity[points] * normal).sum(axis=1), 0.0)
        gained = dt * inflow * self.walls.length[points - fluid] / spacing**2
        if self.axisymmetric and gained.any():
            gained *= dt * leaving / gained.sum()
        due = self.due + gained
        wanted = max(np.count_nonzero(left < LEAST_DISTANCE), np.count_nonzero(due >= 1.0))
        slots = np.argsort(soon)[:wanted]  # those that are about to leave go where others are overdue
        slots = slots[left[slots] < LEAST_DISTANCE + 1.0]
        staying = np.ones(fluid, dtype=bool)
        staying[slots] = False
        chosen = np.zeros(len(slots), dtype=int)
        for k in range(len(slots)):
            chosen[k] = np.argmax(due)
            due[chosen[k]] -= 1.0
        places = self.roomiest(place[points[chosen]], normal[chosen], place[near[staying[near]]], time)
        sources = np.append(np.flatnonzero(staying), np.arange(fluid, len(place)))
        self.replaced = slots, [view(field)[slots] for field in self.stored_fields], self.due
        self.due = due
        if len(slots):
            self.take_levels(slots, places, sources, place[sources], powers_up_to(DEGREE), AROUND[DEGREE])
            view(self.points.position)[slots] = places

    def roomiest(self, ends: np.ndarray, normals: np.ndarray, others: np.ndarray, time: float) -> np.ndarray:
        """Return places (n, 2) in front of points on ``ends`` (n, 2) that are farthest from walls and ``others``.

        ``normals`` (n, 2): into the fluid.
        """
        spacing, across = self.problem.spacing, np.stack([-normals[:, 1], normals[:, 0]], axis=1)
        around = ends[:, None] + spacing * (AWAY[:, None] * normals[:, None] + ALONG[:, None] * across[:, None])
        flat = around.reshape(-1, 2) + self.walls.origin
        free = np.min([body.nearest(flat, time).distance for body in self.solid], axis=0).reshape(around.shape[:2])
        for k, (candidates, from_walls) in enumerate(zip(around, free, strict=True)):
            close = others[np.abs(others - ends[k]).max(axis=1) < UNJUDGED * spacing]
            room = np.linalg.norm(candidates[:, None] - close, axis=2).min(axis=1, initial=UNJUDGED * spacing)
            place = candidates[np.argmax(np.minimum(room, 2.0 * from_walls))]
            others = np.append(others, [place], axis=0)
        return others[len(others) - len(ends) :]

    def take_levels(
        self,
        slots: np.ndarray,
        places: np.ndarray,
        sources: np.ndarray,
        of_sources: np.ndarray,
        powers: Sequence[tuple[int, int]],
        around: int,
    ) -> None:
        """Give the points in ``slots`` the time levels that the fluid has at ``places`` (n, 2).

        ``sources``: slots of the points from which they come, which are at ``of_sources`` (m, 2). ``powers`` of x and y
        in the polynomials through those ``around`` a place.
        """
        from scipy.spatial import cKDTree

        near = self.from_ends(of_sources) < 2.0 * UNJUDGED
        sources, of_sources = sources[near], of_sources[near]
        factors = self.carried_factors(sources, of_sources)
        if self.axisymmetric:
            sources, of_sources = np.tile(sources, 2), np.concatenate([of_sources, self.mirrored(of_sources)])
        nearest, weights = nearest_fits(cKDTree(of_sources), places, powers, around)
        for field in self.boundary.carried_fields:
            values = view(field)[sources[nearest]].astype(float)
            if field is self.levels.fields:
                values *= factors[nearest % len(factors)]
            view(field)[slots] = np.einsum("ik,ik...->i...", weights, values)
        view(self.levels.position)[slots] = places

    def carried_factors(self, sources: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return factors (n, fields) of the time levels of ``sources`` that have moved to ``positions`` (n, 2)."""
        factors = np.ones((len(sources), view(self.levels.fields).shape[1]))
        lowest, first = self.problem.origin[1], self.levels.first_pressure
        before, radius = view(self.levels.position)[sources, 1] + lowest, positions[:, 1] + lowest
        factors[:, :first] = np.tile(self.coordinates.carried_factors(before, radius), VELOCITIES)
        return factors

    def entered(self, position: np.ndarray) -> np.ndarray:
        """Return positions (n, 2) at a time within the last step; particles that enter later are at the ends."""
        position = position.copy()
        low, high = sorted(self.problem.open_ends)
        position[:, 0] = np.clip(position[:, 0], low, high)
        return position

    def reject(self) -> None:
        """Take back the exchange of an attempt that was rejected."""
        if self.replaced:
            slots, values, self.due = self.replaced
            for field, before in zip(self.stored_fields, values, strict=True):
                view(field)[slots] = before
        self.replaced = None

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {**{name: getattr(self, name).tolist() for name in KEPT}, "outflows": self.outflows}

    def restore_host_state(self, state: Mapping[str, Any], places: Any = None) -> None:
        """Restore the numbers of ``host_state``."""
        for name in KEPT:
            setattr(self, name, np.array(state[name]))
        self.outflows = state["outflows"]
