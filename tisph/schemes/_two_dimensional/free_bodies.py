"""Bodies that the flow carries: their velocities at the end of a step, found together with the fluid's.

Of a body of mass M (with the moment of inertia as the third of its numbers) the velocities X obey, by the backward
differences of the fluid,

    M (gamma_0 X - sum_q alpha_q X^(n+1-q)) / dt = F(X) + load,

where F, the fluid's force and torque, is that of the pressure and the velocities which the fluid has when its walls
move with X. An outer iteration solves for these. Then X changes by minus J^-1 times the residual, where

    J = gamma_0 (M + M_a),   M_a = rho pi R^2 (1 + 4 K_1(z)/(z K_0(z))),   R/delta = z,   delta^2 = nu dt/gamma_0,

is what a circle alone would need: M_a is its added mass and what its viscous layer, of one step, drags along (G. G.
Stokes 1851; H. Lamb, Hydrodynamics, 1932, art. 328, for a growth rate gamma_0/dt), and around the centre
4 rho pi R^2 delta^2 (1 + z K_0(z)/(2 K_1(z))); of a sphere M_a = (4/3) rho pi R^3 (1/2 + (9/2) (1 + z)/z^2). That
holds the fluid's added mass, without which light bodies are unstable whatever the step (P. Causin, J. F. Gerbeau,
F. Nobile, Comput. Methods Appl. Mech. Eng. 194 (2005) 4506-4527).
For other shapes, walls and neighbours the differences of the last iterations make up (Anderson's method: H. F. Walker,
P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715-1735).

Near contact keeps bodies apart between which there are no particles any more. Down to about a spacing the fluid between
two walls is resolved, lubrication with it. Nearer than the ``distance`` each point of a body pushes a wall away, along
the normal of that, with the pressure

    p = p_0 (distance/gap - 1)^2,      p_0 = rho U (U + nu/L),

of the velocity and the length of reference: it rises beyond all bounds as the gap closes, so no two bodies overlap. It
acts on both alike. It is a model, and no lubrication: how often, how long and how strong it acts is counted.
"""

import itertools
import math

import numpy as np

FINER = 4
"""Points of contact within a particle spacing."""

CLOSEST = 0.02
"""Part of the ``distance`` below which gaps count as that, for a finite force."""

WINDOW = 3
"""Differences of iterations that are kept."""

MOST_ITERATIONS = 20

RESIDUAL = 0.3
"""Change of the velocities of bodies up to which they have converged, over the tolerance of a step."""


