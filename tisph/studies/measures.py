"""Measures of whole runs that a suite names in its checks: numbers that need more than arithmetic.

A measure is a function of the ``Result`` of one or more runs, whose last sample exists, and of keyword parameters.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from tisph import scenes
from tisph.measures.channel import integral
from tisph.measures.fits import interpolated
from tisph.measures.metrics import relative_difference
from tisph.results import open_run
from tisph.studies import heat
from tisph.studies.expressions import Number
from tisph.studies.processes import Result

NODES = 32
"""Nodes of the angular momentum, along the axis and (Gauss-Legendre) across: twice as many change it by 1e-6."""


def resolved_samples(result: Result) -> int:
    """Return the number of samples whose flow is resolved."""
    return sum(sample["resolved"] for sample in result.summary["samples"])


def largest(result: Result, *, number: str, off: ArrayLike = 0.0) -> float:
    """Return the largest absolute value over all samples of a number, less ``off`` (one value, or one a sample)."""
    return float(np.abs(_series(result, number) - off).max())


def largest_velocity(result: Result, *, off: float, scale: float) -> float:
    """Return the largest velocity of fluid and bodies at the last sample, less ``off`` along x, over ``scale``.

    The angular velocities of the bodies count as velocities of points at a distance of 1.
    """
    arrays = result.arrays()
    last = max(key.partition("/")[0] for key in arrays)
    fluid = [arrays[f"{last}/u"] - off, arrays[f"{last}/v"]]
    bodies = [result.bodies("velocity")[-1] - [off, 0.0], result.bodies("angular_velocity")[-1]]
    return max(np.abs(each).max() for each in (*fluid, *bodies)) / scale


def particles_off(result: Result, *, number: str, expected: Sequence[float | None]) -> float:
    """Return the largest relative difference of a mean over the particles from its ``expected`` values at the samples.

    ``number``: an expression of fields of a sample, such as stress_xx - stress_yy; each field is averaged. Samples
    without an expected value (null) are not judged.
    """
    return float(np.nanmax(np.abs(_means(result, number) / np.array(expected, dtype=float) - 1.0)))


def mean_of_particles(result: Result, *, number: str) -> float:
    """Return the mean over the particles of a ``number`` (see ``particles_off``) at all samples."""
    return float(_means(result, number).mean())


def modulus_off(result: Result, *, number: str, amplitude: float, expected: Sequence[float]) -> float:
    """Return the largest difference of G' and G'' of a ``number`` (see ``particles_off``) from ``expected``, over G''.

    number = amplitude (G' sin t + G'' cos t) + higher odd harmonics; samples are evenly spaced over half a period.
    """
    t, values = _series(result, "t"), _means(result, number)
    found = [2.0 * np.mean(values * wave(t)) / amplitude for wave in (np.sin, np.cos)]
    return float(np.abs(np.subtract(found, expected)).max() / expected[1])


def pair_off(result: Result, *, field: str, expected: ArrayLike, scale: float) -> float:
    """Return the largest difference of a ``field`` of a pair of bodies from ``expected``, over ``scale``.

    The second body of the pair moves opposite to the first one, and turns as it does.
    """
    first, second = result.bodies(field)[-1, :2]  # the walls follow
    both = np.array([first, second if field == "angular_velocity" else -second])
    return float(np.abs(both - expected).max() / scale)


def time_difference(first: Result, second: Result, *, number: str, value: float) -> float:
    """Return the relative difference of the times at which a falling number of two runs reaches ``value``."""
    times = [np.interp(-value, -_series(run, number), _series(run, "t")) for run in (first, second)]
    return abs(times[0] / times[1] - 1)


def history_error(result: Result, *, number: str) -> float:
    """Return the largest error of a number of history.csv where the flow is resolved, over its largest exact value."""
    history = open_run(result.folder).history
    resolved = history["resolved"] > 0
    found, exact = history[number][resolved], history[f"{number}_exact"][resolved]
    return np.abs(found - exact).max() / exact.max()


def mean_of_history(result: Result, *, number: str, since: float) -> float:
    """Return the mean of a number of history.csv from the time ``since`` on."""
    return float(_history(result, number, since)[1].mean())


def mean_off(first: Result, second: Result, *, number: str, since: float) -> float:
    """Return the relative difference of the means of a number of history.csv of two runs."""
    means = [mean_of_history(run, number=number, since=since) for run in (first, second)]
    return abs(means[0] / means[1] - 1)


def limit(first: Result, second: Result, *, number: str) -> float:
    """Return a number of the last sample for a parameter of 0, linear in it, which the second run halves."""
    return float(2.0 * _series(second, number)[-1] - _series(first, number)[-1])


def frequency(result: Result, *, number: str, since: float) -> float:
    """Return the frequency at which a number of history.csv rises through its mean, NaN where it does not twice."""
    time, values = _history(result, number, since)
    values = values - values.mean()
    rises = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    at = time[rises] - values[rises] * np.diff(time)[rises] / np.diff(values)[rises]
    return float((len(at) - 1) / (at[-1] - at[0])) if len(at) > 1 else math.nan


def crest(result: Result, *, number: str, since: float, harmonics: int) -> float:
    """Return the largest value of the periodic curve, with this many ``harmonics``, through a number of history.csv.

    The scatter of single times would raise their largest value. The frequency is that of ``lift``.
    """
    time, values = _history(result, number, since)
    turn = 2.0 * math.pi * frequency(result, number="lift", since=since)

    def waves(t: np.ndarray) -> np.ndarray:
        return np.stack([wave(k * turn * t) for k in range(harmonics + 1) for wave in (np.cos, np.sin)], axis=1)

    factors = np.linalg.lstsq(waves(time), values, rcond=None)[0]
    return float((waves(np.linspace(0.0, 2.0 * math.pi / turn, 400)) @ factors).max())


def peak(result: Result, *, number: str, between: Sequence[float], when: bool = False) -> float:
    """Return the largest value, or its time (``when``), of a quartic through a number of history.csv in an interval."""
    time, values = _history(result, number, between[0])
    chosen = time <= between[1]
    curve = np.polynomial.Polynomial.fit(time[chosen], values[chosen], 4)
    times = np.linspace(between[0], between[1], 1000)
    return float(times[np.argmax(curve(times))] if when else curve(times).max())


def error_near_axis(result: Result, *, sample: int) -> float:
    """Return the largest error of u within three spacings of the axis over the largest one elsewhere.

    Near the axis particles have neighbours on one side only. ``sample``: its number, from 0.
    """
    arrays, name = result.arrays(), f"sample_{sample:03d}"
    error = np.abs(arrays[f"{name}/u"] - arrays[f"{name}/u_exact"])
    near = arrays[f"{name}/y"] < 3.0 * result.summary["numbers"]["spacing"]
    return error[near].max() / error[~near].max()


def momentum_off(result: Result, *, drive: float) -> float:
    """Return the largest residual of the momentum balance in a cell, over the larger of drive and drag.

    ``drive``: force on the fluid. Samples are ends and middles of intervals, whose impulses are integrated by Simpson's
    rule.
    """
    t, momentum, drag = (_series(result, name) for name in ("t", "superficial_velocity", "drag"))
    net, length = drive - drag, t[2::2] - t[:-2:2]
    impulse = length / 6 * (net[:-2:2] + 4 * net[1::2] + net[2::2])
    rest = (momentum[2::2] - momentum[:-2:2] - impulse) / length
    return np.abs(rest).max() / max(drive, np.abs(drag).max())


def momentum_of_all(result: Result, *, density: float, area: float, load: float) -> float:
    """Return the largest momentum along x of fluid and bodies, which is 0 under opposite loads, over the impulse.

    ``density``, ``area``: of each body, in a fluid of density 1; ``load``: the larger force.
    """
    bodies = (density - 1.0) * area * result.bodies("velocity")[..., 0].sum(axis=1)
    return np.abs(_series(result, "superficial_velocity") + bodies).max() / (load * result.last["t"])


def momentum_of_bodies(result: Result, *, density: float, area: float, loads: Sequence[float], first: int) -> float:
    """Return the difference of a body's momentum along x to its impulse, over the impulse of the larger load.

    ``loads``: force on each body; ``first``: number of the sample at which the integration begins, since the fluid's
    force falls as 1/sqrt(t) at first.
    """
    t = _series(result, "t")[first:]
    impulse = simpson(result.bodies("force")[first:, :, 0] + np.array(loads), x=t, axis=0)
    velocity = result.bodies("velocity")[first:, :, 0]
    return np.abs(density * area * (velocity[-1] - velocity[0]) - impulse).max() / (max(loads) * np.ptp(t))


def angular_momentum_off(result: Result) -> float:
    """Return the relative residual of the balance of angular momentum between cylinders and the impulses of torques.

    From the first sample to the last, over the larger impulse. The angular momentum is an integral over nodes; the
    values there are interpolated by polynomials of degree 6 through the particles.
    """
    history, samples = open_run(result.folder).history, result.summary["samples"]
    ends = samples[0]["t"], samples[-1]["t"]
    impulses = [_impulse(history["t"], history[f"torque_{side}"], ends) for side in ("inner", "outer")]
    before, after = (_angular_momentum(result, place) for place in (0, len(samples) - 1))
    return abs(after - before + sum(impulses)) / np.abs(impulses).max()


def mode_off(result: Result, *, number: str, since: float, rate: float, frequency: float) -> float:
    """Return the difference of a mode from a growth ``rate`` and an angular ``frequency``, over the frequency.

    Its energy is a ``number`` of history.csv: e^(2 rate t) (a + b cos(2 frequency t) + c sin(2 frequency t)), fitted
    from the time ``since`` on to equal relative errors.
    """
    time, values = _history(result, number, since)

    def residual(root: np.ndarray) -> np.ndarray:
        swing = np.stack([np.ones_like(time), *(wave(2.0 * root[1] * time) for wave in (np.cos, np.sin))], axis=1)
        scaled = values * np.exp(-2.0 * root[0] * (time - time[0]))
        return swing @ np.linalg.lstsq(swing, scaled, rcond=None)[0] / scaled.mean() - scaled / scaled.mean()

    found = least_squares(residual, [rate, frequency], x_scale=frequency).x
    return float(np.hypot(*(found - [rate, frequency])) / frequency)


def critical_value(*results: Result, at: Sequence[float], expected: float) -> float:
    """Return the relative error of the Reynolds number at which the growth rate is 0.

    The rate is a parabola through the runs' rates; ``at``: their Reynolds numbers over the ``expected`` one.
    """
    rates = [result.last["growth_rate"] for result in results]
    if None in rates or not np.isfinite(rates).all():
        return math.nan
    zeros = np.roots(np.polyfit(at, rates, 2))
    return abs(zeros[np.argmin(np.abs(zeros - 1.0))] - 1.0)


def drag_off_table(
    result: Result,
    *,
    weissenberg: Sequence[float],
    drags: Sequence[float],
    viscosity: float,
    drive: float,
    relaxation_time: float,
) -> float:
    """Return the relative difference of the drag on a cylinder of radius 1 in a channel to a table.

    ``drags``: drag over dynamic viscosity and mean velocity, at the ``weissenberg`` numbers relaxation time * mean
    velocity / radius. The pressure gradient along the channel adds the force ``drive`` * pi on the cylinder.
    """
    velocity = result.last["superficial_velocity"]
    found = (result.last["drag"] + drive * math.pi) / (viscosity * velocity)
    return abs(found / float(CubicSpline(weissenberg, drags)(relaxation_time * velocity)) - 1)


def intrinsic_viscosity_off(*results: Result, fractions: Sequence[float], viscosity: float, expected: float) -> float:
    """Return the relative error of the intrinsic viscosity: the limit of (stress - 1)/fraction at the fraction 0.

    A line through the values at ``fractions`` gives the limit. The stress on the walls of a cell of length 1 is over
    dynamic ``viscosity`` and a shear rate of 1.
    """
    stresses = [0.5 * (run.last["drag_bottom"] - run.last["drag_top"]) / viscosity for run in results]
    rises = (np.array(stresses) - 1) / fractions
    return abs(np.polyfit(fractions, rises, 1)[1] / expected - 1)


def stated_error(result: Result, *finer: Result, field: str, t: float) -> float:
    """Return the estimated error of a ``field`` at the time ``t`` over the true error.

    The true error is relative, L2 over the particles: the difference from the exact solution, or from a ``finer`` run.
    ``field``: velocity or pressure.
    """
    sample, estimates = result.sample(t, "t"), result.summary.get("error_estimate", {}).get("samples")
    if not sample or not estimates:
        return math.nan
    place = result.summary["samples"].index(sample)
    stated = estimates[place]["fields"][field]["error"]
    exact = {"velocity": "l2", "pressure": "l2_pressure"}[field]
    true = _off_finer(field, place, result, *finer) if finer else sample[exact]
    return math.nan if stated is None else stated / true


MEASURES: dict[str, Callable[..., float]] = {
    function.__name__: function
    for function in (
        resolved_samples,
        largest,
        largest_velocity,
        particles_off,
        mean_of_particles,
        modulus_off,
        pair_off,
        time_difference,
        history_error,
        mean_of_history,
        mean_off,
        limit,
        frequency,
        crest,
        peak,
        error_near_axis,
        momentum_off,
        momentum_of_all,
        momentum_of_bodies,
        angular_momentum_off,
        mode_off,
        critical_value,
        drag_off_table,
        intrinsic_viscosity_off,
        stated_error,
    )
}
MEASURES |= heat.MEASURES
"""Value of ``measure`` in a suite -> function."""


def _series(result: Result, number: str) -> np.ndarray:
    """Return the values of a number at all samples."""
    expression = Number(number, "with")
    return np.array([expression(result, sample) for sample in result.summary["samples"]], dtype=float)


def _means(result: Result, number: str) -> np.ndarray:
    """Return the values of an expression of the fields' means over the particles, at all samples."""
    expression, arrays = Number(number, "with"), result.arrays()
    samples: dict[str, dict[str, float]] = {}
    for key in sorted(arrays):
        sample, _, field = key.partition("/")
        samples.setdefault(sample, {})[field] = float(arrays[key].mean())
    return np.array([expression(result, means) for means in samples.values()])


def _history(result: Result, number: str, since: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of a number of history.csv from the time ``since`` on."""
    history = open_run(result.folder).history
    chosen = (history["t"] >= since) & np.isfinite(history[number])
    return history["t"][chosen], history[number][chosen]


def _impulse(t: np.ndarray, torque: np.ndarray, ends: tuple[float, float]) -> float:
    known = np.isfinite(torque)  # there is none at the start
    return np.diff(np.interp(ends, t[known], integral(t[known], torque[known])))[0]


def _angular_momentum(result: Result, place: int) -> float:
    scene: Any = scenes.of(open_run(result.folder).config)
    arrays = result.arrays()
    x, y, w = (arrays[f"sample_{place:03d}/{name}"] for name in "xyw")
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    radii = scene.inner_radius + scene.extent[1] * 0.5 * (nodes + 1.0)
    along = scene.length * (np.arange(NODES) + 0.5) / NODES
    points = np.stack(np.meshgrid(along, radii, indexing="ij"), axis=-1).reshape(-1, 2)
    swirl = interpolated(scene, np.stack([x, y], axis=1), w[:, None], points)[:, 0].reshape(NODES, NODES).mean(axis=0)
    return scene.density * scene.length * np.pi * scene.extent[1] * np.sum(weights * radii**2 * swirl)


def _off_finer(field: str, place: int, result: Result, finer: Result) -> float:
    """Return the relative L2 difference of a field to the field of a finer run, over the particles of the coarser."""
    names = {"velocity": "uv", "pressure": ["pressure"]}[field]
    both = [list(open_run(run.folder).snapshots())[place] for run in (result, finer)]
    points = [np.stack([each.x, each.y], axis=1) for each in both]
    values = [np.stack([getattr(each, name) for name in names], axis=1) for each in both]
    values[1] = interpolated(scenes.of(open_run(finer.folder).config), points[1], values[1], points[0])
    weight, values = both[0].weight, [each.T for each in values]
    if field == "pressure":  # known up to a constant
        values = [each - np.mean(weight * each) for each in values]
    off: Any = relative_difference(values[0], values[1], weight)
    return off
