"""The error of a run before it runs, for ``tisph check``: rough, L2 at the time of a sample, in plain numbers.

With delta the depth over which the velocity changes, an operator of order p errs by a constant times (spacing/delta)^p,
as measured in start-up flows from 8 to 100 across (``tisph verify``, ``tisph stress``); steps, walls and polymer add
theirs. Of flows that do not start from rest nothing is said (None). Where the velocity crosses zero it is the root mean
square over the reference velocity that is meant.
"""

import math

from tisph import families

EXPLICIT, EXPLICIT_WITHOUT_IMPULSE = 0.031, 0.06
"""Error of the explicit scheme over (spacing/delta)^2, with walls that give their impulse and with others."""

IMPLICIT = {4: 5e-3, 2: 0.03}
"""Error of the implicit scheme over (spacing/delta)^order, by order."""

MISSING_IMPULSE = 0.016
"""What walls that do not give their impulse add to it, over (spacing/delta)^2 at either order."""

MISSING_CURVATURE = 0.2
"""What walls that do not obey the momentum equation add under a drive g, over |g| spacing^2 / (nu U)."""

POLYMER = 3.0
"""Error of the flow of an Oldroyd-B liquid over that of a Newtonian one with the same delta."""

SLOW = 10.0
"""Relaxation times over which the viscosity by which delta grows goes from the solvent's to the total one."""

RESOLVED = 60.0
"""Cell Reynolds number U spacing/nu above which rows that slide past each other in the layer at a wall that started mix
the liquid of the explicit scheme; the error then grows with its square."""

STEPS, EARLY, FORGETTING = 2.0, 0.018, 0.75
"""Error of the steps over their tolerance up to t* = EARLY; from then on it falls with that power of the time."""

STRAIN = 7e-6
"""Error of steps that their strain limits, over its third power."""

LARGEST = 0.5
"""Larger errors are not told apart: the profile is lost."""


def explicit(config, channel, time):
    """Return the estimate at ``time`` for scheme ``wcsph``, None where there is none."""
    if config.initial.state != "rest" or time == 0.0 or config.scheme.operators == "standard":
        return None
    obey = _obey_momentum(config.walls)
    coefficient = (EXPLICIT if obey else EXPLICIT_WITHOUT_IMPULSE) * (POLYMER if channel.polymer else 1.0)
    error = coefficient * _resolution(channel, time) ** 2 * _mixing(channel)
    return min(LARGEST, error if obey else error + _curvature(channel))


def implicit(config, channel, tolerance, strain, time):
    """Return the estimate at ``time`` for scheme ``implicit`` with steps of ``tolerance`` and ``strain``, or None."""
    if config.initial.state != "rest" or time == 0.0:
        return None
    order = config.scheme.operators.order
    resolution = _resolution(channel, time)
    late = time / channel.viscous_time / EARLY
    steps = STEPS * tolerance * min(1.0, late**-FORGETTING) + STRAIN * strain**3
    error = IMPLICIT[order] * resolution**order + steps
    if not _obey_momentum(config.walls):
        error += MISSING_IMPULSE * resolution**2 + _curvature(channel)
    return min(LARGEST, error)


def _obey_momentum(walls):
    return families.load("walls", walls.treatment.type).Treatment.obeys_momentum


def _resolution(channel, time):
    """Spacing over the depth that the motion of a wall has reached at ``time``, or reaches ever."""
    viscosity = channel.kinematic_viscosity
    fastest = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    if channel.polymer:
        viscosity -= channel.polymer_viscosity * math.exp(-time / (SLOW * channel.polymer.relaxation_time))
    return channel.spacing / min(math.sqrt(viscosity * min(time, 1 / fastest if fastest else math.inf)), channel.gap)


def _mixing(channel):
    """Factor by which the explicit scheme errs more where walls start faster than their layer is resolved."""
    if not any(channel.wall_jumps) and not channel.bottom.oscillates and not channel.top.oscillates:
        return 1.0
    return max(1.0, channel.reference_velocity * channel.spacing / channel.kinematic_viscosity / RESOLVED) ** 2


def _curvature(channel):
    if not channel.acceleration:
        return 0.0
    change = abs(channel.acceleration) * channel.spacing**2 / channel.kinematic_viscosity
    return MISSING_CURVATURE * change / channel.reference_velocity
