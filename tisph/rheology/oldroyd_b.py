"""Oldroyd-B fluid: a Newtonian solvent and a polymer stress that relaxes and is carried with the flow.

    S + relaxation_time * (dS/dt - L S - S L^T) = eta_p (L + L^T),    L_ab = du_a/dx_b,

with the polymer's share eta_p = (1 - solvent_fraction) eta of the total dynamic viscosity eta; the solvent's
eta_s = solvent_fraction * eta acts as in a Newtonian fluid (J. G. Oldroyd, Proc. R. Soc. Lond. A 200 (1950)
523-541). S [mass/(length time^2)] is symmetric; d/dt follows a particle.
"""

from typing import Any, Literal

from tisph.rheology import _laws


class Mode(_laws.Mode):
    """Relaxation time [time]."""

    type: Literal["oldroyd_b"] = "oldroyd_b"


class Parameters(Mode):
    """Relaxation time [time], and the solvent's fraction of the total viscosity in ``fluid``."""

    solvent_fraction: _laws.SolventFraction


class Law(_laws.Law):
    """S = modulus * C, the polymer a suspension of linear springs; see ``_laws.Law``."""

    def relaxation(self, c: Any) -> tuple:
        """Return -C/relaxation_time."""
        return tuple(-1.0 / self.relaxation_time * c[k] for k in range(self.components))
