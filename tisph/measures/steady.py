"""Whether a flow has become steady: by its kinetic energy over the last times, or by what its scene follows.

The first is asked at any time of a run: the errors of a cavity's samples wait for it. The second is asked at the end,
of numbers that do not scatter as means over particles do.
"""

import numpy as np

CHANGE = 1e-3
"""Change, over the size of a number, up to which it is the same."""

LAST = 0.1
"""Part of the run over which nothing may have changed."""

SPAN = 5.0
"""Times ``_moment`` that are looked back."""

STEADY = 3e-4
"""Relative change of the kinetic energy in such a time, below which a flow is called steady."""

SCATTER = 6.0
"""Standard errors of the slope, were its values independent, up to which it may be scatter: three, since those that
follow one another are not. Means over particles scatter by 2e-3 in a cavity of 25 x 25, slopes over ``SPAN`` by 2.5e-4,
and every fourth time was called unsteady."""


def steady_since(times, values, sizes):
    """First of the ``times`` (n,) from which on ``values`` (n, numbers) are the last ones; None where that is too late.

    ``sizes`` (numbers,): what changes are taken over.
    """
    if not len(times):
        return None
    off = ~(np.abs(values - values[-1]) <= CHANGE * np.asarray(sizes)).all(axis=1)
    first = np.flatnonzero(off)[-1] + 1 if off.any() else 0
    quiet = first < len(times) and times[first] <= times[-1] - LAST * (times[-1] - times[0])
    return float(times[first]) if quiet else None


def steadiness(scene, t, series, column=0, words="kinetic energy"):
    """Return ``energy_change``, ``steady`` and ``steady_reason`` (None where it is) at time ``t``, by name.

    The first is the relative change of the kinetic energy in a ``_moment``: the slope of a straight line through what
    was followed in the last ``SPAN`` of them. ``series`` is that of ``Scene.diagnostics``; another ``column`` of it
    than the first, the last of the ``words``, has its own name, such as ``torque_change``.
    """
    key = f"{words.split()[-1]}_change"
    step = _moment(scene)
    times, series_values = series[2] if len(series) > 2 else (np.empty(0), np.empty((0, 1)))
    if t < scene.start_time + SPAN * step:
        return _unsteady(key, f"the flow has run for less than {SPAN * step:.3g}")
    recent = (times >= t - SPAN * step) & (times <= t)
    if np.count_nonzero(recent) < 3:
        return _unsteady(key, "the history has too few times")
    when, values = times[recent] / step, series_values[recent, column]
    mean = np.mean(values)
    change = float(abs(np.polyfit(when, values, 1)[0] / mean))
    scatter = np.std(values - np.polyval(np.polyfit(when, values, 2), when)) / abs(mean)
    if not change <= max(STEADY, SCATTER * scatter / (np.std(when) * np.sqrt(len(when)))):
        return _unsteady(key, f"the {words} changes by {change:.1e} in a time of {step:.3g}", change)
    return {key: change, "steady": True, "steady_reason": None}


def _moment(scene):
    """The shorter of the times in which the flow goes the reference length, and a fifth of that of its viscosity."""
    return min(scene.reference_length / scene.reference_velocity, 0.2 * scene.viscous_time)


def _unsteady(key, reason, change=None):
    return {key: change, "steady": False, "steady_reason": reason}
