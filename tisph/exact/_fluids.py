"""Fluids of ``start_up``: shear stress of the solvent, or of an inelastic fluid, and laws of the polymer's modes."""

from dataclasses import dataclass
from typing import Any, ClassVar


@dataclass(frozen=True)
class ViscoelasticFluid:
    """Kinematic viscosity of the solvent (> 0, else ValueError) and ``laws`` of the polymer's modes, over density.

    Without any it is a Newtonian fluid.

    ``tolerance`` of a step in time and its ``stages``: with 7 there are twice as many steps, in 1.5 times the time.
    """

    subtracts_layer: ClassVar[bool] = True
    tolerance: ClassVar[float] = 1e-9
    stages: ClassVar[int] = 9

    solvent_viscosity: float
    laws: tuple[Any, ...]

    def __post_init__(self):
        if not self.solvent_viscosity > 0:
            raise ValueError(f"solvent_viscosity must be above 0, not {self.solvent_viscosity}")

    @property
    def longest_time(self):
        """The longest relaxation time."""
        return max((law.relaxation_time for law in self.laws), default=0.0)

    @property
    def total_viscosity(self):
        """Kinematic viscosity at vanishing shear rate."""
        return self.solvent_viscosity + sum(law.polymer_viscosity for law in self.laws)

    def flux(self, rate):
        """The solvent's shear stress."""
        return self.solvent_viscosity * rate

    layer_flux = flux
    """That of the part of the shear rate which has inertia of its own."""


@dataclass(frozen=True)
class InelasticFluid:
    """Generalised Newtonian: ``law.viscosity(shear_rate_squared)``, kinematic; ``total_viscosity``, typical of it.

    ``tolerance`` of a step in time: at a jump the front passes point by point, and 1e-10 takes twice the time, while
    the elements leave 5e-8. More ``stages`` make steps longer, but Newton's method slower. ``subtracts_layer``: whether
    a jump of a wall is left to a closed form.
    """

    subtracts_layer: ClassVar[bool] = False
    tolerance: ClassVar[float] = 1e-8
    stages: ClassVar[int] = 5

    law: Any
    total_viscosity: float
    laws: tuple[Any, ...] = ()
    longest_time: float = 0.0

    def flux(self, rate):
        """Shear stress."""
        return self.law.viscosity(rate * rate) * rate

    def layer_flux(self, rate):
        """Nothing: the whole flow is solved for."""
        return 0.0 * rate


def fluid_of(rheology, kinematic_viscosity, density):
    """The fluid with the parameters ``rheology``, None of a Newtonian one."""
    if rheology is None:
        return ViscoelasticFluid(kinematic_viscosity, ())
    if rheology.carries_stress:
        return ViscoelasticFluid(rheology.solvent_fraction * kinematic_viscosity, rheology.laws(kinematic_viscosity))
    return InelasticFluid(rheology.law(kinematic_viscosity, density), kinematic_viscosity)
