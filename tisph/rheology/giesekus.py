"""Giesekus fluid: polymers that relax faster the more they are stretched, by a drag that is not the same all around.

    S + relaxation_time * (dS/dt - L S - S L^T) + mobility * relaxation_time/eta_p * S S = eta_p (L + L^T)

with L_ab = du_a/dx_b and eta_p = (1 - solvent_fraction) eta; the solvent adds what a Newtonian fluid of the viscosity
solvent_fraction * eta does, and eta, in ``fluid``, is the viscosity at vanishing shear rate. In the excess C of the
conformation tensor over rest, S = eta_p/relaxation_time * C and relaxation(C) = -(C + mobility C C)/relaxation_time.

Shear thins; both normal stress differences are there, N2/N1 -> -mobility/2 at small rates. With mobility 0 it would be
``oldroyd_b``. Source: H. Giesekus, J. Non-Newtonian Fluid Mech. 11 (1982) 69-109.
"""

from typing import Annotated, Literal

from pydantic import Field

from tisph.rheology import _laws


class Mode(_laws.Mode):
    """Relaxation time [time]; ``mobility``, 0 to 1: how much stretched polymers lose drag (0.5 at most is usual)."""

    type: Literal["giesekus"] = "giesekus"
    mobility: Annotated[float, Field(ge=0, le=1)]


class Parameters(Mode):
    """As ``Mode``, and the solvent's share of the total viscosity that stands in ``fluid``."""

    solvent_fraction: _laws.SolventFraction


class Law(_laws.Law):
    """S = modulus * C; see ``_laws.Law``."""

    def __init__(self, parameters, polymer_viscosity):
        super().__init__(parameters, polymer_viscosity)
        self.mobility = parameters.mobility

    def relaxation(self, c):
        """-(C + mobility C C)/relaxation_time."""
        xx, xy, yy = c[0], c[1], c[2]
        rate, mobility = -1.0 / self.relaxation_time, self.mobility
        return (
            rate * (xx + mobility * (xx * xx + xy * xy)),
            rate * (xy + mobility * (xx + yy) * xy),
            rate * (yy + mobility * (xy * xy + yy * yy)),
            *(rate * (c[k] + mobility * c[k] * c[k]) for k in range(3, self.components)),
        )
