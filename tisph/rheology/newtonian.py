"""Newtonian fluid: stress proportional to the rate of deformation, constant viscosity."""

from typing import Any, ClassVar, Literal

from tisph.config.base import Model


class Parameters(Model):
    """No parameters: the viscosity is in ``fluid``."""

    carries_stress: ClassVar[bool] = False

    type: Literal["newtonian"] = "newtonian"

    def law(self, viscosity: float, density: float) -> Any:
        """Return the ``Law``, for code that serves fluids of any viscosity; see ``_laws.Inelastic``."""
        return Law(viscosity)


class Law:
    """A constant viscosity."""

    def __init__(self, viscosity: float) -> None:
        self.constant = viscosity

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate."""
        return self.constant + 0.0 * shear_rate_squared
