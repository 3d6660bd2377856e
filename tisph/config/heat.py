"""Sections ``temperature`` and ``scalars``: quantities that the fluid carries, and that diffuse in it.

The equations are in docs/theory/heat.md. Walls and bodies without a condition let nothing through.
"""

import math
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from tisph.config.base import Model, Positive, Signed
from tisph.config.fields import either
from tisph.config.formula import FieldValue
from tisph.config.sections import Label, text_type
from tisph.formula import names_in

LARGEST_EXPONENT = 300.0
"""Largest exponent of a factor of the viscosity: beyond it the factor leaves the range of numbers."""


class Flux(Model):
    """Amount that flows from a wall into the fluid, per area and time: heat, or dissolved substance."""

    flux: FieldValue


Condition = either(FieldValue, Flux, lambda value: isinstance(value, dict | Flux), "a map such as {flux: 0}")
"""Condition at a wall: the value there, or the flux."""

Conditions = Annotated[dict[str, Condition], Field(max_length=100)]


class Carried(Model):
    """A quantity T that moves with the fluid: DT/Dt = diffusivity * Laplacian of T + source.

    ``initial``, ``source`` and conditions are numbers, or formulas of x, y and the time t. ``walls``: the condition at
    each wall by its name, ``bodies``: of all bodies, or of each one. ``inlet``: value of the fluid that enters, else
    that at the start.
    """

    unset_keys: ClassVar[tuple[str, ...]] = ("walls", "bodies", "inlet")

    initial: FieldValue = 0.0
    source: FieldValue = 0.0
    walls: Conditions = Field(default_factory=dict)
    bodies: Annotated[tuple[Condition, ...], Field(strict=False, max_length=100)] = ()
    inlet: FieldValue | None = None

    @property
    def varies_along(self) -> bool:
        """Whether an initial value, a source or a condition depends on x."""
        values: tuple[Any, ...] = (self.initial, self.source, self.inlet, *self.walls.values(), *self.bodies)
        formulas = (getattr(value, "flux", value) for value in values)
        return any(isinstance(each, str) and "x" in names_in(each) for each in formulas)


class Scalar(Carried):
    """A dissolved substance, which has no effect on the flow, by its ``name`` in results."""

    name: text_type(r"[a-z][a-z0-9_]{0,31}", "a name: 1 to 32 small letters, digits or _ that begin with a letter")
    diffusivity: Positive


class Exponential(Model):
    """Viscosity and relaxation times are exp(-coefficient (T - reference)) times their values at the reference."""

    type: Literal["exponential"] = "exponential"
    coefficient: Signed

    def exponent(self, temperature: Any, reference: float) -> Any:
        """Return the logarithm of the factor at a ``temperature``."""
        return -self.coefficient * (temperature - reference)


class Arrhenius(Model):
    """The factor is exp(activation_temperature (1/T - 1/reference)), with absolute temperatures."""

    type: Literal["arrhenius"]
    activation_temperature: Signed

    def exponent(self, temperature: Any, reference: float) -> Any:
        """Return the logarithm of the factor at a ``temperature``; NaN where it is not absolute."""
        return self.activation_temperature * (1.0 / np.where(temperature > 0.0, temperature, np.nan) - 1.0 / reference)


class Wlf(Model):
    """The factor is 10^(-c1 (T - reference)/(c2 + T - reference)).

    Source: M. L. Williams, R. F. Landel, J. D. Ferry, J. Am. Chem. Soc. 77 (1955) 3701-3707.
    """

    type: Literal["wlf"]
    c1: Positive
    c2: Positive

    def exponent(self, temperature: Any, reference: float) -> Any:
        """Return the logarithm of the factor at a ``temperature``; NaN at the one where it is infinite, and below."""
        above = self.c2 + temperature - reference
        return -math.log(10.0) * self.c1 * (temperature - reference) / np.where(above > 0.0, above, np.nan)


LAWS = {"exponential": Exponential, "arrhenius": Arrhenius, "wlf": Wlf}


def _tag(law: Any) -> str:
    return f"<{law.get('type') if isinstance(law, dict) else getattr(law, 'type', law)}>"


ThermalLaw = Annotated[
    Annotated[Exponential, Tag("<exponential>")]
    | Annotated[Arrhenius, Tag("<arrhenius>")]
    | Annotated[Wlf, Tag("<wlf>")],
    Discriminator(_tag, "unknown_law", f"must be a map with a type: {', '.join(LAWS)}"),
]


class Temperature(Carried):
    """Temperature: rho c DT/Dt = div(k grad T) + viscous heating + rho c source.

    ``conductivity`` k [mass length/(time^3 temperature)] and ``heat_capacity`` c per mass
    [length^2/(time^2 temperature)]. With ``viscous_heating`` the power of the stresses heats the fluid. A fluid of
    thermal ``expansion`` beta [1/temperature] in ``gravity`` has the body force -beta (T - reference) gravity.
    ``viscosity``: factor of viscosity and relaxation times, 1 at the ``reference``. ``unit``: label of the unit.
    """

    unset_keys: ClassVar[tuple[str, ...]] = (*Carried.unset_keys, "gravity", "viscosity")

    conductivity: Positive
    heat_capacity: Positive
    viscous_heating: bool = False
    reference: Signed = 0.0
    expansion: Signed = 0.0
    gravity: Annotated[tuple[Signed, Signed], Field(strict=False)] | None = None
    viscosity: ThermalLaw | None = None
    unit: Label = "K"
