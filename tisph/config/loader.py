"""From a YAML file and ``--set`` overrides to a checked Config, or to one message that says what is wrong."""

import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tisph.config.fields import nearest
from tisph.config.messages import describe
from tisph.config.schema import FORMER_KEYS, Config, model_of
from tisph.config.yaml_text import KeyPath, YamlTextError, in_one_line, parse
from tisph.errors import ConfigError

LARGEST_FILE = 64 * 1024
"""Bytes; a config is a few kilobytes, and a wrong file should not be parsed for minutes."""

MOST_SHOWN = 5


class Source:
    """Raw data of a config with the origin (file and line, or override) of every key."""

    def __init__(self, path: str):
        self.path = path
        self.data: dict[str, Any] = {}
        self._origins: dict[KeyPath, tuple[int, str]] = {}
        self._former: dict[str, str] = {}

    def read(self) -> None:
        """Fill in the file's data; raises ConfigError."""
        try:
            document = parse(_read_text(self.path))
        except YamlTextError as error:
            where = f"{self.path}:{error.line}" if error.line else self.path
            raise ConfigError(f"{where}: {error.text}") from None
        if not isinstance(document.data, dict):
            kind = {list: "a list", type(None): "empty"}.get(type(document.data), "a single value")
            raise ConfigError(f"{self.path}: is {kind}; it must be a map of keys such as 'scene: channel'")
        for old, new in FORMER_KEYS.items():
            if old in document.data and new in document.data:
                raise ConfigError(
                    f"{self.path}:{document.lines[new,]}: {new}: is the new name of {old}: give one of them"
                )
        self.data = {self._present(key): value for key, value in document.data.items()}
        lines = document.lines.items()
        self._origins = {(self._present(key), *below): (line, f"{self.path}:{line}") for (key, *below), line in lines}

    def override(self, text: str, rank: int) -> None:
        """Set one key from ``key.path=value``; ``rank`` orders its errors among those of the overrides."""
        dotted, equals, value = text.partition("=")
        label = f"--set {in_one_line(text)}"
        first, *below = (part.strip() for part in dotted.split("."))
        place = (self._present(first), *below)
        if not equals or not all(place):
            raise ConfigError(f"{label}: must look like key.path=value, such as time.end=2.7")
        try:
            parsed = parse(value).data
        except YamlTextError as error:
            raise ConfigError(f"{label}: the value {error.text}") from None
        origin = (LARGEST_FILE + rank, label)
        parent = self.data
        for depth, part in enumerate(place[:-1], start=1):
            if part not in parent:
                parent[part] = {}
                self._origins[place[:depth]] = origin
            parent = parent[part]
            if not isinstance(parent, dict):
                self._refuse_to_go_below(".".join(place[:depth]), parent, label)
        parent[place[-1]] = parsed
        replaced = [old for old in self._origins if old[: len(place)] == place]
        for old in replaced:
            del self._origins[old]
        self._origins[place] = origin

    def _present(self, key: str) -> str:
        """The present name of a section that is written with its former one."""
        if key in FORMER_KEYS:
            self._former[FORMER_KEYS[key]] = key
        return FORMER_KEYS.get(key, key)

    def as_written(self, message: str) -> str:
        """A message that begins with a key, with the name that the config has for its section."""
        section = re.match("[^. ]*", message).group()
        return self._former.get(section, section) + message[len(section) :]

    def _refuse_to_go_below(self, key: str, value: Any, label: str) -> None:
        kind = "is a list: give it as a whole" if isinstance(value, list) else "is not a map of keys"
        example = f", such as {key}=[1.0, 2.0]" if isinstance(value, list) else ""
        raise ConfigError(f"{label}: {key} {kind}{example}")

    def written(self, place: KeyPath) -> int:
        """Order of ``place`` itself, -1 where it was left out."""
        return self._origins.get(place, (-1, ""))[0]

    def origin(self, place: KeyPath) -> tuple[int, str]:
        """Order and name of where ``place``, or the nearest map around it, was written."""
        while place and place not in self._origins:
            place = place[:-1]
        return self._origins.get(place, (0, self.path))


def load(path: str | Path, overrides: Sequence[str] = ()) -> Config:
    """Read a config file, apply ``key.path=value`` overrides in turn, and check everything.

    Raises ConfigError with one message that names file, line, key, value and what is allowed for each of the
    first few mistakes. ``name`` defaults to the file's name without its ending.
    """
    source = Source(str(path))
    source.read()
    for rank, text in enumerate(overrides):
        source.override(text, rank)
    source.data.setdefault("name", _default_name(source.path))
    try:
        return model_of(source.data).model_validate(source.data)
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
