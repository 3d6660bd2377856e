"""The base of every parameter model: frozen, strict types, finite numbers, no unknown keys."""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_serializer, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

# Beyond these magnitudes products of a few inputs (a Reynolds number, a time step) leave the range of f64.
SMALLEST, LARGEST = 1e-30, 1e30


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


Whole = Annotated[int, BeforeValidator(_whole)]
"""A whole number, which may be written as 10.0."""

Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
"""A physical quantity that cannot be zero or negative."""

NonNegative = Annotated[float, Field(ge=0, le=LARGEST)]
"""A physical quantity that may be 0, such as a time or a mass."""

Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
"""A physical quantity of either sign, such as a velocity."""

Problem = tuple[str, str] | tuple[str, str, str]
"""Dotted key and text of an error; a second key where its value may be the wrong one instead."""

REFUSED = "refused"
"""Type of the errors with a complete text, which the loader does not change."""


def refusal(text: str) -> PydanticCustomError:
    """Return an error to raise in a validator; ``text`` says which values are allowed."""
    return PydanticCustomError(REFUSED, "{text}", {"text": text})


def refusals(found: list[tuple[Any, ...]]) -> ValidationError:
    """Return one error to raise in a model validator, from (place below the model, text, value) of each error.

    A fourth item is another place that may be wrong: the error names the place that was written last.
    """
    details = []
    for place, text, value, *others in found:
        error = PydanticCustomError(REFUSED, "{text}", {"text": text, "others": others})
        details.append(InitErrorDetails(type=error, loc=place, input=value))
    return ValidationError.from_exception_data("Config", details)


def refuse(found: list[tuple[Any, ...]]) -> None:
    """Raise the ``refusals`` of all errors ``found``, if there are any."""
    if found:
        raise refusals(found)


def findings(model: Any, keys: Iterable[str], text: str) -> list[tuple[Any, ...]]:
    """Return errors for ``refuse`` with this ``text``, for those ``keys`` of a ``model`` that have a value."""
    return [((key,), text, getattr(model, key)) for key in keys if getattr(model, key) not in (None, ())]


class Model(BaseModel):
    """Parameters of a config: a string is no number, NaN and inf are refused.

    Exactly one of ``exclusive_keys`` must have a value; ``null`` counts as not given. ``exclusive_keys`` and
    ``unset_keys`` without a value are left out of the resolved config.
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
