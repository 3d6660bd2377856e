"""Which fault explains an error: each is fitted to the data, and named only if hardly any error remains.

Faults that explain it equally well cannot be told apart by these data, and are all named: more times may tell.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from tisph.assessment.error_location import TOO_SMALL
from tisph.assessment.faults import Fault, faults
from tisph.measures.metrics import root_mean_square, velocities

EXPLAINS = 0.3
"""A fault explains an error of which no more than that part remains with it: a tenth of its square."""

EQUAL, ROUGH = 1.5, 0.01
"""Faults are told apart where one leaves that many times as much as the best, and that part of the error besides."""

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
    fits = [_fitted(fault, scene, samples) for fault in faults(scene, times)]
    fits.sort(key=lambda each: each.remain)
    explaining = [each for each in fits if each.remain <= EXPLAINS * error and each.significant]
    if explaining:
        most = EQUAL * explaining[0].remain + ROUGH * error
        explaining = [each for each in explaining if each.remain <= most]
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
    names = [name for name in ("u", "v") if name in scene.fields]

    def residuals(parameter):
        exact = fault.flow(scene, float(parameter[0]))
        parts = [
            u - np.array([np.broadcast_to(exact(name, *at), at[1].shape) for name in names]) for at, u, _ in samples
        ]
        return np.nan_to_num(np.concatenate([part.ravel() for part in parts]) / scene.reference_velocity, nan=1e3)

    guesses = [guess for guess in fault.guesses if fault.low < guess < fault.high]
    starts = sorted(guesses, key=lambda guess: np.sum(np.square(residuals([guess]))))[:2]
    fits = [
        least_squares(residuals, [start], bounds=([fault.low], [fault.high]), x_scale=max(abs(start), 1e-3))
        for start in starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    return Finding(fault, float(best.x[0]), root_mean_square(best.fun))
