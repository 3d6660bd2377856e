"""FENE-P fluid: polymers are springs that cannot be stretched beyond a length (Peterlin's closure).

    dA/dt = L A + A L^T - (f A - 1)/relaxation_time,    S = eta_p/relaxation_time * (f A - 1)
    f = (L^2 - 3)/(L^2 - tr A),    L^2 = ``maximum_extension``

with the conformation tensor A in three dimensions, A = 1 and f = 1 at rest, L_ab = du_a/dx_b and eta_p =
(1 - solvent_fraction) eta; the solvent is Newtonian with the viscosity solvent_fraction * eta, and eta, in ``fluid``,
is the viscosity at vanishing shear rate. With C = A - 1 and f - 1 = tr C/(L^2 - 3 - tr C), relaxation(C) =
-(f C + (f - 1))/relaxation_time. C_zz, the stretch across the plane of the flow, is also computed.

Shear thins; N2 is 0; the elongational viscosity is finite. With L^2 -> infinity it is ``oldroyd_b``. Sources:
R. B. Bird, P. J. Dotson and N. L. Johnson, J. Non-Newtonian Fluid Mech. 7 (1980) 213-235; L. E. Wedgewood and
R. B. Bird, Ind. Eng. Chem. Res. 27 (1988) 1313-1320.
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from tisph.config.base import LARGEST
from tisph.rheology import _laws


class Mode(_laws.Mode):
    """Relaxation time [time]; ``maximum_extension``: L^2, the largest trace of A, 3 at rest (usual: 10 to 1e4).

    It is the square of the longest over the root mean square length along one axis at rest.
    """

    linear_stress: ClassVar[bool] = False

    type: Literal["fene_p"] = "fene_p"
    maximum_extension: Annotated[float, Field(gt=3, le=LARGEST)]


class Parameters(Mode):
    """As ``Mode``, and the solvent's fraction of the total viscosity in ``fluid``."""

    solvent_fraction: _laws.SolventFraction


class Law(_laws.Law):
    """Components xx, xy, yy and zz; see ``_laws.Law``."""

    components: int = 4

    def __init__(self, parameters: Any, polymer_viscosity: float) -> None:
        super().__init__(parameters, polymer_viscosity)
        self.slack = parameters.maximum_extension - 3.0

    def relaxation(self, c: Any) -> tuple:
        """Return -(f A - 1)/relaxation_time."""
        return tuple(-1.0 / self.relaxation_time * pull for pull in self._pull(c))

    def stress(self, c: Any) -> tuple:
        """Return modulus * (f A - 1)."""
        return tuple(self.modulus * pull for pull in self._pull(c))

    def _pull(self, c: Any) -> tuple:
        """Return f A - 1 = f C + (f - 1)."""
        trace = c[0] + c[2] + c[3]
        more = trace / (self.slack - trace)  # f - 1
        return (c[0] + more * (1.0 + c[0]), c[1] + more * c[1], c[2] + more * (1.0 + c[2]), c[3] + more * (1.0 + c[3]))
