"""The table of references: FLOW.yaml of this folder, printed by ``tisph references`` and read by suites and documents.

    title: DFG benchmark 2D-1           # the flow in a few words
    convention: ...                     # lengths, velocities, viscosities, signs; half or whole body
    sources:
      nabh: {cite: "G. Nabh (1998)", how: tabulated, checked: "where the value was read"}
    numbers:
      drag_coefficient:
        unit: "1"
        values:                         # the first one is the reference, the others are compared with it
          - {source: nabh, value: 5.57953523384, spread: 1.0e-11}
          - {source: tutorial, value: 5.61, spread: 0.005, wrong: "why it differs"}

``how`` is one of ``WAYS``. ``checked`` says where the value was read or recomputed, and is false where it was not.
``spread`` is the stated uncertainty, or one unit of the last digit. ``computed``, in place of ``value``, is an
expression of ``tisph.exact``, numpy (``np``) and ``of("other_number")`` of the same flow.

Two values agree if they differ by the sum of their spreads at most. A value that does not agree needs ``wrong``, the
reason; a value with ``wrong`` must not agree. Every other pair is a failure of the table.
"""

import json
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tisph.config.fields import nearest
from tisph.config.yaml_text import parse
from tisph.exact import cavity, couette, taylor_vortices

FOLDER = Path(__file__).parent

WAYS = ("exact", "own computation", "tabulated", "digitised")
"""Ways in which a value was obtained."""

ENTRY = re.compile(r"(?:(?P<factor>[-+.\de]+)\*)?(?P<flow>[a-z]\w*)\.(?P<name>\w[\w.]*)")
"""FLOW.NUMBER, with a factor before it or without: ``0.002*dfg_2d_1.drag_coefficient``."""

COLUMNS = 80

AGREES, CONTRADICTS, DISAGREES = "agrees", "contradicts", "DISAGREES"

ROUNDING = 1e-9
"""Part of the sum of two spreads by which two values may differ beyond it."""


@dataclass(frozen=True)
class Value:
    """One value of a number: its ``spread`` (same unit), the ``source``'s name, and why it is ``wrong``, or empty."""

    value: float
    spread: float
    source: str
    wrong: str


@dataclass(frozen=True)
class Pair:
    """The reference of a number beside another value of it; ``difference`` and ``allowed`` in the number's unit."""

    flow: str
    name: str
    reference: Value
    other: Value

    @property
    def difference(self) -> float:
        """Absolute difference of the two values."""
        return abs(self.reference.value - self.other.value)

    @property
    def allowed(self) -> float:
        """Sum of the two spreads."""
        return (self.reference.spread + self.other.spread) * (1 + ROUNDING)

    @property
    def verdict(self) -> str:
        """``AGREES``; ``CONTRADICTS`` for a reason that the table states; else ``DISAGREES``."""
        agrees = self.difference <= self.allowed
        if self.other.wrong:
            return DISAGREES if agrees else CONTRADICTS
        return AGREES if agrees else DISAGREES


@cache
def flows() -> dict[str, Any]:
    """Return the data of all flows by name."""
    paths = sorted(FOLDER.glob("*.yaml"))
    return {path.stem: parse(path.read_text(encoding="utf-8")).data for path in paths}


def flow_named(name: str) -> dict[str, Any]:
    """Return the data of a flow; ValueError with the nearest name where there is none."""
    if name not in flows():
        near = [flow for flow in flows() if name in flow]
        text = f"; there are {', '.join(near)}" if near else nearest(name, flows())
        raise ValueError(f"there is no reference flow {name!r}{text}; tisph references lists them")
    return flows()[name]


def values(flow: str, name: str) -> list[Value]:
    """Return all values of a number of a flow, the reference first; ValueError where there is no such number."""
    numbers = flow_named(flow)["numbers"]
    if name not in numbers:
        raise ValueError(f"{flow} has no number {name!r}{nearest(name, numbers)}; tisph references {flow} lists them")
    return [
        Value(_value(flow, one), float(one["spread"]), one["source"], one.get("wrong", ""))
        for one in numbers[name]["values"]
    ]


