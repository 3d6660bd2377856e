"""Validation errors as the lines that a user reads: key, value, what is allowed, nearest valid key."""

import json
import re
from collections.abc import Callable, Iterator
from functools import reduce
from operator import getitem
from typing import Any, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from tisph.config.base import REFUSED, SMALLEST, Model
from tisph.config.fields import OTHER_TAG, USUAL_TAG_START, Member, nearest
from tisph.config.schema import Config, model_of
from tisph.config.yaml_text import KeyPath, in_one_line

TEXTS = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "finite_number": "must be a finite number",
    "string_type": "must be text (in quotes where it looks like a number)",
    "tuple_type": "must be a list such as [1.0, 2.0]",
    "model_type": "must be a map of keys",
    "missing": "is missing",
    "too_short": "must not be empty",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "multiple_of": "must be a multiple of {multiple_of:g}",
    "too_long": "must have at most {max_length} items",
    "literal_error": "must be {expected}",
}
"""What is allowed, by pydantic's type of error; a type that is not here keeps pydantic's own words."""


def describe(error: ValidationError, data: Any, written: Callable[[KeyPath], int]) -> list[tuple[KeyPath, str]]:
    """Place and message of every error of a failed validation of the raw ``data``.

    ``written(place)`` orders places by when they were written, of several that may be to blame.
    """
    return [_describe(_blame_last(details, data, written), data) for details in error.errors(include_url=False)]


def _blame_last(details: Any, data: Any, written: Callable[[KeyPath], int]) -> Any:
    for place in details.get("ctx", {}).get("others", ()):
        if written(place) > written(details["loc"]):
            return {**details, "loc": place, "input": reduce(getitem, place, data)}
    return details


def show(value: object) -> str:
    """A value as it could stand in a YAML file, cut where it is long."""
    return in_one_line(json.dumps(value, default=str, ensure_ascii=False))


def _describe(details: Any, data: Any) -> tuple[KeyPath, str]:
    whole = details["loc"]
    known = len(whole) - (details["type"] == "extra_forbidden")  # an unknown key may look like a tag
    place = (*(part for part in whole[:known] if not _is_tag(part)), *whole[known:])
    key = in_one_line(".".join(map(str, place)))
    text = _text(details, place, data)
    last = whole[-1] if whole and known == len(whole) else None
    if last != OTHER_TAG and _is_tag(last):
        text += f", or {last[len(USUAL_TAG_START) : -1]}"
    if details["type"] == "missing" or isinstance(details["input"], (dict, Model)):
        return place, f"{key}: {text}"
    return place, f"{key} = {show(details['input'])}: {text}"


def _is_tag(part: object) -> bool:
    return isinstance(part, str) and part.startswith("<")


def _text(details: Any, place: KeyPath, data: Any) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == REFUSED:
        return context["text"]
    if kind == "extra_forbidden":
        return _unknown_key(place, data)
    if context.get("ge") == SMALLEST:
        return f"must be greater than 0 (at least {SMALLEST:g})"
    text = TEXTS[kind].format(**context) if kind in TEXTS else details["msg"]
    given = details["input"]
    comma = kind == "float_type" and isinstance(given, str) and re.fullmatch(r"[-+]?\d+,\d+(e[-+]?\d+)?", given)
    return f"{text}, with a decimal point: {given.replace(',', '.')}" if comma else text


def _unknown_key(place: KeyPath, data: Any) -> str:
    whole = model_of(data)
    model: type[Model] = whole
    field = None
    for part in place[:-1]:
        data = data[part]
        field = field if isinstance(part, int) else model.model_fields[part]  # the items of a list are of one kind
        model = _model_below(field, data, isinstance(part, int))
    allowed = model.keys() if issubclass(model, Config) else list(model.model_fields)
    elsewhere = (f"; nearest: {key}" for key in _dotted_keys(whole) if key.endswith(f".{place[-1]}"))
    suggestion = nearest(place[-1], allowed) or next(elsewhere, "")
    return f"unknown key{suggestion}; allowed: {', '.join(allowed)}"


def _dotted_keys(model: type[Model], before: str = "") -> Iterator[str]:
    """Full names of all keys, but for those of family members."""
    for name, field in model.model_fields.items():
        yield before + name
        below = _static_model(field)
        if below:
            yield from _dotted_keys(below, f"{before}{name}.")


def _model_below(field: FieldInfo, data: Any, is_item: bool) -> type[Model] | None:
    """Model of the map ``data`` that stands at ``field``, or is an item of a list there."""
    marks = [*([] if is_item else field.metadata), *_marks(field.annotation, is_item)]
    members = [mark for mark in marks if isinstance(mark, Member)]
    return members[0].model(data) if members else _static_model(field)


def _marks(annotation: Any, of_items: bool) -> Iterator[Any]:
    """Marks of the choices in a type, those of the items of lists or the others."""
    for each in get_args(annotation):
        if (get_origin(annotation) is tuple) == of_items:
            yield from getattr(each, "__metadata__", ())
        yield from _marks(each, of_items)


def _static_model(field: FieldInfo) -> type[Model] | None:
    choices = getattr(field.annotation, "__args__", (field.annotation,))
    plain = (getattr(item, "__origin__", item) for item in choices)
    return next((item for item in plain if isinstance(item, type) and issubclass(item, Model)), None)
