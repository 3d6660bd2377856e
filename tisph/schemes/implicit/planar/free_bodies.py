"""Bodies that the flow carries: their velocities at the end of a step, found together with the fluid's.

Of a body of mass M (with the moment of inertia as the third of its numbers) the velocities X obey, by the backward
differences of the fluid,

    M (gamma_0 X - sum_q alpha_q X^(n+1-q)) / dt = F(X) + load,

where F are the force and torque of the fluid, by the pressure and the velocities that it has when its walls move with
X. An outer iteration solves for these. Then X changes by minus J^-1 times the residual, where

    J = gamma_0 (M + M_a),   M_a = rho pi R^2 (1 + 4 K_1(z)/(z K_0(z))),   R/delta = z,   delta^2 = nu dt/gamma_0,

is exact for a circle alone: M_a is its added mass and the mass that its viscous layer, of one step, drags along (G. G.
Stokes 1851; H. Lamb, Hydrodynamics, 1932, art. 328, for a growth rate gamma_0/dt), and around the centre 4 rho pi R^2
delta^2 (1 + z K_0(z)/(2 K_1(z))); of a sphere M_a = (4/3) rho pi R^3 (1/2 + (9/2) (1 + z)/z^2). M_a contains the
fluid's added mass, without which light bodies are unstable whatever the step (P. Causin, J. F. Gerbeau, F. Nobile,
Comput. Methods Appl. Mech. Eng. 194 (2005) 4506-4527). For other shapes, walls and neighbours the differences of the
last iterations correct J (Anderson's method: H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715-1735).

Near contact keeps bodies apart between which there are no particles any more. Down to about a spacing the fluid between
two walls is resolved, lubrication with it. Nearer than the ``distance`` each point of a body pushes a wall away, along
the normal of that, with the pressure

    p = p_0 (distance/gap - 1)^2,      p_0 = rho U (U + nu/L),

of the velocity and the length of reference: it rises beyond all bounds as the gap closes, so no two bodies overlap. It
acts on both alike. It is a model, and no lubrication: how often, how long and how strong it acts is counted.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tisph.errors import DivergedError
from tisph.geometry.body import BodyState
from tisph.geometry.ends import Inlet, OpenEnd
from tisph.numerics.stokes import Unknowns, WallRows
from tisph.runtime import real, scalar, ti, view
from tisph.schemes.implicit.planar.equations import Equations
from tisph.schemes.implicit.planar.parts import MOST_ITERATIONS, BoundaryPart, Coupling
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import TimeWeights
from tisph.schemes.implicit.planar.wall_boundary import WallBoundary

Pair = tuple[int, int]
"""Numbers of two bodies."""

FINER = 4
"""Points of contact within a particle spacing."""

CLOSEST = 0.02
"""Part of the ``distance`` below which gaps count as that, for a finite force."""

WINDOW = 3
"""Differences of iterations that are kept."""

MEAN_RADIUS = 2.5
"""Radius, in particle spacings, of the mean with which the pressure is continued into a gap that closes."""

CONTINUED = 1.0, 0.5
"""Distances from a wall to the other one, in particle spacings, between which the pressure becomes one that is
continued from around the gap, as bodies approach."""

NARROW = 2.0
"""Width of a gap, in particle spacings, below which divergence in it is left as it is. There its removal lets it grow:
the gradient of a pressure that is to remove it has the opposite divergence."""

RESIDUAL = 0.3
"""Change of the velocities of bodies up to which they have converged, over the tolerance of a step."""


THICKEST = 5.0
"""Radii to which a viscous layer grows at most, where walls or other bodies are."""


class Contact:
    """Between the free bodies among ``bodies``, or those and the others; nearer than a ``distance`` they touch.

    ``touching``: the pairs that do at present. ``count`` of contacts so far, ``duration`` with at least one, and the
    ``largest`` force per length across the plane.
    """

    def __init__(self, bodies: Sequence[Any], distance: float, pressure: float, spacing: float) -> None:
        self.bodies, self.distance, self.pressure = bodies, distance, pressure
        self.outlines: list[Any] = [
            body.shape.boundary_points(spacing / FINER) if body.shape.area else None for body in bodies
        ]
        # points of the first of two free bodies push against the second, and points of a free body against a wall
        self.pairs = [
            (first, second)
            for first, second in itertools.permutations(range(len(bodies)), 2)
            if bodies[first].free
            and bodies[first].shape.fluid_side == "outside"
            and not isinstance(bodies[second], OpenEnd)
            if first < second or not bodies[second].free
        ]
        self.in_fluid = np.array([bool(body.shape.area) and body.shape.fluid_side == "outside" for body in bodies])
        self.radii = np.array(
            [body.bounding_radius if in_fluid else 0.0 for body, in_fluid in zip(bodies, self.in_fluid, strict=True)]
        )
        self.reset()

    def reset(self) -> None:
        """Forget all contacts."""
        self.touching: set[Pair] = set()
        self.count, self.duration, self.largest = 0, 0.0, 0.0

    def loads(self, states: Sequence[BodyState]) -> tuple[np.ndarray, dict[Pair, float], dict[Pair, float]]:
        """Return force, torque and stresslet (bodies, 4) on bodies in these ``states``; force and gap of each pair.

        Stresslets are taken from the centre of each body, as in ``WallPoints.sums``: both of a pair add up to the
        stresslet of its force over the vector between the centres.
        """
        loads, forces, gaps = np.zeros((len(self.bodies), 4)), {}, {}
        for first, second in self._near_pairs(states):
            found = self._between(first, states[first], states[second])
            if found is None:
                continue
            gap, points, pushes = found
            forces[first, second], gaps[first, second] = float(np.hypot(*pushes.sum(axis=0))), gap
            for number, sign in ((first, 1.0), (second, -1.0)):
                arm = states[number].from_centre(points)
                loads[number, :2] += sign * pushes.sum(axis=0)
                along, across = np.sum(arm[:, 0] * pushes[:, 1]), np.sum(arm[:, 1] * pushes[:, 0])
                loads[number, 2:] += sign * np.array([along - across, 0.5 * (along + across)])
        return loads, forces, gaps

    def _near_pairs(self, states: Sequence[BodyState]) -> list[Pair]:
        """Return the pairs whose bounding circles are within the distance."""
        if not self.pairs:
            return []
        first, second = np.array(self.pairs).T
        centres = np.array([state.centre for state in states])
        apart = centres[second] - centres[first]
        away = np.hypot(*(apart - self.bodies[first[0]].nearest_copy(apart)).T)
        for number in set(second[~self.in_fluid[second]].tolist()):
            away = np.where(second == number, states[number].nearest(centres).distance[first], away)
        near = away <= self.radii[first] + self.radii[second] + self.distance
        return [pair for pair, may_touch in zip(self.pairs, near, strict=True) if may_touch]

    def _between(self, number: int, first: BodyState, second: BodyState) -> tuple[float, np.ndarray, np.ndarray] | None:
        """Return the smallest gap, points and forces on them (n, 2) of the ``first`` body; None where it is far.

        ``number``: of the first body.
        """
        boundary = first.placed(self.outlines[number])
        foot = second.nearest(boundary.point)
        near = foot.distance < self.distance
        if not near.any():
            return None
        gaps = np.maximum(foot.distance[near], CLOSEST * self.distance)
        push = self.pressure * (self.distance / gaps - 1.0) ** 2 * boundary.length[near]
        return float(foot.distance.min()), boundary.point[near], push[:, None] * foot.normal[near]

    def accept(self, forces: Any, dt: float) -> None:
        """Take note of a step ``dt`` in which pairs pushed with these ``forces``."""
        self.count += len(set(forces) - self.touching)
        self.touching = set(forces)
        self.duration += dt if forces else 0.0
        self.largest = max([self.largest, *forces.values()])

    def state(self) -> Any:
        """Return the numbers that a resumed run needs."""
        return [sorted(map(list, self.touching)), self.count, self.duration, self.largest]

    def restore(self, state: Any) -> None:
        """Restore the numbers of ``state``."""
        touching, self.count, self.duration, self.largest = state
        self.touching = {tuple(pair) for pair in touching}


class FreeBodies:
    """The free ones of the bodies of ``walls``, a ``WallPoints``: n of them, with velocities (n, 3)."""

    def __init__(self, problem: Problem) -> None:
        walls, density = problem.walls, problem.density
        assert walls is not None
        assert problem.contact is not None
        self.walls, self.density, self.viscosity = walls, density, problem.kinematic_viscosity
        distance, pressure = problem.contact
        self.contact = Contact(walls.bodies, distance, pressure, problem.wanted_spacing.smallest)
        self.index = [number for number, body in enumerate(walls.bodies) if body.free]
        self.motions = [walls.bodies[number].motion for number in self.index]
        inertias = [motion.inertia for motion in self.motions]
        self.mass, self.load = (
            np.array([getattr(each, name) for each in inertias]) / density for name in ("mass", "load")
        )
        self.has_inertia = problem.inertia
        self.mass *= self.has_inertia
        self.moves = ~np.array([each.held for each in inertias])
        self.massless_rotation = self.moves[:, 2] & (self.mass[:, 2] == 0.0)
        self.radius = np.array([walls.bodies[number].shape.length for number in self.index]) / (2 * math.pi)
        self.arm = np.stack([np.ones_like(self.radius)] * 2 + [self.radius], axis=1)
        self.converged, self.axisymmetric = 0.0, problem.axisymmetric

    def accelerate(self, acceleration: float) -> None:
        """Let the fluid around be under an ``acceleration`` along x, whose pressure acts on the bodies, too."""
        for index, motion in enumerate(self.motions):
            self.load[index, 0] = motion.inertia.load[0] / self.density + motion.inertia.displaced * acceleration

    def reset(self, time: float) -> None:
        """Go back to before the start, at ``time``."""
        for motion in self.motions:
            motion.reset(time)
        self.contact.reset()

    def restart(self) -> None:
        """Forget earlier levels."""
        for motion in self.motions:
            motion.restart()

    def accept(self, time: float) -> None:
        """Let the velocities of a step that ends at ``time`` be the newest."""
        self.contact.accept(self.touching, self.dt)
        self.attempt()
        for motion in self.motions:
            motion.accept(time)

    @property
    def newest(self) -> np.ndarray:
        """Velocities (n, 3) at the end of the last step."""
        return np.array([motion.velocities[0] for motion in self.motions])

    def added_mass(self, duration: float) -> np.ndarray:
        """Return M_a (n, 3) per unit density for a step with dt/gamma_0 = ``duration``."""
        displaced, depth = math.pi * self.radius**2, math.sqrt(self.viscosity * duration)
        if self.axisymmetric:
            displaced = 4.0 / 3.0 * self.radius * displaced
            along = displaced * (0.5 + 4.5 * (1.0 + self.radius / max(depth, 1e-300)) * (depth / self.radius) ** 2)
            return np.stack([along, along, displaced * self.radius**2], axis=1)
        along, around = displaced, np.full_like(displaced, 1e-3) * displaced * self.radius**2
        if depth > 0.0:
            from scipy.special import k0e, k1e

            z = self.radius / depth
            along = displaced * (1.0 + 4.0 * k1e(z) / (z * k0e(z)))
            around = 4.0 * displaced * depth**2 * (1.0 + 0.5 * z * k0e(z) / k1e(z))
        return np.stack([along, along, around], axis=1)

    def prepare(self, times: TimeWeights, dt: float, time: float) -> None:
        """Begin a step ``dt`` that ends at ``time`` with velocities extrapolated from the last steps."""
        self.gamma0, alpha = times.bdf()
        self.dt = dt
        levels = [np.array([motion.velocities[level] for motion in self.motions]) for level in range(self.depth)]
        self.known = sum(weight * level for weight, level in zip(alpha, levels, strict=False))
        self.extrapolated = np.array([motion.extrapolated(time) for motion in self.motions])
        self.lower = sum(weight * level for weight, level in zip(times.lower_extrapolation(), levels, strict=False))
        loads, self.touching, self.gaps = self.contact.loads(self.walls.states(time))
        self.pushes = loads[self.index, :3] / self.density
        self.begin(self.extrapolated.copy(), self.gamma0 * (self.mass + self.added_mass(dt / self.gamma0)))
        self.attempt()

    def unknowns(self, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M sigma, all forces but the fluid's with the known part of the momentum, and J/dt, (n, 3) each.

        In J the layer is at most ``THICKEST`` radii deep.
        """
        load = self.load + self.pushes + self.mass * self.known / dt
        inertia = self.mass * self.gamma0 / dt
        deepest = (THICKEST * self.radius.min()) ** 2 / self.viscosity
        duration = min(dt / self.gamma0, deepest) if self.has_inertia else deepest
        return inertia, load, inertia + self.added_mass(duration) / duration

    @property
    def depth(self) -> int:
        """Number of levels."""
        return len(self.motions[0].velocities)

    def begin(self, velocities: np.ndarray, jacobian: np.ndarray) -> None:
        """Begin to iterate, from these ``velocities`` (n, 3) or accelerations."""
        self.velocities, self.jacobian = velocities, jacobian
        self.steps: list[np.ndarray] = []
        self.places: list[np.ndarray] = []

    def begin_start(self, acceleration: Sequence[float]) -> None:
        """Begin with the accelerations (n, 3) of bodies in a fluid without bounds, which has one of (2,) itself."""
        added = self.added_mass(0.0)
        jacobian = self.mass + added
        alone = (self.load + added * [*acceleration, 0.0]) / jacobian
        self.begin(np.where(self.moves, alone, 0.0), jacobian)

    def step_residual(self, loads: np.ndarray) -> np.ndarray:
        """Return the residual (n, 3) of a step in which the fluid's force and torque per unit density are ``loads``."""
        change = self.gamma0 * self.velocities - self.known
        return self.mass * change - self.dt * (loads + self.load + self.pushes)

    def correct(
        self, residual: np.ndarray, least: float, curls: np.ndarray | None = None, found: np.ndarray | None = None
    ) -> bool:
        """Change the velocities by their ``residual``; return whether they need not be, by ``least`` of a speed.

        ``curls`` (count,): curls at walls with which the fluid was solved for, and ``found`` (count,): curls of that
        solution. They change with the velocities; the next ones are written into ``curls``.
        """
        step = np.where(self.moves, -residual / self.jacobian, 0.0)
        self.converged = float(np.abs(self.arm * step).max())
        if not math.isfinite(self.converged):  # of a fluid without a solution, which stops the run
            return True
        if self.converged <= least:
            return True
        place, change = (self.arm * self.velocities).ravel(), (self.arm * step).ravel()
        if curls is not None:
            place, change = np.concatenate([place, curls]), np.concatenate([change, found - curls])
        self.places.append(place)
        self.steps.append(change)
        del self.places[: -WINDOW - 1], self.steps[: -WINDOW - 1]
        new = place + change
        if len(self.steps) > 1:
            steps, places = np.diff(self.steps, axis=0), np.diff(self.places, axis=0)
            weights = np.linalg.lstsq(steps.T, change, rcond=1e-6)[0]
            new -= weights @ (steps + places)
        self.velocities = new[: self.arm.size].reshape(-1, 3) / self.arm
        if curls is not None:
            curls[...] = new[self.arm.size :]
        return False

    def attempt(self) -> None:
        """Let the bodies have the present velocities at the end of the step."""
        for motion, velocity in zip(self.motions, self.velocities, strict=True):
            motion.attempt(velocity)

    @property
    def overlap(self) -> bool:
        """Whether bodies overlap at the end of the present step."""
        return min(self.gaps.values(), default=1.0) <= 0.0

    def difference(self) -> tuple[float, float]:
        """Return the largest difference of a body's velocities from those extrapolated, and the one of lower order."""
        both = np.abs(self.arm * (self.velocities - np.stack([self.extrapolated, self.lower]))).reshape(2, -1)
        largest = both[0].argmax()
        return float(both[0, largest]), float(both[1, largest])

    def state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        return {"motions": [motion.state() for motion in self.motions], "contact": self.contact.state()}

    def restore(self, state: Any) -> None:
        """Restore the numbers of ``state``."""
        for motion, its in zip(self.motions, state["motions"], strict=True):
            motion.restore(its)
        self.contact.restore(state["contact"])


