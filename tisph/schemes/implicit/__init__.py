"""Implicit incompressible particles: least-squares operators, long steps that follow the flow, no sound.

The velocities obey u' = nu A u + what walls and drive give, A being least-squares rows of order 2 or 4 in the
arrangement of the middle of a step (``tisph/least_squares``), closed by ghosts beyond the walls (``_ghosts.py``), and
are advanced by an implicit method of third order with an error estimate (``_esdirk.py``). There is a pressure from the
moment on when the velocities have a divergence that truncation errors do not explain (``_pressure.py``).
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Model
from tisph.schemes.implicit._scheme import Scheme
from tisph.schemes.implicit._walls import OBEY_MOMENTUM

__all__ = ["Parameters", "Scheme", "problems"]


class LeastSquares(Model):
    """Degree up to which the operators are exact: 4, or 2 (a third of the time for a step, second-order errors)."""

    order: Literal[2, 4] = 4


class Parameters(Model):
    """Choices of the implicit scheme.

    ``largest_strain``: how far rows of particles may slide along one another in a step, over their distance.
    """

    type: Literal["implicit"] = "implicit"
    operators: LeastSquares = LeastSquares()
    largest_strain: Annotated[float, Field(gt=0, le=2)] = 1.0


def problems(config):
    """Yield dotted key and text of everything in a config that this scheme cannot serve."""
    if config.fluid.rheology.carries_stress:
        text = "has no polymer stress: give {type: wcsph}, or fluid.rheology {type: newtonian}"
        yield "scheme.type", f"implicit {text}"
    if config.walls.treatment.type not in OBEY_MOMENTUM:
        yield "walls.treatment.type", f"is not one that scheme implicit serves: take {' or '.join(OBEY_MOMENTUM)}"
