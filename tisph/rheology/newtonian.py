"""Newtonian liquid: stress proportional to the rate of deformation, constant viscosity."""

from typing import Literal

from tisph.config.base import Model


class Parameters(Model):
    """No parameters: the viscosity stands in ``fluid``."""

    type: Literal["newtonian"] = "newtonian"
