"""Temperature and dissolved substances of a scene: from the keys of a config to ``measures/substance.py``; errors."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph import registry
from tisph.config.base import Problem
from tisph.config.fields import nearest
from tisph.config.heat import LARGEST_EXPONENT, Carried, Flux, Temperature
from tisph.formula import FieldFormula
from tisph.measures.flow import FAINT
from tisph.measures.heat import walls_of
from tisph.measures.substance import TEMPERATURE, Condition, Substance
from tisph.scenes._spacing import key_of
from tisph.scenes._views import COLOURS

if TYPE_CHECKING:
    from tisph.config.schema import Config

INSULATED = Condition(flux=FieldFormula(0.0))

PLACES = 41
"""Places along each side of the box at which the size of initial values and conditions is found."""

BUOYANT = 125.0
"""Buoyancy B drives slow flow at B L^2/(72 sqrt(3) nu) between a hot and a cold wall: the number in B L^2/(125 nu)."""


def carried(config: "Config") -> dict[str, Carried]:
    """Return the sections of a config that describe substances, by their dotted keys; the temperature first."""
    found: dict[str, Carried] = {TEMPERATURE: config.temperature} if config.temperature else {}
    return found | {f"scalars.{index}": scalar for index, scalar in enumerate(config.scalars)}


def condition_keys(flow: Any) -> list[tuple[str, str]]:
    """Return pairs (section, name or number) of the conditions of each wall and body of a flow, in its order."""
    if flow.parallel:
        return [("walls", "bottom"), ("walls", "top")]
    names = [key_of(name) for name in getattr(flow, "names", ())] + [""] * len(flow.bodies)
    pairs = [("bodies.0" if name == "sphere" else name).partition(".") for name in names[: len(flow.bodies)]]
    return [(section, name) for section, _, name in pairs]


def _conditions(section: Carried, flow: Any) -> Iterator[Condition]:
    """Yield the condition at each wall and body of a flow."""
    for place, name in condition_keys(flow):
        given: Any = section.walls.get(name) if place == "walls" else None
        if place == "walls" and given is None:  # all sides of a closed wall have one name
            given = section.walls.get(name.rpartition("_")[0])
        if place == "bodies" and section.bodies:
            given = section.bodies[int(name) if len(section.bodies) > 1 else 0]
        if isinstance(given, Flux):
            yield Condition(flux=FieldFormula(given.flux))
        else:
            yield INSULATED if given is None else Condition(value=FieldFormula(given))


def _samples(flow: Any, found: Substance, end: float) -> Iterator[tuple[str, np.ndarray]]:
    """Yield keys below a section, and values of their formulas at places in the fluid and on walls, at three times."""
    low, size, start = np.array(flow.origin), np.array(flow.extent), flow.start_time
    x, y = (low[axis] + size[axis] * np.linspace(0.0, 1.0, PLACES) for axis in (0, 1))
    places = np.stack([each.ravel() for each in np.meshgrid(x, y)], axis=1)
    x, y = places[flow.region.distance(places) >= 0.0].T
    yield "initial", found.initial(x, y, start)
    times = (start, 0.5 * (start + end), end)
    yield "source", np.stack([found.source(x, y, t) for t in times])
    keys, walls = condition_keys(flow), walls_of(flow, found, start)
    for wall in walls:
        formula: Any = wall.condition.value or wall.condition.flux
        yield ".".join(keys[wall.number]), np.stack([formula(*wall.points.T, t) for t in times])
    if flow.flows_through:
        yield "inlet", np.stack([found.inlet(x, y, t) for t in times])


def _size(flow: Any, found: Substance, end: float) -> float:
    """Return the range of initial values and conditions; fluxes and viscous heating add differences of their own."""
    samples, length = dict(_samples(flow, found, end)), flow.reference_length
    keys, rate = condition_keys(flow), float(np.abs(samples.pop("source")).max())
    fluxes = [".".join(key) for key, each in zip(keys, found.conditions, strict=True) if each.flux]
    per_length = [float(np.abs(samples.pop(key)).max()) for key in fluxes if key in samples]
    more = [length * each / (found.capacity * found.diffusivity) for each in per_length]
    more.append(found.heating * flow.kinematic_viscosity * flow.velocity_scale**2 / found.diffusivity)
    more.append(rate * min(end - flow.start_time, length**2 / found.diffusivity))
    values = np.concatenate([each.ravel() for each in samples.values()])
    return max(float(np.ptp(values)), *more)


def _substance(config: "Config", section: Any, flow: Any) -> Substance:
    """Return the substance that a ``section`` of a config describes."""
    effects: dict[str, Any] = {}
    name, unit, capacity = getattr(section, "name", TEMPERATURE), "", 1.0
    if isinstance(section, Temperature):
        capacity, unit = flow.density * section.heat_capacity, section.unit
        effects = {"reference": section.reference, "expansion": section.expansion, "law": section.viscosity}
        effects["heating"] = 1.0 / section.heat_capacity if section.viscous_heating else 0.0
        effects["gravity"] = section.gravity or (0.0, 0.0)
    diffusivity = section.conductivity / capacity if isinstance(section, Temperature) else section.diffusivity
    inlet = section.initial if section.inlet is None else section.inlet
    effects |= {"initial": FieldFormula(section.initial), "source": FieldFormula(section.source)}
    return Substance(
        name=name,
        unit=unit,
        diffusivity=diffusivity,
        capacity=capacity,
        inlet=FieldFormula(inlet),
        conditions=tuple(_conditions(section, flow)),
        scale=1.0,
        **effects,
    )


def _jumps(flow: Any, each: Substance) -> Iterator[int]:
    """Yield the numbers of the walls at which a given value differs from the initial one."""
    for wall in walls_of(flow, each, flow.start_time):
        given, (x, y) = wall.given(flow.start_time), wall.points.T
        if len(given) and np.abs(given - each.initial(x, y, flow.start_time)).max() > FAINT * each.scale:
            yield wall.number


def with_substances(flow: Any, config: "Config") -> Any:
    """Return a ``flow`` made from a ``config`` with its temperature and dissolved substances.

    Where nothing else moves the fluid, its reference velocity is an estimate of the buoyant one, or else diffusivity
    over length, the speed of conduction.
    """
    sections = carried(config)
    if not sections:
        return flow
    found = tuple(_substance(config, section, flow) for section in sections.values())
    found = tuple(replace(each, scale=_size(flow, each, config.time.end) or 1.0) for each in found)
    changes: dict[str, Any] = {"substances": tuple(replace(each, jumps=tuple(_jumps(flow, each))) for each in found)}
    if not (flow.given_velocity or flow.velocity_scale):
        length = flow.reference_length
        drive = max(float(np.hypot(*each.buoyancy)) * each.scale for each in found)
        buoyant = min(math.sqrt(drive * length), drive * length**2 / (BUOYANT * flow.kinematic_viscosity))
        changes["given_velocity"] = buoyant or max(each.diffusivity for each in found) / length
    return replace(flow, **changes)


def substance_problems(config: "Config") -> Iterator[Problem]:
    """Yield the errors in the temperature and the dissolved substances of a ``config``."""
    sections = carried(config)
    if not sections:
        return
    names = [scalar.name for scalar in config.scalars]
    for index, name in enumerate(names):
        if name in names[:index] or name in (*TAKEN, *COLOURS):
            yield f"scalars.{index}.name", f"must differ from other names of results; {name} is one"
            return
    if not any(config.problems()):
        flow = registry.load("scenes", config.scene).Scene.from_config(config)
        for key, section in sections.items():
            wrong = list(_condition_problems(key, section, flow))
            yield from wrong
            for name, values in () if wrong else _samples(flow, _substance(config, section, flow), config.time.end):
                if not np.isfinite(values).all():
                    yield f"{key}.{name.partition('.')[0]}", "must be finite at all places and times of the flow"
    if config.temperature:
        yield from _temperature_problems(config, config.temperature)


TAKEN = ("temperature", "x", "y", "u", "v", "w", "t", "step", "area", "density", "pressure", "passages", "bodies")
"""Names that a dissolved substance must not have, as files have them for other fields."""


def _condition_problems(key: str, section: Carried, flow: Any) -> Iterator[Problem]:
    """Yield errors of conditions at walls and bodies that the ``flow`` does not have."""
    keys = condition_keys(flow)
    solid = [body.solid for body in flow.bodies] or len(keys) * [True]
    walls = [name for (place, name), wall in zip(keys, solid, strict=True) if place == "walls" and wall]
    known = {*walls, *(name.rpartition("_")[0] for name in walls)} - {""}
    for name in section.walls:
        if name not in known:
            words = f"must be one of {', '.join(walls)}{nearest(name, known)}" if walls else "must be left out: none"
            yield f"{key}.walls", f"{words}; {name} is no wall of this flow"
    count = sum(place == "bodies" for place, _ in keys)
    if len(section.bodies) not in ({0, 1, count} if count else {0}):
        text = f"must be one condition for all bodies, or one for each of {count}" if count else "must be left out"
        yield f"{key}.bodies", f"{text}: there {'is' if count == 1 else 'are'} {count or 'no'} bodies"
    if section.inlet is not None and not flow.flows_through:
        yield f"{key}.inlet", "is the value of fluid that enters, and none does: leave it out"


def _temperature_problems(config: "Config", section: Temperature) -> Iterator[Problem]:
    """Yield errors of the effects of the temperature on the flow."""
    if bool(section.expansion) != bool(section.gravity and any(section.gravity)):
        yield "temperature.expansion", "and gravity do nothing without each other: give both, or none"
    own = getattr(getattr(config, "drive", None), "gravity", None)
    if own and section.gravity and own != section.gravity:
        yield "temperature.gravity", f"must be that of drive.gravity, {list(own)}"
    if section.viscosity and section.viscosity.type == "arrhenius" and not section.reference > 0.0:
        yield "temperature.reference", "must be above 0, an absolute temperature, with an arrhenius viscosity"
    elif section.viscosity:
        given: Mapping[str, Any] = {"initial": section.initial, "inlet": section.inlet}
        given = {**given, **{f"walls.{name}": value for name, value in section.walls.items()}}
        for name, value in given.items():
            if isinstance(value, int | float):
                with np.errstate(all="ignore"):
                    exponent = float(section.viscosity.exponent(np.float64(value), section.reference))
                if not abs(exponent) <= LARGEST_EXPONENT:
                    text = f"must have a viscosity: the factor of the law is exp({exponent:g}) there"
                    yield f"temperature.{name}", text
    if section.viscosity and not config.parallel and config.fluid.polymer:
        text = "is for fluids without polymer in two-dimensional flow: leave it out, or take a parallel channel"
        yield "temperature.viscosity", text
    held = any(not isinstance(value, Flux) for value in (*section.walls.values(), *section.bodies))
    walls = not all(config.periodic) or getattr(config, "bodies", None)
    if section.viscous_heating and walls and not (held or section.walls or section.bodies or config.flows_through):
        text = "would heat the fluid without end between insulated walls: give a wall a temperature, or a flux"
        yield "temperature.viscous_heating", text
