"""What laws share: of polymers the variable that particles carry, and how a flow deforms it; of others a viscosity.

The variable of polymers is the excess C = A - 1 of the conformation tensor A over its value at rest, which is 1. With
L_ab = du_a/dx_b and d/dt along a particle's path every law reads

    dC/dt = L C + C L^T + L + L^T + relaxation(C),    S = stress(C),    relaxation(0) = stress(0) = 0

Components stand in the order xx, xy, yy and, where the law needs it, zz. The functions are arithmetic on components
without branches: NumPy arrays, real or complex, Python floats and Taichi expressions all pass through the same lines.
In a kernel they are called as ``ti.static(law.relaxation((xx, xy, yy)))``, without which Taichi warns of them.

Source: A. N. Beris and B. J. Edwards, Thermodynamics of Flowing Systems (1994), chapter 8.
"""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator

from tisph import registry
from tisph.config.base import Model, Positive, refusal


def _share(value: float) -> float:
    if not 0 < value <= 1:
        raise refusal(
            "must be greater than 0 and at most 1: at 0 (upper-convected Maxwell) what starts at a wall is a front "
            "without thickness, and the momentum equation there divides by the solvent's viscosity; take 0.01 or less, "
            "docs/theory/fluids.md says how such a fluid differs"
        )
    return value


SolventFraction = Annotated[float, AfterValidator(_share)]
"""The solvent's share of the total viscosity that stands in ``fluid``."""


def exp(x):
    """The exponential function of NumPy arrays, numbers and Taichi expressions alike."""
    if isinstance(x, (np.ndarray, np.number, float, complex)):
        return np.exp(x)
    from tisph.runtime import ti  # an expression in a kernel: Taichi is there already

    return ti.exp(x)


class Inelastic(Model):
    """Base of the parameters of inelastic laws, whose viscosity depends on the shear rate."""

    carries_stress: ClassVar[bool] = False

    def law(self, viscosity, density):
        """``Law`` of a fluid with these parameters; ``viscosity`` is that of ``fluid``, over the ``density``."""
        return registry.load("rheology", self.type).Law(self, viscosity, density)


class Mode(Model):
    """Relaxation time [time] of a polymer."""

    carries_stress: ClassVar[bool] = True
    linear_stress: ClassVar[bool] = True
    """Whether the stress is the modulus times C."""

    type: str
    relaxation_time: Positive

    def laws(self, viscosity):
        """Tuple of the one ``Law`` of a fluid whose total viscosity is ``viscosity``."""
        return (self.law((1.0 - self.solvent_fraction) * viscosity),)

    def law(self, polymer_viscosity):
        """``Law`` of this mode."""
        return registry.load("rheology", self.type).Law(self, polymer_viscosity)


class Law:
    """A polymer of modulus ``polymer_viscosity`` / relaxation time.

    Stresses are per unit density where ``polymer_viscosity`` is (kinematic, length^2/time), and mass/(length time^2)
    where it is dynamic.
    """

    components: ClassVar[int] = 3

    def __init__(self, parameters, polymer_viscosity):
        self.relaxation_time = parameters.relaxation_time
        self.polymer_viscosity = polymer_viscosity
        self.modulus = polymer_viscosity / parameters.relaxation_time

    def in_three_dimensions(self):
        """Let the components be xx, xy, yy and zz, whether the law needs the last in planar flow or not."""
        self.components = 4
        return self

    def relaxation(self, c):
        """Tuple of dC/dt by relaxation alone, at the components ``c``."""
        raise NotImplementedError

    def stress(self, c):
        """Tuple of the polymer stress S at the components ``c``: modulus * C."""
        return tuple(self.modulus * c[k] for k in range(self.components))

    def rate_in_shear(self, c, rate):
        """Tuple of dC/dt in simple shear, du/dy = ``rate``: without a gradient along y, C_yy is not stretched."""
        xx, xy, *rest = self.relaxation(c)
        return (2 * rate * c[1] + xx, rate * (1 + c[2]) + xy, *rest)

    def rate(self, c, gradient):
        """Tuple of dC/dt for the components xx, xy, yx, yy of the velocity ``gradient`` L, L_xy = du/dy."""
        lxx, lxy, lyx, lyy = (gradient[k] for k in range(4))
        xx, xy, yy, *rest = self.relaxation(c)
        return (
            2 * (lxx * (1 + c[0]) + lxy * c[1]) + xx,
            lxy * (1 + c[2]) + lyx * (1 + c[0]) + (lxx + lyy) * c[1] + xy,
            2 * (lyx * c[1] + lyy * (1 + c[2])) + yy,
            *rest,
        )
