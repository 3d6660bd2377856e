"""Incompressible particles with least-squares operators and long implicit steps that follow the flow.

Parallel flow (``schemes/implicit/channel``): the velocities u along the channel obey u' = nu A u + s(t), with boundary
terms and body acceleration in s. A is a least-squares Laplacian of order 2 or 4 in the arrangement of the middle of a
step (``tisph/numerics/least_squares.py``), closed by ghosts beyond the walls. An implicit Runge-Kutta method of third
order advances u and estimates its error. The velocities across the channel are 0, and the pressure is constant.

Two-dimensional flow (``schemes/implicit/planar``): velocity, pressure and motion are of third order in time, too.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Model, Problem
from tisph.config.schema import Config
from tisph.numerics import SKIN, SUPPORT
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.scenes._spacing import spacing_problems
from tisph.scenes._substances import substance_problems
from tisph.schemes import unsupported, unused
from tisph.schemes._protocol import Scheme, SchemeEstimates
from tisph.schemes.implicit.channel.step import TOLERANCE, step_control
from tisph.schemes.implicit.channel.walls import TREATMENTS

PERIODIC = [(True, False), (True, True), (False, False)]
"""Boxes that it can serve, by whether they are periodic in x and y."""

LEAST_COLUMNS = math.ceil(3 * (max(SUPPORT.values()) + SKIN))
"""Smallest number of particles along a period."""

LARGEST_TOLERANCE, LARGEST_STRAIN = 0.1, 2.0
"""Largest values that a config may have."""


class LeastSquares(Model):
    """Degree up to which the operators are exact: 4, or 2 (a third of the time for a step, second-order errors)."""

    order: Literal[2, 4] = 4


class Parameters(Model):
    """Choices of the implicit scheme.

    ``largest_strain``: largest displacement of neighbouring layers along one another in a step, over their distance.
    ``largest_courant``: in two-dimensional flow, largest displacement of a particle in a step, in spacings.
    ``error_ratio``: there, error of all steps over the error of the spacing as the divergence shows it, towards which
    the tolerance falls, to a tenth of its value; None where the tolerance stays.
    """

    type: Literal["implicit"] = "implicit"
    operators: LeastSquares = LeastSquares()
    largest_strain: Annotated[float, Field(gt=0, le=2)] = 0.5
    largest_courant: Annotated[float, Field(gt=0, le=3)] = 0.3
    error_ratio: Annotated[float, Field(gt=0)] | None = None


def build(config: Config, scene: Scene, targets: Sequence[float], serial: bool) -> Scheme:
    """Return the scheme of parallel flow for a scene of parallel flow, else the scheme of two-dimensional flow."""
    if not isinstance(scene, Channel):
        from tisph.schemes.implicit import planar

        return planar.build(config, scene, targets, serial)
    from tisph.schemes.implicit.channel.scheme import ChannelScheme

    return ChannelScheme(config, scene, step_control(config, scene, targets), serial)


def coarsen_steps(config: Config, factor: float) -> Config:
    """Return a config of this scheme with steps ``factor`` times as long.

    The estimated error of a step scales with the third power of its length, in two-dimensional flow with the fourth.
    Courant numbers stay: they are in spacings, which are ``factor`` times as long.
    """
    if config.time.cfl != "auto" or config.singular:
        return config
    tolerance = config.time.tolerance
    if tolerance == "auto" and config.parallel:
        tolerance = TOLERANCE
    elif tolerance == "auto":
        from tisph.schemes.implicit import planar

        tolerance = planar.TOLERANCE
    time = {"tolerance": min(tolerance * factor ** (3 if config.parallel else 4), LARGEST_TOLERANCE)}
    strain = {"largest_strain": min(config.scheme.largest_strain * factor, LARGEST_STRAIN)} if config.parallel else {}
    changed = {"time": config.time.model_copy(update=time), "scheme": config.scheme.model_copy(update=strain)}
    return config.model_copy(update=changed)


def orders(config: Config) -> tuple[float, float]:
    """Return the least and the largest order in the spacing that counts as observed.

    The operators of order 4 have the order 3 in time and 3 to 4 in space, 5 on lattices. One more or less is scatter.
    """
    return (2.0, 6.0) if config.scheme.operators.order == 4 else (1.0, 3.5)


OPEN_COURANT = 1.0
"""Largest Courant number of a flow with open ends. With 2, in which two columns of particles enter in a step, errors of
1e-9 at the inlet grew to 3e-3 of the velocity, in a parabola with 41 across; with 1 they did not grow."""


def problems(config: Config) -> Iterator[Problem]:
    """Yield dotted key and text of everything in a config that this scheme cannot serve."""
    yield from unsupported(config, "implicit")
    if isinstance(config.scheme, Parameters):
        yield from unused(config, "implicit")
    yield from substance_problems(config)
    if not config.parallel:
        yield from _problems_in_two_dimensions(config)
        return
    if config.columns < LEAST_COLUMNS:
        text = f"must be at least {LEAST_COLUMNS * config.spacing:.6g}, {LEAST_COLUMNS} particle spacings"
        yield "geometry.length", f"{text}: the neighbour search of scheme implicit needs three cells along x"
    if config.walls.treatment.type not in TREATMENTS:
        text = f"implicit has no {config.walls.treatment.type} walls"
        yield "walls.treatment.type", f"{text}; take {' or '.join(TREATMENTS)}, or scheme wcsph"
    if (config.temperature or config.scalars) and not config.walls.treatment.obeys_momentum:
        text = "must be consistent_image with a temperature or dissolved substances"
        yield "walls.treatment.type", f"{text}: only its images follow from the equations at the wall"


def _problems_in_two_dimensions(config: Config) -> Iterator[Problem]:
    if min(config.columns, config.rows) < LEAST_COLUMNS:
        text = f"must be at least {LEAST_COLUMNS} along x and y"
        yield "discretisation.particles_across", f"{text}: the neighbour search of scheme implicit needs three cells"
    yield from spacing_problems(config)
    if "walls" in config.members:
        text = f"implicit has no {config.walls.treatment.type} walls in two-dimensional flow"
        yield "walls.treatment.type", f"{text}, but closes its operators itself: leave treatment out, or take wcsph"
    if not isinstance(config.scheme, Parameters):
        return
    if config.scheme.operators.order != 4:
        yield "scheme.operators.order", "must be 4 in two-dimensional flow"
    if config.flows_through and config.scheme.largest_courant > OPEN_COURANT:
        yield "scheme.largest_courant", f"must be at most {OPEN_COURANT:g} in flow through open ends"


def estimates(config: Config, scene: Scene) -> SchemeEstimates:
    """Return the estimates of a run of this scheme for ``tisph check``."""
    if not isinstance(scene, Channel):
        from tisph.schemes.implicit import planar

        return planar.estimates(config, scene)
    from tisph.schemes._estimate import implicit

    return implicit(config, scene, step_control(config, scene, sorted({*config.time.samples, config.time.end})))
