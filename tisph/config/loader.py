"""Read a YAML file, or a dict in its place: return a checked config, or raise an error with a line for each mistake.

Each line has the key, its value, the allowed values and the nearest valid key.
"""

import json
import re
import shutil
import tempfile
import unicodedata
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import reduce
from operator import getitem
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeAlias, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from tisph import registry
from tisph.config.base import REFUSED, SMALLEST, Model
from tisph.config.fields import OTHER_TAG, USUAL_TAG_START, Member, nearest
from tisph.config.schema import FORMER_KEYS, Config, model_of
from tisph.config.yaml_text import KeyPath, YamlTextError, in_one_line, parse
from tisph.errors import ConfigError, TisphError

TEXTS = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "finite_number": "must be a finite number",
    "string_type": "must be text (in quotes where it looks like a number)",
    "tuple_type": "must be a list such as [1.0, 2.0]",
    "model_type": "must be a map of keys",
    "dict_type": "must be a map of names",
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
"""pydantic's type of an error -> text; other types have pydantic's own text."""

HINTS = {
    "pressure_gradient": "nearest: drive.acceleration, the force per mass, which is -(pressure gradient)/density",
    "fluid.viscosity": "dynamic_viscosity, or kinematic_viscosity = dynamic_viscosity / density",
    "slip": "nearest: slip_length of a wall or body, a length or infinite",
    "walls.type": "walls have no type: the fluid has their velocity, or slips with slip_length",
    "ends.max_velocity": "velocity is the mean over the inlet, 2/3 of the largest between plane walls",
    "ends.flow_rate": "velocity is the mean over the inlet: the flow rate over its width",
    "drive.pressure": "nearest: drive.acceleration, the force per mass, which is -(pressure gradient)/density",
    "drive.flow_rate": "no flow rate is given: in slow flow it is proportional to drive.acceleration",
}
"""Unknown key, also as SECTION.KEY -> the way to the same flow, or the words that there is none."""


def describe(error: ValidationError, data: Any, written: Callable[[KeyPath], int]) -> list[tuple[KeyPath, str]]:
    """Return place and message of every error of a failed validation of the raw ``data``.

    ``written(place)``: order in which places were written; of several possible places of an error the last is named.
    """
    return [_describe(_blame_last(details, data, written), data) for details in error.errors(include_url=False)]


def _blame_last(details: Any, data: Any, written: Callable[[KeyPath], int]) -> Any:
    for place in details.get("ctx", {}).get("others", ()):
        if written(place) > written(details["loc"]):
            return {**details, "loc": place, "input": reduce(getitem, place, data)}
    return details


def show(value: object) -> str:
    """Return a value as in a YAML file, cut where it is long."""
    return in_one_line(json.dumps(value, default=str, ensure_ascii=False))


def _describe(details: Any, data: Any) -> tuple[KeyPath, str]:
    whole = details["loc"]
    known = len(whole) - (details["type"] == "extra_forbidden")  # an unknown key may look like a tag
    place = (*(part for part in whole[:known] if not _is_tag(part)), *whole[known:])
    key = in_one_line(".".join(map(str, place)))
    text = _text(details, place, data)
    last: Any = whole[-1] if whole and known == len(whole) else None
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
    model: Any = whole
    field: Any = None
    for part in place[:-1]:
        data = data[part]
        if model and part in model.model_fields:  # else an item of a list, or of a map of names: all are of one kind
            field = model.model_fields[part]
        model = _model_below(field, data, isinstance(part, int))
    allowed = model.keys() if issubclass(model, Config) else list(model.model_fields)
    hint = HINTS.get(f"{place[0]}.{place[-1]}", HINTS.get(str(place[-1])))
    suggestion = f"; {hint}" if hint else _in_scenes(place) or nearest(place[-1], _alike(place[-1], allowed))
    suggestion = suggestion or _elsewhere(place, whole)
    return f"unknown key{suggestion}; allowed: {', '.join(allowed)}"


