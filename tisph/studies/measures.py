"""Measures of whole runs that a suite names in its checks: numbers that take more than arithmetic.

Each takes the ``Result`` of one or more runs, whose last sample exists, and parameters by keyword.
"""

import math

import numpy as np
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from tisph import scenes
from tisph.measures.channel import integral
from tisph.measures.fits import interpolated
from tisph.results import open_run
from tisph.studies.expressions import Number

NODES = 32
"""Nodes along the axis, and of Gauss-Legendre across, of the angular momentum: twice as many change it by 1e-6."""


def resolved_samples(result) -> int:
    """Return the number of samples that are called resolved."""
    return sum(sample["resolved"] for sample in result.summary["samples"])


def largest(result, *, number, off=0.0) -> float:
    """Return the largest absolute value over all samples of a number, less ``off`` (one value, or one a sample)."""
    return float(np.abs(_series(result, number) - off).max())


def largest_velocity(result, *, off, scale) -> float:
    """Return the largest velocity of fluid and bodies at the last sample, less ``off`` along x, over ``scale``.

    The angular velocities of the bodies count as velocities of points at a distance of 1.
    """
    arrays = result.arrays()
    last = max(key.partition("/")[0] for key in arrays)
    fluid = [arrays[f"{last}/u"] - off, arrays[f"{last}/v"]]
    bodies = [result.bodies("velocity")[-1] - [off, 0.0], result.bodies("angular_velocity")[-1]]
    return max(np.abs(each).max() for each in (*fluid, *bodies)) / scale


def pair_off(result, *, field, expected, scale) -> float:
    """Return the largest difference of a ``field`` of a pair of bodies from ``expected``, over ``scale``.

    The second body of the pair moves opposite to the first one, and turns as it does.
    """
    first, second = result.bodies(field)[-1, :2]  # the walls follow
    both = np.array([first, second if field == "angular_velocity" else -second])
    return float(np.abs(both - expected).max() / scale)


def time_difference(first, second, *, number, value) -> float:
    """Return by how much the times differ at which a falling number of two runs comes to ``value``, relative."""
    times = [np.interp(-value, -_series(run, number), _series(run, "t")) for run in (first, second)]
    return abs(times[0] / times[1] - 1)


def history_error(result, *, number) -> float:
    """Return the largest error of a number of history.csv where the flow is resolved, over its largest exact value."""
    history = open_run(result.folder).history
    resolved = history["resolved"] > 0
    found, exact = history[number][resolved], history[f"{number}_exact"][resolved]
    return np.abs(found - exact).max() / exact.max()


def error_near_axis(result, *, sample) -> float:
    """Return the largest error of u within three spacings of the axis over the largest one elsewhere.

    Near the axis particles have neighbours on one side only. ``sample``: its number, from 0.
    """
    arrays, name = result.arrays(), f"sample_{sample:03d}"
    error = np.abs(arrays[f"{name}/u"] - arrays[f"{name}/u_exact"])
    near = arrays[f"{name}/y"] < 3.0 * result.summary["numbers"]["spacing"]
    return error[near].max() / error[~near].max()


def momentum_off(result, *, drive) -> float:
    """Return the largest rate of momentum in a cell that drive and drag do not explain, over the larger of these.

    ``drive``: force on the fluid. Samples are ends and middles of intervals, whose impulses are integrated by Simpson's
    rule.
    """
    t, momentum, drag = (_series(result, name) for name in ("t", "superficial_velocity", "drag"))
    net, length = drive - drag, t[2::2] - t[:-2:2]
    impulse = length / 6 * (net[:-2:2] + 4 * net[1::2] + net[2::2])
    rest = (momentum[2::2] - momentum[:-2:2] - impulse) / length
    return np.abs(rest).max() / max(drive, np.abs(drag).max())


def momentum_of_all(result, *, density, area, load) -> float:
    """Return the largest momentum along x of fluid and bodies, which opposite loads keep at 0, over the impulse.

    ``density`` and ``area`` of each body in a fluid of density 1; ``load``: the larger force.
    """
    bodies = (density - 1.0) * area * result.bodies("velocity")[..., 0].sum(axis=1)
    return np.abs(_series(result, "superficial_velocity") + bodies).max() / (load * result.last["t"])


def momentum_of_bodies(result, *, density, area, loads, first) -> float:
    """Return by how much the momentum of a body along x is off its impulse, over the impulse of the larger load.

    ``loads``: force on each body; ``first``: number of the sample at which the integration begins, since the fluid's
    force falls as 1/sqrt(t) at first.
    """
    t, loads = _series(result, "t")[first:], np.array(loads)
    impulse = simpson(result.bodies("force")[first:, :, 0] + loads, x=t, axis=0)
    velocity = result.bodies("velocity")[first:, :, 0]
    return np.abs(density * area * (velocity[-1] - velocity[0]) - impulse).max() / (loads.max() * np.ptp(t))


