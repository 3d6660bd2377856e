"""What a run will be, before it runs: steps and time, with the implicit scheme errors; for ``tisph check``."""

import itertools
import math

from tisph.equation_of_state import sound_speed
from tisph.schemes import _error_estimate, _limits
from tisph.schemes._error_estimate import SampleEstimate
from tisph.schemes._plan import steps_between
from tisph.schemes._time_step import effective_viscosity, time_step_limits

EXPLICIT_COST = 150e-9
"""Rough cost of one particle and step of the explicit scheme on two threads [s]."""

IMPLICIT_COST, IMPLICIT_OVERHEAD = 2.5e-6, 2e-3
"""The same of the implicit scheme, order 4, and of a step whatever the number of particles [s]."""

EXPLICIT_STEPS = 1.0, 1.01
"""Steps of a run of the explicit scheme over the counted ones, least and most: in the stability matrix 1 to 1.004."""


def explicit(config, channel):
    """Return the numbers of a run of scheme ``wcsph``."""
    length = config.discretisation.smoothing_ratio * channel.spacing
    sound = sound_speed(
        config.scheme.equation_of_state,
        reference_velocity=channel.peak_velocity,
        kinematic_viscosity=channel.kinematic_viscosity,
        length=channel.reference_length,
        density=channel.density,
        elastic_speed=channel.elastic_speed,
    )
    artificial = config.scheme.artificial_viscosity
    limits = time_step_limits(
        config.time.cfl,
        smoothing_length=length,
        sound_speed=sound,
        reference_velocity=channel.peak_velocity,
        kinematic_viscosity=effective_viscosity(channel.solvent_viscosity, artificial, length, sound),
        acceleration=abs(channel.acceleration),
        elastic_speed=channel.elastic_speed,
        relaxation_time=channel.polymer.relaxation_time if channel.polymer else math.inf,
    )
    binding = min(limits, key=lambda name: limits[name])
    *counts, steps = step_counts(config.start_time, [*config.time.samples, config.time.end], limits[binding])
    samples = zip(config.time.samples, counts, strict=True)
    return {
        "mach": channel.peak_velocity / sound,
        "sound_speed": sound,
        "time_step": limits[binding],
        "binding_limit": binding,
        "steps": steps,
        "run_time": channel.particles * steps * EXPLICIT_COST,
        "lost": channel.parallel and _limits.profile_lost(config, channel),
        "samples": [SampleEstimate(t, n, steps_factors=EXPLICIT_STEPS) for t, n in samples],
    }


def implicit(config, channel, control):
    """Return the numbers of a run of scheme ``implicit``, with the ``control`` of its steps."""
    samples, layers = _error_estimate.implicit(config, channel, control)
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": layers.longest,
        "binding_limit": "cfl" if control.fixed else "strain" if layers.strained else "accuracy",
        "steps": layers.steps,
        "run_time": layers.steps * (IMPLICIT_OVERHEAD + channel.rows * channel.columns * IMPLICIT_COST),
        "lost": False,
        "samples": samples,
    }


def step_counts(start, targets, longest):
    """Steps no longer than ``longest`` from ``start`` up to every target (ascending), each hit exactly."""
    pairs = itertools.pairwise([start, *targets])
    steps = (steps_between(before, after, longest) if after > before else 0 for before, after in pairs)
    return list(itertools.accumulate(steps))