def _alike(name: object, allowed: Iterable[str]) -> list[str]:
    """Return the ``allowed`` keys that an unknown ``name`` may mean.

    A name with a further word is another quantity, as is max_velocity for velocity. A name that is part of several
    keys may be any of them.
    """
    words = str(name).split("_")
    longer = [key for key in allowed if {*words} < {*key.split("_")}]
    return [key for key in allowed if key.count("_") >= len(words) - 1 and (key not in longer or len(longer) == 1)]


def _elsewhere(place: KeyPath, whole: type[Model]) -> str:
    """Return the one key of this name in another section, as a hint; of deeper places none has the same meaning."""
    found = [key for key, _ in _dotted_keys(whole) if key.endswith(f".{place[-1]}")]
    return f"; nearest: {found[0]}" if len(place) < 3 and len(found) == 1 else ""


def _in_scenes(place: KeyPath) -> str:
    """Return the scenes that have a section of this name, or the keys that have its name as a value, as a hint."""
    found: dict[str, list[str]] = {}
    for scene in registry.names("scenes"):
        for key, field in _dotted_keys(registry.load("scenes", scene).Config):
            if place == (key,) or place[-1] in get_args(field.annotation):
                found.setdefault(key, []).append(scene)
    if not found:
        return ""
    value = "" if place[-1] in found else f"a value of {', '.join(found)}, "
    scenes = sorted({scene for each in found.values() for scene in each})
    return f"; {value}only for scene{'s' * (len(scenes) > 1)} {', '.join(scenes)}"


