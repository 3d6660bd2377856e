"""Newtonian liquid: stress proportional to the rate of deformation, constant viscosity."""

from typing import ClassVar, Literal

from tisph.config.base import Model


class Parameters(Model):
    """No parameters: the viscosity stands in ``fluid``."""

    carries_stress: ClassVar[bool] = False

    type: Literal["newtonian"] = "newtonian"
