"""What a run will be, computed before it runs: the scheme itself, reduced to the layers of its start lattice.

In a plane flow on the lattice all particles of a layer do the same. With one velocity for each layer, the operators,
walls, start and step control of a scheme are those of the run at a thousandth of its cost, and the exact solution is
known: so the error and the number of steps of every sample are computed, not guessed. Layers know nothing of disordered
particles and of single precision: no error is stated of such runs, which ``tisph run --estimate-error`` finds.
"""

from dataclasses import dataclass, replace

import numpy as np

from tisph.measures.metrics import relative_error, rms_error
from tisph.schemes import _limits
from tisph.schemes._error_estimate.explicit_layers import ExplicitLayers
from tisph.schemes._error_estimate.implicit_layers import ImplicitLayers
from tisph.schemes._plan import steps_between
from tisph.schemes._stages.stages import SOLVER_TOLERANCE

MOST_LAYERS = {"newtonian": 128, "coupled": 50}
"""Layers that are computed with. Of a finer lattice the error of the explicit scheme is taken to be of second order in
the spacing, and that of the implicit one to be that of its steps."""

RESTS = 100.0
"""Reference velocity over the root mean square of the fluid's, above which it counts as at rest."""

ROUND_OFF = 1e-13
"""That the explicit scheme has in any case."""


@dataclass(frozen=True)
class SampleEstimate:
    """Estimates of one sample: its time ``t``, the number of ``steps`` up to it, errors as in the summary.

    ``l2`` and ``rms``, see ``measures/metrics.py``, are None where the model cannot tell, ``l2`` also where the
    fluid rests, or nearly so. ``at_most``: the run may have a smaller error. ``steps_reliable``: the steps are an
    estimate; else no more than a guess, from the speed that the config gives.
    """

    t: float
    steps: int
    l2: float | None
    rms: float | None
    at_most: bool = False
    steps_reliable: bool = True


@dataclass(frozen=True)
class _Layers:
    """Velocities ``u`` of layers and the exact ones in ``reference``, at time ``t``: what error measures look at."""

    t: float
    u: np.ndarray
    reference: dict[str, np.ndarray]


def explicit(config, channel, largest_dt):
    """Return the ``SampleEstimate`` of every sample of scheme ``wcsph`` with steps of at most ``largest_dt``."""
    channel = channel.in_flow_frame()
    known = channel.parallel and not off_layers(config) and not _limits.mixes(config, channel)
    layers, finer = None, 1.0
    if known:
        coarse = _coarse(channel, "coupled" if channel.polymer else "newtonian")
        layers, finer = ExplicitLayers(config, coarse), (coarse.rows / channel.rows) ** 2
    samples, steps, before = [], 0, channel.start_time
    for time in config.time.samples:
        if time > before:
            steps += steps_between(before, time, largest_dt)
        before = time
        if layers is None:
            samples.append(SampleEstimate(time, steps, None, None))
        elif time == channel.start_time:
            samples.append(_start(channel, layers.heights))
        else:
            estimate = _sample(channel, layers.heights, time, steps, layers.velocity(time), ROUND_OFF, finer)
            samples.append(estimate)
    return samples


def implicit(config, channel, control):
    """Return the ``SampleEstimate`` of every sample of scheme ``implicit``, and the layers at the end of the run.

    ``control``: the step control of the run; its targets must be all times that steps meet.
    """
    channel = channel.in_flow_frame()
    coupled = config.fluid.rheology.type != "newtonian" or channel.driven_side is not None
    layers = ImplicitLayers(config, _coarse(channel, "coupled" if coupled else "newtonian"), control)
    samples = []
    for time in config.time.samples:
        layers.run_to(time)
        if time == channel.start_time:
            samples.append(_start(channel, layers.heights))
        elif layers.unknown or off_layers(config):
            samples.append(SampleEstimate(time, layers.steps, None, None))
        else:
            least = SOLVER_TOLERANCE * control.tolerance
            samples.append(_sample(channel, layers.heights, time, layers.steps, layers.velocity, least))
    layers.run_to(config.time.end)
    reliable = not _limits.breaks_up(config, channel)
    return [replace(each, steps_reliable=reliable) for each in samples], layers


def off_layers(config):
    """Tell whether particles do not stay on layers, or have fewer digits than these."""
    return config.initial.jitter > 0 or config.discretisation.precision != "f64"


def _coarse(channel, fluid):
    """Return the channel with no more layers than are computed with."""
    most = MOST_LAYERS[fluid]
    if channel.rows <= most:
        return channel
    return replace(channel, rows=most, spacing=channel.gap / most)


def _start(channel, heights):
    """Return the estimate of a sample at the start, which is the exact solution."""
    return _sample(channel, heights, channel.start_time, 0, channel.initial_velocity(heights), 0.0)


def _sample(channel, heights, time, steps, velocity, least, finer=1.0):
    """Return the ``SampleEstimate`` from the velocities of layers.

    ``least``: error that residuals or round-off may have, over the reference velocity. ``finer``: error of all layers
    of the channel over that of those that were computed with.
    """
    exact = channel.exact_velocity(heights, time)
    scale = relative_error(channel, _Layers(time, exact + channel.reference_velocity, {"u": exact}))  # L2 over rms
    error = rms_error(channel, _Layers(time, velocity, {"u": exact})) * finer
    rms = max(error, least)
    return SampleEstimate(time, steps, rms * scale if scale and scale < RESTS else None, rms, error < least)