def angular_momentum_off(result) -> float:
    """Return by how much the angular momentum between cylinders is off the impulse of their torques, relative.

    From the first sample to the last, over the larger impulse. The angular momentum is an integral over nodes, whose
    values come from polynomials of degree 6 through the particles.
    """
    history, samples = open_run(result.folder).history, result.summary["samples"]
    ends = samples[0]["t"], samples[-1]["t"]
    impulses = [_impulse(history["t"], history[f"torque_{side}"], ends) for side in ("inner", "outer")]
    before, after = (_angular_momentum(result, place) for place in (0, len(samples) - 1))
    return abs(after - before + sum(impulses)) / np.abs(impulses).max()


def critical_value(*results, at, expected) -> float:
    """Return the relative error of the Reynolds number at which the growth rate is 0.

    The rate is a parabola through the runs' rates; ``at``: their Reynolds numbers over the ``expected`` one.
    """
    rates = [result.last["growth_rate"] for result in results]
    if None in rates or not np.isfinite(rates).all():
        return math.nan
    zeros = np.roots(np.polyfit(at, rates, 2))
    return abs(zeros[np.argmin(np.abs(zeros - 1.0))] - 1.0)


def drag_off_table(result, *, weissenberg, drags, viscosity, drive, relaxation_time) -> float:
    """Return the relative error of the drag on a cylinder of radius 1 in a channel beside a table.

    ``drags`` over dynamic viscosity and mean velocity, by ``weissenberg`` number, relaxation time * mean velocity over
    radius. The pressure that falls along the channel pushes the cylinder with the force ``drive`` * pi.
    """
    velocity = result.last["superficial_velocity"]
    found = (result.last["drag"] + drive * math.pi) / (viscosity * velocity)
    return abs(found / float(CubicSpline(weissenberg, drags)(relaxation_time * velocity)) - 1)


def intrinsic_viscosity_off(*results, fractions, viscosity, expected) -> float:
    """Return the relative error of the intrinsic viscosity: (stress - 1)/fraction on a line, at the fraction 0.

    The stress is that on the walls of a cell of length 1, over dynamic ``viscosity`` and a shear rate of 1.
    """
    stresses = [0.5 * (run.last["drag_bottom"] - run.last["drag_top"]) / viscosity for run in results]
    rises = (np.array(stresses) - 1) / fractions
    return abs(np.polyfit(fractions, rises, 1)[1] / expected - 1)


def stated_error(result, *finer, field, t) -> float:
    """Return the error of a ``field`` at the time ``t`` that a run states of itself, over the true error.

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


MEASURES = {
    function.__name__: function
    for function in (
        resolved_samples,
        largest,
        largest_velocity,
        pair_off,
        time_difference,
        history_error,
        error_near_axis,
        momentum_off,
        momentum_of_all,
        momentum_of_bodies,
        angular_momentum_off,
        critical_value,
        drag_off_table,
        intrinsic_viscosity_off,
        stated_error,
    )
}
"""Functions by the name that ``measure`` in a suite gives."""


def _series(result, number):
    """Values of a number at all samples."""
    expression = Number(number, "with")
    return np.array([expression(result, sample) for sample in result.summary["samples"]], dtype=float)


def _impulse(t, torque, ends):
    known = np.isfinite(torque)  # there is none at the start
    return np.diff(np.interp(ends, t[known], integral(t[known], torque[known])))[0]


def _angular_momentum(result, place):
    scene, arrays = scenes.of(open_run(result.folder).config), result.arrays()
    x, y, w = (arrays[f"sample_{place:03d}/{name}"] for name in "xyw")
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    radii = scene.inner_radius + scene.extent[1] * 0.5 * (nodes + 1.0)
    along = scene.length * (np.arange(NODES) + 0.5) / NODES
    points = np.stack(np.meshgrid(along, radii, indexing="ij"), axis=-1).reshape(-1, 2)
    swirl = interpolated(scene, np.stack([x, y], axis=1), w[:, None], points)[:, 0].reshape(NODES, NODES).mean(axis=0)
    return scene.density * scene.length * np.pi * scene.extent[1] * np.sum(weights * radii**2 * swirl)


def _off_finer(field, place, result, finer):
    """Relative L2 difference of a field from that of a finer run, over the particles of the coarser one."""
    names, points, values = {"velocity": "uv", "pressure": ["pressure"]}[field], [], []
    for run in (result, finer):
        arrays, sample = run.arrays(), f"sample_{place:03d}"
        points.append(np.stack([arrays[f"{sample}/{name}"] for name in "xy"], axis=1))
        values.append(np.stack([arrays[f"{sample}/{name}"] for name in names], axis=1))
    values[1] = interpolated(scenes.of(open_run(finer.folder).config), points[1], values[1], points[0])
    if field == "pressure":  # known up to a constant
        values = [each - each.mean() for each in values]
    return float(np.linalg.norm(values[0] - values[1]) / np.linalg.norm(values[1]))
