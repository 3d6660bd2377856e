"""What a config asks of the steps of the implicit scheme in a parallel flow."""

import math

from tisph.schemes._step_control import StepControl

TOLERANCE = 3e-7
"""Of a step, where the config leaves it open."""

FIRST = 0.25
"""First step in spacing^2 / nu, the time in which a wall that starts moves the layer next to it."""


def control(config, channel, targets):
    """Return the control of the steps that a config asks for."""
    tolerance = TOLERANCE if config.time.tolerance == "auto" else config.time.tolerance
    jump_times = {time for wall in (channel.bottom, channel.top) for time in wall.jump_times}
    if config.time.cfl != "auto":
        first = config.time.cfl * channel.spacing / channel.reference_velocity
        chosen = StepControl(tolerance, lambda _gradient: first, fixed=True, jump_times=jump_times)
    else:
        first = FIRST * channel.spacing**2 / channel.kinematic_viscosity
        strain = config.scheme.largest_strain
        limit = lambda gradient: strain / gradient if gradient > 0.0 else math.inf  # noqa: E731
        chosen = StepControl(tolerance, limit, jump_times=jump_times)
    chosen.dt_next = first
    chosen.set_targets(targets, channel.start_time)
    return chosen
