"""The type of a value in a config that may vary in space and time: a number, or a formula."""

from typing import Annotated, Any

from pydantic import AfterValidator

from tisph.config.base import Signed, refusal
from tisph.config.fields import either
from tisph.formula import LONGEST, OF_PLACES, FormulaError, compiled


def _formula(allowed: str) -> Any:
    """Return the type of the text of a formula; ``allowed``: its description in messages."""

    def check(text: str) -> str:
        words = f"a number, or {allowed} with the functions {', '.join(OF_PLACES)}"
        if len(text) > LONGEST:
            raise refusal(f"must be {words}, of at most {LONGEST} characters")
        try:
            _, names = compiled(text, tuple(OF_PLACES))
        except FormulaError:
            raise refusal(f"must be {words}") from None
        if not names <= {"x", "y", "t"}:
            raise refusal(f"must be {words}; {', '.join(sorted(names - {'x', 'y', 't'}))} has no value")
        return text

    return Annotated[str, AfterValidator(check)]


OF_PLACE_AND_TIME = "a formula of x, y and t"
FieldValue = either(Signed, _formula(OF_PLACE_AND_TIME), lambda value: isinstance(value, str), OF_PLACE_AND_TIME)
"""A value that may vary: a number, or a formula of x, y and t as a text."""
