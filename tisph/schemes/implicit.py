"""Implicit incompressible particles: least-squares operators, long steps that follow the flow, no sound.

The velocities obey u' = nu A u + what walls and drive give, A being least-squares rows of order 2 or 4 in the
arrangement of the middle of a step (``tisph/least_squares``), closed by ghosts beyond the walls (``_ghosts.py``), and
are advanced by an implicit method of third order with an error estimate (``schemes/_channel``).

Such a flow is parallel: the velocities across the channel are 0, and the pressure is constant. In two-dimensional flow
pressure and motion are of third order in time, too: ``tisph/schemes/_two_dimensional``.
"""

import math
from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Model
from tisph.least_squares import SKIN, SUPPORT
from tisph.schemes import unsupported
from tisph.schemes._channel.walls import OBEY_MOMENTUM
from tisph.schemes._step_control import StepControl

PERIODIC = [(True, False), (True, True), (False, False)]
"""Boxes that it can have, by whether they are periodic in x and y."""

LEAST_COLUMNS = math.ceil(3 * (max(SUPPORT.values()) + SKIN))

TOLERANCE = 3e-7
"""Of a step, where the config leaves it open."""

FIRST = 0.25
"""First step in spacing^2 / nu, the time in which a wall that starts moves the layer next to it."""

LARGEST_TOLERANCE, LARGEST_STRAIN = 0.1, 2.0
"""That a config may give."""


class LeastSquares(Model):
    """Degree up to which the operators are exact: 4, or 2 (a third of the time for a step, second-order errors)."""

    order: Literal[2, 4] = 4


class Parameters(Model):
    """Choices of the implicit scheme.

    ``largest_strain``: how far rows of particles may slide along one another in a step, over their distance.
    ``largest_courant``: in two-dimensional flow, how many spacings the fastest particle may go in a step.
    """

    type: Literal["implicit"] = "implicit"
    operators: LeastSquares = LeastSquares()
    largest_strain: Annotated[float, Field(gt=0, le=2)] = 0.5
    largest_courant: Annotated[float, Field(gt=0, le=3)] = 0.3


def build(config, scene, targets, serial):
    """Return the scheme of a scene, that of parallel flow where it is parallel."""
    if not scene.parallel:
        from tisph.schemes import _two_dimensional

        return _two_dimensional.build(config, scene, targets, serial)
    from tisph.schemes._channel.scheme import ChannelScheme

    return ChannelScheme(config, scene, control(config, scene, targets), serial)


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


def coarsen_steps(config, factor):
    """Return a config of this scheme with steps ``factor`` times as long; Courant numbers are over the spacing already.

    The estimated error of a step scales with the third power of its length, in two-dimensional flow with the fourth.
    """
    if config.time.cfl != "auto":
        return config
    turns = not config.parallel
    tolerance = config.time.tolerance
    if tolerance == "auto":
        tolerance = TOLERANCE
        if turns:
            from tisph.schemes import _two_dimensional

            tolerance = _two_dimensional.TOLERANCE
    time = {"tolerance": min(tolerance * factor ** (4 if turns else 3), LARGEST_TOLERANCE)}
    strain = {"largest_strain": min(config.scheme.largest_strain * factor, LARGEST_STRAIN)}
    changed = {"time": config.time.model_copy(update=time), "scheme": config.scheme.model_copy(update=strain)}
    return config.model_copy(update=changed)


def orders(config):
    """Return the least and the largest order in the spacing that is to be expected.

    Third in time, third to fourth in space and a fifth on lattices; or second. One more or less is scatter.
    """
    return (2.0, 6.0) if config.scheme.operators.order == 4 else (1.0, 3.5)


def problems(config):
    """Yield dotted key and text of everything in a config that this scheme cannot serve."""
    yield from unsupported(config, "implicit")
    if not config.parallel:
        yield from _problems_without_walls(config)
        return
    if config.columns < LEAST_COLUMNS:
        text = f"must be at least {LEAST_COLUMNS * config.spacing:.6g}, {LEAST_COLUMNS} particle spacings"
        yield "geometry.length", f"{text}: the neighbour search of scheme implicit needs three cells along x"
    if config.walls.treatment.type not in OBEY_MOMENTUM:
        text = f"implicit has no {config.walls.treatment.type} walls"
        yield "walls.treatment.type", f"{text}; take {' or '.join(OBEY_MOMENTUM)}, or scheme wcsph"


def _problems_without_walls(config):
    if min(config.columns, config.rows) < LEAST_COLUMNS:
        text = (
            f"must be at least {LEAST_COLUMNS} along x and y: the neighbour search of scheme implicit needs three cells"
        )
        yield "discretisation.particles_across", text
    if "walls" in config.members:
        text = f"implicit has no {config.walls.treatment.type} walls in two-dimensional flow"
        yield "walls.treatment.type", f"{text}, but closes its operators itself: leave treatment out, or take wcsph"
    if config.scheme.type == "implicit" and config.scheme.operators.order != 4:
        yield "scheme.operators.order", "must be 4 in two-dimensional flow"


def estimates(config, scene):
    """Return the estimates of a run of this scheme for ``tisph check``."""
    if not scene.parallel:
        from tisph.schemes import _two_dimensional

        return _two_dimensional.estimates(config, scene)
    from tisph.schemes._estimate import implicit

    return implicit(config, scene, control(config, scene, sorted({*config.time.samples, config.time.end})))
