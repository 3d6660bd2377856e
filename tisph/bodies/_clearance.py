"""Checks that bodies are large enough for particles around them, and far enough apart."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from tisph.config.base import Problem
from tisph.geometry.body import Body, gap, smallest_gap
from tisph.geometry.wanted_spacing import WantedSpacing

LEAST_GAP = 2.0
"""Smallest gap between walls, in particle spacings."""

ROUNDING = 1e-5
"""Part of a gap that is round-off: a gap is correct to 1e-6 of the walls (``geometry/body.py``)."""

LEAST_RADIUS, LEAST_HOLLOW, LEAST_WIDTH = 2.0, 1.0, 5.0
"""Least radius of convex corners and bends, and of concave ones, and least width of bodies, in particle spacings.

Runs with circles of 2 spacings fail at the first step, with corners of 1 or sharp concave ones soon after it.
The support of wall points is 4.5 spacings, and reaches through a thinner body.
"""

BULGES = {
    "radius": ("radius", "a circle"),
    "half_axes": ("half_axes", "an end"),
    "corners": ("corner_radius", "a corner"),
    "points": ("points", "a bend"),
    "outline": ("outline", "a bend"),
}
"""Key that defines a body's shape -> (key of its smallest radius, name of the part that has this radius)."""

Walls = dict[str, Body]
"""The other walls by their names in messages."""


def problems(
    bodies: Sequence[Body], walls: Walls, wanted: WantedSpacing, times: Iterable[float] = (0.0,)
) -> Iterator[Problem]:
    """Yield the gaps of ``bodies`` that are too small, at the first of the ``times`` at which there are any.

    Of bodies that enter later only those are compared which enter at the same time.
    """
    for time in times:
        found = list(_too_close(bodies, walls, wanted, time))
        if found:
            yield from found
            return


def size_problems(shapes: Iterable[tuple[str, Any, Body]], wanted: WantedSpacing, across: float) -> Iterator[Problem]:
    """Yield bodies and walls that are too small; ``shapes`` are triples of key, parameters of the shape and ``Body``.

    ``across`` is the length of ``particles_across`` spacings, the largest that are ``wanted``.
    """
    for key, parameters, body in shapes:
        spacing = wanted.along(body)
        own = spacing < wanted.largest
        found = _too_small(parameters.shaped_by, body.shape, spacing, across, own)
        if found:
            yield f"{key}.{found[0]}", found[1]


def _too_small(shaped_by: str, shape: Any, spacing: float, across: float, own: bool) -> tuple[str, str] | None:
    """Return the key of the part of ``shape`` that is too small, and the reason; None where all is large enough.

    ``own``: whether its ``spacing`` is smaller than that of the flow.
    """
    radius_key, what = BULGES[shaped_by]
    convex = 0.5 * LEAST_WIDTH if what == "a circle" else LEAST_RADIUS
    for radius, least in ((shape.convex_radius, convex), (shape.smallest_radius, LEAST_HOLLOW)):
        if radius < least * spacing * (1 - 1e-9):
            larger = math.ceil(1e4 * least * spacing / across) * across / 1e4
            enough = [f"corner_radius: {larger:.6g}"] if what == "a corner" else []
            enough += [_finer(radius / least, across, own)] if radius else []
            return radius_key, _too_few(f"{what} of radius {radius:.4g}", radius / spacing, least, enough)
    width = _width(shape)
    if width < LEAST_WIDTH * spacing * (1 - 1e-3):
        enough = [_finer(width / LEAST_WIDTH, across, own)]
        return shaped_by, _too_few(f"a body {width:.4g} wide", width / spacing, LEAST_WIDTH, enough)
    return None


def _width(shape: Any) -> float:
    """Return the smallest distance of two parallel lines around a body; infinity for a wall, without an inside."""
    if shape.fluid_side == "inside" or not shape.area:
        return math.inf
    angle = np.pi / 180 * np.arange(180)
    along = shape.boundary_points(shape.length / 1000).point @ np.stack([np.cos(angle), np.sin(angle)])
    return float(np.ptp(along, axis=0).min())


def _finer(spacing: float, across: float, own: bool) -> str:
    """Return the words for a ``spacing`` that is small enough: of a body or wall with its ``own``, or of the flow."""
    if own:
        return f"a spacing of {0.9995 * spacing:.4g} there"
    return f"particles_across: {math.ceil(across / spacing - 1e-9)}"


def _too_few(what: str, spacings: float, least: float, enough: list[str]) -> str:
    return f"{what} has {spacings:.3g} spacings; it needs at least {least:g}: {' or '.join(enough)}"


def _too_close(bodies: Sequence[Body], walls: Walls, wanted: WantedSpacing, time: float) -> Iterator[Problem]:
    """Yield all gaps to ``walls`` and the smallest gap among ``bodies`` that are too small at ``time``."""
    spacings = [wanted.along(body) for body in bodies]
    of_walls = {name: wanted.along(wall) for name, wall in walls.items()}
    short = 1.0 - ROUNDING
    for i, body in enumerate(bodies):
        for name, wall in walls.items():
            apart, spacing = gap(body, wall, time), min(spacings[i], of_walls[name])
            if apart < LEAST_GAP * spacing * short:
                spacing = min(spacing, wanted.between(body, wall, time))
            if apart < LEAST_GAP * spacing * short:
                yield f"bodies.{i}.centre", _words(apart, name, spacing, time)
    for enters in sorted({body.enters for body in bodies}):
        together = [index for index, body in enumerate(bodies) if body.enters == enters]
        apart, pair = smallest_gap([bodies[index] for index in together], time)
        if pair is None:
            continue
        i, j = (together[index] for index in pair)
        spacing = min(spacings[i], spacings[j])
        if apart < LEAST_GAP * spacing * short:
            spacing = min(spacing, wanted.between(bodies[i], bodies[j], time))
        if apart >= LEAST_GAP * spacing * short:
            continue
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
