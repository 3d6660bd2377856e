"""``discretisation.refine: auto``: the places to refine, from the samples of a first run.

At a spacing h the operators miss e(h) = e(H) (h/H)^5 at a particle (``measures/indicator.py``), H being the spacing of
the flow. This is a ``goal`` everywhere where the spacing is

    h = H (goal / e(H))^(1/5),   H/FINEST <= h <= H.                                                  (1)

The goal is the one for which there are ``MORE`` times as many particles as in the first run. Places are chosen one
after the other, each for the particle that lacks the most, until each particle has at most ``ENOUGH`` times h.
Candidates are points and parts of the boundary, with any distance up to which their spacing holds. The one that serves
the most is chosen among those that add at most ``WASTE`` times the particles that are needed where they serve.

Points on a wall that moves keep their distances (``_spacing.py``): all such walls get one spacing, and no other place
reaches them. Open ends and corners under sharp lids keep the spacing of the flow.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
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
"""Particles over those of the first run: as many as one spacing smaller by the root of 2 would need. They are worth it
where the error falls by more than with that."""

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


@dataclass
class _Demand:
    """The particles (n,) of all samples, and the distances that limit their spacings.

    ``error``: what is missed at the ``largest`` spacing. ``width`` of the particles in the first run, and spacing
    ``given`` by the config. ``away``: distances (n,) from each part of the boundary by its key. ``free``: distances
    (n,) from the nearest place that keeps the spacing of the flow; ``free_part``: such distances of the parts.
    ``fixed`` and ``moving``: keys of the parts at rest, and of the others.
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
    free_part: Mapping[str, float]
    fixed: Sequence[str]
    moving: Sequence[str]

    def wanted(self, goal: float) -> np.ndarray:
        """Return the spacings (n,) of equation (1)."""
        with np.errstate(divide="ignore"):
            return self.largest * np.clip((goal / self.error) ** (1.0 / DEGREE), 1.0 / FINEST, 1.0)

    def allowed(self, free: Any) -> Any:
        """Return the smallest spacing of a place at a distance ``free`` from those that keep the flow's spacing."""
        return self.largest - self.growth * np.minimum(free, self.largest / self.growth)

    def distance(self, place: Refinement) -> np.ndarray:
        """Return the distances (n,) of the particles from a place."""
        if place.near:
            return np.min([self.away[key] for key in _named(self.away, place.near)], axis=0)
        assert place.at
        return InBox(place.at, place.at, place.spacing, periods=self.periods).distance(self.places, 0.0)

    def spacing(self, place: Refinement, distance: np.ndarray) -> np.ndarray:
        """Return the spacings (n,) at a ``distance`` (n,) from one place."""
        return np.minimum(self.largest, place.spacing + self.growth * np.maximum(distance - place.within, 0.0))

    def candidates(
        self, index: int, spacing: float, least: Mapping[str, float]
    ) -> Iterator[tuple[Refinement, np.ndarray]]:
        """Yield places that give the particle ``index`` about a ``spacing``, and the distances (n,) from them.

        They are the point there, and around parts of the boundary, which have at ``least`` a spacing by their key.
        """
        x, y = (_rounded(each) for each in self.places[index])
        found: list[tuple[Any, float, float]] = [({"at": (x, y)}, spacing, self.free[index])]
        found += [({"near": key}, max(own, spacing), self.free_part[key]) for key, own in least.items()]
        for where, size, free in found:
            distance = self.distance(Refinement(**where, spacing=size))
            serving = distance[index] - (ENOUGH * spacing - size) / self.growth
            for within in (0.0, *(size * WIDER**k for k in range(WIDTHS))):
                if serving <= within <= free - (self.largest - size) / self.growth:
                    yield Refinement(**where, spacing=size, within=_rounded(within)), distance


def _rounded(value: float) -> float:
    """Return a ``value`` in six digits, as it stands in the config of the results."""
    return float(f"{value:.6g}")


def _named(keys: Any, name: str) -> list[str]:
    """Return the keys of a part, or of all bodies."""
    return [key for key in keys if key == name or key.startswith(f"{name}.")]


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


def _chosen(demand: _Demand, wanted: np.ndarray) -> tuple[list[Refinement], np.ndarray]:
    """Return places that give the spacings ``wanted`` (n,) as far as possible, and the spacings (n,) with them."""
    chosen, spacing, area = list(_around_moving(demand, wanted)), demand.given, demand.width**2
    for place in chosen:
        spacing = np.minimum(spacing, demand.spacing(place, demand.distance(place)))
    least = dict.fromkeys(demand.fixed, 0.0) | {
        str(each.near): each.spacing for each in chosen if each.near in demand.away
    }
    wanted = np.maximum(wanted, np.minimum(demand.allowed(demand.free), demand.largest))
    while len(chosen) < MOST:
        index = int(np.argmax(spacing / wanted))
        if spacing[index] <= ENOUGH * wanted[index] or wanted[index] > demand.largest / SLIGHT:
            break
        best: tuple[float, float] | None = None
        for place, distance in demand.candidates(index, _rounded(wanted[index]), least):
            after = np.minimum(spacing, demand.spacing(place, distance))
            served = (spacing > ENOUGH * wanted) & (after <= ENOUGH * wanted)
            needed = float((area / wanted**2 - area / spacing**2)[served].sum())
            added = float((area / after**2 - area / spacing**2).sum())
            rank = (needed if added <= WASTE * needed else 0.0, needed / added)
            if served[index] and (best is None or rank > best):
                best, found = rank, (place, after)
        if best is None:
            break
        place, spacing = found
        chosen.append(place)
    return chosen, spacing