def _dotted_keys(model: type[Model], before: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Yield the dotted names and the fields of all keys, except the keys of family members."""
    for name, field in model.model_fields.items():
        yield before + name, field
        below = _static_model(field)
        if below:
            yield from _dotted_keys(below, f"{before}{name}.")


def _model_below(field: FieldInfo, data: Any, is_item: bool) -> type[Model] | None:
    """Return the model of the map ``data``, which is the value of ``field``, or an item of a list there."""
    marks = [*([] if is_item else field.metadata), *_marks(field.annotation, is_item)]
    members = [mark for mark in marks if isinstance(mark, Member)]
    return members[0].model(data) if members else _static_model(field, data)


def _marks(annotation: Any, of_items: bool) -> Iterator[Any]:
    """Yield the marks of the choices in a type: only of items of lists, or only of others."""
    for each in get_args(annotation):
        if (get_origin(annotation) is tuple) == of_items:
            yield from getattr(each, "__metadata__", ())
        yield from _marks(each, of_items)


def _static_model(field: FieldInfo, data: Any = None) -> type[Model] | None:
    """Return the model in the type of a field; of models with a key ``type`` the one that the map ``data`` names."""
    choices, found = [field.annotation], []
    for each in choices:
        found += [each] if isinstance(each, type) and issubclass(each, Model) else []
        choices += get_args(each)
    named = data.get("type") if isinstance(data, dict) else None
    typed = [each for each in found if "type" in each.model_fields]
    fitting = [each for each in typed if named in get_args(each.model_fields["type"].annotation)]
    return next(iter([*fitting, *found]), None)


Asked: TypeAlias = "str | PathLike[str] | Mapping[str, Any] | Config"
"""A YAML file, a dict with the contents of such a file, or a checked config."""


@contextmanager
def config_file(config: Asked) -> Iterator[str]:
    """Yield the path of a YAML file with ``config``; in errors a temporary file is called ``config``."""
    if isinstance(config, str | PathLike):
        yield fspath(config)
        return
    with tempfile.TemporaryDirectory(prefix="tisph-") as folder:
        path = Path(folder) / "run.yaml"
        resolved = getattr(config, "resolved_yaml", None)
        if not resolved:
            copy_shapes(config, Path.cwd(), Path(folder))
        path.write_text(resolved() if resolved else json.dumps(_plain(config)), encoding="utf-8")
        try:
            yield str(path)
        except TisphError as error:
            raise type(error)(re.sub(rf"{re.escape(str(path))}(:\d+)?", "config", str(error))) from None


def copy_shapes(data: Any, here: Path, folder: Path) -> None:
    """Copy the files of shapes in the raw data of a config, which are ``here``, to the ``folder`` of its YAML file."""
    for value in data.values() if isinstance(data, Mapping) else data if isinstance(data, list | tuple) else ():
        copy_shapes(value, here, folder)
    given = data.get("file") if isinstance(data, Mapping) else None
    name = given.get("path") if isinstance(given, Mapping) else given
    here = here.resolve()
    if isinstance(name, str) and (source := here / name).is_file() and here in source.resolve().parents:
        target = folder / source.resolve().relative_to(here)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def loaded(config: Asked, overrides: Mapping[str, Any]) -> Config:
    """Return ``config`` with ``overrides`` as a checked ``Config``; raises ConfigError."""
    if isinstance(config, Config) and not overrides:
        return config
    with config_file(config) as path:
        return load(path, override_texts(overrides))


def override_texts(overrides: Mapping[str, Any]) -> list[str]:
    """Return ``key.path=value`` for each of ``overrides``, values by dotted key."""
    return [f"{key}={json.dumps(_plain(value))}" for key, value in overrides.items()]


def _plain(value: Any) -> Any:
    """Return ``value`` as plain data: numbers and arrays of NumPy and others become Python's."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple | range):
        return [_plain(each) for each in value]
    return value if value is None or isinstance(value, str | bool | int | float) else str(value)


LARGEST_FILE = 64 * 1024
"""Largest file that is parsed [bytes]; a config has a few kilobytes, and another file could take minutes."""

MOST_SHOWN = 5


class Source:
    """Raw data of a config with the origin (file and line, or override) of every key."""

    def __init__(self, path: str):
        self.path = path
        self.data: dict[str, Any] = {}
        self._origins: dict[KeyPath, tuple[int, str]] = {}
        self._former: dict[str, str] = {}
        self._overridden: set[str] = set()

    def read(self) -> None:
        """Read the data of the file; raises ConfigError."""
        try:
            document = parse(_read_text(self.path))
        except YamlTextError as error:
            where = f"{self.path}:{error.line}" if error.line else self.path
            raise ConfigError(f"{where}: {error.text}") from None
        if not isinstance(document.data, dict):
            kind = {list: "a list", type(None): "empty"}.get(type(document.data), "a single value")
            raise ConfigError(f"{self.path}: is {kind}; it must be a map of keys such as 'scene: channel'")
        self._check_names(document.data, lambda new: f"{self.path}:{document.lines[new,]}: ")
        self.data = {self._present(key): value for key, value in document.data.items()}
        for (key, *below), line in document.lines.items():
            place = (self._present(str(key)), *below)
            self._origins[place] = line, f"{self.path}:{line}"

    def override(self, text: str, rank: int) -> None:
        """Set one key from ``key.path=value``; ``rank``: order of the override, for its errors."""
        dotted, equals, value = text.partition("=")
        label = f"--set {in_one_line(text)}"
        first, *below = (part.strip() for part in dotted.split("."))
        self._overridden.add(first)
        self._check_names(self._overridden, lambda new: f"{label}: ")
        keys = (self._present(first), *below)
        if not equals or not all(keys):
            raise ConfigError(f"{label}: must look like key.path=value, such as time.end=2.7")
        try:
            parsed = parse(value).data
        except YamlTextError as error:
            raise ConfigError(f"{label}: the value {error.text}") from None
        origin = (LARGEST_FILE + rank, label)
        parent: Any = self.data
        place: KeyPath = ()
        for depth, part in enumerate(keys, start=1):
            place = (*place, step(parent, part, f"{label}: {'.'.join(map(str, place))}"))
            if depth == len(keys):
                parent[place[-1]] = parsed
                break
            if isinstance(parent, dict) and part not in parent:
                parent[part] = {}
                self._origins[place] = origin
            parent = parent[place[-1]]
        replaced = [old for old in self._origins if old[: len(place)] == place]
        for old in replaced:
            del self._origins[old]
        self._origins[place] = origin

    @staticmethod
    def _check_names(sections: Container[str], where: Callable[[str], str]) -> None:
        """Raise ConfigError if ``sections`` have one section by two names; ``where(new)`` begins its message."""
        for old, new in FORMER_KEYS.items():
            if old in sections and new in sections:
                raise ConfigError(f"{where(new)}{new}: is the new name of {old}: give one of them")

    def _present(self, key: str) -> str:
        """Return the present name of a section, and store its former name if the config has that."""
        if key in FORMER_KEYS:
            self._former[FORMER_KEYS[key]] = key
        return FORMER_KEYS.get(key, key)

    def as_written(self, message: str) -> str:
        """Return a message that begins with a key, with the section's name in the config."""
        section = re.split("[. ]", message)[0]
        return self._former.get(section, section) + message[len(section) :]

    def written(self, place: KeyPath) -> int:
        """Return the order of ``place`` itself, -1 where it was left out."""
        return self._origins.get(place, (-1, ""))[0]

    def origin(self, place: KeyPath) -> tuple[int, str]:
        """Return order and name of the line or override with ``place``, or with the nearest map around it."""
        while place and place not in self._origins:
            place = place[:-1]
        return self._origins.get(place, (0, self.path))


def step(parent: Any, part: str, label: str) -> str | int:
    """Return the key or index ``part`` below ``parent``; ConfigError, which begins with ``label``, without one."""
    if isinstance(parent, dict):
        return part
    if not isinstance(parent, list):
        raise ConfigError(f"{label} is not a map of keys")
    if not (part.isdecimal() and int(part) < len(parent)):
        raise ConfigError(f"{label} is a list of {len(parent)}: {part} must be its index, from 0 on")
    return int(part)


def load(path: str | Path, overrides: Sequence[str] = ()) -> Config:
    """Return a config file with ``key.path=value`` overrides, applied in turn, as a checked config.

    Raises ConfigError with one message that names file, line, key, value and the allowed values for each of the
    first few mistakes. ``name`` defaults to the file's name without its ending.
    """
    source = Source(str(path))
    source.read()
    for rank, text in enumerate(overrides):
        source.override(text, rank)
    source.data.setdefault("name", _default_name(source.path))
    try:
        context = {"folder": Path(path).parent, "data": source.data}  # for shapes from files
        return model_of(source.data).model_validate(source.data, context=context)
    except ValidationError as error:
        raise ConfigError(_message(error, source)) from None


def _message(error: ValidationError, source: Source) -> str:
    found = [(source.origin(place), text) for place, text in describe(error, source.data, source.written)]
    lines = [f"{where}: {source.as_written(text)}" for (_, where), text in sorted(found)]
    more = len(lines) - MOST_SHOWN
    return "\n".join(lines[:MOST_SHOWN] + ([f"and {more} more"] if more > 0 else []))


def _default_name(path: str) -> str:
    whole = unicodedata.normalize("NFC", Path(path).stem)  # macOS keeps an umlaut as a letter and a mark
    safe = re.sub(r"[^\w.-]", "_", whole)[:64].strip(".")
    return safe or "run"


def _read_text(path: str) -> str:
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file{_nearest_file(Path(path))}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(f"{path}: cannot be read: {reason}") from None
    if len(content) > LARGEST_FILE:
        raise ConfigError(f"{path}: is larger than {LARGEST_FILE} bytes: is this a config?")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise ConfigError(f"{path}:{line}: is not UTF-8 text (byte {error.start})") from None


def _nearest_file(path: Path) -> str:
    try:
        return nearest(path.name, [entry.name for entry in path.parent.iterdir() if entry.suffix == ".yaml"])
    except OSError:
        return ""