class Contact:
    """Between the free bodies among ``bodies``, or those and the others; nearer than a ``distance`` they touch.

    ``touching``: the pairs that do at present. ``count`` of contacts so far, ``duration`` with at least one, and the
    ``largest`` force per length across the plane.
    """

    def __init__(self, bodies, distance, pressure, spacing):
        self.bodies, self.distance, self.pressure = bodies, distance, pressure
        self.outlines = [body.shape.boundary_points(spacing / FINER) if body.shape.area else None for body in bodies]
        # points of one of two free bodies push against the other, those of a free one against a wall
        self.pairs = [
            (first, second)
            for first, second in itertools.permutations(range(len(bodies)), 2)
            if bodies[first].free and bodies[first].shape.fluid_side == "outside"
            if first < second or not bodies[second].free
        ]
        self.in_fluid = np.array([bool(body.shape.area) and body.shape.fluid_side == "outside" for body in bodies])
        self.radii = np.array(
            [body.bounding_radius if in_fluid else 0.0 for body, in_fluid in zip(bodies, self.in_fluid, strict=True)]
        )
        self.reset()

    def reset(self):
        """Forget all contacts."""
        self.touching, self.count, self.duration, self.largest = set(), 0, 0.0, 0.0

    def loads(self, time):
        """Return force, torque and stresslet (bodies, 4) at ``time``, and by pair the force and the smallest gap.

        Both stresslets of a pair add up to that of its force and of the vector between the centres, as those of
        ``WallPoints.sums`` are from these.
        """
        loads, forces, gaps = np.zeros((len(self.bodies), 4)), {}, {}
        for first, second in self._near_pairs(time):
            found = self._between(first, second, time)
            if found is None:
                continue
            gap, points, pushes = found
            forces[first, second], gaps[first, second] = float(np.hypot(*pushes.sum(axis=0))), gap
            for number, sign in ((first, 1.0), (second, -1.0)):
                away = points - self.bodies[number].at(time).centre
                arm = away - self.bodies[number].nearest_copy(away)
                loads[number, :2] += sign * pushes.sum(axis=0)
                along, across = np.sum(arm[:, 0] * pushes[:, 1]), np.sum(arm[:, 1] * pushes[:, 0])
                loads[number, 2:] += sign * np.array([along - across, 0.5 * (along + across)])
        return loads, forces, gaps

    def _near_pairs(self, time):
        """Return those of the pairs that may be within the distance: what is in the circles around bodies may be."""
        if not self.pairs:
            return []
        first, second = np.array(self.pairs).T
        centres = np.array([body.at(time).centre for body in self.bodies])
        apart = centres[second] - centres[first]
        away = np.hypot(*(apart - self.bodies[first[0]].nearest_copy(apart)).T)
        for number in set(second[~self.in_fluid[second]].tolist()):
            away = np.where(second == number, self.bodies[number].nearest(centres, time).distance[first], away)
        near = away <= self.radii[first] + self.radii[second] + self.distance
        return [pair for pair, may_touch in zip(self.pairs, near, strict=True) if may_touch]

    def _between(self, first, second, time):
        """Return the smallest gap, points and forces on them (n, 2) of the ``first`` body; None where it is far."""
        one, other = self.bodies[first], self.bodies[second]
        boundary = one.placed(self.outlines[first], time)
        foot = other.nearest(boundary.point, time)
        near = foot.distance < self.distance
        if not near.any():
            return None
        gaps = np.maximum(foot.distance[near], CLOSEST * self.distance)
        push = self.pressure * (self.distance / gaps - 1.0) ** 2 * boundary.length[near]
        return float(foot.distance.min()), boundary.point[near], push[:, None] * foot.normal[near]

    def accept(self, forces, dt):
        """Take note of a step ``dt`` in which pairs pushed with these ``forces``."""
        self.count += len(set(forces) - self.touching)
        self.touching = set(forces)
        self.duration += dt if forces else 0.0
        self.largest = max([self.largest, *forces.values()])

    def state(self):
        """What a resumed run needs."""
        return [sorted(map(list, self.touching)), self.count, self.duration, self.largest]

    def restore(self, state):
        """Take up what ``state`` returned."""
        touching, self.count, self.duration, self.largest = state
        self.touching = {tuple(pair) for pair in touching}


