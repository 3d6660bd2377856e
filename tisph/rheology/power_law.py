"""Power-law fluid: a viscosity that falls or grows with a power of the shear rate; inelastic.

    viscosity = eta * ((rate^2 + least_rate^2)/reference_rate^2)^((index - 1)/2),    rate^2 = 2 D:D = (du/dy)^2 in shear

The viscosity eta in ``fluid`` is that at ``reference_rate``, so that the consistency is K = eta * reference_rate^(1 -
index), and the shear stress K rate^index. Below ``least_rate`` the fluid is Newtonian: without that, its viscosity at
rest would be infinite (index < 1) or 0 (index > 1). Scales (Reynolds number, viscous time) go by eta: take as the
reference rate one that is typical of the flow. Source: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of
Polymeric Liquids 1 (2nd ed. 1987), section 4.1.
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.config.base import Positive
from tisph.rheology import _laws


class Parameters(_laws.Inelastic):
    """``index``, 0.3 (thins) to 1.5 (thickens); ``reference_rate`` and ``least_rate`` [1/time]."""

    type: Literal["power_law"] = "power_law"
    index: Annotated[float, Field(ge=0.3, le=1.5)]
    reference_rate: Positive
    least_rate: Positive


class Law:
    """Its viscosity, in the unit of ``viscosity``, that of the fluid; arithmetic as of the laws of polymers."""

    def __init__(self, parameters, viscosity, density=1.0):
        self.scale = viscosity
        self.power = 0.5 * (parameters.index - 1.0)
        self.reference, self.least = parameters.reference_rate**2, parameters.least_rate**2

    def viscosity(self, shear_rate_squared):
        """Viscosity at the square of the shear rate."""
        return self.scale * ((shear_rate_squared + self.least) / self.reference) ** self.power
