"""Walls along which the fluid slips: the velocity of the fluid at their points is unknown, and follows the wall stress.

With the velocity w of the fluid relative to the wall, the unit normal n into the fluid, a unit tangent t, the slip
length b, and the dynamic viscosity mu of solvent and polymer together,

    n . w = 0,      t . w = (b/mu) t . sigma . n,

in which sigma is the whole stress, of a polymer, too. The speeds X = t . w are unknowns of the coupled solver
(``numerics/stokes.py``), and their equations, with the particle spacing h and per unit density,

    t . sigma . n / (nu (1/b + 1/h)) = X (1/b) / (1/b + 1/h),

hold for an infinite b, too: t . sigma . n = 0. sigma contains the curvature kappa of the wall, d_n w_t - kappa w_t. In
axisymmetric flow there are two tangents, along the wall in the half-plane, and around the axis.

Points move with the wall, and the fluid slides past them. Their time levels are those of the fluid that is at them: in
each step they are carried along the wall, by cubic splines. So the difference of the velocities in time is the
acceleration of fluid, with the part -kappa w_t^2 along the normal that the pressure of a curved wall balances.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.numerics.stokes import Unknowns
from tisph.runtime import ti, view
from tisph.schemes.implicit.planar.parts import BoundaryPart, Coupling
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, TimeWeights
from tisph.schemes.implicit.planar.wall_boundary import WallBoundary

if TYPE_CHECKING:
    from tisph.schemes.implicit.planar.equations import Equations


DEPARTURES = 4
"""Iterations for the place from which fluid at a wall has come in a step, each more exact by a Courant number."""


@ti.data_oriented
class SlippingWalls(BoundaryPart):
    """The ``BoundaryPart`` of walls with a slip length, whose m points are ``chosen`` among the points on walls.

    ``stiffness`` (m,): inverse slip lengths. ``velocity_there`` (m, components): newest velocity of the fluid at the
    points, of which the part along the wall counts. ``speeds`` (levels, m): slip in the plane of this fluid at the last
    time levels, newest first.
    """

    def __init__(self, boundary: WallBoundary) -> None:
        self.boundary, self.problem = boundary, boundary.problem
        self.walls: Any = boundary.walls
        self.chosen = np.flatnonzero(self.walls.slip_length)
        self.stiffness = 1.0 / self.walls.slip_length[self.chosen]
        self.components = boundary.levels.components
        self.velocity_there = np.zeros((len(self.chosen), self.components))
        self.time = self.problem.start_time
        self.speeds = np.zeros((VELOCITIES, len(self.chosen)))
        self.before: Any = None

    @property
    def slots(self) -> np.ndarray:
        """Slots (m,) of the points."""
        return self.boundary.points.in_fluid + self.chosen

    def couplings(self, rounding: float, slow: bool) -> list[Coupling]:
        """Return the coupling of the slip with the fluid."""
        return [SlipCoupling(self)]

    def reset(self, time: float) -> None:
        """Return to the state before the start, at ``time``."""
        self.time = time
        self.velocity_there[...] = 0.0

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Carry the time levels along the walls, and extrapolate the velocities to the end of a step, at ``time``.

        Return True, since nothing overlaps.
        """
        fields = *self.boundary.carried_fields, self.boundary.levels.position
        values = [(view(field), view(field)[self.slots]) for field in fields]
        self.before = self.time, self.velocity_there, self.speeds, values
        if len(weights.offsets) == 1:  # at the start, or after a jump of the speed of a wall
            self.time = math.nextafter(self.time, math.inf)
            self.speeds = np.zeros_like(self.speeds)
            self.speeds[0] = self.slip()[0]
        self.carry(weights.step_integral())
        self.time = time
        levels = view(self.boundary.levels.fields)[self.slots, : VELOCITIES * self.components].astype(float)
        levels = levels.reshape(len(levels), VELOCITIES, self.components)
        before = view(self.boundary.levels.position)[self.slots, 1] + self.problem.origin[1]
        levels *= self.boundary.coordinates.carried_factors(before, self.radii)[:, None]
        self.velocity_there = np.einsum("a,iac->ic", weights.extrapolation(VELOCITIES), levels)
        return True

    def carry(self, weights: np.ndarray) -> None:
        """Give the points the time levels of the fluid that is at them after a step with these ``weights`` of speeds.

        Fluid at the place s before the step is at s + sum_q w_q speed_q(s) after it.
        """
        self.speeds, heights, first = self.speeds.copy(), self.walls.at(self.time)[0][self.chosen, 1], 0
        fields = self.boundary.carried_fields
        for number, part in enumerate(self.walls.parts):
            if not self.walls.bodies[number].slip_length:
                continue
            own = slice(first, first + part.stop - part.start)  # among the points that slip
            first, slots = own.stop, self.slots[own]
            carried = [view(field)[slots].reshape(len(slots), -1).T.astype(float) for field in fields]
            rows = [weights @ self.speeds[:, own], heights[own]]
            place, curve = self.walls.curve(number, np.vstack([*rows, self.speeds[:, own], *carried]), self.time)
            origin = place
            for _ in range(DEPARTURES):
                origin = place - curve(origin)[0]
            _, height, *found = curve(origin)
            self.speeds[:, own], found = found[:VELOCITIES], found[VELOCITIES:]
            view(self.boundary.levels.position)[slots, 1] = height
            for field, values in zip(fields, carried, strict=True):
                view(field)[slots] = np.reshape(np.transpose(found[: len(values)]), view(field)[slots].shape)
                found = found[len(values) :]

    def reject(self) -> None:
        """Take back what ``predict`` has changed."""
        if self.before:
            self.time, self.velocity_there, self.speeds, values = self.before
            for field, value in values:
                field[self.slots] = value
        self.before = None

    def accept(self, time: float) -> None:
        """Store the slip of the step that ends at ``time``."""
        self.before = None
        self.speeds = np.concatenate([self.slip()[:1], self.speeds[:-1]])

    def forget(self) -> None:
        """Take the newest velocities, which do not jump with the velocity of a wall."""
        self.velocity_there = self.boundary.newest_velocities[self.slots].astype(float)

    def end_impulse(self, equations: "Equations") -> None:
        """Compute the velocities after the impulse of the start, whose potential is the present pressure."""
        solver: Any = equations  # Coupled
        potential = view(equations.pressure.x)[: self.boundary.points.fluid].astype(float)
        self.velocity_there = self.boundary.fluid_velocity[self.chosen]
        for component, matrix in enumerate((solver.stokes.wall_x, solver.stokes.wall_y)):
            self.velocity_there[:, component] -= (matrix @ potential)[self.chosen]

    @property
    def radii(self) -> np.ndarray:
        """Distances (m,) of the points from the axis; 1 in planar flow."""
        if not self.problem.axisymmetric:
            return np.ones(len(self.chosen))
        return self.walls.radii(self.time)[self.chosen]

    @property
    def tangents(self) -> np.ndarray:
        """Unit vectors (tangents, m, components) along the walls, of velocities."""
        x, y = self.walls.at(self.time)[1][self.chosen].T
        none = np.zeros_like(x)
        vectors = [[-y, x, none], [none, none, none + 1.0]]
        found = np.array(vectors[: 1 + self.problem.swirls])[:, : self.components]
        return found.transpose(0, 2, 1)

    def along(self, velocity: np.ndarray) -> np.ndarray:
        """Return the parts (tangents, m) of a ``velocity`` (m, components), as unknowns, along the walls."""
        return np.einsum("tmc,mc->tm", self.tangents, self.problem.velocities(velocity, self.radii))

    def slip(self) -> np.ndarray:
        """Return the speeds X (tangents, m) of the fluid along the walls, relative to these."""
        return self.along(self.velocity_there - self.walls.velocities(self.time)[self.chosen])

    def velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Return the ``velocity`` (count, components) of the points, with that of the fluid along the walls."""
        speeds = self.along(self.velocity_there - velocity[self.chosen])
        change = np.einsum("tmc,tm->mc", self.tangents, speeds)
        velocity[self.chosen] += self.problem.unknowns(change, self.radii)
        return velocity

    def sliding(self) -> np.ndarray:
        """Return the normal acceleration (count,) of the fluid that slides along the walls, beyond its point's."""
        speed = np.zeros(self.walls.count)
        speed[self.chosen] = self.slip()[0]
        return self.walls.sliding_acceleration(speed, self.time)

    def acceleration(self, acceleration: np.ndarray) -> np.ndarray:
        """Return the ``acceleration`` (count, components) of the points with that of the fluid that slides there."""
        normal = np.zeros_like(acceleration)
        normal[:, :2] = self.sliding()[:, None] * self.boundary.normals
        radii = self.walls.radii(self.time) if self.problem.axisymmetric else np.ones(len(normal))
        return acceleration + self.problem.unknowns(normal, radii)

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {"slip_speeds": self.speeds.tolist(), "slip_time": self.time}

    def restore_host_state(self, state: Mapping[str, Any], places: Any = None) -> None:
        """Restore the numbers of ``host_state``."""
        self.speeds, self.time = np.array(state["slip_speeds"]), state["slip_time"]