class FreeBodies:
    """The free ones of the bodies of ``walls``, a ``WallPoints``: n of them, with velocities (n, 3)."""

    def __init__(self, problem):
        walls, density = problem.walls, problem.density
        self.walls, self.density, self.viscosity = walls, density, problem.kinematic_viscosity
        self.contact = Contact(walls.bodies, *problem.contact, walls.spacing)
        self.index = [number for number, body in enumerate(walls.bodies) if body.free]
        self.motions = [walls.bodies[number].motion for number in self.index]
        inertias = [motion.inertia for motion in self.motions]
        self.mass, self.load = (
            np.array([getattr(each, name) for each in inertias]) / density for name in ("mass", "load")
        )
        self.moves = ~np.array([each.held for each in inertias])
        self.massless_rotation = self.moves[:, 2] & (self.mass[:, 2] == 0.0)
        self.radius = np.array([walls.bodies[number].shape.length for number in self.index]) / (2 * math.pi)
        self.arm = np.stack([np.ones_like(self.radius)] * 2 + [self.radius], axis=1)
        self.converged, self.axisymmetric = 0.0, problem.axisymmetric

    def accelerate(self, acceleration):
        """Let the fluid around be under an ``acceleration`` along x, whose pressure acts on the bodies, too."""
        for index, motion in enumerate(self.motions):
            self.load[index, 0] = motion.inertia.load[0] / self.density + motion.inertia.displaced * acceleration

    def reset(self, time):
        """Go back to before the start, at ``time``."""
        for motion in self.motions:
            motion.start(time, motion.inertia.velocity)
        self.contact.reset()

    def restart(self):
        """Forget earlier levels."""
        for motion in self.motions:
            motion.restart()

    def accept(self, time):
        """Let the velocities of a step that ends at ``time`` be the newest."""
        self.contact.accept(self.touching, self.dt)
        self.attempt()
        for motion in self.motions:
            motion.accept(time)

    @property
    def newest(self):
        """Velocities (n, 3) at the end of the last step."""
        return np.array([motion.velocities[0] for motion in self.motions])

    def added_mass(self, duration):
        """Return M_a (n, 3) per unit density for a step of which dt/gamma_0 is the ``duration``."""
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

    def prepare(self, times, dt, time):
        """Take up a step ``dt`` that ends at ``time``: begin with what the last steps extrapolate to."""
        self.gamma0, alpha = times.bdf()
        self.dt = dt
        levels = [np.array([motion.velocities[level] for motion in self.motions]) for level in range(self.depth)]
        self.known = sum(weight * level for weight, level in zip(alpha, levels, strict=False))
        self.extrapolated = np.array([motion.extrapolated(time) for motion in self.motions])
        loads, self.touching, self.gaps = self.contact.loads(time)
        self.pushes = loads[self.index, :3] / self.density
        self.begin(self.extrapolated, self.gamma0 * (self.mass + self.added_mass(dt / self.gamma0)))
        self.attempt()

    @property
    def depth(self):
        """Number of levels."""
        return len(self.motions[0].velocities)

    def begin(self, velocities, jacobian):
        """Begin to iterate, from these ``velocities`` (n, 3) or accelerations."""
        self.velocities, self.jacobian = velocities, jacobian
        self.steps, self.places = [], []

    def begin_start(self, acceleration):
        """Begin with the accelerations (n, 3) of bodies in a fluid without bounds, which has one of (2,) itself."""
        added = self.added_mass(0.0)
        jacobian = self.mass + added
        alone = (self.load + added * [*acceleration, 0.0]) / jacobian
        self.begin(np.where(self.moves, alone, 0.0), jacobian)

    def step_residual(self, loads):
        """Return the residual (n, 3) of a step in which the fluid's force and torque per unit density are ``loads``."""
        change = self.gamma0 * self.velocities - self.known
        return self.mass * change - self.dt * (loads + self.load + self.pushes)

    def correct(self, residual, least, curls=None, found=None):
        """Change the velocities by their ``residual``; return whether they need not be, by ``least`` of a speed.

        ``curls`` (count,) at walls were the given ones, and ``found`` the ones that came of it: they change with the
        velocities, and what they are to be next is returned in ``curls``.
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

    def attempt(self):
        """Let the bodies have the present velocities at the end of the step."""
        for motion, velocity in zip(self.motions, self.velocities, strict=True):
            motion.attempt(velocity)

    @property
    def overlap(self):
        """Whether bodies overlap at the end of the present step."""
        return min(self.gaps.values(), default=1.0) <= 0.0

    def difference(self):
        """Return the largest difference of a body's velocities from those extrapolated."""
        return float(np.abs(self.arm * (self.velocities - self.extrapolated)).max())

    def state(self):
        """What a resumed run needs."""
        return {"motions": [motion.state() for motion in self.motions], "contact": self.contact.state()}

    def restore(self, state):
        """Take up what ``state`` returned."""
        for motion, its in zip(self.motions, state["motions"], strict=True):
            motion.restore(its)
        self.contact.restore(state["contact"])