@ti.data_oriented
class FreeBodyPart(BoundaryPart):
    """The ``BoundaryPart`` of ``bodies`` (``FreeBodies``) that the flow carries.

    They may come so close that no particle is between them, but points on both, whose equations are one and the same:
    they leave the pressure there undetermined. ``continued`` is the part, 0 to 1, in which the pressure at a point is
    the mean of the pressures around instead, which continues it into the gap. ``narrow`` tells whether a particle is in
    a gap in which divergence is left as it is.
    """

    finds_impulse = True

    def __init__(self, boundary: WallBoundary) -> None:
        self.boundary, self.problem, self.points = boundary, boundary.problem, boundary.points
        self.bodies = FreeBodies(self.problem)
        bodies = boundary.walls.bodies
        self.free = [bodies[number] for number in self.bodies.index]
        self.inlets = [end for end in boundary.walls.ends if isinstance(end, Inlet)]
        self.continued = ti.field(real(), self.points.capacity)
        self.narrow = ti.field(ti.i32, self.points.capacity)
        self.per_spacing = scalar(1.0 / self.problem.spacing)

    def couplings(self, rounding: float, slow: bool) -> list[Coupling]:
        """Return the coupling of the velocities of the bodies."""
        kind = CoupledFreeBodies if slow else FreeBodyCoupling
        return [kind(self.boundary, self.bodies, rounding)]

    def reset(self, time: float) -> None:
        """Return to the state before the start, at ``time``."""
        self.bodies.reset(time)

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Begin the step of the bodies with extrapolated velocities; return whether none of them overlap."""
        self.bodies.prepare(weights, dt, time)
        return not self.bodies.overlap

    def accept(self, time: float) -> None:
        """Raise DivergedError where a body has come to an inlet, at ``time``; through outlets it leaves."""
        for body, end in itertools.product(self.free, self.inlets):
            away = float(end.nearest(body.at(time).centre[None]).distance[0]) - body.bounding_radius
            if away < NARROW * self.problem.spacing:
                x, y = body.at(time).centre
                text = f"x: a free body at ({x:.4g}, {y:.4g}) reaches the inlet at t = {time:.4g}"
                raise DivergedError(f"{text}: let the run end before, or make the channel longer")

    def forget(self) -> None:
        """Forget velocities of earlier times."""
        self.bodies.restart()

    def approach(self, distances: np.ndarray) -> None:
        """Set where the pressure is continued, and the particles in narrow gaps, by ``distances`` (points, 2).

        Distances are over the relative spacing of a point.
        """
        spacing, n_fluid = self.problem.spacing, self.points.in_fluid
        nearness = (CONTINUED[0] - distances[self.boundary.slots, 1] / spacing) / (CONTINUED[0] - CONTINUED[1])
        view(self.continued)[self.boundary.slots] = np.clip(nearness, 0.0, 1.0)
        view(self.narrow)[:n_fluid] = distances[:n_fluid].sum(axis=1) < NARROW * spacing

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x, and with it the buoyancy of the bodies."""
        self.bodies.accelerate(acceleration)

    def stokes_rows(self, rows: WallRows) -> WallRows:
        """Return the ``rows`` with the parts of equations that hold where gaps close."""
        narrow = view(self.narrow)[: self.points.in_fluid] > 0
        walls = 1.0 - view(self.continued)[self.boundary.slots].astype(float)
        return replace(rows, open_walls=walls, open_fluid=np.where(narrow, 0.0, 1.0))

    def compared(self, groups: list[list[int]]) -> list[list[int]]:
        """Return no group: forces on bodies that move freely are not compared."""
        return []

    def contact_loads(self, time: float) -> np.ndarray:
        """Return the loads (bodies, 4) of contacts at ``time``, which depend on places alone and need no levels."""
        contact = self.bodies.contact
        return contact.loads([body.at(time) for body in contact.bodies])[0]

    def numbers(self) -> Mapping[str, Any]:
        """Return number and duration of contacts, and the largest contact force."""
        contact = self.bodies.contact
        return {"contacts": contact.count, "contact_time": contact.duration, "contact_force": contact.largest}

    def places(self) -> dict[str, Any]:
        """Return numbers from which the places of the bodies at present can be restored."""
        return self.bodies.state()

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs, by name."""
        return {"free": self.bodies.state()}

    def restore_host_state(self, state: Mapping[str, Any], places: Any = None) -> None:
        """Restore the numbers of ``host_state``, or those ``places``."""
        self.bodies.restore(places or state["free"])

    @ti.func
    def row_weight(self, i, k, slope):
        """Return the weight of neighbour ``k`` in the equation at a point; in a gap that closes it is a mean's."""
        per_spacing = self.per_spacing[None] / self.points.relative(i)
        apart = self.points.separation(i, self.points.neighbours[k]) * per_spacing
        nearness = self.per_spacing[None] ** 2 * ti.max(0.0, 1.0 - apart.dot(apart) / MEAN_RADIUS**2) ** 2
        return slope + self.continued[i] * (nearness - slope)

    @ti.func
    def open_part(self, i, value):
        """Return the part of a right-hand ``value`` at a point that lies in no gap that closes."""
        return value * (1.0 - self.continued[i])

    @ti.func
    def kept_part(self, i, kept, gamma0):
        """Return k gamma_0, with k = 1 for a particle in a narrow gap."""
        return ti.select(self.narrow[i] > 0, gamma0, kept)


