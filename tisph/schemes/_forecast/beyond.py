"""What rows of the start lattice do not have: disorder, digits of single precision, residuals of linear systems."""

import math
from dataclasses import dataclass

import numpy as np

from tisph.schemes._limits import DISORDERED_OF_ORDER_2, DISORDERED_SOLVENT, LOST, MIXED, RESOLVED, STIFF, STIFFEST
from tisph.schemes._time_step import AUTO_CFL

ROUNDING = {"f32": 2.0**-25, "f64": 2.0**-54}
"""Rounding error of numbers below 1, at most."""


STIRRED, STIRRED_BY_DRIVE = 0.7, 0.17
"""Error that disorder leaves of the start of a flow in the implicit scheme, over (spacing/gap)^2 and the jitter: times
the jump of a wall over the reference velocity, and of flows without one. Measured over the disordered cells of the
stability matrix (8, 25 and 50 across, cell Reynolds numbers 2 to 400), where it spreads as an impulse does that is put
in too deep.
"""

SLIDING = 28.0
"""Cell Reynolds number from which on it has this size, and below which it falls with the third power: as many spacings
do rows slide past each other while the layer at the wall grows to the depth of one, and has no derivatives."""


AT_REST = 0.03
"""What is left of it where rows do not slide, measured likewise."""

LARGEST_JITTER = 0.3
"""Of the stability matrix, in spacings."""


@dataclass(frozen=True)
class Noise:
    """Errors that rows do not have and that may cancel, as root mean squares: ``rounding`` and ``stirred`` over the
    reference velocity, ``residual`` over the velocities at most.

    ``shuffled``: whether particles have left the rows, which err more than they do. ``normal``: what disorder makes of
    the normal stresses of polymer, over the errors of the rows.
    """

    rounding: float = 0.0
    stirred: float = 0.0
    residual: float = 0.0
    shuffled: bool = False
    normal: float = 0.0


def mixes(config, channel):
    """Tell whether the explicit scheme mixes the liquid next to a wall that starts or oscillates."""
    return _starts(channel) and cell_reynolds(channel) > (RESOLVED if config.initial.jitter > 0 else MIXED)


def lost(config, channel):
    """Tell whether it has mixed all of it up to the last sample."""
    fastest = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    time = min(config.time.samples[-1], 1 / fastest if fastest else math.inf)
    depth = min(math.sqrt(channel.kinematic_viscosity * time), channel.gap) / channel.spacing
    ratio = cell_reynolds(channel) / RESOLVED
    return _starts(channel) and ratio > 1.0 and ratio >= LOST * depth


def cell_reynolds(channel):
    """Reynolds number of a spacing, U spacing / nu."""
    return channel.reference_velocity * channel.spacing / channel.kinematic_viscosity


def stiffness(config, channel):
    """Return what ``STIFF`` is about: how fast polymer answers a jump, the solvent's layer being a spacing deep."""
    if not channel.polymer:
        return 0.0
    modulus = sum(law.modulus for law in config.fluid.rheology.laws(channel.kinematic_viscosity))
    return modulus * (channel.spacing / channel.solvent_viscosity) ** 2


def _starts(channel):
    return any(channel.wall_jumps) or channel.bottom.oscillates or channel.top.oscillates


def explicit(config, channel, rate):
    """Return the ``Noise`` of scheme ``wcsph``, which takes ``rate`` steps in the unit of time, or None."""
    number, disordered = config.time.cfl, config.initial.jitter > 0
    if disordered and number != "auto" and number > STIFFEST * AUTO_CFL:
        return None
    shuffled = disordered and cell_reynolds(channel) > SLIDING
    return Noise(rounding=_rounding(config, rate * _memory(channel)), shuffled=shuffled)


