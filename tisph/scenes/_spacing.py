"""Spacing that varies: from the keys of a config to the sources of ``geometry/wanted_spacing.py``, and its errors.

Particles are closer to one another at walls and bodies with a ``spacing``, and where ``discretisation.refine`` says so.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph import registry
from tisph.config.base import Problem
from tisph.config.fields import nearest
from tisph.config.schema import too_many
from tisph.config.sections import GAPS, LARGEST_GROWTH
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.line import Line
from tisph.geometry.wanted_spacing import GROWTH, InBox, InGaps, NearBody, Source, WantedSpacing

if TYPE_CHECKING:
    from tisph.config.schema import Config
    from tisph.measures.flow import FlowInBox

FINEST = 64
"""Largest ratio of the spacing of the flow to another one."""

CLEAR_OF_CORNERS = 6.0
"""Least distance, in spacings of the flow, between corners at which a lid slides past a wall and a smaller spacing."""

ROUNDING = 1e-9
"""Relative difference of equal spacings."""

PIECES = 1000
"""Pieces of a wall at whose points spacings are compared."""

LATTICE = (np.arange(128) + 0.5) / 128
"""Places over the sides of the box from which the number of particles is estimated."""

EVEN = 1e-3
"""Relative variation of an even spacing along a wall that rotates."""


def parts_of(flow: "FlowInBox") -> dict[str, Body]:
    """Return the bodies and walls of a scene by their dotted keys in the config, without open ends."""
    named = zip(getattr(flow, "names", ()), flow.bodies, strict=False)
    return {key_of(name): body for name, body in named if body.solid}


def key_of(name: str) -> str:
    """Return the dotted key of a part by its ``name`` in results, such as _0, body_0, sphere or _top."""
    own = name.removeprefix("body").removeprefix("_")
    return own if own == "sphere" else f"bodies.{own or 0}" if not own or own.isdigit() else f"walls.{own}"


def sources_of(config: "Config", parts: Mapping[str, Body]) -> list[tuple[str, Source]]:
    """Return pairs (dotted key, source) of a ``config`` whose ``parts`` are bodies and walls by dotted key."""
    found: list[tuple[str, Source]] = [
        (key, NearBody(body, spacing))
        for key, spacing in config.at_walls("spacing").items()
        for body in _named(parts, key)
    ]
    periods: Any = tuple(size if period else 0.0 for size, period in zip(config.extent, config.periodic, strict=True))
    for index, place in enumerate(config.discretisation.places):
        key, how = f"discretisation.refine.{index}", (place.spacing, place.within)
        if place.near == GAPS:
            found.append((key, InGaps(tuple(parts.values()), place.spacing, config.discretisation.growth or GROWTH)))
        elif place.near:
            found += [(key, NearBody(body, *how)) for body in _named(parts, place.near)]
        else:
            corners: Any = place.box or (place.at, place.at)
            found.append((key, InBox(corners[0], corners[1], *how, periods)))
    return found


def _named(parts: Mapping[str, Body], name: str) -> list[Body]:
    """Return the part with this ``name``, or all parts of a suspension or a closed wall."""
    return [body for key, body in parts.items() if key == name or key.startswith((f"{name}.", f"{name}_"))]


def wanted_spacing(config: "Config", parts: Mapping[str, Body]) -> WantedSpacing:
    """Return the spacing that a ``config`` wants at each place; ``parts``: its bodies and walls by dotted key."""
    sources = tuple(source for _, source in sources_of(config, parts))
    return WantedSpacing(config.spacing, sources, config.discretisation.growth or GROWTH)


def with_sources(flow: Any, config: "Config") -> Any:
    """Return a ``flow`` made from a ``config`` with the places where particles are closer to one another."""
    if not config.spacings:
        return flow
    wanted = wanted_spacing(config, parts_of(flow))
    return replace(flow, spacing_sources=wanted.sources, growth=wanted.growth)


def spacing_problems(config: "Config") -> Iterator[Problem]:
    """Yield the errors in the spacings of a ``config``, the first kind of them that there is."""
    largest, least = config.spacing, config.spacing / FINEST
    text = f"must be at most the spacing of the flow, {largest:.6g}, and at least a {FINEST}th of it, {least:.6g}"
    within = least * (1.0 - ROUNDING), largest * (1.0 + ROUNDING)
    wrong: list[Problem] = [
        (key, text) for key, spacing in config.spacings.items() if not within[0] <= spacing <= within[1]
    ]
    yield from wrong
    if wrong or not config.spacings or any(config.problems()):
        return
    flow = registry.load("scenes", config.scene).Scene.from_config(config)
    parts, growth = parts_of(flow), config.discretisation.growth or GROWTH
    sources = sources_of(config, parts)
    if wrong := list(_misplaced(config, flow, parts)):
        yield from wrong
        return
    reach = [(key, source, source.within + (largest - source.spacing) / growth) for key, source in sources]
    keep = flow.flows_through or any(body.slip_length for body in flow.bodies)
    for find in (_at_ends, _at_corners, *([_at_moving_parts] if keep else [])):
        if wrong := list(find(config, flow, parts, reach)):
            yield wrong[0]
            return
    finest = min(config.spacings, key=lambda key: config.spacings[key])
    yield from too_many(config, _about_particles(with_sources(flow, config)), finest)


def _about_particles(flow: Any) -> float:
    """Return the number of particles of a ``flow`` to some per cent, by the spacings at places of a lattice."""
    x, y = np.meshgrid(*(low + size * LATTICE for low, size in zip(flow.origin, flow.extent, strict=True)))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    places = places[flow.region.distance(places) > 0.0]
    return float(math.prod(flow.extent) / x.size * (flow.wanted_spacing.at(places) ** -2.0).sum())


Reach = Sequence[tuple[str, Any, float]]
"""Dotted key of each source, the source, and the distance from it beyond which the spacing is that of the flow."""


def _misplaced(config: "Config", flow: Any, parts: Mapping[str, Body]) -> Iterator[Problem]:
    """Yield errors of places to refine that are no part of the flow."""
    low, high = np.array(flow.origin), np.add(flow.origin, flow.extent)
    for index, place in enumerate(config.discretisation.places):
        key, corners = f"discretisation.refine.{index}", np.array(place.box or (place.at, place.at))
        if place.near is not None:
            if not parts:
                yield f"{key}.near", "must be left out in a flow without bodies and walls: give at, or box"
            elif place.near == GAPS:
                if len(parts) < 2 or place.within:
                    yield f"{key}.near", "must be left out with one body or wall alone, and where within is given"
            elif not _named(parts, place.near):
                yield f"{key}.near", f"must be one of {', '.join(parts)}{nearest(place.near, parts)}"
        elif (corners[0] > corners[1]).any():
            yield f"{key}.box", "must be the lowest corner, and then the highest one"
        elif np.where(flow.periodic, -1.0, np.maximum(low - corners[1], corners[0] - high)).max() >= 0.0:
            where = f"x from {low[0]:.6g} to {high[0]:.6g}, y from {low[1]:.6g} to {high[1]:.6g}"
            yield f"{key}.{'box' if place.box else 'at'}", f"must be in the box of the flow, {where}"


def moves(body: Body) -> bool:
    """Return whether distances from a ``body`` change as it moves."""
    if body.free or isinstance(body.shape, Circle | Line):
        along = np.array([body.motion.x.largest_speed, body.motion.y.largest_speed])
        across = np.abs(body.shape.normal) @ along if isinstance(body.shape, Line) else along.sum()
        return body.free or bool(across)
    return not body.steady


def _at_ends(config: "Config", flow: Any, parts: Mapping[str, Body], reach: Reach) -> Iterator[Problem]:
    """Yield errors of spacings that reach open ends, through which particles pass with the spacing of the flow."""
    for end in (body for body in flow.bodies if not body.solid):
        side = "left" if end.shape.normal[0] > 0.0 else "right"
        places = end.boundary_points(end.shape.length / PIECES).point
        for key, source, far in reach:
            if moves(getattr(source, "body", end)):
                yield f"{key}.spacing", "must be left out at a body that moves between open ends"
            apart = float(source.distance(places, flow.start_time).min())
            if apart < far * (1.0 - ROUNDING):
                text = f"must be that of the flow, {flow.spacing:.6g}, at ends.{side}, {apart:.4g} away"
                yield f"{key}.spacing", f"{text}: {_ways(config, source, apart, far)}"


def _at_corners(config: "Config", flow: Any, parts: Mapping[str, Body], reach: Reach) -> Iterator[Problem]:
    """Yield errors of spacings near corners at which a lid slides past a wall: flow there is known for one spacing."""
    clear = CLEAR_OF_CORNERS * flow.spacing
    for corner in flow.corners:
        for key, source, far in reach:
            apart = float(source.distance(np.array([corner.place]), flow.start_time)[0]) - clear
            if apart < far * (1.0 - ROUNDING):
                x, y = corner.place
                text = f"must be that of the flow, {flow.spacing:.6g}, up to {clear:.4g} from the corner ({x:g}, {y:g})"
                ways = _ways(config, source, apart, far, clear)
                yield f"{key}.spacing", f"{text} under a sharp lid: {ways}; or take walls.lid.profile: regular"


def _at_moving_parts(config: "Config", flow: Any, parts: Mapping[str, Body], reach: Reach) -> Iterator[Problem]:
    """Yield errors of spacings that will vary along a wall: points on walls keep their distances as these move."""
    growth = config.discretisation.growth or GROWTH
    for key, source, _ in reach:
        centre = getattr(source, "body", None)
        for name, part in parts.items():
            changes = moves(part) or (centre is not None and moves(centre))
            if part is centre or not (changes or not part.steady):
                continue
            near_it = [each.spacing for _, each, _ in reach if getattr(each, "body", None) is part]
            own = min([flow.spacing, *near_it])
            points = part.boundary_points(part.shape.length / PIECES).point
            apart = source.distance(points, flow.start_time)
            wanted = np.minimum(source.spacing + growth * np.maximum(apart - source.within, 0.0), own)
            least = float(apart.min())
            if wanted.min() < own * (1.0 - ROUNDING) and (changes or np.ptp(wanted) > EVEN * own):
                far = source.within + (own - source.spacing) / growth
                text = f"reaches {name}, {least:.4g} away, and one of them moves, while points on walls do not come"
                same = f"closer to one another: give {name} the spacing {source.spacing:.6g}, too"
                yield f"{key}.spacing", f"{text} {same}; or {_ways(config, source, least, far)}"


def _ways(config: "Config", source: Any, apart: float, far: float, clear: float = 0.0) -> str:
    """Return ways to keep the spacings at a ``source`` off a place that is ``apart``, and not ``far``, from it.

    ``clear``: distance between this place and one to be named.
    """
    body = getattr(source, "body", None)
    if body is not None and not body.shape.area:
        return "leave it out at this wall"
    growth, ways = config.discretisation.growth or GROWTH, [f"leave {_up(far + clear)} between them"]
    if (room := apart - source.within) > 0.0:
        steep = growth * (far - source.within) / room
        ways += [f"give discretisation.growth {_up(steep)}"] if steep < LARGEST_GROWTH else []
        ways.append(f"give a spacing of {_up(source.spacing + growth * (far - apart))} or more")
    return ", or ".join(ways)


def _up(value: float) -> str:
    """Return a ``value`` in four digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return f"{math.ceil(value / unit * (1.0 - ROUNDING)) * unit:.4g}"
