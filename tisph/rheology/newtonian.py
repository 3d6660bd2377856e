"""Newtonian fluid: stress proportional to the rate of deformation, constant viscosity."""

from typing import ClassVar, Literal

from tisph.config.base import Model


class Parameters(Model):
    """No parameters: the viscosity stands in ``fluid``."""

    carries_stress: ClassVar[bool] = False

    type: Literal["newtonian"] = "newtonian"

    def law(self, viscosity, density):
        """Its ``Law``, for what serves fluids of any viscosity; arguments as of those (``_laws.Inelastic``)."""
        return Law(viscosity)


class Law:
    """A constant viscosity."""

    def __init__(self, viscosity):
        self.constant = viscosity

    def viscosity(self, shear_rate_squared):
        """Viscosity at the square of the shear rate."""
        return self.constant + 0.0 * shear_rate_squared
