"""Place of an error, and the faults that explain it.

A fault is the exact flow of a changed scene with one parameter. ``flow(scene, value)`` returns this flow, a function of
(field, x, y, t). The parameter of each fault is fitted to the data, and the fault is named only if hardly any error
remains. Faults that explain the error equally well cannot be distinguished by these data, and are all named; data of
more times may distinguish them.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.assessment.alignment import Aligned
from tisph.assessment.columns import SIZES
from tisph.geometry.motion import WallMotion
from tisph.measures.metrics import root_mean_square, velocities
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot

Flow = Callable[..., np.ndarray]
"""Velocities of an exact flow: a function of (field, x, y, t)."""

HALF = 0.1
"""Largest difference [spacings] of a distance from 1/2 that is called half a spacing."""

EXPONENT = 38.5
"""exp(-EXPONENT) is below the round-off of 1."""

FEWEST_SINES, MOST_SINES = 1000, 4000
"""Terms of the series: at least for a polymer, whose terms fall with the third power of n; at most at early times."""


@dataclass(frozen=True)
class Fault:
    """A fault ``name`` with a parameter between ``low`` and ``high``, which is 0 without the fault.

    ``least``: smaller values mean nothing, since every discretisation has such an error. ``guesses``: starts of the
    fit, not needed if the velocities are ``linear`` in the parameter. ``choices``: the only values of the parameter, if
    given. ``words(value)`` returns the fault in words.
    """

    name: str
    flow: Callable[[Any, float], Flow]
    words: Callable[[float], str]
    low: float = -np.inf
    high: float = np.inf
    least: float = 0.0
    guesses: tuple[float, ...] = ()
    linear: bool = False
    choices: tuple[float, ...] = ()


def faults(scene: Scene, times: Sequence[float]) -> list[Fault]:
    """Return all faults that apply to a ``scene`` at ``times``; a factor of the velocities comes first."""
    found = [*_factors(scene.units), *_origin(scene)]
    if isinstance(scene, Channel) and not scene.superposes:
        return found
    found += [_time(scene, times), *_viscosity(scene)]
    if isinstance(scene, Channel):
        found += [*_drive(scene), *_displaced_walls(scene), *_slip(scene), *_start(scene, times)]
    return found


def exact(scene: Scene) -> Flow:
    """Return the exact velocities at one time: a series between walls of constant velocities, else ``scene.exact``.

    The series costs far less than ``scene.exact``.
    """
    if not isinstance(scene, Channel) or not scene.superposes:
        return scene.exact
    if any(wall.oscillates or wall.jump_times for wall in scene.pair):
        return scene.exact
    channel = scene
    return lambda field, x, y, t: _series(channel, np.asarray(y, dtype=float), t)


def _series(scene: Channel, y: np.ndarray, t: float) -> np.ndarray:
    """Return the velocity of a Newtonian or Oldroyd-B fluid between walls of velocities U0, U1, constant after t = 0.

    The developed flow is U0 (1 - y/H) + U1 y/H + g y (H - y)/(2 nu). The velocity differs from it by the sum of
    a_n(t) sin(k y), k = n pi/H; the gradient of the polymer stress differs from its developed value by the sum of
    b_n(t) sin(k y). With the solvent fraction s and x = (a_n, b_n):

        dx/dt = A x,    A = [[-s nu k^2, 1], [-(1 - s) nu k^2 / relaxation_time, -1 / relaxation_time]]
    """
    nu, gap, g, polymer = scene.kinematic_viscosity, scene.gap, scene.acceleration, scene.polymer
    share, relaxation = (polymer.solvent_fraction, polymer.relaxation_time) if polymer else (1.0, scene.viscous_time)
    count = 1 + int(np.sqrt(EXPONENT / (share * nu * t / gap**2)) / np.pi)
    n = np.arange(1, min(max(count, FEWEST_SINES if polymer else 0), MOST_SINES) + 1)
    rate, signs = nu * (np.pi * n / gap) ** 2, (-1.0) ** n
    parts = 2 / (np.pi * n) * np.array([np.ones_like(signs), -signs])  # sines of 1 - y/H and of y/H
    walls = np.array([wall.cosine for wall in scene.pair])
    before = np.array([wall.cosine if wall.before is None else wall.before for wall in scene.pair])
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


def _linear(
    name: str, towards: Callable[[Any], Flow], words: Callable[[float], str], low: float = -np.inf, high: float = np.inf
) -> Fault:
    """Return the fault with the flow (1 - value) * exact flow + value * flow ``towards(scene)``."""

    def flow(scene: Scene, value: float) -> Flow:
        own, other = exact(scene), towards(scene)
        return lambda *at: (1 - value) * own(*at) + value * other(*at)

    return Fault(name, flow, words, low, high, 0.002, linear=True)


def _factors(units: Any) -> Iterator[Fault]:
    """Yield the faults of velocities with a factor: any factor, the wrong sign, or another unit of length."""

    def twice(scene: Scene) -> Flow:
        return lambda *at: 2 * exact(scene)(*at)

    def times(value: float) -> str:
        return f"the velocities are {1 + value:.4g} times those of the config"

    def unit(value: float) -> str:
        return f"{times(value)}: they are in {names[value]}/{units.time}, --unit velocity={names[value]}/{units.time}"

    plain = _linear("factor", twice, times)
    size = SIZES["length"].get(units.length, np.nan)
    names = {size / other - 1: name for name, other in SIZES["length"].items() if abs(np.log10(size / other)) >= 1}
    yield plain
    yield replace(plain, name="sign", words=lambda _: "the velocities have the wrong sign", choices=(-2.0,))
    if names:
        yield replace(plain, name="unit", words=unit, choices=tuple(names))


def _origin(scene: Scene) -> Iterator[Fault]:
    """Yield the fault of vortices in a periodic box with another origin, some quarters of a period away.

    Origins half a period away along both axes are the same.
    """
    if scene.periodic != (True, True):
        return
    quarter, places = 0.25 * scene.reference_length, [(i, j) for j in (0, 1) for i in range(4)]

    def flow(scene: Scene, value: float) -> Flow:
        right, up = quarter * np.array(places[int(value)])
        return lambda field, x, y, t: scene.exact(field, x - right, y - up, t)

    def words(value: float) -> str:
        right, up = quarter * np.array(places[int(value)])
        return f"the vortices have another phase: --origin {right:g},{up:g}, quarters of a period from the one taken"

    yield Fault("origin", flow, words, choices=tuple(range(1, len(places))))


def _drive(scene: Channel) -> Iterator[Fault]:
    """Yield the fault of another body acceleration."""

    def twice(scene: Channel) -> Flow:
        return exact(replace(scene, acceleration=2 * scene.acceleration))

    if scene.acceleration:
        yield _linear("drive", twice, lambda value: f"the drive is {1 + value:.4g} times that of the config")


def _viscosity(scene: Scene) -> Iterator[Fault]:
    """Yield the fault of another viscosity; outside a channel only for Newtonian fluids, whose flow is solved fast."""
    if not (scene.parallel or scene.rheology is None):
        return

    def flow(scene: Scene, value: float) -> Flow:
        return exact(replace(scene, kinematic_viscosity=scene.kinematic_viscosity * np.exp(value)))

    def words(value: float) -> str:
        text = f"the viscosity is {np.exp(value):.4g} times that of the config"
        same = f", or the gap {np.exp(-0.5 * value):.4g} times as wide, with heights scaled by it"
        return text + same * scene.parallel

    far = (-2.5, -1.5, 1.5, 2.5) if scene.parallel else ()  # where a flow is not solved anew for each
    yield Fault("viscosity", flow, words, np.log(0.02), np.log(50.0), 0.005, (-0.7, 0.01, 0.7, *far))


def _time(scene: Scene, times: Sequence[float]) -> Fault:
    earliest, latest = min(times), max(times)

    def flow(scene: Scene, value: float) -> Flow:
        return lambda field, x, y, t: exact(scene)(field, x, y, t + value)

    def words(value: float) -> str:
        way = "later" if value > 0 else "earlier"
        return f"the clock is off: the data are of {abs(value):.4g} {scene.units.time} {way} than stated"

    low = scene.start_time - earliest if scene.start_time else -0.99 * earliest
    return Fault("time", flow, words, min(low, -1e-9), 5 * latest, 0.005 * latest, (0.5 * low, 0.01 * latest, latest))


def _displaced_walls(scene: Channel) -> list[Fault]:
    limit = 0.2 * scene.gap / scene.spacing
    sides = {
        "walls": ((1, 1), "both walls act"),
        "bottom_wall": ((1, 0), "the bottom wall acts"),
        "top_wall": ((0, 1), "the top wall acts"),
        "shift": ((-1, 1), "all heights are off: the channel lies"),
    }
    return [_displaced(scene, name, *side, limit) for name, side in sides.items()]


def _displaced(scene: Channel, name: str, outward: tuple[int, int], subject: str, limit: float) -> Fault:
    """Return the fault of walls displaced by ``outward`` (bottom, top) times the parameter, in spacings."""

    def flow(scene: Channel, value: float) -> Flow:
        below, above = (side * value * scene.spacing for side in outward)
        wider = replace(scene, gap=scene.gap + below + above)
        return lambda field, x, y, t: exact(wider)(field, x, np.clip(y + below, 0.0, wider.gap), t)

    def words(value: float) -> str:
        size = "half a spacing" if abs(abs(value) - 0.5) < HALF else f"{abs(value):.3g} spacings"
        fitted = f"{abs(value):.3g} spacings, {abs(value) * scene.spacing:.4g} {scene.units.length}"
        if name == "shift":
            return f"{subject} {size} too {'high' if value > 0 else 'low'} in the data ({fitted})"
        if value < 0:
            return f"{subject} {size} inside the fluid ({fitted})"
        return f"{subject} {size} outside the fluid ({fitted}), or the fluid slips there with that slip length"

    return Fault(name, flow, words, -limit, limit, 0.1, (-0.5, 0.5))


def _slip(scene: Channel) -> Iterator[Fault]:
    """Yield the fault of slip: the fluid at a moving wall is slower than the wall by a fraction of its velocity."""

    def at_rest(scene: Channel) -> Flow:
        bottom, top = (wall.scaled(0.0) for wall in scene.pair)
        return exact(replace(scene, bottom=bottom, top=top))

    def words(value: float) -> str:
        if value < 0:
            return f"the walls move {-100 * value:.3g} % faster than the config says"
        return f"the fluid slips: at a moving wall it has {100 * (1 - value):.4g} % of the wall's velocity"

    if any(wall.largest_speed for _, wall in scene.walls):
        yield _linear("slip", at_rest, words, -1.0, 1.0)


def _start(scene: Channel, times: Sequence[float]) -> Iterator[Fault]:
    """Yield the faults of another start, at rest or developed: superpositions, which hold for linear fluids only."""
    stops = any(wall.before is not None for _, wall in scene.walls)
    swings = scene.polymer and any(wall.oscillates for _, wall in scene.walls)
    scheduled = any(wall.jump_times for _, wall in scene.walls)  # nothing has developed before
    if stops or swings or scheduled or scene.start_time:
        return

    def other(scene: Channel) -> Flow:
        return exact(replace(scene, initial_state="rest" if scene.starts_developed else "developed", start_time=0.0))

    def words(value: float) -> str:
        if scene.starts_developed:
            return f"the start was not the developed flow, but {100 * (1 - value):.4g} % of it"
        return f"the start was not at rest, but with {100 * value:.4g} % of the developed flow"

    yield _linear("start", other, words, -1.5, 1.5)
    if not scene.starts_developed and not scene.polymer:
        yield _linear("uniform_start", _dragged, lambda value: _uniform(scene, value), -2.0, 2.0)


def _dragged(scene: Channel) -> Flow:
    """Return the flow from a start with the reference velocity U: the exact flow plus U times (1 - u1).

    u1 is the flow from rest between walls of velocity 1.
    """
    dragged = exact(replace(scene, top=WallMotion(1.0), bottom=WallMotion(1.0), acceleration=0.0))
    return lambda *at: exact(scene)(*at) + scene.reference_velocity * (1 - dragged(*at))


def _uniform(scene: Scene, value: float) -> str:
    speed = value * scene.reference_velocity
    return f"the start was not at rest, but with a uniform velocity of {speed:.4g} ({100 * value:.4g} % of U)"


STANDS_OUT = 2.0
"""The error is in one third of the channel if its root mean square there is this many times the values elsewhere."""

TOO_SMALL = 1e-8
"""Root mean square error over U that needs no explanation: numerical references have an error of this size."""

CHANGES = 1.1
"""An error grows or falls if it changes by more than this factor from the first time to the last."""


def error_location(scene: Scene, snapshot: Snapshot) -> dict[str, Any]:
    """Return the place of the error of one sample, in numbers and in ``words``.

    ``largest``: the place (x, y) of the largest error, ``largest_error`` over U; between plane walls also ``thirds``:
    root mean square errors over U near the bottom wall, in the middle, and near the top wall.
    """
    values, exact = velocities(scene, snapshot)
    size = np.sqrt(np.square(values - exact).sum(axis=0)) / scene.reference_velocity
    index = int(np.argmax(size))
    found = {"largest": [float(snapshot.x[index]), float(snapshot.y[index])], "largest_error": float(size[index])}
    if root_mean_square(size) < TOO_SMALL:
        return {**found, "words": "as small as that of the reference, or round-off"}
    if not isinstance(scene, Channel):
        return {**found, "words": f"largest at ({snapshot.x[index]:.4g}, {snapshot.y[index]:.4g})"}
    thirds = _thirds(snapshot.y / scene.gap, size)
    excess = float((values - exact)[0, index])
    found |= {"thirds": thirds, "words": f"{_side(thirds)}; {_largest(scene, snapshot.y[index], excess)}"}
    return found


def _thirds(height: np.ndarray, size: np.ndarray) -> dict[str, float]:
    part = np.clip((3 * height).astype(int), 0, 2)
    return {
        name: root_mean_square(size[part == index]) if (part == index).any() else 0.0
        for index, name in enumerate(("bottom", "middle", "top"))
    }


def _side(thirds: dict[str, float]) -> str:
    ranked = sorted(thirds, key=lambda name: thirds[name], reverse=True)
    places = {"bottom": "near the bottom wall", "middle": "in the middle", "top": "near the top wall"}
    if thirds[ranked[0]] >= STANDS_OUT * thirds[ranked[1]]:
        return places[ranked[0]]
    if thirds[ranked[1]] >= STANDS_OUT * thirds[ranked[2]]:
        return f"{places[ranked[0]]} and {places[ranked[1]]}"
    return "all across the channel"


def _largest(scene: Channel, y: float, excess: float) -> str:
    below = y < 0.5 * scene.gap
    distance = abs(y if below else scene.gap - y) / scene.spacing
    name = "bottom" if below else "top"
    way = "above" if excess > 0 else "below"
    return f"largest {distance:.3g} spacings from the {name} wall (y = {y:.4g}), where u is {way} the exact one"


def trend(samples: Sequence[tuple[float, float]]) -> str:
    """Return in words how the root mean square error changes in time; empty with one time only.

    ``samples``: pairs (t, rms) in the order of time.
    """
    if len(samples) < 2 or min(rms or 0.0 for _, rms in samples) < TOO_SMALL:
        return ""
    (first, before), (last, after) = samples[0], samples[-1]
    change = after / before
    span = f"from t = {first:g} to {last:g}"
    if change > CHANGES:
        return f"the error grows {span}, by a factor of {change:.3g}"
    if change < 1 / CHANGES:
        return f"the error falls {span}, by a factor of {1 / change:.3g}"
    return f"the error stays as it is {span}"


EXPLAINS = 0.3
"""A fault explains an error if no more than this fraction of it remains: a tenth of its square."""

EQUAL, EQUAL_UNIT = 1.05, 2**0.5
"""Ratio of the remaining errors of a fault and of the best one, above which the two are distinguished. It is larger for
a unit, whose given factor may add as much error as remains with the best factor."""

LEFT = 0.1
"""Largest remaining error over the size of the velocities: a larger one is no error of a discretisation."""

STEPS, HALVINGS = 30, 10
"""Steps of a fit, and halvings of one that does not lower the error."""

AT_AN_END = 1e-3
"""Distance from an end of a parameter's range, over the range, at which the fit has run against this end."""

