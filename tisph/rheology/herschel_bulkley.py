"""Herschel-Bulkley fluid: it hardly flows below a yield stress, and by a power law above it; regularised, inelastic.

    viscosity = K g^(index - 1) + yield_stress (1 - exp(-m g))/g,    g^2 = rate^2 + (0.001/m)^2

with m = ``regularisation`` and rate^2 = 2 D:D = (du/dy)^2 in shear. The viscosity eta in ``fluid`` is that of the
flowing part at ``reference_rate``, without the yield stress: K = eta * reference_rate^(1 - index), so that with index 1
(Bingham) it is the plastic viscosity and the reference rate is of no account. Scales go by eta.

m [time] is Papanastasiou's parameter. Nothing is rigid: where the stress is below the yield stress the fluid creeps,
as one of a viscosity of about yield_stress * m, with rates up to some 1/m. A plug is not quite flat, and its edge,
where the stress passes the yield stress, is blurred by the rates between 1/m and a few times that; the larger m, the
flatter and the sharper. The exponential leaves 1 % of the yield stress out at a rate of 4.6/m. The 0.001/m keeps
the viscosity finite at rest for every index.

Sources: W. H. Herschel and R. Bulkley, Kolloid-Z. 39 (1926) 291-300; T. C. Papanastasiou, J. Rheol. 31 (1987) 385-404.
"""

from typing import Annotated, Literal

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
    """Its viscosity, in the unit of ``viscosity``, that of the fluid; ``density`` 1 where that is a dynamic one."""

    def __init__(self, parameters, viscosity, density=1.0):
        self.yield_stress = parameters.yield_stress / density
        self.consistency = viscosity * parameters.reference_rate ** (1.0 - parameters.index)
        self.power = 0.5 * (parameters.index - 1.0)
        self.regularisation = parameters.regularisation
        self.least = (1e-3 / parameters.regularisation) ** 2

    def viscosity(self, shear_rate_squared):
        """Viscosity at the square of the shear rate."""
        squared = shear_rate_squared + self.least
        rate = squared**0.5
        yielding = self.yield_stress * (1.0 - _laws.exp(-self.regularisation * rate)) / rate
        return self.consistency * squared**self.power + yielding
