"""The base of every parameter model: frozen, strict types, finite numbers, no unknown keys."""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_serializer, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

# Beyond these magnitudes products of a few inputs (a Reynolds number, a time step) leave the range of f64.
SMALLEST, LARGEST = 1e-30, 1e30

Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
"""A physical quantity that cannot be zero or negative."""

NonNegative = Annotated[float, Field(ge=0, le=LARGEST)]
"""A physical quantity that may be 0, such as a time or a mass."""

Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
"""A physical quantity of either sign, such as a velocity."""

Problem = tuple[str, str] | tuple[str, str, str]
"""Dotted key and what is wrong with its value; a second key where it is as much the other one's fault."""

REFUSED = "refused"
"""Type of the errors whose text is complete: the loader shows it as it stands."""


def refusal(text: str) -> PydanticCustomError:
    """An error to raise in a validator, saying in ``text`` what is allowed."""
    return PydanticCustomError(REFUSED, "{text}", {"text": text})


def refusals(found: list[tuple[Any, ...]]) -> ValidationError:
    """One error to raise in a model validator, from (place below the model, text, value) of each finding.

    A fourth item is another place that may be to blame: of the two, the one that was written last.
    """
    details = []
    for place, text, value, *others in found:
        error = PydanticCustomError(REFUSED, "{text}", {"text": text, "others": others})
        details.append(InitErrorDetails(type=error, loc=place, input=value))
    return ValidationError.from_exception_data("Config", details)


def refuse(found: list[tuple[Any, ...]]) -> None:
    """Raise the ``refusals`` of what is ``found``, if there is any."""
    if found:
        raise refusals(found)


def findings(model: Any, keys: Iterable[str], text: str) -> list[tuple[Any, ...]]:
    """What ``refuse`` takes, with this ``text``, of those of the ``keys`` of a ``model`` that have a value."""
    return [((key,), text, getattr(model, key)) for key in keys if getattr(model, key) not in (None, ())]


class Model(BaseModel):
    """Parameters as they stand in a config: a string is no number, NaN and inf are refused.

    Of the keys in ``exclusive_keys`` exactly one must have a value; ``null`` counts as not given. These and the
    ``unset_keys`` are left out of the resolved config where they have no value.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    exclusive_keys: ClassVar[tuple[str, ...]] = ()
    unset_keys: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _check_exclusive_keys(self) -> "Model":
        given = [key for key in self.exclusive_keys if getattr(self, key) is not None]
        rule = f"give exactly one of {', '.join(self.exclusive_keys)}"
        if self.exclusive_keys and not given:
            raise refusals([((), f"{rule}: none is given", {})])
        if len(given) > 1:
            text = f"{rule}: {' and '.join(given)} are given (null unsets)"
            raise refusals([((given[-1],), text, getattr(self, given[-1]))])
        return self

    @model_serializer(mode="wrap")
    def _leave_out_unused_keys(self, handler: Any) -> dict[str, Any]:
        unused = [key for key in (*self.exclusive_keys, *self.unset_keys) if getattr(self, key) in (None, ())]
        return {key: value for key, value in handler(self).items() if key not in unused}
