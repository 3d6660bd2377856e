"""What a run will be, computed before it runs: the scheme itself, reduced to the rows of its start lattice.

In a plane flow on the lattice all particles of a row do the same. With one velocity for each row, the operators, walls,
start and step control of a scheme are those of the run at a thousandth of its cost, and the exact solution is known:
so the error and the number of steps of every sample are computed, not guessed. What rows do not have is added in
``beyond.py``: particles in disorder, digits of single precision, residuals of linear systems.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from tisph.measures.metrics import relative_error, rms_error
from tisph.schemes._forecast import beyond, explicit_rows
from tisph.schemes._plan import steps_between

MOST_ROWS = {"newtonian": 128, "polymer": 50}
"""Rows of the explicit scheme that are computed with; of a finer lattice the error is taken to go with the square of
the spacing."""

MOST_IMPLICIT_ROWS = 400
"""The same of the implicit scheme, whose error is that of its steps where the lattice is finer."""


TYPICAL = 3.0
"""What may add up over what does, as it is stated: residuals of a linear system seldom all have the same sense."""

RESTS = 100.0
"""Reference velocity over the root mean square of the liquid's, above which it counts as at rest."""

DIGITS = 1e-13
"""Digits to which rows are computed: smaller errors are not told apart."""


@dataclass(frozen=True)
class Forecast:
    """Estimates of one sample: its time ``t``, the number of ``steps`` up to it, errors as in the summary.

    ``l2`` and ``rms``, see ``measures/metrics.py``, are None where the model cannot tell, ``l2`` also where the
    liquid rests, or nearly so. ``at_most``: they are what may add up and may as well cancel: the run may err less.
    ``known``: the steps are an estimate; else no more than a guess, from the speed that the config gives.
    """

    t: float
    steps: int
    l2: float | None
    rms: float | None
    at_most: bool = False
    known: bool = True


@dataclass(frozen=True)
class _Rows:
    """Velocities ``u`` of rows and the exact ones in ``reference``, at time ``t``: what error measures look at."""

    t: float
    u: np.ndarray
    reference: dict[str, np.ndarray]


def explicit(config, channel, longest):
    """Return the ``Forecast`` of every sample of scheme ``wcsph`` with steps of at most ``longest``."""
    channel = channel.in_own_frame()
    forecasts, steps, before = [], 0, channel.start_time
    rows = None if not channel.parallel or beyond.mixes(config, channel) else _explicit_rows(config, channel)
    for time in config.time.samples:
        if time > before:
            steps += steps_between(before, time, longest)
        before = time
        forecasts.append(_explicit_sample(config, channel, rows, time, steps, longest))
    return forecasts


def _explicit_rows(config, channel):
    most = MOST_ROWS["polymer" if channel.polymer else "newtonian"]
    return explicit_rows.Rows(config, _coarse(channel, most))


def _explicit_sample(config, channel, rows, time, steps, longest):
    if rows is None:
        return Forecast(time, steps, None, None)
    if time == channel.start_time:
        return _start(channel, rows.heights)
    finer = (rows.rows / channel.rows) ** 2
    rate = steps / (time - channel.start_time)
    noise = beyond.explicit(config, channel, rate)
    return _forecast(channel, rows.heights, time, steps, rows.velocity(time), noise, finer)


def implicit(config, channel, control):
    """Return the ``Forecast`` of every sample of scheme ``implicit``, and the ``Rows`` at the end of the run.

    ``control``: the ``StepControl`` of the run; its targets must be all times that steps meet.
    """
    from tisph.schemes._forecast import elastic_rows, implicit_rows  # they need the package that needs this one

    channel = channel.in_own_frame()
    if config.fluid.rheology.type != "newtonian" or channel.driven_side is not None:
        rows = elastic_rows.ElasticRows(config, _coarse(channel, MOST_ROWS["polymer"]), control)
    else:
        rows = implicit_rows.Rows(config, _coarse(channel, MOST_IMPLICIT_ROWS), control)
    forecasts, counts = [], [(channel.start_time, 0)]
    for time in config.time.samples:
        if time == channel.start_time:
            forecasts.append(_start(channel, rows.heights))
            continue
        rows.run_to(time)
        counts.append((time, rows.steps))
        noise = None if rows.beyond else beyond.implicit(config, channel, rows.residual, counts)
        forecasts.append(_forecast(channel, rows.heights, time, rows.steps, rows.velocity, noise))
    rows.run_to(config.time.end)
    known = not beyond.breaks_up(config, channel)
    return [replace(each, known=known) for each in forecasts], rows


def _coarse(channel, most):
    """Return the channel with no more than ``most`` rows."""
    if channel.rows <= most:
        return channel
    return replace(channel, rows=most, spacing=channel.gap / most)


def _start(channel, heights):
    """Return the forecast of a sample at the start, which is the exact solution."""
    velocity = channel.initial_velocity(heights)
    return _forecast(channel, heights, channel.start_time, 0, velocity, beyond.Noise(), 0.0)


def _forecast(channel, heights, time, steps, velocity, noise, finer=1.0):
    """Return the ``Forecast`` from the velocities of rows and the ``Noise`` of particles, None where it is not known.

    ``finer``: error of all rows of the channel over that of those that were computed with.
    """
    if noise is None:
        return Forecast(time, steps, None, None)
    exact = channel.exact_velocity(heights, time)
    scale = relative_error(channel, _Rows(time, exact + channel.reference_velocity, {"u": exact}))  # L2 over rms
    own = rms_error(channel, _Rows(time, velocity, {"u": exact})) * finer
    residual = noise.residual / scale / TYPICAL if scale else 0.0
    possible = math.hypot(residual, noise.rounding, noise.stirred, noise.normal * own, DIGITS if own else 0.0)
    rms = math.hypot(own, possible)
    # disorder has either sign: a few times as much as is usual may take away two thirds of the rest
    cancels = noise.shuffled or possible > own or TYPICAL * noise.stirred > 2.0 / 3.0 * own
    return Forecast(time, steps, rms * scale if scale and scale < RESTS else None, rms, cancels)
