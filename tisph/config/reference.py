"""The reference of keys: meaning, unit, allowed values and default of every key, as ``tisph keys`` prints them.

Range and default come from the models of the config; ``keys.yaml`` has meaning and unit. A key without a line there is
a KeyError.
"""

import inspect
import re
import textwrap
import typing
from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from tisph import registry
from tisph.config.base import LARGEST, SMALLEST, Model
from tisph.config.fields import Member
from tisph.config.yaml_text import parse

MEANINGS = parse((Path(__file__).parent / "keys.yaml").read_text(encoding="utf-8")).data
FAMILIES = {
    "schemes": "Schemes: `scheme: {type: NAME, ...}`",
    "rheology": "Fluid laws: `fluid: {rheology: {type: NAME, ...}}`",
    "walls": "Wall treatments: `walls: {treatment: {type: NAME, ...}}`",
    "bodies": "Shapes: `bodies: [{type: NAME, ...}]`",
    "suspensions": "Suspensions: `bodies: {type: NAME, ...}`",
}
SAME_KEYS = {"suspensions": "bodies"}
"""Families whose keys have the meanings of another family."""
SIDES = re.compile(r"^(walls|ends)\.(top|bottom|inner|outer|left|right)\b")

Entries = dict[str, FieldInfo]
"""Dotted key -> field of a model."""


def scene_keys() -> tuple[Entries, dict[str, Entries]]:
    """Return the keys that all scenes have, and the further keys of each scene, by its name."""
    scenes = {name: dict(fields(registry.load("scenes", name).Config)) for name in registry.names("scenes")}
    shared = [key for key in scenes["channel"] if all(key in each for each in scenes.values())]
    shared = [key for key in shared if not key.startswith(("geometry", "walls", "initial"))]
    own = {name: {key: each[key] for key in each if key not in shared} for name, each in scenes.items()}
    return {key: scenes["channel"][key] for key in shared}, own


def member_keys(family: str, name: str) -> tuple[Entries, str]:
    """Return the keys of a member, and the text before their names in ``keys.yaml``."""
    return dict(fields(registry.load(family, name).Parameters)), f"{SAME_KEYS.get(family, family)}/"


def sections(scene: str) -> list[str]:
    """Return the names of the sections, and of the keys outside of sections, in the configs of a ``scene``."""
    shared, scenes = scene_keys()
    return list(dict.fromkeys(key.partition(".")[0] for key in shared | scenes[scene]))


def listing(scene: str | None = None, section: str | None = None) -> Iterator[str]:
    """Yield lines of 100 columns about all keys, about a ``scene``, or about a ``section`` of it."""
    shared, scenes = scene_keys()
    chosen = {"All scenes": shared}
    chosen |= {
        f"\nScene {name}: {summary('scenes', name)}": own for name, own in scenes.items() if scene in (None, name)
    }
    if section:
        chosen = {
            head: {key: field for key, field in each.items() if key.partition(".")[0] == section}
            for head, each in chosen.items()
        }
    for head, each in chosen.items():
        yield from (head, *lines(each)) if each else ()
    used = {family for each in chosen.values() for field in each.values() for family in families(field)}
    for family, title in FAMILIES.items():
        for name in registry.names(family) if family in used else ():
            yield f"\n{title.partition(':')[0]}: {name}"
            yield from lines(*member_keys(family, name))


def lines(entries: Entries, above: str = "") -> Iterator[str]:
    """Yield lines about keys: key, allowed values, unit and default, then the meaning."""
    for key, meaning, unit, possible, given in rows(entries, above):
        text = f"{key}: {possible}{f' [{unit}]' if unit else ''}; {f'default {given}' if given else 'must be given'}"
        yield from textwrap.wrap(text.replace("`", ""), 100, initial_indent="  ", subsequent_indent=" " * 8)
        yield from textwrap.wrap(meaning.replace("`", ""), 100, initial_indent=" " * 6, subsequent_indent=" " * 6)


def families(field: FieldInfo) -> Iterator[str]:
    """Yield the names of the families of a field, or of an item of its list."""
    yield from (one.family for one in field.metadata if isinstance(one, Member))
    waiting = list(typing.get_args(field.annotation))
    for each in waiting:
        yield from (one.family for one in getattr(each, "__metadata__", ()) if isinstance(one, Member))
        waiting += typing.get_args(each)


def code(names: Iterable[str]) -> str:
    """Return names in a row, each as code."""
    return ", ".join(f"`{name}`" for name in names)


def summary(family: str, name: str) -> str:
    """Return the first sentence of the docstring of a member."""
    first = " ".join(str(registry.load(family, name).__doc__).partition("\n\n")[0].split())
    return re.split(r"(?<=[a-z)])[.:] ", first)[0].rstrip(".") + "."


