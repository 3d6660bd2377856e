"""Phan-Thien-Tanner fluid: a network of polymers that is destroyed faster the more it is stretched.

    Y S + relaxation_time * (dS/dt - L S - S L^T) = eta_p (L + L^T),    z = extensibility * relaxation_time/eta_p * tr S
    Y = 1 + z (form ``linear``)  or  exp(z) (``exponential``)

with L_ab = du_a/dx_b and eta_p = (1 - solvent_fraction) eta; the solvent is Newtonian with the viscosity
solvent_fraction * eta, and eta, in ``fluid``, is the viscosity at vanishing shear rate. The network is affine: it does
not slip relative to the flow. In the excess C of the conformation tensor over rest, S = eta_p/relaxation_time * C and
relaxation(C) = -Y C/relaxation_time with z = extensibility * tr C.

The fluid is shear-thinning; N2 is 0; the elongational viscosity is bounded (linear: it levels off; exponential: it has
a maximum). With extensibility 0 it is ``oldroyd_b``. Sources: N. Phan-Thien and R. I. Tanner, J. Non-Newtonian Fluid
Mech. 2 (1977) 353-365 (linear); N. Phan-Thien, J. Rheol. 22 (1978) 259-283 (exponential).
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tisph.rheology import _laws


class Mode(_laws.Mode):
    """Relaxation time [time]; ``extensibility``, 0 to 1 (usual: 0.01 to 0.25); ``form`` of Y, linear by default."""

    type: Literal["phan_thien_tanner"] = "phan_thien_tanner"
    extensibility: Annotated[float, Field(ge=0, le=1)]
    form: Literal["linear", "exponential"] = "linear"


class Parameters(Mode):
    """As ``Mode``, and the solvent's fraction of the total viscosity in ``fluid``."""

    solvent_fraction: _laws.SolventFraction


class Law(_laws.Law):
    """S = modulus * C; see ``_laws.Law``."""

    def __init__(self, parameters: Any, polymer_viscosity: float) -> None:
        super().__init__(parameters, polymer_viscosity)
        self.extensibility = parameters.extensibility
        self.destruction = {"linear": _linear, "exponential": _laws.exp}[parameters.form]

    def relaxation(self, c: Any) -> tuple:
        """Return -Y C/relaxation_time."""
        trace = c[0] + c[2]
        for k in range(3, self.components):
            trace = trace + c[k]
        rate = -1.0 / self.relaxation_time * self.destruction(self.extensibility * trace)
        return tuple(rate * c[k] for k in range(self.components))


def _linear(z: Any) -> Any:
    return 1.0 + z
