"""Carreau-Yasuda fluid: a viscosity between two plateaus with a power law between them; inelastic.

    viscosity = eta_inf + (eta - eta_inf) (1 + (time * rate)^transition)^((index - 1)/transition)

with rate^2 = 2 D:D = (du/dy)^2 in shear. eta in ``fluid`` is the viscosity at vanishing shear rate, and eta_inf =
fraction_at_infinity * eta; scales such as the Reynolds number are computed with eta. The transition 2 is Carreau's law.
Sources: P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99-127; K. Yasuda, R. C. Armstrong and R. E. Cohen, Rheol. Acta 20
(1981) 163-178.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from tisph.config.base import Positive
from tisph.rheology import _laws


class Parameters(_laws.Inelastic):
    """``time``, lambda: 1/shear rate at the onset of thinning; ``index``, n, of the power law, 0.3 to 1.5.

    ``transition``, Yasuda's a, 1 to 4: sharpness of the onset. ``fraction_at_infinity``, 0 to 1: eta_inf/eta, the
    viscosity at infinite over the viscosity at vanishing shear rate.
    """

    type: Literal["carreau_yasuda"] = "carreau_yasuda"
    time: Positive
    index: Annotated[float, Field(ge=0.3, le=1.5)]
    transition: Annotated[float, Field(ge=1, le=4)] = 2.0
    fraction_at_infinity: Annotated[float, Field(ge=0, le=1)] = 0.0


class Law:
    """Law with the unit of the fluid's ``viscosity``; arithmetic without branches, see ``_laws``."""

    def __init__(self, parameters: Any, viscosity: float, density: float = 1.0) -> None:
        self.infinite = parameters.fraction_at_infinity * viscosity
        self.falling = viscosity - self.infinite
        self.time_squared = parameters.time**2
        self.half = 0.5 * parameters.transition
        self.power = (parameters.index - 1.0) / parameters.transition

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate."""
        return (
            self.infinite + self.falling * (1.0 + (self.time_squared * shear_rate_squared) ** self.half) ** self.power
        )
