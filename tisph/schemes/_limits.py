"""Where the stability matrix (``tisph stability``) found the end of what is known of a scheme, in plain numbers."""

import math

STABLE_CELL_RE = 60.0
"""Cell Reynolds number U spacing/nu up to which disordered runs of the explicit scheme vary little in density in the
stability matrix, and above which they mix."""

LOST_LAYERS = 4.0
"""Cell Reynolds number over ``STABLE_CELL_RE``, over the thickness of the layer at a wall in spacings, from which on
half of the profile is lost."""

DISORDERED_CELL_RE_OF_ORDER_2 = 1.0
"""Cell Reynolds number above which disordered runs of order 2 of the implicit scheme have any error, or stop."""

DISORDERED_SOLVENT_CELL_RE = 10.0
"""Cell Reynolds number by the viscosity of the solvent, where there is polymer, up to which disordered runs are stable:
one failed at 20, and above it they take more steps and have larger errors than layers, or stop."""

STIFF_POLYMER = 4.0
"""Modulus of the polymer per unit density times (spacing over solvent viscosity) squared, up to which disordered
particles of the implicit scheme have the error of a lattice at an impulsively started wall: at 3.5 they had, at 14 it
was eight times as large."""


def cell_reynolds(channel):
    """Reynolds number of a spacing, U spacing / nu."""
    return channel.reference_velocity * channel.spacing / channel.kinematic_viscosity


def profile_lost(config, channel):
    """Tell whether the explicit scheme mixes all fluid that a wall has moved up to the last sample."""
    fastest = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    time = min(config.time.samples[-1], 1 / fastest if fastest else math.inf)
    thickness = min(math.sqrt(channel.kinematic_viscosity * time), channel.gap) / channel.spacing
    ratio = cell_reynolds(channel) / STABLE_CELL_RE
    return _starts(channel) and ratio > 1.0 and ratio >= LOST_LAYERS * thickness


def polymer_stiffness(config, channel):
    """Return what ``STIFF_POLYMER`` is about: how fast polymer responds, the solvent's layer being a spacing thick."""
    if not channel.polymer:
        return 0.0
    modulus = sum(law.modulus for law in config.fluid.rheology.laws(channel.kinematic_viscosity))
    return modulus * (channel.spacing / channel.solvent_viscosity) ** 2


def breaks_up(config, channel):
    """Tell whether disordered particles of the implicit scheme may leave the flow that layers have."""
    solvent = channel.reference_velocity * channel.spacing / channel.solvent_viscosity
    return bool(channel.polymer) and config.initial.jitter > 0 and solvent > DISORDERED_SOLVENT_CELL_RE


def _starts(channel):
    return any(channel.wall_jumps) or channel.bottom.oscillates or channel.top.oscillates
