"""``discretisation.refine: auto``: the places to refine, from the samples of a first run.

At a spacing h the operators miss e(h) = e(H) (h/H)^5 at a particle (``measures/indicator.py``), H being the spacing of
the flow. This is a ``goal`` everywhere where the spacing is

    h = H (goal / e(H))^(1/5),   H/FINEST <= h <= H.                                                  (1)

The goal is the one for which there are ``MORE`` times as many particles as in the first run. Places are chosen one
after the other, each for the particle that lacks the most, until each particle has at most ``ENOUGH`` times h.
Candidates are points and parts of the boundary, with any distance up to which their spacing holds. The one that serves
the most is chosen among those that add at most ``WASTE`` times the particles that are needed where they serve.

Points on a wall that moves keep their distances (``_spacing.py``): such a wall has one spacing s_j all around, and no
place reaches it that wants a smaller one. With the distances d_jk of moving walls, s_j <= s_k + g d_jk. Free bodies
have the same spacing. Open ends and corners under sharp lids keep the spacing of the flow.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.config.sections import Refinement
from tisph.geometry.body import Body
from tisph.geometry.wanted_spacing import GROWTH, InBox
from tisph.measures.indicator import DEGREE, missed
from tisph.scenes._spacing import CLEAR_OF_CORNERS, PIECES, moves, parts_of, spacing_problems
from tisph.snapshot import Snapshot

if TYPE_CHECKING:
    from tisph.config.schema import Config

FINEST = 8.0
"""Largest ratio of the spacing of the flow to another one: the smallest one sets the steps."""

MORE = 2.0
"""Particles over those of the first run: as many as one spacing smaller by the root of 2 would need. More particles are
worth their cost where the error falls by more than with that."""

ENOUGH, WASTE = 1.25, 1.5
"""Spacing over equation (1) that is small enough; particles that a place may add over those that are needed."""

WIDER, WIDTHS = 1.25, 30
"""Ratio between the distances up to which the spacing of a candidate holds, and their number."""

MOST = 40
"""Number of places: each costs some microseconds in each step."""

SLIGHT = 1.1
"""Ratio to the spacing of the flow below which no place is made."""

NEAR, SHARE = 2.0, 0.1
"""Distance, in spacings of the flow, within which particles decide about the spacing of a wall that moves, and the
share of them that may want a smaller one."""

HALVINGS = 12
"""Bisections of the logarithm of the goal."""

LOOKS = 20
"""Times of the run, beside those of the samples, at which walls with a given motion are looked at."""

MOST_PARTICLES = 20_000
"""Number of particles that are looked at, in all samples together."""


class _Boundary:
    """Parts of the boundary of a ``flow`` in its first run, and the distances that limit spacings there.

    ``members``: keys of the parts that are one, all free bodies or a single part, by the key of the whole. ``moving``:
    keys of those whose points keep their distances. ``looks``: parts by key at a time, and the time.
    """

    def __init__(self, flow: Any, seen: Sequence[Any], snapshots: Sequence[Snapshot], end: float):
        self.flow, self.first = flow, parts_of(flow)
        self.states = [(parts_of(scene), each) for scene, each in zip(seen, snapshots, strict=True)]
        given = {key: part for key, part in self.first.items() if not part.free}
        times = np.linspace(flow.start_time, end, LOOKS)
        self.looks: list[tuple[dict[str, Body], float]] = [(self.first, flow.start_time)]
        self.looks += [*((parts, each.t) for parts, each in self.states), *((given, float(t)) for t in times)]
        bodies = [key for key in self.first if key.startswith("bodies.")]
        together = bodies if len(bodies) > 1 and all(self.first[key].free for key in bodies) else []
        self.members = {key: [key] for key in self.first if key not in together}
        self.members |= {"bodies": together} if together else {}
        self.moving = [
            key for key in self.members if self._any(key, moves) or self._any(key, lambda part: not part.steady)
        ]
        self.ends = [body for body in flow.bodies if not body.solid]
        self.corners = np.reshape([corner.place for corner in flow.corners], (-1, 2))
        self.clear = CLEAR_OF_CORNERS * flow.spacing

    def _any(self, key: str, holds: Callable[[Body], bool]) -> bool:
        return any(holds(self.first[each]) for each in self.members[key])

    def away(self, key: str) -> np.ndarray:
        """Return the distances (n,) of the particles of all states from a part."""
        found = [
            np.min([parts[each].nearest(_positions(state), state.t).distance for each in self.members[key]], axis=0)
            for parts, state in self.states
        ]
        return np.concatenate(found)

    def apart(self, key: str, other: str) -> float:
        """Return the least distance between two parts."""
        found = [
            float(parts[one].nearest(_points(parts[two], time), time).distance.min())
            for parts, time in self.looks
            for one in self.members[key]
            for two in self.members[other]
            if {one, two} <= parts.keys()
        ]
        return min(found)

    def free(self, key: str) -> float:
        """Return the least distance of a part from the places that keep the spacing of the flow around it."""
        travels, t = self._any(key, moves), self.flow.start_time
        if self.ends and travels:
            return -math.inf
        others = self.moving if key not in self.moving else [each for each in self.members if each not in self.moving]
        found = [self.apart(key, other) for other in others if key not in self.moving or travels]
        for part in map(self.first.get, self.members[key]):
            assert part
            found += [float(part.nearest(_points(end), t).distance.min()) for end in self.ends]
            found += [float(distance) - self.clear for distance in part.nearest(self.corners, t).distance]
        return min(found, default=math.inf)

    def free_points(self, places: np.ndarray) -> np.ndarray:
        """Return the distances (n,) of ``places`` (n, 2) from those that keep the spacing of the flow around them."""
        free = np.full(len(places), math.inf)
        moving = {each for key in self.moving for each in self.members[key]}
        for parts, time in self.looks:
            for key in moving & parts.keys():
                free = np.minimum(free, parts[key].nearest(places, time).distance)
        for end in self.ends:
            free = np.minimum(free, end.nearest(places, self.flow.start_time).distance)
        for corner in self.corners:
            free = np.minimum(free, np.hypot(*(places - corner).T) - self.clear)
        return free


@dataclass
class _Demand:
    """The particles (n,) of all samples, and the distances that limit their spacings.

    ``error``: what is missed at the ``largest`` spacing. ``width`` of the particles in the first run, and spacing
    ``given`` by the config. ``away``: distances (n,) from each part of the boundary by its key. ``free``: distances
    (n,) from the nearest place that keeps the spacing of the flow; ``fixed`` and ``moving``: such distances of the
    parts by key. ``apart``: distances between parts that move.
    """

    largest: float
    growth: float
    periods: Any
    places: np.ndarray
    error: np.ndarray
    width: np.ndarray
    given: np.ndarray
    away: Mapping[str, np.ndarray]
    free: np.ndarray
    fixed: Mapping[str, float]
    moving: Mapping[str, float]
    apart: Mapping[tuple[str, str], float]

    def wanted(self, goal: float) -> np.ndarray:
        """Return the spacings (n,) of equation (1)."""
        with np.errstate(divide="ignore"):
            return self.largest * np.clip((goal / self.error) ** (1.0 / DEGREE), 1.0 / FINEST, 1.0)

    def allowed(self, free: Any) -> Any:
        """Return the smallest spacing of a place at a distance ``free`` from those that keep the flow's spacing."""
        return np.minimum(self.largest, self.largest - self.growth * np.minimum(free, self.largest / self.growth))

    def longest(self, spacing: float, free: float) -> float:
        """Return the distance up to which a ``spacing`` may hold at such a place."""
        return free - (self.largest - spacing) / self.growth

    def distance(self, place: Refinement) -> np.ndarray:
        """Return the distances (n,) of the particles from a place."""
        if place.near:
            return self.away[place.near]
        assert place.at
        return InBox(place.at, place.at, place.spacing, periods=self.periods).distance(self.places, 0.0)

    def spacing(self, place: Refinement, distance: np.ndarray) -> np.ndarray:
        """Return the spacings (n,) at a ``distance`` (n,) from one place."""
        return np.minimum(self.largest, place.spacing + self.growth * np.maximum(distance - place.within, 0.0))

    def of_moving(self, wanted: np.ndarray) -> dict[str, float]:
        """Return the spacings of the parts that move, where the particles have the ``wanted`` (n,) ones."""
        found = {}
        for key, free in self.moving.items():
            near = wanted[self.away[key] <= NEAR * self.largest]
            size = float(np.quantile(near, SHARE)) if near.size else self.largest
            found[key] = max(size, float(self.allowed(free))) if size <= self.largest / SLIGHT else self.largest
        for (key, other), apart in self.apart.items():
            found[key] = max(found[key], float(self.allowed(self.moving[other])) - self.growth * apart)
        grown = {key: [found[key]] for key in found}
        for (key, other), apart in self.apart.items():
            grown[other].append(found[key] + self.growth * apart)
        return {
            key: _rounded(min(sizes)) if min(sizes) < self.largest else self.largest for key, sizes in grown.items()
        }

    def candidates(
        self, index: int, spacing: float, own: Mapping[str, float]
    ) -> Iterator[tuple[Refinement, np.ndarray]]:
        """Yield places that give the particle ``index`` about a ``spacing``, and the distances (n,) from them.

        They are the point there, and around parts of the boundary. ``own``: spacings of the parts that move.
        """
        x, y = (_rounded(each) for each in self.places[index])
        found: list[tuple[Any, float, float]] = [({"at": (x, y)}, spacing, self.longest(spacing, self.free[index]))]
        found += [({"near": key}, spacing, self.longest(spacing, free)) for key, free in self.fixed.items()]
        for key, free in self.moving.items():
            size = max(own[key], spacing)
            others = [self.apart[key, other] - (own[other] - size) / self.growth for other in own if other != key]
            found.append(({"near": key}, size, min([self.longest(size, free), *others])))
        for where, size, most in found:
            distance = self.distance(Refinement(**where, spacing=size))
            serving = distance[index] - (ENOUGH * spacing - size) / self.growth
            for within in (0.0, *(size * WIDER**k for k in range(WIDTHS))):
                if serving <= within <= most:
                    yield Refinement(**where, spacing=size, within=_rounded(within)), distance


