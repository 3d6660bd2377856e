"""Errors and steps of samples before a run: the implicit scheme itself, reduced to the layers of its start lattice.

In a plane flow on the lattice all particles of a layer do the same. With one velocity for each layer, the operators,
walls, start and step control of the implicit scheme are those of the run at a thousandth of its cost, and the exact
solution is known: so the error and the number of steps of every sample are computed, not guessed. Layers know nothing
of disordered particles and of single precision. Of such runs, of the explicit scheme and of two-dimensional flows no
error is stated before the run; ``tisph run --estimate-error`` states one.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from tisph.measures.metrics import relative_error, rms_error
from tisph.schemes import _limits
from tisph.schemes._error_estimate.implicit_layers import ImplicitLayers
from tisph.schemes._stages.stages import SOLVER_TOLERANCE

MOST_LAYERS = {"newtonian": 128, "coupled": 50}
"""Layers that are computed with. Of a finer lattice the error is taken to be that of the steps."""

RESTS = 100.0
"""Reference velocity over the root mean square of the fluid's, above which it counts as at rest."""

LAYERS, DISORDERED, GUESSED = (0.97, 1.03), (0.9, 1.4), (0.3, 2.0)
"""Steps of runs over the estimated ones, least and most: on a lattice, of disordered particles or in single precision,
and where these break up or steps are only counted. In the stability matrix they are 0.99 to 1.01, 0.95 to 1.37 and 0.36
to 1.75."""


@dataclass(frozen=True)
class SampleEstimate:
    """Estimates of one sample: its time ``t``, the number of ``steps`` up to it, errors as in the summary.

    ``l2`` and ``rms``, see ``measures/metrics.py``, are None where there is no estimate before the run, ``l2`` also
    where the fluid rests, or nearly so. ``at_most``: the run may have a smaller error. ``steps_reliable``: the steps
    are an estimate; else no more than a guess, from the speed that the config gives. ``steps_factors``: least and
    largest steps of the run over ``steps``. ``judged_by``: numbers of the run that decide whether its sample is
    resolved, in words; empty where that is known before.
    """

    t: float
    steps: int
    l2: float | None = None
    rms: float | None = None
    at_most: bool = False
    steps_reliable: bool = True
    steps_factors: tuple[float, float] = (1.0, 1.0)
    judged_by: tuple[str, ...] = ()

    def steps_range(self, steps):
        """Return the least and the largest number of steps of the run where ``steps`` are estimated."""
        low, high = self.steps_factors
        return max(min(1, steps), math.floor(low * steps)), math.ceil(high * steps)


@dataclass(frozen=True)
class _Layers:
    """Velocities ``u`` of layers and the exact ones in ``reference``, at time ``t``: what error measures look at."""

    t: float
    u: np.ndarray
    reference: dict[str, np.ndarray]


def implicit(config, channel, control):
    """Return the ``SampleEstimate`` of every sample of scheme ``implicit``, and the layers at the end of the run.

    ``control``: the step control of the run; its targets must be all times that steps meet.
    """
    channel = channel.in_flow_frame()
    coupled = config.fluid.rheology.type != "newtonian" or channel.driven_side is not None
    layers = ImplicitLayers(config, _coarse(channel, "coupled" if coupled else "newtonian"), control)
    samples, reliable = [], not _limits.breaks_up(config, channel)  # it is about disordered particles
    for time in config.time.samples:
        layers.run_to(time)
        if time == channel.start_time:
            exact = channel.initial_velocity(layers.heights)
            samples.append(_sample(channel, layers.heights, time, 0, exact, 0.0))
        elif layers.unknown or off_layers(config):
            factors = GUESSED if layers.unknown or not reliable else DISORDERED
            samples.append(SampleEstimate(time, layers.steps, steps_reliable=reliable, steps_factors=factors))
        else:
            least = SOLVER_TOLERANCE * control.tolerance
            sample = _sample(channel, layers.heights, time, layers.steps, layers.velocity, least)
            samples.append(replace(sample, steps_factors=LAYERS))
    layers.run_to(config.time.end)
    return samples, layers


def off_layers(config):
    """Tell whether particles do not stay on layers, or have fewer digits than these."""
    return config.initial.jitter > 0 or config.discretisation.precision != "f64"


def _coarse(channel, fluid):
    """Return the channel with no more layers than are computed with."""
    most = MOST_LAYERS[fluid]
    if channel.rows <= most:
        return channel
    return replace(channel, rows=most, spacing=channel.gap / most)


def _sample(channel, heights, time, steps, velocity, least):
    """Return the ``SampleEstimate`` from the velocities of layers.

    ``least``: error that residuals may have, over the reference velocity.
    """
    exact = channel.exact_velocity(heights, time)
    scale = relative_error(channel, _Layers(time, exact + channel.reference_velocity, {"u": exact}))  # L2 over rms
    error = rms_error(channel, _Layers(time, velocity, {"u": exact}))
    rms = max(error, least)
    return SampleEstimate(time, steps, rms * scale if scale and scale < RESTS else None, rms, error < least)