class SlipCoupling(Coupling):
    """The ``Coupling`` of the slip at the points of ``walls``, a ``SlippingWalls``, with the fluid."""

    def __init__(self, walls: SlippingWalls) -> None:
        self.part, self.boundary, self.problem = walls, walls.boundary, walls.problem

    def unknowns(self, dt: float) -> Unknowns:
        """Return the slip X (tangents * m,) as unknowns of a step ``dt``."""
        from scipy.sparse import csr_matrix

        part, boundary, problem = self.part, self.boundary, self.problem
        tangents, count, components = part.tangents.shape
        total = part.stiffness + 1.0 / problem.spacing
        columns = np.repeat(np.arange(tangents * count), components)
        rows = np.tile(components * part.chosen[:, None] + np.arange(components), (tangents, 1)).ravel()
        shape = components * boundary.walls.count, tangents * count
        per_speed = np.stack([problem.unknowns(tangent, part.radii) for tangent in part.tangents])
        scale = 1.0 / (problem.kinematic_viscosity * total)
        motion = csr_matrix((per_speed.ravel(), (rows, columns)), shape)
        forces = csr_matrix(((part.tangents * scale[:, None]).ravel(), (columns, rows)), shape[::-1])
        viscosity = problem.solvent_viscosity + boundary.extra_stress.viscosity
        local = boundary.extra_stress.local_viscosities(viscosity, boundary.points.fluid)[part.slots]
        slope = view(boundary.operators.diagonal)[part.slots] / view(boundary.weight)[part.slots]
        inertia = part.stiffness / total
        response = inertia + scale * local * np.abs(slope)
        none = np.zeros(tangents * count)
        return Unknowns(
            motion,
            forces,
            none,
            none,
            np.tile(inertia, tangents),
            csr_matrix((tangents * count, boundary.points.fluid)),
            forces @ boundary.known_tractions().ravel(),
            part.slip().ravel(),
            np.full(tangents * count, 1.0 / np.sqrt(boundary.points.in_fluid)),
            np.tile(response, tangents),
        )

    def take(self, equations: "Equations", found: np.ndarray) -> None:
        """Let the fluid slip with the speeds X that were ``found``."""
        part, problem = self.part, self.problem
        slip = np.einsum("tmc,tm->mc", part.tangents, found.reshape(len(part.tangents), -1))
        wall = part.walls.velocities(part.time)[part.chosen]
        part.velocity_there = wall + problem.unknowns(slip, part.radii)
        self.boundary.update_velocity(part.time)
