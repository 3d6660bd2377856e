"""YAML 1.2 text to plain data with the line of every key, and back: maps, lists and plain values only."""

import io
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, Event, NodeEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

MOST_LEVELS = 20
"""Deepest nesting that is read; a config has four levels."""

LONGEST_SHOWN = 60
"""Number of characters of a user's text in a message."""

KeyPath = tuple[str | int, ...]

# ruamel's scanner and constructor also raise Python's errors on some malformed texts
PARSER_ERRORS = (YAMLError, ValueError, TypeError, AttributeError, IndexError, KeyError, AssertionError)


class YamlTextError(Exception):
    """Text that is no acceptable YAML, with the error's ``text``, and its ``line`` (from 1) where known."""

    def __init__(self, text: str, line: int | None = None):
        super().__init__(text)
        self.text, self.line = text, line


def in_one_line(text: str) -> str:
    """Return a user's text for a message: in one line, with control characters escaped, cut where it is long."""
    escaped = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[:LONGEST_SHOWN])
    return escaped if len(text) <= LONGEST_SHOWN else f"{escaped}..."


@dataclass
class Document:
    """Plain data (maps, lists and plain values) and the line, from 1, of every key and item."""

    data: Any
    lines: dict[KeyPath, int]


def parse(text: str) -> Document:
    """Return the data of one YAML document; raises YamlTextError for everything but plain data."""
    try:
        reader, builder = _reader(), _Builder()
        events = list(_plain_events(reader.parse(text)))
        reader._parser = _Parsed(events)  # otherwise the composer scans the text again, which doubles the time
        return Document(builder.plain(reader.composer.get_single_node()), builder.lines)
    except PARSER_ERRORS as error:
        raise YamlTextError(*_parser_message(error, text)) from None


def dump(data: dict[str, Any]) -> str:
    """Return plain data as block-style YAML; ``parse`` returns the same data, with bitwise the same numbers."""
    writer = _reader()
    writer.default_flow_style = False
    writer.sort_base_mapping_type_on_output = False
    stream = io.StringIO()
    writer.dump(data, stream)
    return stream.getvalue()


def _reader() -> Any:
    return YAML(typ="safe", pure=True)


def _parser_message(error: Any, given: str) -> tuple[str, int | None]:
    for number, line in enumerate(given.splitlines(), start=1):
        if "\t" in line[: len(line) - len(line.lstrip())]:
            return "a tab; YAML indents with spaces", number
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    marked = isinstance(error, MarkedYAMLError)
    text = ", ".join(part for part in (error.context, error.problem) if part) if marked else ""
    text = text or str(error).partition("\n")[0] or type(error).__name__
    return f"is not YAML: {text}", mark.line + 1 if mark else None


def _plain_events(events: Iterable[Any]) -> Iterator[Event]:
    """Yield the events, and refuse aliases and deep nesting before any alias is expanded."""
    level = 0
    for event in events:
        line = event.start_mark.line + 1
        if isinstance(event, AliasEvent):
            raise YamlTextError(f"alias *{event.anchor}: aliases are not allowed, write the value out", line)
        if isinstance(event, NodeEvent) and event.anchor is not None:
            raise YamlTextError(f"anchor &{event.anchor}: anchors are not allowed, write the value out", line)
        if getattr(event, "tag", None) is not None:
            tag = str(event.tag).replace("tag:yaml.org,2002:", "!!")
            raise YamlTextError(f"tag {tag}: tags are not allowed, write a plain value", line)
        level += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
        if level > MOST_LEVELS:
            raise YamlTextError(f"nested more than {MOST_LEVELS} levels deep", line)
        yield event


def _decimal_comma(data: dict[str, Any], node: Node, key: Any) -> str:
    """Return a remark if the number ``key`` of ``node`` may be the decimals of the last value, as in {gap: 1,0}."""
    name, before = next(reversed(data.items()), ("", None))
    if not isinstance(key, int | float) or type(before) is not int or not name.isprintable():
        return ""
    return f"; a decimal comma? write {name}: {before}.{node.value}"


class _Parsed:
    """The events of a parser again, with the methods that ruamel's composer calls."""

    def __init__(self, events: list[Event]):
        self._coming = events[::-1]

    def check_event(self, *kinds: type[Event]) -> bool:
        return isinstance(self._coming[-1], kinds)

    def peek_event(self) -> Event:
        return self._coming[-1]

    def get_event(self) -> Event:
        return self._coming.pop()


class _Builder:
    """Builds plain data from the nodes of one document, and stores the line of every key and item."""

    def __init__(self) -> None:
        self.lines: dict[KeyPath, int] = {}
        self._constructor = _reader().constructor

    def plain(self, node: Node | None, path: KeyPath = ()) -> Any:
        if isinstance(node, MappingNode):
            return self._map(node, path)
        if isinstance(node, SequenceNode):
            places = [(*path, index) for index in range(len(node.value))]
            self.lines.update({place: item.start_mark.line + 1 for place, item in zip(places, node.value, strict=True)})
            return [self.plain(item, place) for place, item in zip(places, node.value, strict=True)]
        return None if node is None else self._scalar(node)

    def _map(self, node: MappingNode, path: KeyPath) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            key = self._scalar(key_node) if isinstance(key_node, ScalarNode) else None
            if not isinstance(key, str):
                shown = repr(in_one_line(key_node.value)) if isinstance(key_node, ScalarNode) else "a map or list"
                raise YamlTextError(f"key {shown}: keys must be words{_decimal_comma(data, key_node, key)}", line)
            place = (*path, key)
            if key in data:
                dotted = in_one_line(".".join(map(str, place)))
                raise YamlTextError(f"duplicate key {dotted}: already given in line {self.lines[place]}", line)
            self.lines[place] = line
            data[key] = self.plain(value_node, place)
        return data

    def _scalar(self, node: Any) -> Any:
        if node.tag.endswith((":merge", ":value")):  # the keys << and =, which have no meaning here
            return node.value
        try:
            return self._constructor.construct_object(node)
        except PARSER_ERRORS:
            raise YamlTextError(
                f"cannot read the value {in_one_line(node.value)!r}", node.start_mark.line + 1
            ) from None