def _value(flow: str, entry: dict[str, Any]) -> float:
    if "computed" not in entry:
        return float(entry["value"])
    names: dict[str, Any] = {"cavity": cavity, "couette": couette, "taylor_vortices": taylor_vortices, "np": np}
    names["of"] = lambda name: values(flow, name)[0].value
    return float(eval(entry["computed"], names))  # an expression of this folder's own files


def number(text: str) -> float:
    """Return the value of ``FLOW.NUMBER`` or ``FACTOR*FLOW.NUMBER``; ValueError where it names no reference."""
    found = ENTRY.fullmatch(text.replace(" ", ""))
    if found is None:
        raise ValueError(f"{text!r}: must be a number, or a reference such as dfg_2d_1.drag_coefficient")
    return float(found["factor"] or 1.0) * values(found["flow"], found["name"])[0].value


def pairs(flow: str) -> Iterator[Pair]:
    """Yield the reference of each number of a flow beside each other value of it."""
    for name in flow_named(flow)["numbers"]:
        reference, *others = values(flow, name)
        yield from (Pair(flow, name, reference, other) for other in others)


def as_json(flow: str | None) -> str:
    """Return a flow, or all, as JSON text: the data of the files with the values and verdicts."""
    found = {}
    for name in [flow] if flow else flows():
        numbers = {
            key: {
                **entry,
                "value": values(name, key)[0].value,
                "values": [
                    {**given, "value": value.value}
                    for given, value in zip(entry["values"], values(name, key), strict=True)
                ],
            }
            for key, entry in flow_named(name)["numbers"].items()
        }
        compared = [
            {"number": pair.name, "source": pair.other.source, "difference": pair.difference, "verdict": pair.verdict}
            for pair in pairs(name)
        ]
        found[name] = {**flow_named(name), "numbers": numbers, "compared": compared}
    return json.dumps(found, indent=2)


def summary() -> list[str]:
    """Return a line for each flow, then the lines of each pair of values that do not agree."""
    width = max(map(len, flows()))
    lines = []
    for name, data in flows().items():
        first, *more = textwrap.wrap(data["title"], COLUMNS - width - 2)
        lines += [f"{name:{width}}  {first}", *(" " * (width + 2) + line for line in more)]
    apart = [pair for name in flows() for pair in pairs(name) if pair.verdict != AGREES]
    lines += ["", "values that differ from the reference by more than both spreads:"]
    for pair in apart:
        words = f"{pair.other.value:.10g} ({pair.other.source}), reference {pair.reference.value:.10g}: "
        words += pair.other.wrong or "no reason is stated"
        lines += _wrapped(f"{pair.verdict} {pair.flow}.{pair.name}: {words}", "  ")
    return lines


def listing(flow: str) -> list[str]:
    """Return the lines of one flow: convention, numbers with all values, sources."""
    data = flow_named(flow)
    lines = [*_wrapped(f"{flow}: {data['title']}", ""), *_wrapped(data["convention"], "  "), ""]
    verdicts = {(pair.name, pair.other): pair.verdict for pair in pairs(flow)}
    for name, entry in data["numbers"].items():
        confirmed = any(pair.verdict == AGREES for pair in pairs(flow) if pair.name == name)
        confirmed |= data["sources"][values(flow, name)[0].source]["how"] == "exact"
        words = f"{name} [{entry['unit']}]{'' if confirmed else ' NO SECOND SOURCE'}"
        lines += _wrapped(f"{words}: {entry['says']}" if "says" in entry else words, "")
        for value in values(flow, name):
            verdict = verdicts.get((name, value), "")
            words = f"{value.value:.12g} +- {value.spread:.2g}"
            lines += [f"  {words:32} {value.source:28} {verdict}".rstrip()]
            lines += _wrapped(value.wrong, "      ") if value.wrong else []
    lines += ["", "sources"]
    for name, source in data["sources"].items():
        checked = f"checked: {source['checked']}" if source["checked"] else "NOT CHECKED"
        command = f" by {source['command']}" if "command" in source else ""
        lines += _wrapped(f"{name}: {source['cite']}; {source['how']}{command}; {checked}", "  ")
    return lines


def _wrapped(text: str, indent: str) -> list[str]:
    return textwrap.wrap(text, COLUMNS, initial_indent=indent, subsequent_indent=indent + "  ", break_long_words=False)
