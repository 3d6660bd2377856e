"""Several polymers in one solvent, a spectrum of relaxation times: the stresses of the modes add up.

    S = sum of S_k,    each S_k by its own law, of the polymer viscosity fraction_k * eta

with the total viscosity eta at vanishing shear rate in ``fluid``. The shares of all modes and ``solvent_fraction`` add
up to 1. Modes are any of ``oldroyd_b``, ``giesekus``, ``phan_thien_tanner`` and ``fene_p``, also mixed:

    rheology: {type: multi_mode, solvent_fraction: 0.1, modes: [{type: oldroyd_b, relaxation_time: 1.0, fraction: 0.6},
               {type: giesekus, relaxation_time: 0.1, mobility: 0.2, fraction: 0.3}]}

Source: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric Liquids 1 (2nd ed. 1987), chapters 5 and 7.
"""

import math
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from tisph import registry
from tisph.config.base import Model, refusals
from tisph.config.fields import Member, nearest, one_of
from tisph.rheology import _laws

MOST_MODES = 20


class _Share(Model):
    """``fraction``: the mode's share of the total viscosity."""

    fraction: Annotated[float, Field(gt=0, le=1)]

    if TYPE_CHECKING:
        type: str  # a field of the mode

    def __reduce__(self) -> tuple:
        """Return a recipe for another process: the class is made at run time, so that it is in no module."""
        return _with_numbers, (self.type, dict(self))


class _OfMode(Member):
    """A map whose ``type`` names a polymer, with its parameters and its fraction."""

    def model(self, value: object) -> type[Model] | None:
        """Return the parameter model of the mode that the raw map ``value`` names, None if there is none."""
        found = super().model(value)
        mode = found and _mode(found.model_fields["type"].default)
        return mode and _with_share(mode)

    def _refuse(self, value: Any) -> Exception:
        if not isinstance(value, dict):
            return super()._refuse(value)
        choices = [name for name in registry.names("rheology") if _mode(name)]
        return refusals([(("type",), one_of(choices) + nearest(value["type"], choices), value["type"])])


def _mode(name: str) -> type[Model] | None:
    """Return the parameter model of a mode of the rheology ``name``, None if that is not a polymer of one mode."""
    return getattr(registry.load("rheology", name), "Mode", None)


@cache
def _with_share(mode: type[Model]) -> type[Model]:
    return type("Mode", (_Share, mode), {"__doc__": mode.__doc__, "__module__": mode.__module__})


def _with_numbers(name: str, numbers: dict[str, Any]) -> Model:
    return _with_share(_mode(name))(**numbers)


Modes = Annotated[
    tuple[Annotated[Any, _OfMode("rheology", usual="oldroyd_b")], ...],
    Field(strict=False, max_length=MOST_MODES),
]


class Parameters(Model):
    """The solvent's fraction of the total viscosity in ``fluid``, and the ``modes``."""

    carries_stress: ClassVar[bool] = True

    type: Literal["multi_mode"] = "multi_mode"
    solvent_fraction: _laws.SolventFraction
    modes: Modes

    @model_validator(mode="after")
    def _check_sum(self) -> "Parameters":
        if not self.modes:
            raise refusals([(("modes",), "must not be empty", {})])
        total = self.solvent_fraction + math.fsum(mode.fraction for mode in self.modes)
        if abs(total - 1) > 1e-9:  # shares are typed in by hand, as 1/3 may be
            text = f"must add up to 1 with solvent_fraction, but make {total:.10g}"
            raise refusals([(("modes",), f"the fractions {text}", {})])
        return self

    def laws(self, viscosity: float) -> tuple:
        """Return the ``Law`` of each mode; ``viscosity``: total viscosity."""
        return tuple(mode.law(mode.fraction * viscosity) for mode in self.modes)

    @property
    def relaxation_time(self) -> float:
        """Mean relaxation time of the modes, weighted by their fractions [time]."""
        whole = sum(mode.fraction for mode in self.modes)
        return sum(mode.fraction * mode.relaxation_time for mode in self.modes) / whole