class FreeBodyCoupling(Coupling):
    """The ``Coupling`` of the free ``bodies`` of a ``boundary`` with the fluid: loads and velocities.

    With the velocities of the bodies it finds the curl of the vorticity at walls. ``precision``: relative rounding
    error of loads; ``allowed``: change of a velocity up to which bodies have converged.
    """

    sets_curls = True

    def __init__(self, boundary: WallBoundary, bodies: FreeBodies, precision: float) -> None:
        self.boundary, self.bodies, self.precision = boundary, bodies, precision
        self.rounding = self.allowed = self.curl_scale = self.time = 0.0

    def prepare(self, equations: "Equations", dt: float, gamma0: float, time: float, allowed: float) -> None:
        """Begin a step ``dt`` that ends at ``time``, whose velocities may have an error ``allowed``."""
        bodies, walls = self.bodies, self.boundary.walls
        self.time, self.allowed = time, RESIDUAL * allowed
        fastest = float(np.abs(bodies.arm * bodies.velocities).max())
        self.rounding = self.precision * fastest * math.sqrt(walls.count) / (dt * walls.spacing)
        self.curl_scale = bodies.viscosity * dt / gamma0 / math.sqrt(walls.count)

    def correct(self, equations: "Equations") -> bool:
        """Change the velocities of the bodies by the loads of the fluid; return whether they had converged."""
        boundary, scale = self.boundary, self.curl_scale
        boundary.levels.measure_at_walls(equations.velocity.x)
        strain = boundary.loads.strain(boundary.velocity)
        loads = self._loads(equations, strain, boundary.extra_stress.implicit_wall_stress(strain))
        given = scale * boundary.present_curls.astype(float)
        boundary.update_normal_curls(equations.velocity.x)
        found = scale * boundary.present_curls.astype(float)
        if self.bodies.correct(self.bodies.step_residual(loads), self.allowed, given, found):
            return True
        boundary.present_curls[...] = given / scale
        self.bodies.attempt()
        boundary.update_velocity(self.time)
        equations.set_wall_velocity(boundary.solver_velocity())
        return False

    def error(self) -> tuple[float, float]:
        """Return the differences of the bodies' velocities; infinite where these have not converged."""
        return self.bodies.difference() if self.bodies.converged <= self.allowed else (math.inf, math.inf)

    def store(self, time: float) -> None:
        """Store the velocities of the bodies at the ``time`` at the end of a step."""
        self.bodies.accept(time)

    def _loads(self, equations: "Equations", strain: np.ndarray, extra: Any) -> np.ndarray:
        """Return force and torque (n, 3), per unit density, of pressure, ``strain`` and ``extra`` stress at walls."""
        boundary = self.boundary
        pressure = view(equations.pressure.x)[boundary.slots].astype(float)
        tractions = boundary.loads.tractions(pressure, boundary.normals, strain, extra)
        return boundary.walls.sums(tractions, self.time)[0, self.bodies.index, :3]

    def start(self, equations: "Equations", tolerance: float) -> bool:
        """Find the velocities after the start of bodies and fluid that move against each other before.

        A pressure acts on both at once; its impulse on the one is opposite to that on the other. Return whether the
        system of the impulse was solved.
        """
        bodies, boundary = self.bodies, self.boundary
        self.time = boundary.problem.start_time
        self._start_rotations()
        before = bodies.newest
        bodies.begin(before, bodies.mass + bodies.added_mass(0.0))
        for _ in range(MOST_ITERATIONS):
            solved = boundary.find_impulse(equations, tolerance)
            impulse = -view(equations.pressure.x)[boundary.slots].astype(float)[:, None] * boundary.normals
            loads = boundary.walls.sums(impulse[None], self.time)[0, bodies.index, :3]
            residual = bodies.mass * (bodies.velocities - before) - loads
            if bodies.correct(residual, tolerance * np.abs(boundary.velocity - boundary.fluid_velocity).max()):
                break
            self._start_with(bodies.velocities)
        boundary.levels.subtract_gradient(equations.pressure.x)
        bodies.begin_start(boundary.problem.acceleration)
        self._set_accelerations()
        return solved

    def _start_rotations(self) -> None:
        """Turn bodies without a moment of inertia as the fluid at their surface turns.

        Else the layer that begins there, as thin as it is strong, would turn them with a torque that nothing resists.
        """
        bodies, boundary = self.bodies, self.boundary
        slip = np.stack([boundary.fluid_velocity, boundary.walls.velocities(self.time)])
        around = boundary.walls.sums(slip, self.time)[:, bodies.index, 2]
        rate = (around[0] - around[1]) / boundary.walls.moments(self.time)[bodies.index]
        turned = bodies.newest
        turned[:, 2] += np.where(bodies.massless_rotation, rate, 0.0)
        self._start_with(turned)

    def _start_with(self, velocities: np.ndarray) -> None:
        for motion, velocity in zip(self.bodies.motions, velocities, strict=True):
            motion.start(self.time, velocity)
        self.boundary.update_velocity(self.time)

    def _set_accelerations(self) -> None:
        for motion, acceleration in zip(self.bodies.motions, self.bodies.velocities, strict=True):
            motion.change = acceleration

    def correct_start(self, equations: "Equations", tolerance: float) -> bool:
        """Change the first accelerations of the bodies by the first pressure; return whether they had converged.

        Loads of a pressure that was solved to a ``tolerance`` are no more exact: where they change no longer,
        extrapolating from their changes would lead anywhere.
        """
        bodies = self.bodies
        loads = self._loads(equations, self.boundary.loads.strain(self.boundary.velocity), 0.0)
        residual = bodies.mass * bodies.velocities - loads - bodies.load
        residual[bodies.massless_rotation, 2] = 0.0  # no acceleration of theirs alters a torque
        if bodies.correct(residual, tolerance * np.abs(bodies.arm * bodies.velocities).max()):
            return True
        self._set_accelerations()
        self.boundary.set_accelerations(equations)
        return False