def implicit(config, channel, residual, counts):
    """Return the ``Noise`` of scheme ``implicit``; ``counts``: (time, steps) up to now, ascending.

    None for disorder that it does not keep: of order 2, and with polymer where the solvent has little viscosity.
    ``residual``: of the linear systems, in all they do to the end of a step, over the velocities. The residuals of all
    steps that the flow remembers may have the same sense.
    """
    disordered = config.initial.jitter > 0
    if disordered and config.scheme.operators.order == 2 and cell_reynolds(channel) > DISORDERED_OF_ORDER_2:
        return None
    if breaks_up(config, channel):
        return None
    times, steps = zip(*counts, strict=True)
    remembered = steps[-1] - float(np.interp(times[-1] - _memory(channel), times, steps))
    stirred = _stirred(config, channel)
    stirred *= _spread(config, channel, times[-1] - channel.start_time) if stirred else 0.0
    # rows have the same normal stress everywhere; those of particles differ by its error, Wi times that of the shear
    normal = config.initial.jitter * channel.weissenberg
    return Noise(_rounding(config, remembered), stirred, residual * (1.0 + remembered), normal=normal)


def breaks_up(config, channel):
    """Tell whether disordered particles of the implicit scheme may leave the flow that rows have."""
    solvent = channel.reference_velocity * channel.spacing / channel.solvent_viscosity
    return bool(channel.polymer) and config.initial.jitter > 0 and solvent > DISORDERED_SOLVENT


def _spread(config, channel, age):
    """Root mean square of a dipole of momentum at a wall, from when it is a spacing deep, over that of one wave.

    Its waves k start with amplitudes k, as the slope of the layer that an impulse makes; the rows have no more than one
    each.
    """
    waves = np.arange(1.0, channel.rows + 1.0)
    left = _left(config, channel, waves, max(age, channel.spacing**2 / channel.kinematic_viscosity))
    return math.sqrt(float(np.sum((waves * left) ** 2)))


def _left(config, channel, waves, age):
    """Return what is left of ``waves`` sin(k pi y/gap) of the velocity after ``age`` in a liquid at rest.

    exp(-(k pi)^2 t*), or with polymer the first component of the linear map of velocity and stresses: stresses that the
    wave has made while it was there drive it on for as long as they last.
    """
    numbers = math.pi / channel.gap * waves
    if not channel.polymer:
        return np.exp(-channel.kinematic_viscosity * numbers**2 * age)
    laws = config.fluid.rheology.laws(channel.kinematic_viscosity)
    rates = np.zeros((len(waves), len(laws) + 1, len(laws) + 1))
    rates[:, 0, 0] = -channel.solvent_viscosity * numbers**2
    for place, law in enumerate(laws, 1):
        rates[:, 0, place] = -math.sqrt(law.modulus) * numbers  # of stresses over the root of the modulus
        rates[:, place, 0] = math.sqrt(law.modulus) * numbers
        rates[:, place, place] = -1.0 / law.relaxation_time
    values, vectors = np.linalg.eig(rates)  # two that are equal but for rounding leave half of the digits
    shares = np.linalg.solve(vectors, np.eye(len(laws) + 1)[:, :1])[..., 0]
    return np.sum(vectors[:, 0] * shares * np.exp(age * values), axis=1).real


def _stirred(config, channel):
    """Error that disorder leaves of the start; rounding makes as much of it in the end where it is not damped.

    All of it, too, where polymer answers a jump before the layer has derivatives.
    """
    number, jitter = cell_reynolds(channel), config.initial.jitter
    if config.discretisation.precision == "f32" and number > MIXED:
        jitter = max(jitter, LARGEST_JITTER)
    jump = max(abs(one) for one in channel.wall_jumps) / channel.reference_velocity
    size = jitter * max(STIRRED * jump, STIRRED_BY_DRIVE) * (channel.spacing / channel.gap) ** 2
    early = (number / SLIDING) ** 3 + ((stiffness(config, channel) / STIFF) ** 3 if jump else 0.0)
    return size * (AT_REST + early / (1.0 + early))


def _memory(channel):
    """Time in which the slowest wave of the flow falls by a factor e."""
    return channel.viscous_time / math.pi**2


def _rounding(config, steps):
    """Error that the roundings of ``steps`` leave, which have no sense in common."""
    return ROUNDING[config.discretisation.precision] * (1.0 + math.sqrt(steps))
