"""Base classes of laws: the conformation tensor of polymers and its deformation by the flow, or a viscosity.

Particles of a polymer solution carry the excess C = A - 1 of the conformation tensor A over its value 1 at rest. With
L_ab = du_a/dx_b and d/dt along a particle's path every law is

    dC/dt = L C + C L^T + L + L^T + relaxation(C),    S = stress(C),    relaxation(0) = stress(0) = 0

The order of components is xx, xy, yy and, where the law needs it, zz. The functions are arithmetic on components
without branches: NumPy arrays, real or complex, Python floats and Taichi expressions all use the same lines. Kernels
call them as ``ti.static(law.relaxation((xx, xy, yy)))``, since Taichi warns of other calls.

Source: A. N. Beris and B. J. Edwards, Thermodynamics of Flowing Systems (1994), chapter 8.
"""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import AfterValidator

from tisph import registry
from tisph.config.base import Model, Positive, refusal


def _share(value: float) -> float:
    if not 0 < value <= 1:
        raise refusal(
            "must be greater than 0 and at most 1: at 0 (upper-convected Maxwell) a started wall sends out a front "
            "without thickness, and the momentum equation there divides by the solvent's viscosity; take 0.01 or less, "
            "docs/theory/fluids.md says how such a fluid differs"
        )
    return value


SolventFraction = Annotated[float, AfterValidator(_share)]
"""The solvent's fraction of the total viscosity in ``fluid``."""


def exp(x: Any) -> Any:
    """Return the exponential of a NumPy array, a number or a Taichi expression."""
    if isinstance(x, (np.ndarray, np.number, float, complex)):
        return np.exp(x)
    from tisph.runtime import ti  # an expression in a kernel: Taichi is loaded already

    return ti.exp(x)


class Inelastic(Model):
    """Base of the parameters of inelastic laws, whose viscosity depends on the shear rate."""

    carries_stress: ClassVar[bool] = False

    type: str

    def law(self, viscosity: float, density: float) -> Any:
        """Return the ``Law``; ``viscosity``: the viscosity in ``fluid`` divided by the ``density``."""
        return registry.load("rheology", self.type).Law(self, viscosity, density)


class Mode(Model):
    """Relaxation time [time] of a polymer."""

    carries_stress: ClassVar[bool] = True
    linear_stress: ClassVar[bool] = True
    """Whether the stress is the modulus times C."""

    type: str
    relaxation_time: Positive

    if TYPE_CHECKING:
        solvent_fraction: float  # a field of the ``Parameters`` of each law

    def laws(self, viscosity: float) -> tuple:
        """Return the tuple of the one ``Law`` of a fluid with the total ``viscosity``."""
        return (self.law((1.0 - self.solvent_fraction) * viscosity),)

    def law(self, polymer_viscosity: float) -> Any:
        """Return the ``Law`` of this mode."""
        return registry.load("rheology", self.type).Law(self, polymer_viscosity)


class Law:
    """A polymer of modulus ``polymer_viscosity`` / relaxation time.

    Stresses are per unit density if ``polymer_viscosity`` is kinematic [length^2/time], and in mass/(length time^2) if
    it is dynamic. ``c``: tuple of the components of C, each an array, a number or a Taichi expression.
    """

    components: int = 3

    def __init__(self, parameters: Any, polymer_viscosity: float) -> None:
        self.relaxation_time = parameters.relaxation_time
        self.polymer_viscosity = polymer_viscosity
        self.modulus = polymer_viscosity / parameters.relaxation_time

    def in_three_dimensions(self) -> "Law":
        """Set the components to xx, xy, yy and zz, even if the law does not need zz in planar flow; return self."""
        self.components = 4
        return self

    def relaxation(self, c: Any) -> tuple:
        """Return the components of dC/dt by relaxation alone, at the components ``c``."""
        raise NotImplementedError

    def stress(self, c: Any) -> tuple:
        """Return the components of the polymer stress S at the components ``c``: modulus * C."""
        return tuple(self.modulus * c[k] for k in range(self.components))

    def rate_in_shear(self, c: Any, rate: Any) -> tuple:
        """Return the components of dC/dt in simple shear, du/dy = ``rate``; C_yy changes by relaxation only."""
        xx, xy, *rest = self.relaxation(c)
        return (2 * rate * c[1] + xx, rate * (1 + c[2]) + xy, *rest)

    def rate(self, c: Any, gradient: Any) -> tuple:
        """Return the components of dC/dt for the velocity ``gradient`` L: xx, xy, yx, yy, L_xy = du/dy."""
        lxx, lxy, lyx, lyy = (gradient[k] for k in range(4))
        xx, xy, yy, *rest = self.relaxation(c)
        return (
            2 * (lxx * (1 + c[0]) + lxy * c[1]) + xx,
            lxy * (1 + c[2]) + lyx * (1 + c[0]) + (lxx + lyy) * c[1] + xy,
            2 * (lyx * c[1] + lyy * (1 + c[2])) + yy,
            *rest,
        )