def _rounded(value: float) -> float:
    """Return a ``value`` in six digits, as it stands in the config of the results."""
    return float(f"{value:.6g}")


def _points(body: Body, time: float = 0.0) -> np.ndarray:
    """Return points (n, 2) on the wall of a ``body`` at ``time``."""
    return body.boundary_points(body.shape.length / PIECES, time).point


def _positions(snapshot: Snapshot) -> np.ndarray:
    """Return the positions (particles, 2)."""
    return np.stack([snapshot.x, snapshot.y], axis=1).astype(float)


def _demand(config: "Config", flow: Any, snapshots: Sequence[Snapshot]) -> _Demand:
    """Return the demand of the particles in ``snapshots`` of the ``flow`` of a ``config``."""
    seen = [flow.seen(each) for each in snapshots]
    boundary = _Boundary(flow, seen, snapshots, config.time.end)
    places = np.concatenate([_positions(each) for each in snapshots])
    some = slice(None, None, math.ceil(len(places) / MOST_PARTICLES))
    width = np.concatenate([each.widths(flow.spacing) for each in snapshots])
    error, given = (
        np.concatenate([of(scene, each) for scene, each in zip(seen, snapshots, strict=True)])
        for of in (missed, lambda scene, each: scene.wanted_spacing.at(_positions(each), each.t))
    )
    moving = boundary.moving
    return _Demand(
        largest=flow.spacing,
        growth=config.discretisation.growth or GROWTH,
        periods=tuple(size if period else 0.0 for size, period in zip(flow.extent, flow.periodic, strict=True)),
        places=places[some],
        error=(error * (flow.spacing / width) ** DEGREE)[some],
        width=width[some],
        given=given[some],
        away={key: boundary.away(key)[some] for key in boundary.members},
        free=boundary.free_points(places[some]),
        fixed={key: boundary.free(key) for key in boundary.members if key not in moving},
        moving={key: boundary.free(key) for key in moving},
        apart={(one, other): boundary.apart(one, other) for one in moving for other in moving if one != other},
    )


