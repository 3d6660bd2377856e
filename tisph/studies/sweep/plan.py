"""From STUDY.yaml to the runs of a sweep: which keys take which values, together or each with each.

base: couette.yaml                      # a config, beside this file, or its keys as a map
vary:
  discretisation.particles_across: [10, 20, 40]
  time.tolerance: {from: 1.0e-5, to: 1.0e-3, count: 3, spacing: log}
  "fluid.density, walls.top.velocity": [[1.0, 0.5], [2.0, 0.25]]    # go together
collect: [l2, wall_shear_top]           # numbers of the last sample, of numbers or of cost
error: l2                               # by which the summary judges
bound: 1.0e-3                           # the cheapest run below it is named
"""

import hashlib
import itertools
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph.config import load
from tisph.config.fields import nearest
from tisph.config.yaml_text import YamlTextError, dump, parse
from tisph.errors import ConfigError

KEYS = ("name", "base", "vary", "collect", "error", "bound")
RANGE = {"from", "to", "count", "spacing"}

MOST = 100_000
"""Runs; more are a slip of the pen."""


@dataclass(frozen=True)
class Case:
    """One run: the ``values`` of the varied keys, its ``config`` as a plain dict, ``seconds`` that it may take.

    ``name`` is the hash of the config, by which a run is known again. ``refusal`` says why a config is not valid, None
    where it is.
    """

    name: str
    values: dict
    config: dict | None
    seconds: float = 1.0
    refusal: str | None = None


@dataclass(frozen=True)
class Study:
    """A sweep: its name, the varied ``keys``, its cases, what is collected, and the bound of an ``error``, if any."""

    name: str
    keys: tuple[str, ...]
    cases: tuple[Case, ...]
    collect: tuple[str, ...]
    error: str
    bound: float | None


def read(path, forecast):
    """``Study`` that the file ``path`` describes; ConfigError with one message where it cannot be understood.

    ``forecast(config)`` returns the numbers and the warnings of ``tisph check``, or raises ConfigError.
    """
    path = Path(path)
    try:
        data = parse(path.read_text(encoding="utf-8")).data
    except YamlTextError as error:
        raise ConfigError(f"{path}:{error.line or 1}: {error.text}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not isinstance(data, dict) or not {"base", "vary"} <= set(data):
        raise ConfigError(f"{path}: must be a map with the keys base and vary")
    for key in set(data) - set(KEYS):
        raise ConfigError(f"{path}: unknown key {key}{nearest(key, list(KEYS))}")
    keys, rows = _rows(data["vary"], path)
    collect = tuple(data.get("collect", ("l2",)))
    with tempfile.TemporaryDirectory() as scratch:
        base = _base(data["base"], path, Path(scratch))
        cases = tuple(_case(base, dict(zip(keys, row, strict=True)), forecast) for row in rows)
    error = data.get("error", collect[0] if collect else "l2")
    return Study(
        data.get("name", path.stem), keys, cases, tuple(dict.fromkeys((error, *collect))), error, data.get("bound")
    )


def _base(base, path, scratch):
    """Path of the config; a map is written into ``scratch``."""
    if isinstance(base, dict):
        file = scratch / f"{path.stem}.yaml"
        file.write_text(dump(base), encoding="utf-8")
        return file
    found = path.parent / str(base)
    return found if found.is_file() else Path(str(base))


def _rows(vary, path):
    """Keys and all rows of their values, the last key changing fastest."""
    if not isinstance(vary, dict) or not vary:
        raise ConfigError(f"{path}: vary must be a map of keys and their values")
    axes = [_axis(name, values, path) for name, values in vary.items()]
    keys = tuple(key for names, _ in axes for key in names)
    if len(set(keys)) < len(keys):
        raise ConfigError(f"{path}: vary: a key is given twice")
    count = int(np.prod([len(values) for _, values in axes], dtype=object))
    if not 0 < count <= MOST:
        raise ConfigError(f"{path}: vary: {count} runs; 1 to {MOST} are possible")
    return keys, [sum(row, ()) for row in itertools.product(*(values for _, values in axes))]


def _axis(name, values, path):
    """Keys that go together, and their values as tuples."""
    names = tuple(part.strip() for part in name.split(","))
    if isinstance(values, dict):
        values = _range(name, values, path)
    if not isinstance(values, list) or not values:
        raise ConfigError(f"{path}: vary.{name}: must be a list, or a range such as {{from: 1, to: 9, count: 3}}")
    if len(names) == 1:
        return names, [(value,) for value in values]
    if not all(isinstance(value, list) and len(value) == len(names) for value in values):
        raise ConfigError(f"{path}: vary.{name}: each item must be a list of {len(names)} values")
    return names, [tuple(value) for value in values]


def _range(name, given, path):
    """Values from one end to the other, of whole numbers whole ones."""
    if not {"from", "to", "count"} <= set(given) <= RANGE or given.get("spacing", "linear") not in ("linear", "log"):
        raise ConfigError(f"{path}: vary.{name}: a range has the keys from, to, count and spacing (linear or log)")
    ends = given["from"], given["to"]
    try:
        spaced = np.geomspace if given.get("spacing") == "log" else np.linspace
        values = spaced(*ends, given["count"])
    except (TypeError, ValueError) as error:
        raise ConfigError(f"{path}: vary.{name}: {error}") from None
    if all(isinstance(end, int) for end in ends):
        return list(dict.fromkeys(round(value) for value in values))
    return [float(f"{value:.12g}") for value in values]


def _case(base, values, forecast):
    try:
        config = load(base, [f"{key}={json.dumps(value)}" for key, value in values.items()])
        numbers, _ = forecast(config)
    except ConfigError as error:
        return Case(_hash(values), values, None, refusal=str(error))
    data = config.resolved()
    del data["name"]
    data["output"] = {**data["output"], "video": None}
    if config.runtime.threads == "auto":
        data["runtime"] = {**data["runtime"], "threads": 1}  # the runs share the processors, not their loops
    return Case(_hash(data), values, data, float(numbers["run_time"] or 1.0))


def _hash(data):
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]
