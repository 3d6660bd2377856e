"""Whether bodies leave enough clearance: no overlap, and no gap that is too narrow for particles."""

from collections.abc import Iterable, Iterator, Sequence

from tisph.config.base import Problem
from tisph.geometry.body import Body
from tisph.geometry.gaps import gap, smallest_gap

LEAST_GAP = 2.0
"""In particle spacings."""

Walls = dict[str, Body]
"""The other walls by what messages call them."""


def problems(
    bodies: Sequence[Body], walls: Walls, spacing: float, times: Iterable[float] = (0.0,)
) -> Iterator[Problem]:
    """What is wrong with the places of ``bodies`` at the first of the ``times`` at which something is."""
    for time in times:
        found = [*_at_walls(bodies, walls, spacing, time), *_among(bodies, spacing, time)]
        if found:
            yield from found
            return


def _at_walls(bodies: Sequence[Body], walls: Walls, spacing: float, time: float) -> Iterator[Problem]:
    for i, body in enumerate(bodies):
        for name, wall in walls.items():
            apart = gap(body, wall, time)
            if apart < LEAST_GAP * spacing:
                yield f"bodies.{i}.centre", _words(apart, name, spacing, time)


def _among(bodies: Sequence[Body], spacing: float, time: float) -> Iterator[Problem]:
    apart, pair = smallest_gap(bodies, time)
    if pair is None or apart >= LEAST_GAP * spacing:
        return
    i, j = pair
    if i == j:
        yield f"bodies.{i}.centre", _words(apart, "its own periodic copy", spacing, time)
    else:
        yield f"bodies.{j}.centre", _words(apart, f"bodies.{i}", spacing, time), f"bodies.{i}.centre"


def _words(apart: float, name: str, spacing: float, time: float) -> str:
    when = f" at time {time:g}" if time else ""
    least = f"leave {LEAST_GAP:g} spacings, {LEAST_GAP * spacing:.4g}"
    if apart <= 0:
        return f"overlaps {name}{when}, by {-apart:.4g}: {least}"
    return f"comes within {apart:.4g} of {name}{when}: {least}, or take a spacing of at most {apart / LEAST_GAP:.4g}"
