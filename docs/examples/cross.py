"""Cross fluid: a viscosity between two plateaus that falls with a power of the shear rate.

    viscosity = eta_inf + (eta - eta_inf)/(1 + (time * rate)^index),    rate^2 = 2 D:D = (du/dy)^2 in shear

The viscosity eta in ``fluid`` is that at vanishing shear rate, and eta_inf = fraction_at_infinity * eta. Source:
M. M. Cross, J. Colloid Sci. 20 (1965) 417-437.
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Positive
from tisph.rheology import _laws


class Parameters(_laws.Inelastic):
    """``time``: 1/shear rate at the onset of thinning; ``index`` of the power law; ``fraction_at_infinity``."""

    type: Literal["cross"] = "cross"
    time: Positive
    index: Annotated[float, Field(ge=0.3, le=1.0)] = 0.7
    fraction_at_infinity: Annotated[float, Field(ge=0, lt=1)] = 0.1


class Law:
    """Viscosity of a Cross fluid, in the unit of ``viscosity``, the viscosity in ``fluid``."""

    def __init__(self, parameters, viscosity, density=1.0):
        self.infinite = parameters.fraction_at_infinity * viscosity
        self.falling = viscosity - self.infinite
        self.time_squared = parameters.time**2
        self.half = 0.5 * parameters.index

    def viscosity(self, shear_rate_squared):
        """Return the viscosity at the square of the shear rate."""
        return self.infinite + self.falling / (1.0 + (self.time_squared * shear_rate_squared) ** self.half)
