"""Particles that are removed where they crowd and inserted where they are sparse, to follow the wanted spacing.

Of each particle i with the spacing h_i the filling is

    f_i = (1 + sum_j W(r_ij / (R (h_i + h_j)/2))) 7/(pi R^2 E) / (1 - b_i),    W(q) = (1 - q)^4 (1 + 4 q),

1 for particles at the wanted distances, E being ``EVEN``; b_i is the part of the integral of W beyond the nearest wall.
It scatters with the arrangement: means of it, with the weights W, count. Where one is above 1 + ``BAND`` the particle
is removed; where one is below 1 - ``BAND`` a particle is inserted beside it, at the place that is farthest from all
others. Within two spacings one particle is removed or inserted at a time. Shifting evens out the rest. Where the
spacing is the largest one, as many particles flow in as out, and none is removed or inserted. Particles are looked at
after each step: in the longest ones they move a spacing, and the wanted number changes by a fifth.

A particle that is inserted takes all its time levels from polynomials of degree 4 through the points around it, of a
polymer the logarithm of the conformation. So its values have errors of the order h^5, below those of a shift.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tisph.geometry.region import nearest_image
from tisph.runtime import view
from tisph.schemes.implicit.planar.body_exchange import Particles
from tisph.schemes.implicit.planar.open_ends import AROUND, DEGREE, nearest_fits, powers_up_to
from tisph.schemes.implicit.planar.problem import Problem

REACH = 2.5
"""Radius R of the kernel W in spacings."""

EVEN = 1.015
"""Filling where particles that shifting has evened out have the wanted number: a particle is itself one of them. In
vortices with one spacing the mean was 1.0146 to 1.0154 from t = 0.08 to 0.4. Without this factor vortices with a
spacing that varies lost 2.3 % of the particles."""

BAND = 0.12
"""Deviation of the mean filling from 1 from which on particles are removed or inserted."""

APART = 2.0
"""Least distance, in spacings, of two particles that are removed or inserted at the same time."""

BESIDE = np.array([0.5, 0.7, 0.9])[:, None, None] * np.stack(
    [np.cos(np.arange(12) * math.pi / 6), np.sin(np.arange(12) * math.pi / 6)], axis=-1
)
"""Places, in spacings, around a particle with too few others, at which one may be inserted."""

FROM_WALLS = 0.4
"""Least distance of a particle that is inserted from a wall, in spacings."""


def part_beyond(distance: np.ndarray) -> np.ndarray:
    """Return the part (n,) of the integral of W beyond a plane at a ``distance`` (n,) in radii of the kernel."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    x = distance[:, None] + (1.0 - distance[:, None]) * 0.5 * (1.0 + nodes)
    height = np.sqrt(1.0 - x**2)[..., None]
    radius = np.sqrt(x[..., None] ** 2 + (height * 0.5 * (1.0 + nodes)) ** 2)
    kernel = (1.0 - radius) ** 4 * (1.0 + 4.0 * radius)
    across = (kernel * weights).sum(axis=2) * height[..., 0]  # both halves, each of height/2
    return 7.0 / math.pi * (across * weights).sum(axis=1) * 0.5 * (1.0 - distance)


PART_BEYOND = np.linspace(0.0, 1.0, 65), part_beyond(np.linspace(0.0, 1.0, 65))
"""Distances in radii of the kernel, and the parts b beyond."""


