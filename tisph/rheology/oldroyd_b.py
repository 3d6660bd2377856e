"""Oldroyd-B liquid: a Newtonian solvent and a polymer stress that relaxes and is carried with the flow.

    S + relaxation_time * (dS/dt - L S - S L^T) = eta_p (L + L^T),    L_ab = du_a/dx_b,

with the polymer's share eta_p = (1 - solvent_fraction) eta of the total dynamic viscosity eta; the solvent's
eta_s = solvent_fraction * eta acts as in a Newtonian liquid (J. G. Oldroyd, Proc. R. Soc. Lond. A 200 (1950)
523-541). S [mass/(length time^2)] is symmetric; d/dt follows a particle.
"""

from typing import Literal

from tisph.rheology import _polymer
from tisph.runtime import scalar, ti


class Mode(_polymer.Mode):
    """Relaxation time [time]."""

    type: Literal["oldroyd_b"] = "oldroyd_b"


class Parameters(Mode):
    """Relaxation time [time], and the solvent's share of the total viscosity that stands in ``fluid``."""

    solvent_fraction: _polymer.SolventFraction


class Law(_polymer.Law):
    """S = modulus * C, the polymer a suspension of linear springs; see ``_polymer.Law``."""

    def relaxation(self, c):
        """-C/relaxation_time."""
        return tuple(-1.0 / self.relaxation_time * c[k] for k in range(3))


@ti.data_oriented
class Stress:
    """The law of the polymer stress that particles carry: (xx, xy, yy) over the reference density."""

    def __init__(self, channel):
        self.relaxation_rate = scalar(1.0 / channel.polymer.relaxation_time)
        self.modulus = scalar(channel.polymer_viscosity / channel.polymer.relaxation_time)

    @ti.func
    def rate(self, stress, gradient):
        """Return dS/dt = L S + S L^T - S/lambda + G (L + L^T) for L = ``gradient``, with G = eta_p/lambda."""
        return self.stretched(stress, gradient) - self.relaxation_rate[None] * stress + self.strained(gradient)

    @ti.func
    def stretched(self, stress, gradient):
        """Return L S + S L^T: stress carried along with the deformation."""
        xx, xy, yy = stress[0], stress[1], stress[2]
        return ti.Vector(
            [
                2.0 * (gradient[0, 0] * xx + gradient[0, 1] * xy),
                gradient[0, 1] * yy + gradient[1, 0] * xx + (gradient[0, 0] + gradient[1, 1]) * xy,
                2.0 * (gradient[1, 0] * xy + gradient[1, 1] * yy),
            ]
        )

    @ti.func
    def strained(self, gradient):
        """Return G (L + L^T): stress that the deformation makes anew."""
        shear = gradient[0, 1] + gradient[1, 0]
        return self.modulus[None] * ti.Vector([2.0 * gradient[0, 0], shear, 2.0 * gradient[1, 1]])
