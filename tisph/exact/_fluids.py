"""Fluids of the reference solutions: laws of stress, inelastic fluids, and polymer solutions; protocols of rheologies.

All stresses and viscosities are per unit density.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

STEP = 1e-30
"""Complex step: there is no difference whose digits could cancel, so that it may be arbitrarily small."""


def derivative(function: Any, x: Any) -> Any:
    """Return the derivative of a real-analytic ``function`` of one variable at ``x``, exact to round-off."""
    return np.imag(function(x + 1j * STEP)) / STEP


class ViscosityLaw(Protocol):
    """Law of an inelastic fluid; the result has the unit of the viscosity that the law was made with."""

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate [1/time^2]."""


class PolymerLaw(Protocol):
    """Law of one polymer mode: evolution of C, the excess of its conformation tensor over rest, and its stress S.

    ``c``: components xx, xy, yy and, where the law needs it, zz, each an array, a number or a Taichi expression.
    ``rate``: shear rate du/dy of the same shape. Stresses have the unit of ``polymer_viscosity`` / time.
    """

    components: int
    relaxation_time: float
    polymer_viscosity: float
    modulus: float

    def stress(self, c: Any) -> tuple:
        """Return the components of S."""

    def rate_in_shear(self, c: Any, rate: Any) -> tuple:
        """Return the components of dC/dt in simple shear."""


class Rheology(Protocol):
    """Parameters of a non-Newtonian fluid, by a config (``tisph/rheology``).

    ``carries_stress``: whether the fluid is a polymer solution. Only a polymer solution has ``relaxation_time`` [time]
    of the first mode (mean of several modes), ``solvent_fraction`` of the total viscosity, and ``laws``; only an
    inelastic fluid has ``law``. Laws have the unit of the viscosity that they are made with.
    """

    type: str
    carries_stress: bool
    relaxation_time: float
    solvent_fraction: float

    def __hash__(self) -> int:
        """Return a hash: solutions are cached by the parameters."""

    def laws(self, viscosity: float) -> tuple[PolymerLaw, ...]:
        """Return the law of each polymer mode of a fluid with this total ``viscosity``."""

    def law(self, viscosity: float, density: float) -> ViscosityLaw:
        """Return the law of an inelastic fluid of this ``viscosity``, which is dynamic viscosity / ``density``."""


@dataclass(frozen=True)
class ViscoelasticFluid:
    """Kinematic viscosity of the solvent (> 0, else ValueError) and ``laws`` of the polymer's modes per unit density.

    Without laws it is a Newtonian fluid.

    ``tolerance`` and ``stages`` of a step in time: 7 stages need twice as many steps and 1.5 times the computing time.
    """

    subtracts_layer: ClassVar[bool] = True
    tolerance: ClassVar[float] = 1e-9
    stages: ClassVar[int] = 9

    solvent_viscosity: float
    laws: tuple[PolymerLaw, ...]

    def __post_init__(self) -> None:
        if not self.solvent_viscosity > 0:
            raise ValueError(f"solvent_viscosity must be above 0, not {self.solvent_viscosity}")

    @property
    def longest_time(self) -> float:
        """The longest relaxation time."""
        return max((law.relaxation_time for law in self.laws), default=0.0)

    @property
    def total_viscosity(self) -> float:
        """Kinematic viscosity at vanishing shear rate."""
        return self.solvent_viscosity + sum(law.polymer_viscosity for law in self.laws)

    def flux(self, rate: Any) -> Any:
        """Return the solvent's shear stress at a shear ``rate``."""
        return self.solvent_viscosity * rate

    layer_flux = flux
    """Shear stress of the analytic layer, whose own inertia balances it."""


@dataclass(frozen=True)
class InelasticFluid:
    """Generalised Newtonian fluid of the kinematic viscosity ``law``; ``total_viscosity``: a typical viscosity.

    ``tolerance`` of a step in time: at a jump the front passes point by point; 1e-10 takes twice the time, while
    the error of the elements is 5e-8. More ``stages`` make steps longer, but Newton's method slower.
    ``subtracts_layer``: whether a closed form is used for a jump of a wall.
    """

    subtracts_layer: ClassVar[bool] = False
    tolerance: ClassVar[float] = 1e-8
    stages: ClassVar[int] = 5

    law: ViscosityLaw
    total_viscosity: float
    laws: tuple[PolymerLaw, ...] = ()
    longest_time: float = 0.0

    def flux(self, rate: Any) -> Any:
        """Return the shear stress at a shear ``rate``."""
        return self.law.viscosity(rate * rate) * rate

    def layer_flux(self, rate: Any) -> Any:
        """Return 0: no analytic layer is subtracted."""
        return 0.0 * rate


Fluid = ViscoelasticFluid | InelasticFluid


def fluid_of(rheology: Rheology | None, kinematic_viscosity: float, density: float) -> Fluid:
    """Return the fluid with the parameters ``rheology``, None for a Newtonian one."""
    if rheology is None:
        return ViscoelasticFluid(kinematic_viscosity, ())
    if rheology.carries_stress:
        return ViscoelasticFluid(rheology.solvent_fraction * kinematic_viscosity, rheology.laws(kinematic_viscosity))
    return InelasticFluid(rheology.law(kinematic_viscosity, density), kinematic_viscosity)
