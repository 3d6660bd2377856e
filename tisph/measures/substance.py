"""Temperature and dissolved substances of a flow: their equation, conditions at walls, and effects on the fluid."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.formula import FieldFormula

TEMPERATURE = "temperature"
"""Name of the temperature among the substances."""


@dataclass(frozen=True)
class Condition:
    """Condition at a wall: the ``value`` there, or the ``flux`` per area and time into the fluid."""

    value: FieldFormula | None = None
    flux: FieldFormula | None = None


@dataclass(frozen=True, kw_only=True)
class Substance:
    """A quantity T by its ``name`` that particles carry: DT/Dt = ``diffusivity`` * Laplacian of T + ``source``.

    * ``capacity``: amount in a volume per T, density * heat capacity of heat and 1 of a dissolved substance, so that
      the flux through a wall is -capacity * diffusivity * dT/dn.
    * ``initial``, ``source`` and ``inlet``, the value of fluid that enters: functions of x, y and time.
    * ``conditions``: of each of the ``bodies`` of the flow, ``Condition(flux=0)`` where a wall lets nothing through.
      A channel has those of the bottom and the top wall.
    * ``scale``: size of its differences, which errors of steps refer to.
    * ``jumps``: numbers of the walls and bodies at which the given value differs from the initial one.
    * ``heating``: rise of T by a power of the stresses of 1 per mass, 0 without viscous heating.
    * ``expansion``: body force -``expansion`` * (T - ``reference``) * ``gravity``; 0 without an effect.
    * ``law``: factor of viscosity and relaxation times (``config/heat.py``); None without an effect.
    """

    name: str
    unit: str
    diffusivity: float
    capacity: float
    initial: FieldFormula
    source: FieldFormula
    inlet: FieldFormula
    conditions: tuple[Condition, ...]
    scale: float
    jumps: tuple[int, ...] = ()
    heating: float = 0.0
    reference: float = 0.0
    expansion: float = 0.0
    gravity: tuple[float, float] = (0.0, 0.0)
    law: Any = None

    @property
    def buoyancy(self) -> np.ndarray:
        """Acceleration (2,) of the fluid per T above the reference."""
        return -self.expansion * np.array(self.gravity)

    @property
    def words(self) -> str:
        """Name in texts."""
        return self.name.replace("_", " ")

    @property
    def sensitivity(self) -> float:
        """Change of the logarithm of the factor of viscosity with T, at the reference."""
        step = 1e-5 * (abs(self.reference) or self.scale)
        exponents = [float(self.law.exponent(self.reference + side * step, self.reference)) for side in (-1.0, 1.0)]
        return (exponents[1] - exponents[0]) / (2.0 * step)

    @property
    def has_source(self) -> bool:
        """Whether the config gives a source."""
        return self.source.given != 0.0

    def factor(self, values: np.ndarray) -> np.ndarray:
        """Return the factor of viscosity and relaxation times at these ``values`` of T, 1 without a law."""
        if self.law is None:
            return np.ones_like(values)
        return np.exp(self.law.exponent(values, self.reference))