MOST_POINTS = 300
"""Largest number of points of a sample in a fit, evenly chosen."""


@dataclass(frozen=True)
class Finding:
    """A fault with its fitted parameter ``value`` and the root mean square error over U that would ``remain``."""

    fault: Fault
    value: float
    remain: float

    @property
    def significant(self) -> bool:
        """Whether the parameter is too large for an error of a discretisation, and not at an end of its range."""
        fault = self.fault
        if fault.choices or not np.isfinite(fault.high - fault.low):
            return abs(self.value) >= fault.least
        at_an_end = min(self.value - fault.low, fault.high - self.value) < AT_AN_END * (fault.high - fault.low)
        return abs(self.value) >= fault.least and not at_an_end

    @property
    def words(self) -> str:
        """The fault in words."""
        return self.fault.words(self.value)


@dataclass(frozen=True)
class Diagnosis:
    """The ``error`` of the data, root mean square over U, the faults that explain it, and all fits, best first."""

    error: float
    explaining: list[Finding]
    fits: list[Finding]


def diagnose(aligned: Sequence[Aligned]) -> Diagnosis:
    """Return the ``Diagnosis`` of the samples of one run; each fault is fitted to all of them at once."""
    scene = aligned[0].scene
    samples = [_chosen(each.scene, each.snapshot) for each in aligned]
    errors = np.concatenate([(u - exact).ravel() for _, u, exact in samples])
    error = root_mean_square(errors) / scene.reference_velocity
    if error < TOO_SMALL:
        return Diagnosis(error, [], [])
    times = [each.snapshot.t for each in aligned]
    fits = sorted((_fitted(fault, scene, samples) for fault in faults(scene, times)), key=lambda each: each.remain)
    size = root_mean_square(np.concatenate([u.ravel() for _, u, _ in samples])) / scene.reference_velocity
    most = min(EXPLAINS * error, LEFT * size)
    equal = {each: (EQUAL_UNIT if each.fault.name == "unit" else EQUAL) * fits[0].remain + TOO_SMALL for each in fits}
    explaining = [each for each in fits if each.remain <= min(most, equal[each]) and each.significant]
    if any(each.fault.name in ("unit", "sign") for each in explaining):  # they say more than a factor does
        explaining = [each for each in explaining if each.fault.name != "factor"]
    explaining.sort(key=lambda each: each.fault.name != "factor")  # the simplest explanation first
    return Diagnosis(error, explaining, fits)


