"""What may be wrong with a result, each as the exact flow of a changed scene: one parameter, and what it means.

A fault is something that the data can be asked: which value of its parameter makes the exact flow come closest to
them, and how close? ``flow(scene, value)`` is the exact flow with the fault, a function of (field, x, y, t).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tisph.assessment.units import SIZES
from tisph.geometry.motion import WallMotion

HALF = 0.1
"""Spacings within which a distance is called half a spacing."""

SAME_UNIT = 0.1
"""Relative difference of a factor from that of a unit, within which it is taken for it: the error of the data."""


@dataclass(frozen=True)
class Fault:
    """A fault by ``name`` with a parameter between ``low`` and ``high``, 0 without the fault.

    ``least``: below it the parameter means nothing, any discretisation has such an error. ``guesses`` are where the fit
    starts. ``words(value)`` says what the fitted value means.
    """

    name: str
    flow: Callable
    words: Callable
    low: float
    high: float
    least: float
    guesses: tuple[float, ...]


def faults(scene, times):
    """All faults that can be asked of a ``scene`` at ``times``."""
    found = [_unit(scene.units), _sign()]
    if scene.parallel and not scene.superposes:
        return found
    found += [_viscosity(), _time(scene, times)]
    if scene.parallel:
        found += [*_displaced_walls(scene), *_slip(scene), *_start(scene, times)]
    return found


def _scaled(factor):
    """The flow of velocities that are ``factor(value)`` times those of the config."""
    return lambda scene, value: lambda field, x, y, t: factor(value) * scene.exact(field, x, y, t)


def _unit(units):
    """Velocities in another unit; the parameter is the logarithm of their factor, to the base 10."""
    sizes = SIZES["length"]

    def words(value):
        factor = 10.0**value
        own = sizes.get(units.length, np.nan)
        names = [name for name, size in sizes.items() if abs(factor * size / own - 1) < SAME_UNIT]
        hint = f": they are in {names[0]}/{units.time}, --unit velocity={names[0]}/{units.time}" if names else ""
        return f"the velocities are {factor:.4g} times those of the config{hint}"

    return Fault("unit", _scaled(lambda value: 10.0**value), words, -8.0, 8.0, 0.5, (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0))


def _sign():
    """Velocities of the wrong sign; 1 + the parameter is their factor."""

    def words(value):
        return f"the velocities have the wrong sign: they are {1 + value:.4g} times those of the config"

    return Fault("sign", _scaled(lambda value: 1 + value), words, -2.5, -1.5, 1.5, (-2.0,))


def _viscosity():
    def flow(scene, value):
        return replace(scene, kinematic_viscosity=scene.kinematic_viscosity * np.exp(value)).exact

    def words(value):
        return f"the viscosity is {np.exp(value):.4g} times that of the config"

    return Fault("viscosity", flow, words, np.log(0.02), np.log(50.0), 0.005, (-0.7, 0.01, 0.7))


def _time(scene, times):
    earliest, latest = min(times), max(times)

    def flow(scene, value):
        return lambda field, x, y, t: scene.exact(field, x, y, t + value)

    def words(value):
        way = "later" if value > 0 else "earlier"
        return f"the clock is off: the data are of {abs(value):.4g} {scene.units.time} {way} than stated"

    low = scene.start_time - earliest if scene.start_time else -0.99 * earliest
    return Fault("time", flow, words, min(low, -1e-9), 5 * latest, 0.005 * latest, (0.5 * low, 0.01 * latest, latest))


def _displaced_walls(scene):
    limit = 0.2 * scene.gap / scene.spacing
    sides = {
        "walls": ((1, 1), "both walls act"),
        "bottom_wall": ((1, 0), "the bottom wall acts"),
        "top_wall": ((0, 1), "the top wall acts"),
        "shift": ((-1, 1), "all heights are off: the channel lies"),
    }
    return [_displaced(scene, name, *side, limit) for name, side in sides.items()]


def _displaced(scene, name, outward, subject, limit):
    """Walls displaced by ``outward`` times the parameter, in spacings."""

    def flow(scene, value):
        below, above = (side * value * scene.spacing for side in outward)
        wider = replace(scene, gap=scene.gap + below + above)
        return lambda field, x, y, t: wider.exact(field, x, np.clip(y + below, 0.0, wider.gap), t)

    def words(value):
        size = "half a spacing" if abs(abs(value) - 0.5) < HALF else f"{abs(value):.3g} spacings"
        fitted = f"{abs(value):.3g} spacings, {abs(value) * scene.spacing:.4g} {scene.units.length}"
        if name == "shift":
            return f"{subject} {size} too {'high' if value > 0 else 'low'} in the data ({fitted})"
        if value < 0:
            return f"{subject} {size} inside the fluid ({fitted})"
        return f"{subject} {size} outside the fluid ({fitted}), or the fluid slips there with that slip length"

    return Fault(name, flow, words, -limit, limit, 0.1, (-0.5, 0.5))


def _slip(scene):
    """The fluid at moving walls is slower than they are by a part of their velocity."""
    if not any(wall.largest_speed for _, wall in scene.walls):
        return

    def flow(scene, value):
        return replace(scene, bottom=scene.bottom.scaled(1 - value), top=scene.top.scaled(1 - value)).exact

    def words(value):
        if value < 0:
            return f"the walls move {-100 * value:.3g} % faster than the config says"
        return f"the fluid slips: at a moving wall it has {100 * (1 - value):.4g} % of the wall's velocity"

    yield Fault("slip", flow, words, -1.0, 1.0, 0.002, (0.01, 0.5))


def _start(scene, times):
    """The start was not at rest, or not the developed flow: superpositions, so of fluids with linear laws only."""
    other = replace(scene, initial_state="rest" if scene.starts_developed else "developed", start_time=0.0)
    stops = any(wall.before is not None for _, wall in scene.walls)
    swings = scene.polymer and any(wall.oscillates for _, wall in scene.walls)
    scheduled = any(wall.jump_times for _, wall in scene.walls)  # nothing has developed before
    if stops or swings or scheduled or scene.start_time:
        return

    def mixed(scene, value):
        return lambda field, x, y, t: (1 - value) * scene.exact(field, x, y, t) + value * other.exact(field, x, y, t)

    def words(value):
        if scene.starts_developed:
            return f"the start was not the developed flow, but {100 * (1 - value):.4g} % of it"
        return f"the start was not at rest, but with {100 * value:.4g} % of the developed flow"

    yield Fault("start", mixed, words, -1.5, 1.5, 0.002, (0.1,))
    if not scene.starts_developed and not scene.polymer:
        yield _uniform_start(scene)


def _uniform_start(scene):
    dragged = replace(scene, top=WallMotion(1.0), bottom=WallMotion(1.0), acceleration=0.0)
    speed = scene.reference_velocity

    def flow(scene, value):
        # the remainder of a uniform velocity: the flow in a frame in which both walls start
        return lambda field, x, y, t: scene.exact(field, x, y, t) + value * speed * (1 - dragged.exact(field, x, y, t))

    def words(value):
        return (
            f"the start was not at rest, but with a uniform velocity of {value * speed:.4g} ({100 * value:.4g} % of U)"
        )

    return Fault("uniform_start", flow, words, -2.0, 2.0, 0.002, (0.1,))
