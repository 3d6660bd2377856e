"""What a run will be, before it runs: steps, time, error of every sample; for ``tisph check``."""

import itertools
import math

from tisph.equation_of_state import sound_speed
from tisph.schemes import _error_estimate, _limits
from tisph.schemes._plan import steps_between
from tisph.schemes._time_step import effective_viscosity, time_step_limits

EXPLICIT_COST = 150e-9
"""Rough cost of one particle and step of the explicit scheme on two threads [s]."""

IMPLICIT_COST, IMPLICIT_OVERHEAD = 2.5e-6, 2e-3
"""The same of the implicit scheme, order 4, and of a step whatever the number of particles [s]."""


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
    steps = step_count(config.start_time, [*config.time.samples, config.time.end], limits[binding])
    return {
        "mach": channel.peak_velocity / sound,
        "sound_speed": sound,
        "time_step": limits[binding],
        "binding_limit": binding,
        "steps": steps,
        "run_time": channel.particles * steps * EXPLICIT_COST,
        "lost": channel.parallel and _limits.profile_lost(config, channel),
        "samples": _error_estimate.explicit(config, channel, limits[binding]),
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


def step_count(start, targets, longest):
    """Steps no longer than ``longest`` from ``start`` through every target (ascending), each hit exactly."""
    pairs = itertools.pairwise([start, *targets])
    return sum(steps_between(before, after, longest) for before, after in pairs if after > before)
