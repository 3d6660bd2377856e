"""Which fault explains an error: each is fitted to the data, and named only if hardly any error remains.

Faults that explain it equally well cannot be told apart by these data, and are all named: more times may tell.
"""

from dataclasses import dataclass

import numpy as np

from tisph.assessment.error_location import TOO_SMALL
from tisph.assessment.faults import Fault, faults
from tisph.measures.metrics import root_mean_square, velocities

EXPLAINS = 0.3
"""A fault explains an error of which no more than that part remains with it: a tenth of its square."""

EQUAL, EQUAL_UNIT = 1.05, 2**0.5
"""Faults are told apart where one leaves that many times as much as the best; a unit where its factor, in place of the
best one, makes as much error as remains anyway."""

LEFT = 0.1
"""Part of the size of the velocities that may remain: more is no error of a discretisation, but another fault."""

STEPS, HALVINGS = 30, 10
"""Steps of a fit, and halvings of one that does not lower the error."""

AT_AN_END = 1e-3
"""Part of the range of a parameter next to its ends, where a fit has run against them."""

MOST_POINTS = 300
"""Points of a sample that a fit looks at, evenly chosen."""


@dataclass(frozen=True)
class Finding:
    """A fault with its fitted parameter ``value`` and the root mean square error over U that would ``remain``."""

    fault: Fault
    value: float
    remain: float

    @property
    def significant(self):
        """Whether the parameter is larger than that of any discretisation, and not as large as it may be."""
        fault = self.fault
        if fault.choices or not np.isfinite(fault.high - fault.low):
            return abs(self.value) >= fault.least
        at_an_end = min(self.value - fault.low, fault.high - self.value) < AT_AN_END * (fault.high - fault.low)
        return abs(self.value) >= fault.least and not at_an_end

    @property
    def words(self):
        """What it says."""
        return self.fault.words(self.value)


@dataclass(frozen=True)
class Diagnosis:
    """The ``error`` of the data, root mean square over U, the faults that explain it, best first, and all fits."""

    error: float
    explaining: list[Finding]
    fits: list[Finding]


def diagnose(aligned):
    """``Diagnosis`` of samples of one run, ``Aligned`` each; their faults are fitted to all of them at once."""
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
    if any(each.fault.name in ("unit", "sign") for each in explaining):  # which say more than their factor
        explaining = [each for each in explaining if each.fault.name != "factor"]
    explaining.sort(key=lambda each: each.fault.name != "factor")  # the plainest of those that cannot be told apart
    return Diagnosis(error, explaining, fits)


def _chosen(scene, snapshot):
    """Return positions and time (x, y, t), velocities and exact ones (fields, points) of some points of a sample."""
    values, exact = velocities(scene, snapshot)
    order = np.argsort(snapshot.y, kind="stable")
    index = order[np.unique(np.linspace(0, len(order) - 1, min(len(order), MOST_POINTS)).round().astype(int))]
    low, high = scene.origin[1], scene.origin[1] + scene.extent[1]
    at = snapshot.x[index], np.clip(snapshot.y, low, high)[index], snapshot.t
    return at, values[:, index], exact[:, index]


def _fitted(fault, scene, samples):
    """``Finding`` with the parameter that leaves the smallest error, from the best of the guesses."""
    names = [name for name in ("u", "v", "w") if name in scene.fields]

    def residuals(value):
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


def _nearest_minimum(residuals, value, fault):
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