def rows(entries: Entries, above: str = "") -> Iterator[tuple[str, ...]]:
    """Yield key, meaning, unit, allowed values and default (empty if the key must be given) as texts."""
    for key, field in entries.items():
        meaning, unit, *said = MEANINGS[above + SIDES.sub(r"\1.SIDE", key)]
        yield key, meaning, unit, allowed(field.annotation, field.metadata), said[0] if said else default(field)


def fields(model: type[Model], above: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Yield dotted key and field of a model; members of a family have their keys apart."""
    for name, field in model.model_fields.items():
        yield f"{above}{name}", field
        below = list(models(field.annotation))
        for each in below:
            yield from fields(each, f"{above}{name}.")
        types: list[Any] = [each.model_fields["type"].annotation for each in below if "type" in each.model_fields]
        if len(types) > 1:
            yield f"{above}{name}.type", FieldInfo(annotation=reduce(or_, types))
        for key, added in added_keys(field.annotation).items():
            yield f"{above}{name}.{key}", added


def added_keys(annotation: Any) -> Entries:
    """Return the keys of items of a list of members that the members themselves do not have."""
    found: Entries = {}
    for each in typing.get_args(annotation):
        for member in (one for one in getattr(each, "__metadata__", ()) if isinstance(one, Member)):
            for name in choices(member):
                own = registry.load(member.family, name).Parameters.model_fields
                model: Any = member.model({"type": name})
                found |= {key: field for key, field in model.model_fields.items() if key not in own}
    return found


def choices(member: Member) -> list[str]:
    """Return the members of a family that the model of a map accepts."""
    return [name for name in registry.names(member.family) if member.model({"type": name})]


def models(annotation: Any) -> Iterator[type[Model]]:
    """Yield the models in the type of a field, without members of families."""
    if isinstance(annotation, type) and issubclass(annotation, Model) and annotation is not Model:
        yield annotation
    for each in typing.get_args(annotation):
        yield from models(each)


def allowed(annotation: Any, metadata: Sequence[Any] = ()) -> str:
    """Return the allowed values of a field in words."""
    member = next((one for one in metadata if isinstance(one, Member)), None)
    if member:
        return "a map with `type`: " + code(choices(member))
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return allowed(inner[0], [*metadata, *constraints(inner[1:])])
    if origin is typing.Literal:
        return code(inner)
    if origin is tuple:
        return ("list, each: " if inner[-1] is ... else f"{len(inner)} values, each: ") + allowed(inner[0])
    if origin is dict:
        return "a map of names"
    if origin is not None:
        return " or ".join(dict.fromkeys(allowed(each, metadata) for each in inner if each is not type(None)))
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return "a map"
    if annotation is str:
        return text_allowed(metadata)
    kind = {float: "number", int: "whole number", bool: "`true`, `false`"}[annotation]
    return f"{kind}{limits(metadata)}"


def text_allowed(metadata: Iterable[Any]) -> str:
    """Return the allowed values of a text: names of a family, or the words of its own check."""
    for one in metadata:
        known = inspect.getclosurevars(one.func).nonlocals if hasattr(one, "func") else {}
        if "family" in known:
            return code(registry.names(known["family"]))
        if "allowed" in known:
            return known["allowed"]
    return "text"


def constraints(metadata: Iterable[Any]) -> Iterator[Any]:
    """Yield all parts of the metadata of a type, with those inside of pydantic's fields."""
    for one in metadata:
        yield from getattr(one, "metadata", [one])


def limits(metadata: Iterable[Any]) -> str:
    """Return the bounds of a number in words, empty without any."""
    bounds = {
        kind: getattr(one, kind)
        for one in constraints(metadata)
        for kind in ("ge", "gt", "le", "lt")
        if hasattr(one, kind)
    }
    words = {"ge": "at least {}", "gt": "above {}", "le": "at most {}", "lt": "below {}"}
    if bounds.get("ge") == SMALLEST:
        bounds = {**{kind: bound for kind, bound in bounds.items() if kind != "ge"}, "gt": 0}
    said = [words[kind].format(f"{bound:g}") for kind, bound in sorted(bounds.items()) if abs(bound) < LARGEST]
    return f" {' and '.join(said)}" if said else ""


def default(field: FieldInfo) -> str:
    """Return the default of a field in words, empty where the key must be given."""
    value = field.get_default(call_default_factory=True) if field.default_factory else field.default
    if value is PydanticUndefined:
        return ""
    if isinstance(value, Model):
        return f"`{value.type}`" if hasattr(value, "type") else "see below"
    if value is None or value == ():
        return "none"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{list(value) if isinstance(value, tuple) else value}`"
