"""Free bodies that leave a stream through an outlet, and bodies that enter it later.

A body leaves as a whole when it has come within ``AT_OUTLET`` spacings of an outlet. Particles fill its place. They
have the velocity U + omega x r of the body, which has no divergence and is continuous at its wall.

A body enters at its place at a given time, with the mean velocity and the mean rotation of the fluid there, or given
ones. The particles in its place are removed. Particles around it make room: they move off its wall, and take their
fields from polynomials through the points before.

The number of particles changes by the area of the body, so that the density stays the same. Time levels begin anew, as
at a start from these velocities: an impulse removes their divergence.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.errors import DivergedError
from tisph.geometry.body import Body, gap
from tisph.geometry.ends import LEAST_DISTANCE, OpenEnd, Outlet
from tisph.geometry.motion import REST
from tisph.geometry.packing import pack, relaxed
from tisph.geometry.region import Region
from tisph.schemes.implicit.planar.open_ends import AROUND, DEGREE, nearest_fits, powers_up_to
from tisph.schemes.implicit.planar.parts import BoundaryPart
from tisph.schemes.implicit.planar.problem import Problem

AT_OUTLET = 2.0
"""Distance from an outlet, in particle spacings, at which a body leaves: down to that the fluid between is resolved."""

LEAST_ROOM = 2.0
"""Least distance, in particle spacings, of a body that enters from other bodies."""

AROUND_BODY, SWEEPS = 4.0, 30
"""Distance, in particle spacings, up to which particles make room for a body that enters; sweeps of ``relaxed``."""

JITTER = 0.3
"""Largest random displacement, in spacings, of the particles in the place of a body: a lattice would tear."""


@dataclass
class Particles:
    """Particles at one time: ``position`` (n, 2), ``fields`` (n, numbers) each, unknown velocities first.

    ``number`` (n,): their places in the order of creation, -1 of new ones. ``passages`` (numbers,): how often the fluid
    of a number has left and other fluid has taken it.
    """

    position: np.ndarray
    fields: list[np.ndarray]
    number: np.ndarray
    passages: np.ndarray

    def keep(self, chosen: np.ndarray) -> None:
        """Keep the particles with these indices alone."""
        self.position, self.number = self.position[chosen], self.number[chosen]
        self.fields = [field[chosen] for field in self.fields]

    def add(self, position: np.ndarray, fields: Sequence[np.ndarray]) -> None:
        """Add particles, which get numbers from ``renumber``."""
        self.number = np.append(self.number, np.full(len(position), -1))
        self.position = np.concatenate([self.position, position])
        self.fields = [np.concatenate(pair) for pair in zip(self.fields, fields, strict=True)]

    def renumber(self) -> None:
        """Give the numbers from 0 on that are not in use to new particles, and to those whose number is too large."""
        count = len(self.number)
        others = (self.number < 0) | (self.number >= count)
        unused = np.setdiff1d(np.arange(count), self.number[~others])
        self.number[others] = unused
        self.passages = np.append(self.passages, np.zeros(max(0, count - len(self.passages)), dtype=int))[:count]
        self.passages[unused] += 1


class BodyExchange:
    """Numbers of the bodies of a problem that are in the fluid, ``present``, and times at which others ``left``."""

    def __init__(self, problem: Problem) -> None:
        self.bodies, self.spacing = problem.all_bodies, problem.spacing
        self.present = [number for number, body in enumerate(self.bodies) if body.enters <= problem.start_time]
        self.left: dict[int, float] = {}

    @property
    def in_fluid(self) -> list[Body]:
        """The bodies and walls that are present."""
        return [self.bodies[number] for number in self.present]

    def leaving(self, time: float) -> list[int]:
        """Return the numbers of the free bodies that have come to an outlet."""
        free = [number for number in self.present if self.bodies[number].free]
        outlets = [body for body in self.in_fluid if isinstance(body, Outlet)] if free else []
        least, found = AT_OUTLET * self.spacing, set()
        for number, outlet in itertools.product(free, outlets):
            body = self.bodies[number]
            if float(outlet.nearest(body.at(time).centre[None]).distance[0]) < body.bounding_radius + least:
                outline = body.boundary_points(self.spacing, time).point
                found |= {number} if outlet.nearest(outline).distance.min() < least else set()
        return sorted(found)

    def entering(self, time: float) -> list[int]:
        """Return the numbers of the bodies that enter at this very ``time``."""
        waiting = set(range(len(self.bodies))).difference(self.present, self.left)
        return sorted(number for number in waiting if self.bodies[number].enters == time)

    def exchange(
        self, problem: Problem, particles: Particles, on_walls: list[np.ndarray], time: float
    ) -> tuple[Problem, list[np.ndarray]]:
        """Let bodies leave and enter at ``time``; return the new problem, and the fields at its points on walls.

        ``particles`` are changed in place. ``on_walls``: fields (count, numbers) at the points on walls before.
        """
        walls = problem.walls
        assert walls is not None
        before = Before(problem, particles, on_walls, time)
        for number in self.leaving(time):
            before.fill(particles, self.bodies[number], self._change(number))
            self.left[number] = time
            self.present.remove(number)
        for number in self.entering(time):
            self._require_room(number, time)
            body = self.bodies[number]
            body.motion.start(time, before.first_velocity(body))  # type: ignore[union-attr]
            self.present = sorted([*self.present, number])
            before.clear(particles, body, self._change(number), self.in_fluid)
        particles.renumber()
        bodies = self.in_fluid
        walls = before.walls.of_bodies(bodies)
        place = walls.at(time)[0] + problem.origin
        known = before.by_body(on_walls)
        found = [known.get(id(body)) or before.at(place[part]) for body, part in zip(bodies, walls.parts, strict=True)]
        fields = [np.concatenate(each) for each in zip(*found, strict=True)]
        velocities = problem.velocities(fields[0], place[:, 1])
        return problem.restarted(walls, len(particles.number), time, place, velocities), fields

    def _change(self, number: int) -> int:
        """Return the number of particles in the place of one of the bodies that are present.

        It is a difference of rounded numbers, so that many bodies have no common error.
        """
        area = [self.bodies[each].shape.area / self.spacing**2 for each in self.present]
        return round(sum(area)) - round(sum(area) - self.bodies[number].shape.area / self.spacing**2)

    def _require_room(self, number: int, time: float) -> None:
        """Raise DivergedError where another body is in the place of one that enters."""
        body = self.bodies[number]
        for other in self.in_fluid:
            if other.in_fluid and gap(body, other, time) < LEAST_ROOM * self.spacing:
                x, y = body.centre
                text = f"x: the body that enters at ({x:.4g}, {y:.4g}), t = {time:.4g}, has another one in its way"
                raise DivergedError(f"{text}: let it enter later, or elsewhere")

    def restore_parts(self, parts: Sequence[BoundaryPart], state: Mapping[str, Any]) -> None:
        """Give the ``parts`` of the new boundary what they need of the ``host_state`` of the old one."""
        motions = [body.motion.state() for body in self.in_fluid if body.free]  # type: ignore[union-attr]
        free = {"motions": motions, "contact": [[], *state.get("free", {"contact": [0, 0, 0.0, 0.0]})["contact"][1:]]}
        for part in parts:
            part.restore_host_state({**state, "free": free})

    def seen(self, seen: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return what is ``seen`` of the bodies that are present as numbers of all: NaN of those that are not."""
        if len(self.present) == len(self.bodies):
            return seen
        scatter = seen["load_scatter"]
        scatter = scatter and (scatter[0], self.present[scatter[1]])
        return {**seen, "bodies": seen["bodies"].among(self.present, len(self.bodies)), "load_scatter": scatter}

    def numbers(self) -> dict[str, Any]:
        """Return the times at which bodies have left for ``summary.json``."""
        return {f"left_{number}": time for number, time in sorted(self.left.items())}

    def state(self) -> dict[str, Any]:
        """Return the data that a resumed run needs."""
        return {"present": self.present, "left": list(self.left.items())}

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Restore the data of ``state``; return whether other bodies are present."""
        before, self.present, self.left = self.present, list(state["present"]), dict(state["left"])
        return before != self.present


class Before:
    """The flow of a ``problem`` at one ``time``: fields (points, numbers) of its particles and points on walls."""

    def __init__(self, problem: Problem, particles: Particles, on_walls: list[np.ndarray], time: float) -> None:
        from scipy.spatial import cKDTree

        assert problem.walls is not None
        self.problem, self.walls, self.spacing, self.time = problem, problem.walls, problem.spacing, time
        self.particles = replace(particles)
        self.fields = [np.concatenate(pair) for pair in zip(particles.fields, on_walls, strict=True)]
        self.tree = cKDTree(np.concatenate([particles.position, self.walls.at(time)[0] + problem.origin]))

    def by_body(self, on_walls: list[np.ndarray]) -> dict[int, list[np.ndarray]]:
        """Return the fields at the points of each body, by its identity."""
        pairs = zip(self.walls.bodies, self.walls.parts, strict=True)
        return {id(body): [field[part] for field in on_walls] for body, part in pairs}

    def at(self, places: np.ndarray) -> list[np.ndarray]:
        """Return the fields at ``places`` (n, 2) by polynomials."""
        nearest, weights = nearest_fits(self.tree, places, powers_up_to(DEGREE), AROUND[DEGREE])
        return [np.einsum("ik,ikn->in", weights, field[nearest]) for field in self.fields]

    def first_velocity(self, body: Body) -> np.ndarray:
        """Return the velocities (3,) with which a body enters: given ones, or mean ones of the fluid in its place."""
        inertia, place = body.motion.inertia, np.array(body.centre)  # type: ignore[union-attr]
        inside = np.flatnonzero(replace(body, motion=REST).nearest(self.particles.position).distance < 0.0)
        velocity = self.problem.velocities(self.particles.fields[0], self.particles.position[:, 1])[inside, :2]
        arm = self.particles.position[inside] - place
        arm -= arm.mean(axis=0)
        mean = velocity.mean(axis=0)
        rotation = (arm[:, 0] @ velocity[:, 1] - arm[:, 1] @ velocity[:, 0]) / (arm**2).sum()
        return np.where(inertia.carried, [*mean, rotation], inertia.velocity)

    def fill(self, particles: Particles, body: Body, count: int) -> None:
        """Add ``count`` particles in the place of a body that leaves, with its velocities."""
        state = body.at(self.time)
        inside = replace(frozen(body, self.time), shape=replace(body.shape, fluid_side="inside"))  # type: ignore[type-var]
        low, high = state.centre - body.bounding_radius, state.centre + body.bounding_radius
        region = Region((inside,), tuple(low.tolist()), tuple(high.tolist()))
        places = pack(region, self.spacing, JITTER, 0, count)
        fields = [field[self.tree.query(places)[1]] for field in self.fields]
        fields[0] = self.problem.unknowns(state.velocity(places), places[:, 1])
        particles.add(places, fields)

    def clear(self, particles: Particles, body: Body, count: int, present: Sequence[Body]) -> None:
        """Remove the ``count`` particles that are deepest in a body that enters, and move others off its wall."""
        distance = body.at(self.time).nearest(particles.position).distance
        kept = np.sort(np.argsort(distance, kind="stable")[count:])
        particles.keep(kept)
        near = np.flatnonzero(distance[kept] < AROUND_BODY * self.spacing)
        solids = tuple(frozen(each, self.time, LEAST_DISTANCE * self.spacing) for each in present)
        low, size = self.problem.origin, (self.problem.length, self.problem.height)
        region = Region(solids, low, (low[0] + size[0], low[1] + size[1]))
        places = relaxed(region, particles.position, self.spacing, SWEEPS, near)[near]
        particles.position[near] = places
        for field, values in zip(particles.fields, self.at(places), strict=True):
            field[near] = values


def frozen(body: Body, time: float, clear: float = 0.0) -> Body:
    """Return a body at rest where ``body`` is at ``time``; an open end is ``clear`` [length] farther in the fluid."""
    state = body.at(time)
    moved = clear * body.shape.normal if isinstance(body, OpenEnd) else 0.0
    return replace(body, centre=tuple((state.centre + moved).tolist()), angle=state.angle, motion=REST)