class Insertion:
    """Insertion and removal of the particles of a ``problem``, with the ``points``, a ``PointCloud``, of its scheme.

    ``inserted`` and ``removed``: numbers of particles so far. ``area``: of the fluid.
    """

    points: Any

    def __init__(self, problem: Problem) -> None:
        self.problem, self.periods = problem, (problem.length, problem.height)

    def reset(self) -> None:
        """Return to the state before the start."""
        self.inserted = self.removed = 0

    def begin(self, position: np.ndarray, time: float) -> None:
        """Take note of the area that particles at ``position`` (n, 2), in the frame of the scene, fill at ``time``."""
        self.area = float(np.square(self.problem.wanted_spacing.at(position, time)).sum())

    def areas(self, places: Sequence[np.ndarray], time: float) -> np.ndarray | None:
        """Return the areas (n,) of particles at ``places`` x, y (n,) as in ``begin``; None with one spacing."""
        if not self.points.graded:
            return None
        squares = np.square(self.problem.wanted_spacing.at(np.stack(places, axis=1), time))
        return squares * (self.area / squares.sum())

    def excess(self, position: np.ndarray, time: float) -> str:
        """Return why there are so many particles at ``position`` (n, 2), in the frame of the scene, in words."""
        wanted = np.square(self.problem.wanted_spacing.at(position, time)).sum()
        if wanted > (1.0 + BAND) * self.area:
            return "the particles have clustered"
        return "the parts with a small spacing have grown since the start"

    def change(self, particles: Particles, crowded: np.ndarray, places: np.ndarray, values: list[np.ndarray]) -> None:
        """Remove the ``crowded`` particles, and add others at ``places`` (m, 2) with these ``values`` (m, numbers)."""
        particles.keep(np.delete(np.arange(len(particles.number)), crowded))
        particles.add(places, values)
        particles.renumber()
        self.inserted, self.removed = self.inserted + len(places), self.removed + len(crowded)

    def values(self, position: np.ndarray, fields: list[np.ndarray], places: np.ndarray) -> list[np.ndarray]:
        """Return ``fields`` (points, numbers) at ``places`` (m, 2), by polynomials through those at ``position``."""
        from scipy.spatial import cKDTree

        periods, count = list(self.periods), len(position)
        if self.problem.axisymmetric:  # all fields are even about the axis
            position = np.concatenate([position, position * [1.0, -1.0] - [0.0, 2.0 * self.problem.origin[1]]])
            periods[1] = 0.0
        tree = cKDTree(position, boxsize=periods)
        nearest, weights = nearest_fits(tree, places, powers_up_to(DEGREE), AROUND[DEGREE])
        return [np.einsum("ik,ikn->in", weights, field[nearest % count].astype(float)) for field in fields]

    def choose(self, position: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices of particles to remove and the places (m, 2) of those to insert.

        ``position`` (points, 2) of the particles, and after them of the points on walls, in the box.
        """
        from scipy.spatial import cKDTree

        inside = self.points.in_fluid
        fluid = position[:inside]
        spacing = self.problem.wanted_spacing.at(fluid + self.problem.origin, time)
        filling, finer = np.ones(inside), np.flatnonzero(spacing < self.problem.spacing)
        filling[finer] = self.filling(position, spacing, time, finer)
        order = np.argsort(-np.abs(filling - 1.0), kind="stable")
        order = order[np.abs(filling[order] - 1.0) > BAND]
        chosen: list[int] = []
        for i in order:
            apart = np.hypot(*nearest_image(fluid[chosen] - fluid[i], self.periods).T)
            if (apart > APART * spacing[i]).all():
                chosen.append(int(i))
        sparse = [i for i in chosen if filling[i] < 1.0]
        tree = cKDTree(position, boxsize=self.periods)
        places = [self.hole(tree, fluid[i], spacing[i], time) for i in sparse]
        crowded = np.array(sorted(set(chosen).difference(sparse)), dtype=int)
        return crowded, np.reshape([place for place in places if place is not None], (-1, 2))

    def hole(self, tree: Any, centre: np.ndarray, spacing: float, time: float) -> np.ndarray | None:
        """Return the place (2,) beside a particle at ``centre`` that is farthest from all points; None without any."""
        places = (centre + spacing * BESIDE.reshape(-1, 2)) % self.periods
        if self.problem.walls:
            distance = self.problem.walls.distance(places, time, self.problem.bodies)
            places = places[distance > FROM_WALLS * spacing]
        if not len(places):
            return None
        return places[np.argmax(tree.query(places)[0])]

    def filling(self, position: np.ndarray, spacing: np.ndarray, time: float, chosen: np.ndarray) -> np.ndarray:
        """Return the means of the filling at the ``chosen`` particles (n,); all have this ``spacing`` (in_fluid,)."""
        inside = self.points.in_fluid
        there = self.pairs(chosen)[1]
        known = np.union1d(chosen, there)  # particles whose filling the means contain
        beyond, own = np.zeros(len(known)), position[known]
        if self.problem.walls:
            distance = self.problem.walls.distance(own, time, self.problem.bodies)
            if self.problem.reaches_axis:
                distance = np.minimum(distance, own[:, 1] + self.problem.origin[1])
            beyond = np.interp(distance / (REACH * spacing[known]), *PART_BEYOND)
        here, there = self.pairs(known)
        apart = nearest_image(position[there] - position[here], self.periods)
        reach = 0.5 * REACH * (spacing[here] + spacing[there])
        nearness = np.maximum(1.0 - np.hypot(*apart.T) / reach, 0.0)
        weight = nearness**4 * (5.0 - 4.0 * nearness)
        total, found = 1.0 + np.bincount(here, weight, inside), np.zeros(inside)
        found[known] = 7.0 / (math.pi * REACH**2 * EVEN) * total[known] / (1.0 - beyond)
        return ((found + np.bincount(here, weight * found[there], inside)) / total)[chosen]

    def pairs(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the pairs of the ``chosen`` particles and their neighbours: indices of both, (pairs,) each."""
        begin, end = (view(each)[chosen] for each in (self.points.begin, self.points.end))
        count = end - begin
        entries = np.repeat(end - np.cumsum(count), count) + np.arange(count.sum())
        here, there = np.repeat(chosen, count), view(self.points.neighbours)[entries]
        among = there < self.points.in_fluid
        return here[among], there[among]

    def numbers(self) -> Mapping[str, Any]:
        """Return the numbers of particles that were inserted and removed, for ``summary.json``."""
        return self.counts if self.points.graded else {}

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of particles that were inserted and removed."""
        return {"inserted": self.inserted, "removed": self.removed}

    def state(self) -> dict[str, Any]:
        """Return the data that a resumed run needs."""
        return {"insertion": [self.inserted, self.removed, self.area]} if self.points.graded else {}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore the data of ``state``."""
        if self.points.graded:
            self.inserted, self.removed, self.area = state["insertion"]
