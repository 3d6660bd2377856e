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

EXPONENT = 38.5
"""exp(-EXPONENT) is below the round-off of 1."""

FEWEST_SINES, MOST_SINES = 1000, 4000
"""Terms of the series for a polymer, whose tail falls with their third power; and for any fluid at early times."""


@dataclass(frozen=True)
class Fault:
    """A fault by ``name`` with a parameter between ``low`` and ``high``, 0 without the fault.

    ``least``: below it the parameter means nothing, any discretisation has such an error. ``guesses`` are where the fit
    starts; none where the velocities are ``linear`` in the parameter. With ``choices`` it has only these values.
    ``words(value)`` says what the fitted value means.
    """

    name: str
    flow: Callable
    words: Callable
    low: float = -np.inf
    high: float = np.inf
    least: float = 0.0
    guesses: tuple[float, ...] = ()
    linear: bool = False
    choices: tuple[float, ...] = ()


def faults(scene, times):
    """All faults that can be asked of a ``scene`` at ``times``: a plain factor first."""
    found = [*_factors(scene.units), *_origin(scene)]
    if scene.parallel and not scene.superposes:
        return found
    found += [_time(scene, times), *_viscosity(scene)]
    if scene.parallel:
        found += [*_drive(scene), *_displaced_walls(scene), *_slip(scene), *_start(scene, times)]
    return found


def exact(scene):
    """``scene.exact`` of the velocities at one time; by a series where that holds, which costs next to nothing."""
    walls = (scene.bottom, scene.top) if scene.parallel and scene.superposes else ()
    if not walls or any(wall.oscillates or wall.jump_times for wall in walls):
        return scene.exact
    return lambda field, x, y, t: _series(scene, np.asarray(y, dtype=float), t)


def _series(scene, y, t):
    """Velocity of a Newtonian or Oldroyd-B fluid between walls whose velocities U0, U1 are constant from t = 0 on.

    The developed flow is U0 (1 - y/H) + U1 y/H + g y (H - y)/(2 nu). The difference from it is the sum of
    a_n(t) sin(k y), k = n pi/H, that of the gradient of the polymer's stress the sum of b_n(t) sin(k y). With the
    solvent fraction s and x = (a_n, b_n):

        dx/dt = A x,    A = [[-s nu k^2, 1], [-(1 - s) nu k^2 / relaxation_time, -1 / relaxation_time]]
    """
    nu, gap, g, polymer = scene.kinematic_viscosity, scene.gap, scene.acceleration, scene.polymer
    share, relaxation = (polymer.solvent_fraction, polymer.relaxation_time) if polymer else (1.0, scene.viscous_time)
    count = 1 + int(np.sqrt(EXPONENT / (share * nu * t / gap**2)) / np.pi)
    n = np.arange(1, min(max(count, FEWEST_SINES if polymer else 0), MOST_SINES) + 1)
    rate, signs = nu * (np.pi * n / gap) ** 2, (-1.0) ** n
    parts = 2 / (np.pi * n) * np.array([np.ones_like(signs), -signs])  # sines of 1 - y/H and of y/H
    walls = np.array([scene.bottom.cosine, scene.top.cosine])
    before = np.array([wall.cosine if wall.before is None else wall.before for wall in (scene.bottom, scene.top)])
    at_rest = not scene.starts_developed
    a = ((0.0 if at_rest else before) - walls) @ parts - at_rest * g * parts.sum(axis=0) / rate
    b = at_rest * (1 - share) * g * parts.sum(axis=0)
    mean = -0.5 * (share * rate + 1 / relaxation)
    root = np.sqrt(mean**2 - rate / relaxation + 0j)
    root = np.where(root == 0, 1e-30, root)
    slow = np.exp(rate / relaxation / (mean - root) * t)  # of the eigenvalue mean + root, without cancellation
    even, odd = 0.5 * (1 + np.exp(-2 * root * t)), -0.5 * np.expm1(-2 * root * t) / root
    amplitude = (slow * (even * a + odd * (b - (share * rate + mean) * a))).real
    developed = walls[0] + (walls[1] - walls[0]) * y / gap + g * y * (gap - y) / (2 * nu)
    heights, index = np.unique(y, return_inverse=True)  # a line across stands in many columns
    return developed + (np.sin(np.pi / gap * heights[:, None] * n) @ amplitude)[index]


def _linear(name, towards, words, low=-np.inf, high=np.inf):
    """Fault of the flow that is 1 - value times the exact one, and value times the flow ``towards(scene)``."""

    def flow(scene, value):
        own, other = exact(scene), towards(scene)
        return lambda *at: (1 - value) * own(*at) + value * other(*at)

    return Fault(name, flow, words, low, high, 0.002, linear=True)


