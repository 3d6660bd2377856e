"""Power-law fluid: a viscosity that falls or grows with a power of the shear rate; inelastic.

    viscosity = eta * ((rate^2 + least_rate^2)/reference_rate^2)^((index - 1)/2),    rate^2 = 2 D:D = (du/dy)^2 in shear

eta in ``fluid`` is the viscosity at ``reference_rate``, so that the consistency is K = eta * reference_rate^(1 -
index), and the shear stress K rate^index. Below ``least_rate`` the fluid is Newtonian: otherwise its viscosity at rest
would be infinite (index < 1) or 0 (index > 1). Scales (Reynolds number, viscous time) are computed with eta: take a
reference rate that is typical of the flow. Source: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric
Liquids 1 (2nd ed. 1987), section 4.1.
"""

from typing import Annotated, Any, Literal

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
    """Law with the unit of the fluid's ``viscosity``; arithmetic without branches, see ``_laws``."""

    def __init__(self, parameters: Any, viscosity: float, density: float = 1.0) -> None:
        self.scale = viscosity
        self.power = 0.5 * (parameters.index - 1.0)
        self.reference, self.least = parameters.reference_rate**2, parameters.least_rate**2

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate."""
        return self.scale * ((shear_rate_squared + self.least) / self.reference) ** self.power