def places_of(config: "Config", flow: Any, snapshots: Sequence[Snapshot]) -> tuple[Refinement, ...]:
    """Return the places to refine for a ``config``, from ``snapshots`` of the ``flow`` in its first run."""
    demand = _demand(config, flow, snapshots)
    if not (demand.error > 0.0).any():
        return ()
    high, found = math.log(demand.error.max()), list[Refinement]()
    low = high - DEGREE * math.log(FINEST)
    for _ in range(HALVINGS):
        goal = 0.5 * (low + high)
        chosen, spacing = _chosen(demand, demand.wanted(math.exp(goal)))
        if np.mean((demand.width / spacing) ** 2) <= MORE:
            high, found = goal, chosen
        else:
            low = goal
    return _accepted(config, found)


def _chosen(demand: _Demand, wanted: np.ndarray) -> tuple[list[Refinement], np.ndarray]:
    """Return places that give the spacings ``wanted`` (n,) as far as possible, and the spacings (n,) with them."""
    own, area = demand.of_moving(wanted), demand.width**2
    chosen = [Refinement(near=key, spacing=size) for key, size in own.items() if size < demand.largest]
    spacing = np.min([demand.given, *(demand.spacing(each, demand.distance(each)) for each in chosen)], axis=0)
    wanted = np.maximum(wanted, demand.allowed(demand.free))
    while len(chosen) < MOST:
        index = int(np.argmax(spacing / wanted))
        if spacing[index] <= ENOUGH * wanted[index] or wanted[index] > demand.largest / SLIGHT:
            break
        best: tuple[float, float] | None = None
        for place, distance in demand.candidates(index, _rounded(wanted[index]), own):
            after = np.minimum(spacing, demand.spacing(place, distance))
            served = (spacing > ENOUGH * wanted) & (after <= ENOUGH * wanted)
            needed = float((area / wanted**2 - area / spacing**2)[served].sum())
            added = float((area / after**2 - area / spacing**2).sum())
            if served[index]:
                rank = (needed if added <= WASTE * needed else 0.0, needed / added)
                if best is None or rank > best:
                    best, found = rank, (place, after)
        if best is None:
            break
        place, spacing = found
        chosen.append(place)
    return chosen, spacing


def _accepted(config: "Config", places: Sequence[Refinement]) -> tuple[Refinement, ...]:
    """Return the ``places`` that the rules for spacings accept (``_spacing.py``)."""
    while places:
        discretisation = config.discretisation.model_copy(update={"refine": tuple(places)})
        problems = spacing_problems(config.model_copy(update={"discretisation": discretisation}))
        refused = {key for key, *_ in problems}
        kept = [each for k, each in enumerate(places) if f"discretisation.refine.{k}.spacing" not in refused]
        if len(kept) == len(places):
            break
        places = kept
    return tuple(places)