def _factors(units):
    """Velocities that are a factor times those of the config; one of their sign, or of a unit of length, by name."""

    def twice(scene):
        return lambda *at: 2 * exact(scene)(*at)

    def times(value):
        return f"the velocities are {1 + value:.4g} times those of the config"

    def unit(value):
        return f"{times(value)}: they are in {names[value]}/{units.time}, --unit velocity={names[value]}/{units.time}"

    plain = _linear("factor", twice, times)
    size = SIZES["length"].get(units.length, np.nan)
    names = {size / other - 1: name for name, other in SIZES["length"].items() if abs(np.log10(size / other)) >= 1}
    yield plain
    yield replace(plain, name="sign", words=lambda _: "the velocities have the wrong sign", choices=(-2.0,))
    if names:
        yield replace(plain, name="unit", words=unit, choices=tuple(names))


def _origin(scene):
    """Another origin of vortices in a periodic box, quarters of a period away; half a period along both is the same."""
    if scene.periodic != (True, True):
        return
    quarter, places = 0.25 * scene.reference_length, [(i, j) for j in (0, 1) for i in range(4)]

    def flow(scene, value):
        right, up = quarter * np.array(places[int(value)])
        return lambda field, x, y, t: scene.exact(field, x - right, y - up, t)

    def words(value):
        right, up = quarter * np.array(places[int(value)])
        return f"the vortices have another phase: --origin {right:g},{up:g}, quarters of a period from the one taken"

    yield Fault("origin", flow, words, choices=tuple(range(1, len(places))))


def _drive(scene):
    """Another acceleration of the fluid."""

    def twice(scene):
        return exact(replace(scene, acceleration=2 * scene.acceleration))

    if scene.acceleration:
        yield _linear("drive", twice, lambda value: f"the drive is {1 + value:.4g} times that of the config")


def _viscosity(scene):
    """Another viscosity: outside a channel of Newtonian fluids only, whose flows are quickly solved."""
    if not (scene.parallel or scene.rheology is None):
        return

    def flow(scene, value):
        return exact(replace(scene, kinematic_viscosity=scene.kinematic_viscosity * np.exp(value)))

    def words(value):
        text = f"the viscosity is {np.exp(value):.4g} times that of the config"
        same = f", or the gap {np.exp(-0.5 * value):.4g} times as wide, with heights scaled by it"
        return text + same * scene.parallel

    far = (-2.5, -1.5, 1.5, 2.5) if scene.parallel else ()  # where a flow is not solved anew for each
    yield Fault("viscosity", flow, words, np.log(0.02), np.log(50.0), 0.005, (-0.7, 0.01, 0.7, *far))


def _time(scene, times):
    earliest, latest = min(times), max(times)

    def flow(scene, value):
        return lambda field, x, y, t: exact(scene)(field, x, y, t + value)

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
        return lambda field, x, y, t: exact(wider)(field, x, np.clip(y + below, 0.0, wider.gap), t)

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

    def at_rest(scene):
        return exact(replace(scene, bottom=scene.bottom.scaled(0.0), top=scene.top.scaled(0.0)))

    def words(value):
        if value < 0:
            return f"the walls move {-100 * value:.3g} % faster than the config says"
        return f"the fluid slips: at a moving wall it has {100 * (1 - value):.4g} % of the wall's velocity"

    if any(wall.largest_speed for _, wall in scene.walls):
        yield _linear("slip", at_rest, words, -1.0, 1.0)


def _start(scene, times):
    """The start was not at rest, or not the developed flow: superpositions, so of fluids with linear laws only."""
    stops = any(wall.before is not None for _, wall in scene.walls)
    swings = scene.polymer and any(wall.oscillates for _, wall in scene.walls)
    scheduled = any(wall.jump_times for _, wall in scene.walls)  # nothing has developed before
    if stops or swings or scheduled or scene.start_time:
        return

    def other(scene):
        return exact(replace(scene, initial_state="rest" if scene.starts_developed else "developed", start_time=0.0))

    def words(value):
        if scene.starts_developed:
            return f"the start was not the developed flow, but {100 * (1 - value):.4g} % of it"
        return f"the start was not at rest, but with {100 * value:.4g} % of the developed flow"

    yield _linear("start", other, words, -1.5, 1.5)
    if not scene.starts_developed and not scene.polymer:
        yield _linear("uniform_start", _dragged, lambda value: _uniform(scene, value), -2.0, 2.0)


def _dragged(scene):
    """The flow, and the remainder of the reference velocity: that of the frame in which both walls start."""
    dragged = exact(replace(scene, top=WallMotion(1.0), bottom=WallMotion(1.0), acceleration=0.0))
    return lambda *at: exact(scene)(*at) + scene.reference_velocity * (1 - dragged(*at))


def _uniform(scene, value):
    speed = value * scene.reference_velocity
    return f"the start was not at rest, but with a uniform velocity of {speed:.4g} ({100 * value:.4g} % of U)"