def _chosen(scene: Scene, snapshot: Snapshot) -> tuple[tuple, np.ndarray, np.ndarray]:
    """Return positions and time (x, y, t), velocities and exact ones (fields, points) of some points of a sample."""
    values, exact = velocities(scene, snapshot)
    order = np.argsort(snapshot.y, kind="stable")
    index = order[np.unique(np.linspace(0, len(order) - 1, min(len(order), MOST_POINTS)).round().astype(int))]
    low, high = scene.origin[1], scene.origin[1] + scene.extent[1]
    at = snapshot.x[index], np.clip(snapshot.y, low, high)[index], snapshot.t
    return at, values[:, index], exact[:, index]


def _fitted(fault: Fault, scene: Scene, samples: Sequence[Any]) -> Finding:
    """Return the ``Finding`` with the parameter of the smallest error; fits start at the two best guesses."""
    names = [name for name in ("u", "v", "w") if name in scene.fields]

    def residuals(value: float) -> np.ndarray:
        flow = fault.flow(scene, float(value))
        parts = [
            u - np.array([np.broadcast_to(flow(name, *at), at[1].shape) for name in names]) for at, u, _ in samples
        ]
        return np.nan_to_num(np.concatenate([part.ravel() for part in parts]) / scene.reference_velocity, nan=1e3)

    if fault.choices:
        best = min(fault.choices, key=lambda choice: np.sum(np.square(residuals(choice))))
    elif fault.linear:
        none = residuals(0.0)
        slope = residuals(1.0) - none
        size = slope @ slope
        best = float(np.clip(-(slope @ none) / size, fault.low, fault.high)) if size else 0.0
    else:
        guesses = [guess for guess in fault.guesses if fault.low < guess < fault.high]
        starts = sorted(guesses, key=lambda guess: np.sum(np.square(residuals(guess))))[:2]
        best = min((_nearest_minimum(residuals, start, fault) for start in starts), key=lambda found: found[1])[0]
    return Finding(fault, best, root_mean_square(residuals(best)))


def _nearest_minimum(residuals: Callable[[float], np.ndarray], value: float, fault: Fault) -> tuple[float, float]:
    """Return the parameter near ``value`` of the least sum of squares, and the sum: Gauss-Newton, steps halved."""
    now = residuals(value)
    for _ in range(STEPS):
        width = 1e-5 * max(abs(value), 1e-3) * (1 if value < 0.5 * (fault.low + fault.high) else -1)
        slope = (residuals(value + width) - now) / width
        size = slope @ slope
        step = -(slope @ now) / size if size else 0.0
        for halved in range(HALVINGS):
            new = float(np.clip(value + 0.5**halved * step, fault.low, fault.high))
            then = residuals(new)
            if then @ then < now @ now:
                break
        else:
            break
        moved, value, now = abs(new - value), new, then
        if moved < 1e-7 * max(abs(value), 1e-3):
            break
    return value, now @ now
