"""What a run will be, before it runs: steps, time, error. Rough, and in plain numbers; for ``tisph check``."""

import itertools
import math

from tisph.equation_of_state import sound_speed
from tisph.schemes import _error
from tisph.schemes._plan import steps_between
from tisph.schemes._time_step import effective_viscosity, time_step_limits

EXPLICIT_COST = 150e-9
"""Rough cost of one particle and step of the explicit scheme on two threads [s]."""

IMPLICIT_COST, IMPLICIT_OVERHEAD = 2.5e-6, 2e-3
"""The same of the implicit scheme, order 4, and of a step whatever the number of particles [s]."""

GROWTH = 0.5
"""Step over the time since the start, at a tolerance of 1e-4; it goes with the cube root of the tolerance."""

PHASE = 0.5
"""Step times angular frequency of a wall, likewise."""


def explicit(config, channel):
    """Return the numbers of a run of scheme ``wcsph``."""
    length = config.discretisation.smoothing_ratio * channel.spacing
    sound = sound_speed(
        config.scheme.equation_of_state,
        reference_velocity=channel.peak_velocity,
        kinematic_viscosity=channel.kinematic_viscosity,
        gap=channel.gap,
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
        "run_time": channel.rows * channel.columns * steps * EXPLICIT_COST,
        "errors": [_error.explicit(config, channel, time) for time in config.time.samples],
    }


def implicit(config, channel, first, tolerance, strain):
    """Return the numbers of a run of scheme ``implicit``, whose first step is ``first`` long."""
    steps, longest, binding = _implicit_steps(config, channel, first, tolerance, strain)
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": longest,
        "binding_limit": binding,
        "steps": steps,
        "run_time": steps * (IMPLICIT_OVERHEAD + channel.rows * channel.columns * IMPLICIT_COST),
        "errors": [_error.implicit(config, channel, tolerance, strain, time) for time in config.time.samples],
    }


def step_count(start, targets, longest):
    """Steps no longer than ``longest`` from ``start`` through every target (ascending), each hit exactly."""
    pairs = itertools.pairwise([start, *targets])
    return sum(steps_between(before, after, longest) for before, after in pairs if after > before)


def _depth(channel, time):
    return min(math.sqrt(channel.kinematic_viscosity * time), channel.gap)


def _implicit_steps(config, channel, first, tolerance, strain):
    """Return number, largest length and limit of the steps, by going through them."""
    if config.time.cfl != "auto":
        return step_count(config.start_time, [*config.time.samples, config.time.end], first), first, "cfl"
    accuracy = (tolerance / 1e-4) ** (1 / 3)
    frequency = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    time, length, steps = config.start_time, first, 0
    while time < config.time.end and steps < 10**7:
        steepest = channel.reference_velocity / _depth(channel, math.pi * max(time, first))
        limits = {
            "accuracy": GROWTH * accuracy * max(time - config.start_time, 2.0 * first),
            "strain": strain / steepest,
            "oscillation": PHASE * accuracy / frequency if frequency else math.inf,
        }
        binding = min(limits, key=lambda name: limits[name])
        length = min(2.0 * length, limits[binding])
        time += length
        steps += 1
    return steps + len(config.time.samples), length, binding
