"""Giesekus fluid: polymers with an anisotropic drag, which relax faster the more they are stretched.

    S + relaxation_time * (dS/dt - L S - S L^T) + mobility * relaxation_time/eta_p * S S = eta_p (L + L^T)

with L_ab = du_a/dx_b and eta_p = (1 - solvent_fraction) eta; the solvent is Newtonian with the viscosity
solvent_fraction * eta, and eta, in ``fluid``, is the viscosity at vanishing shear rate. In the excess C of the
conformation tensor over rest, S = eta_p/relaxation_time * C and relaxation(C) = -(C + mobility C C)/relaxation_time.

The fluid is shear-thinning and has both normal stress differences, N2/N1 -> -mobility/2 at small rates. With mobility 0
it is ``oldroyd_b``. Source: H. Giesekus, J. Non-Newtonian Fluid Mech. 11 (1982) 69-109.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tisph.rheology import _laws


class Mode(_laws.Mode):
    """Relaxation time [time]; ``mobility``, 0 to 1 (usual: up to 0.5): anisotropy of the drag on stretched polymers."""

    type: Literal["giesekus"] = "giesekus"
    mobility: Annotated[float, Field(ge=0, le=1)]


class Parameters(Mode):
    """As ``Mode``, and the solvent's fraction of the total viscosity in ``fluid``."""

    solvent_fraction: _laws.SolventFraction


class Law(_laws.Law):
    """S = modulus * C; see ``_laws.Law``."""

    def __init__(self, parameters: Any, polymer_viscosity: float) -> None:
        super().__init__(parameters, polymer_viscosity)
        self.mobility = parameters.mobility

    def relaxation(self, c: Any) -> tuple:
        """Return -(C + mobility C C)/relaxation_time."""
        xx, xy, yy = c[0], c[1], c[2]
        rate, mobility = -1.0 / self.relaxation_time, self.mobility
        return (
            rate * (xx + mobility * (xx * xx + xy * xy)),
            rate * (xy + mobility * (xx + yy) * xy),
            rate * (yy + mobility * (xy * xy + yy * yy)),
            *(rate * (c[k] + mobility * c[k] * c[k]) for k in range(3, self.components)),
        )