class CoupledFreeBodies(FreeBodyCoupling):
    """The same, of bodies whose velocities are unknowns of the system of velocity and pressure (``equations.Coupled``).

    The residual of GMRES contains their error. Loads of its solution are no measure of that: errors of the fluid's
    velocities that it leaves change them by as much as nu/spacing times these.
    """

    sets_curls = False

    def unknowns(self, dt: float) -> Unknowns:
        """Return the velocities of the bodies in a step ``dt`` as unknowns, without held components."""
        from scipy.sparse import csr_matrix, diags

        free, boundary, moves = self.bodies, self.boundary, self.bodies.moves.ravel()
        motion = boundary.walls.rigid_motion(free.index, self.time)[:, moves]
        forces = (motion.T @ diags(boundary.walls.areas(self.time).ravel())).tocsr()
        inertia, load, response, arm, now = (
            each.ravel()[moves] for each in (*free.unknowns(dt), free.arm, free.velocities)
        )
        displaced = np.zeros_like(free.mass)
        displaced[:, 0] = [motion.inertia.displaced for motion in free.motions]
        none, points = np.zeros_like(now), boundary.points.fluid
        section, load = csr_matrix((len(now), points)), load + forces @ boundary.known_tractions().ravel()
        return Unknowns(motion, forces, none, displaced.ravel()[moves], inertia, section, load, now, arm, response)

    def take(self, equations: "Equations", velocities: np.ndarray) -> None:
        """Give the bodies their ``velocities`` at the end of the step, as they were found."""
        bodies = self.bodies
        before = bodies.velocities.copy()
        bodies.velocities[bodies.moves] = velocities
        nonlinear = self.boundary.extra_stress.nonlinear
        bodies.converged = float(np.abs(bodies.arm * (bodies.velocities - before)).max()) if nonlinear else 0.0
        bodies.attempt()
        self.boundary.update_velocity(self.time)

    def correct(self, equations: "Equations") -> bool:
        """Return whether a stress that depends on the velocities no longer changes those of the bodies."""
        return self.bodies.converged <= self.allowed