def _around_moving(demand: _Demand, wanted: np.ndarray) -> Iterator[Refinement]:
    """Yield one spacing around all walls that move."""
    moving = demand.moving
    near = (
        np.min([np.full(len(wanted), np.inf), *(demand.away[key] for key in moving)], axis=0) <= NEAR * demand.largest
    )
    if not near.any():
        return
    free = min(demand.free_part[key] for key in moving)
    spacing = max(float(np.quantile(wanted[near], SHARE)), float(demand.allowed(free)))
    if spacing > demand.largest / SLIGHT:
        return
    bodies = _named(moving, "bodies")
    together = len(bodies) > 1 and len(bodies) == len(_named(demand.away, "bodies"))
    for key in [*(["bodies"] if together else bodies), *(key for key in moving if key not in bodies)]:
        yield Refinement(near=key, spacing=_rounded(spacing))


def _positions(snapshot: Snapshot) -> np.ndarray:
    """Return the positions (particles, 2)."""
    return np.stack([snapshot.x, snapshot.y], axis=1).astype(float)


def _demand(config: "Config", flow: Any, snapshots: Sequence[Snapshot]) -> _Demand:
    """Return the demand of the particles in ``snapshots`` of the ``flow`` of a ``config``."""
    seen = [flow.seen(each) for each in snapshots]
    parts = [parts_of(each) for each in (flow, *seen)]
    looks = list(zip(parts, [flow.start_time, *(each.t for each in snapshots)], strict=True))
    given = {key: part for key, part in parts[0].items() if not part.free}
    looks += [(given, float(t)) for t in np.linspace(flow.start_time, config.time.end, LOOKS)]
    moving = [key for key, part in parts[0].items() if moves(part) or not part.steady]
    fixed = [key for key in parts[0] if key not in moving]
    ends = [body for body in flow.bodies if not body.solid]
    corners = np.reshape([corner.place for corner in flow.corners], (-1, 2))
    clear = CLEAR_OF_CORNERS * flow.spacing
    positions = [_positions(each) for each in snapshots]
    places = np.concatenate(positions)
    some = slice(None, None, math.ceil(len(places) / MOST_PARTICLES))

    def apart(part: Body, other: Body, time: float) -> float:
        points = other.boundary_points(other.shape.length / PIECES, time).point
        return float(part.nearest(points, time).distance.min())

    def free_part(key: str) -> float:
        part = parts[0][key]
        if ends and moves(part):
            return -math.inf
        found = [apart(part, end, flow.start_time) for end in ends]
        found += [float(each) - clear for each in part.nearest(corners, flow.start_time).distance]
        for other in moving if key in fixed else fixed if moves(part) else ():
            found += [apart(there[key], there[other], time) for there, time in looks if {key, other} <= there.keys()]
        return min(found, default=math.inf)

    free = np.full(len(places), math.inf)
    for there, time in looks:
        for key in there.keys() & moving:
            free = np.minimum(free, there[key].nearest(places, time).distance)
    for end in ends:
        free = np.minimum(free, end.nearest(places, flow.start_time).distance)
    for corner in corners:
        free = np.minimum(free, np.hypot(*(places - corner).T) - clear)
    samples = list(zip(seen, parts[1:], snapshots, positions, strict=True))
    away = {
        key: np.concatenate([there[key].nearest(at, each.t).distance for _, there, each, at in samples])[some]
        for key in parts[0]
    }
    width = np.concatenate([each.widths(flow.spacing) for each in snapshots])
    error = np.concatenate([missed(scene, each) for scene, _, each, _ in samples]) * (flow.spacing / width) ** DEGREE
    spacing = np.concatenate([scene.wanted_spacing.at(at, each.t) for scene, _, each, at in samples])
    return _Demand(
        largest=flow.spacing,
        growth=config.discretisation.growth or GROWTH,
        periods=tuple(size if period else 0.0 for size, period in zip(flow.extent, flow.periodic, strict=True)),
        places=places[some],
        error=error[some],
        width=width[some],
        given=spacing[some],
        away=away,
        free=free[some],
        free_part={key: free_part(key) for key in parts[0]},
        fixed=fixed,
        moving=moving,
    )
