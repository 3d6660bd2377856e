"""Explicit weakly compressible SPH: density carried by the particles, pressure from an equation of state.

The steps, and the kernel that takes one, are in ``_scheme.py``.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Literal

from pydantic import Field

from tisph.config import schema
from tisph.config.base import Model, Problem
from tisph.config.fields import member_name
from tisph.config.schema import Config
from tisph.scenes._scene import Scene
from tisph.schemes import AROUND_BODIES, unsupported
from tisph.schemes._protocol import Scheme, SchemeEstimates
from tisph.schemes.wcsph.equation_of_state import Tait
from tisph.schemes.wcsph.kernels import list_radius

PERIODIC = [(True, False), (True, True), (False, False)]
"""Boxes that the scheme can serve, by whether they are periodic in x and y."""


class Parameters(Model):
    """Choices of the explicit scheme.

    ``operators``: ``consistent`` (corrected, shifted, diffused density) or ``standard`` (the usual WCSPH, for
    comparison). ``artificial_viscosity``: Monaghan's linear coefficient alpha, 0 for none.
    """

    type: Literal["wcsph"] = "wcsph"
    operators: member_name("operators") = "consistent"
    equation_of_state: Tait = Tait()
    artificial_viscosity: float = Field(default=0.0, ge=0, le=10)


def build(config: Config, scene: Scene, targets: Sequence[float], serial: bool) -> Scheme:
    """Return the scheme of a scene, with steps that end on the times ``targets`` exactly."""
    from tisph.schemes.wcsph._scheme import ExplicitScheme

    return ExplicitScheme(config, scene, targets, serial)


def problems(config: Config) -> Iterator[Problem]:
    """Yield dotted key and text of everything in a config that this scheme cannot serve."""
    yield from unsupported(config, "wcsph")
    if config.time.tolerance != "auto":
        yield "time.tolerance", "is for scheme implicit, which estimates the error of its steps; wcsph has time.cfl"
    if config.fluid.rheology.carries_stress and config.scheme.operators != "consistent":
        text = f"{config.fluid.rheology.type} needs the velocity gradient of the consistent operators"
        yield "scheme.operators", f"{text}: give consistent, or fluid.rheology {{type: newtonian}}"
    if config.fluid.rheology.carries_stress and not config.parallel:
        text = f"wcsph has no {config.fluid.rheology.type} fluid in two-dimensional flow"
        yield "scheme.type", f"{text}; take implicit, or fluid.rheology {{type: newtonian}}"
    if not any(config.periodic):
        yield from _problems_around_bodies(config)


def _problems_around_bodies(config: Config) -> Iterator[Problem]:
    if config.flows_through:
        yield "scheme.type", "wcsph has no open ends; take auto or implicit"
    elif not hasattr(getattr(config, "walls", None), "treatment"):
        yield "scheme.type", f"wcsph has no wall treatment for scene {config.scene}; take implicit"
    elif "walls" in config.members and config.walls.treatment.type not in AROUND_BODIES:
        text, (*others, last) = f"{config.walls.treatment.type} is for plane walls", AROUND_BODIES
        yield "walls.treatment.type", f"{text}; take {', '.join(others)} or {last}"
    elif config.smallest_radius < config.spacing:
        text = f"must be at most {config.smallest_radius:g}, the smallest radius of a wall"
        yield schema.resolution_key(config), f"the spacing, {config.spacing:g}, {text}, with scheme wcsph"
    elif "walls" in config.members and config.walls.treatment.type == "comoving_image":
        yield from _problems_of_images(config)


def _problems_of_images(config: Config) -> Iterator[Problem]:
    deepest = list_radius(config.support * config.spacing, config.spacing)
    if config.smallest_radius <= deepest:
        text = (
            f"images {deepest:g} deep, as far as particles see, have no room in a radius of {config.smallest_radius:g}"
        )
        largest = math.floor(1e5 * config.smallest_radius * config.spacing / deepest) / 1e5
        yield "walls.treatment.type", f"{text}; take a spacing below {largest:g}, virtual_image or adami"


def coarsen_steps(config: Config, factor: float) -> Config:
    """Return the config: its steps are limited by multiples of the spacing already."""
    return config


def orders(config: Config) -> tuple[float, float]:
    """Return the least and the largest order in the spacing that counts as observed: second order, and scatter."""
    return 1.0, 3.5


def estimates(config: Config, scene: Scene) -> SchemeEstimates:
    """Return the estimates of a run of this scheme for ``tisph check``."""
    from tisph.schemes._estimate import explicit

    return explicit(config, scene)
