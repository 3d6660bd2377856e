"""Herschel-Bulkley fluid: it hardly flows below a yield stress, and by a power law above it; regularised, inelastic.

    viscosity = K g^(index - 1) + yield_stress (1 - exp(-m g))/g,    g^2 = rate^2 + (0.001/m)^2

with m = ``regularisation`` and rate^2 = 2 D:D = (du/dy)^2 in shear. The viscosity eta in ``fluid`` belongs to the first
term at ``reference_rate``: K = eta * reference_rate^(1 - index). With index 1 (Bingham) eta is the plastic viscosity,
whatever the reference rate. Scales such as the Reynolds number are computed with eta.

m [time] is Papanastasiou's parameter. Nothing is rigid: where the stress is below the yield stress the fluid creeps
with a viscosity of about yield_stress * m and rates up to some 1/m. A plug is not quite flat, and its edge, where the
stress equals the yield stress, is blurred over rates between 1/m and a few 1/m; the larger m, the flatter the plug and
the sharper its edge. At a rate of 4.6/m the exponential is 1 %. With 0.001/m the viscosity at rest is finite for every
index.

Sources: W. H. Herschel and R. Bulkley, Kolloid-Z. 39 (1926) 291-300; T. C. Papanastasiou, J. Rheol. 31 (1987) 385-404.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tisph.config.base import Positive
from tisph.rheology import _laws


class Parameters(_laws.Inelastic):
    """``yield_stress`` [mass/(length time^2)]; ``index``, 0.3 to 1.5; ``reference_rate`` [1/time].

    ``regularisation``: Papanastasiou's m [time]; 1/m should be well below the rates of the flow.
    """

    type: Literal["herschel_bulkley"] = "herschel_bulkley"
    yield_stress: Positive
    index: Annotated[float, Field(ge=0.3, le=1.5)]
    reference_rate: Positive
    regularisation: Positive


class Law:
    """Law with the unit of the fluid's ``viscosity``, which is dynamic viscosity / ``density``."""

    def __init__(self, parameters: Any, viscosity: float, density: float = 1.0) -> None:
        self.yield_stress = parameters.yield_stress / density
        self.consistency = viscosity * parameters.reference_rate ** (1.0 - parameters.index)
        self.power = 0.5 * (parameters.index - 1.0)
        self.regularisation = parameters.regularisation
        self.least = (1e-3 / parameters.regularisation) ** 2

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate."""
        squared = shear_rate_squared + self.least
        rate = squared**0.5
        yielding = self.yield_stress * (1.0 - _laws.exp(-self.regularisation * rate)) / rate
        return self.consistency * squared**self.power + yielding
