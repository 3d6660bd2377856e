"""Suites: runs and their checks as YAML files, our own in ``tisph/suites`` and any file of a user.

    title: Start-up Couette flow
    base: couette.yaml                  # a config beside this file, or its keys as a map; bases: several by name
    runs:                               # changes of the base, keys as of tisph run --set
      coarse: {samples: [1.8, 2.7]}     # samples: times; the last one is the end
      fine: {like: coarse, discretisation.particles_across: 100}       # base: NAME takes one of bases
    checks:                             # see studies/checks.py
      - {run: fine, t: [1.8, 2.7], at_most: {l2: 1.0e-3}}
    quick: {runs: ..., checks: ...}     # with --quick, in place of the above; its runs may be like the runs above
    long: {runs: ..., checks: ...}      # with --long

A run with ``resumed: true`` is stopped after its first checkpoint and resumed; a run with ``estimated: true`` estimates
its error (tisph run --estimate-error).
"""

import copy
import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

from ruamel.yaml import YAML

from tisph.config.fields import nearest
from tisph.config.loader import loaded, step
from tisph.config.yaml_text import Document, YamlTextError, parse
from tisph.errors import ConfigError
from tisph.studies import checks
from tisph.studies.checks import Criterion, SuiteError

FOLDER = Path(__file__).parents[1] / "suites"

PARTS = (
    *("couette", "channel", "viscoelastic", "rheologies", "rheometry", "implicit", "two_dimensional"),
    *("circular_couette", "cavity", "bodies", "free_bodies", "axisymmetric", "two_dimensional_inelastic"),
    *("two_dimensional_polymers", "open_ends", "heat", "estimates"),
)
"""Suites of ``tisph verify``, in the order of its table."""

NOT_QUICK = ("estimates",)
"""Suites that ``tisph verify --quick`` leaves out."""

NAME = re.compile(r"\w[\w.-]*")
"""Pattern of the name of a run, which is also the name of its folder."""

SECTION = ("base", "bases", "runs", "checks")
FLAGS = ("resumed", "estimated")
OF_RUNS = ("base", "like", "samples", *FLAGS)

Config = dict[str, Any]
"""A config as plain data, without its name."""

Place = tuple[str | int, ...]
"""Keys that lead to an entry of the file."""


@dataclass
class Suite:
    """The runs by name, the criteria that judge them, and the names of runs with a flag.

    A run is a config, or a function that runs it in this process and returns ``Result`` and message.
    """

    title: str = ""
    runs: dict[str, Any] = field(default_factory=dict)
    criteria: list[Criterion] = field(default_factory=list)
    resumed: set[str] = field(default_factory=set)
    estimated: set[str] = field(default_factory=set)

    def add(self, other: "Suite") -> None:
        """Add the runs and criteria of another suite, whose runs have other names."""
        self.runs |= other.runs
        self.criteria += other.criteria
        self.resumed |= other.resumed
        self.estimated |= other.estimated


def whole(quick: bool = False) -> Suite:
    """Return all of ``PARTS`` as one suite, less ``NOT_QUICK`` where it is ``quick``."""
    suite = Suite()
    for name in PARTS:
        if not (quick and name in NOT_QUICK):
            suite.add(ours(name, quick))
    return suite


def ours(name: str, quick: bool = False, long: bool = False) -> Suite:
    """Return one of ``PARTS``."""
    return copy.deepcopy(_read_once(FOLDER / f"{name}.yaml", quick, long))


def config_of(name: str, run: str) -> Config:
    """Return the config of a run of one of ``PARTS``."""
    return ours(name).runs[run]


def study(name: str) -> dict[str, Any]:
    """Return the data of a study without checks, a file beside the suites, which may have YAML anchors."""
    return YAML(typ="safe", pure=True).load(FOLDER / f"{name}.yaml")


def read(path: Path, quick: bool = False, long: bool = False) -> Suite:
    """Return the suite of a file, its ``quick`` or its ``long`` section.

    Raises ConfigError, with file, line, key and the fix of a mistake, and where there is no long section.
    """
    return _File(Path(path)).suite("quick" if quick else "long" if long else None)


_read_once = cache(read)


def document(path: Path) -> Document:
    """Return data and lines of a user's YAML file; ConfigError where it cannot be read."""
    try:
        return parse(path.read_text(encoding="utf-8"))
    except YamlTextError as error:
        raise ConfigError(f"{path}:{error.line or 1}: {error.text}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


class _File:
    """The data of a suite's file, with the line of each key."""

    def __init__(self, path: Path):
        self.path = path
        found = document(path)
        self.data, self._lines = found.data, found.lines
        if not isinstance(self.data, dict) or not {"title", "runs", "checks"} <= set(self.data):
            raise ConfigError(f"{path}: a suite is a map with the keys title, base, runs and checks")
        self._require_keys(self.data, (), ("title", *SECTION, "quick", "long"))
        if not isinstance(self.data["title"], str):
            self._fail(("title",), "must be text")

    def suite(self, section: str | None) -> Suite:
        """Return the suite of the file, or of its ``section``, ``quick`` or ``long``."""
        configs, flags = self._runs(self.data, (), {})
        if section is None:
            return Suite(self.data["title"], configs, self._criteria(self.data, (), configs), **flags)
        if section not in self.data:
            if section == "quick":
                return self.suite(None)
            raise ConfigError(f"--long: {self.path.stem} has no long section")
        data = self._map(self.data, (), section)
        self._require_keys(data, (section,), SECTION)
        own, own_flags = self._runs({**self.data, **data}, (section,), configs) if "runs" in data else ({}, {})
        configs |= own
        criteria = self._criteria(data, (section,), configs)
        used = {name for criterion in criteria for name in criterion.runs}
        needed = {name: config for name, config in configs.items() if name in own or name in used}
        flags = {flag: (names | own_flags.get(flag, set())) & used for flag, names in flags.items()}
        return Suite(self.data["title"], needed, criteria, **flags)

    def _runs(self, data: dict, place: Place, known: dict[str, Config]) -> tuple[dict[str, Config], dict[str, set]]:
        """Return the configs of the runs of a section by name, and the names of the runs with each of ``FLAGS``."""
        bases = {name: self._base(base, place, "bases") for name, base in self._map(data, place, "bases").items()}
        base = self._base(data["base"], place, "base") if "base" in data else None
        configs: dict[str, Config] = {}
        flags: dict[str, set] = {flag: set() for flag in FLAGS}
        for name, changes in self._map(data, place, "runs").items():
            where = (*place, "runs", name)
            if not NAME.fullmatch(name):
                self._fail(where, "a name has letters, digits, and the signs . _ - inside")
            if not isinstance(changes, dict):
                self._fail(where, "must be a map of changes, such as {discretisation.particles_across: 50}")
            config = self._start(changes, where, base, bases, {**known, **configs})
            for key, value in changes.items():
                if key not in OF_RUNS:
                    self._change(config, key, value, (*where, key))
            if "samples" in changes:
                times = changes["samples"]
                if not isinstance(times, list) or not times:
                    self._fail((*where, "samples"), "must be a list of times, such as [1.8, 2.7]")
                config["time"] = {**config.get("time", {}), "end": times[-1], "samples": times}
            for flag, names in flags.items():
                if changes.get(flag, False) not in (True, False):
                    self._fail((*where, flag), "must be true or false")
                if changes.get(flag):
                    names.add(name)
            if name in flags["resumed"] & flags["estimated"]:
                self._fail((*where, "estimated"), "not with resumed: a run is one or the other")
            if self.path.parent != FOLDER:  # tests check our own suites
                try:
                    loaded(config, {})
                except ConfigError as error:
                    self._fail(where, str(error).removeprefix("config: "))
            configs[name] = config
        return configs, flags

    def _start(
        self,
        changes: dict,
        where: Place,
        base: Config | None,
        bases: dict[str, Config],
        known: dict[str, Config],
    ) -> Config:
        """Return a copy of the config that a run changes."""
        for key, found in (("like", known), ("base", bases)):
            if key in changes:
                name = changes[key] = str(changes[key])
                if name not in found:
                    self._fail((*where, key), f"there is no {name!r}{nearest(name, list(found))} before it")
                return copy.deepcopy(found[changes[key]])
        if base is None:
            self._fail(where, "needs base: NAME, one of bases, since the suite has no base")
        return copy.deepcopy(base)

    def _base(self, base: Any, place: Place, key: str) -> Config:
        """Return a base, which is a map or the name of a file beside this one."""
        if isinstance(base, dict):
            return base
        if not isinstance(base, str):
            self._fail((*place, key), "must be the name of a config, or a map of its keys")
        path = self.path.parent / base
        try:
            return {key: value for key, value in parse(path.read_text(encoding="utf-8")).data.items() if key != "name"}
        except (OSError, UnicodeDecodeError) as error:
            self._fail((*place, key), f"{base}: cannot be read: {getattr(error, 'strerror', None) or error}")
        except (YamlTextError, AttributeError) as error:
            self._fail((*place, key), f"{base}: is no config: {error}")

    def _change(self, config: Config, key: str, value: Any, where: Place) -> None:
        """Set the value of a dotted ``key``, in which a number is an index in a list."""
        *parents, last = key.split(".")
        try:
            section: Any = config
            for part in parents:
                below = step(section, part, key)
                section = section.setdefault(part, {}) if isinstance(section, dict) else section[below]
            section[step(section, last, key)] = copy.deepcopy(value)
        except ConfigError as error:
            self._fail(where, str(error))

    def _criteria(self, data: dict, place: Place, configs: dict[str, Config]) -> list[Criterion]:
        found: list[Criterion] = []
        entries = data.get("checks", [])
        if not isinstance(entries, list) or not entries:
            self._fail((*place, "checks"), "must be a list of checks")
        for number, entry in enumerate(entries):
            where = (*place, "checks", number)
            if not isinstance(entry, dict):
                self._fail(where, "must be a map, such as {run: fine, t: 2.7, at_most: {l2: 1.0e-3}}")
            try:
                criteria = list(checks.criteria(entry, set(configs)))
                if not criteria:
                    raise SuiteError(None, "checks nothing: a list or a map in it is empty")
                found += criteria
            except SuiteError as mistake:
                self._fail(where if mistake.key is None else (*where, mistake.key), mistake.text)
        return found

    def _map(self, data: dict, place: Place, key: str) -> dict[str, Any]:
        found = data.get(key, {})
        if not isinstance(found, dict):
            self._fail((*place, key), "must be a map")
        return found

    def _require_keys(self, data: dict, place: Place, allowed: tuple[str, ...]) -> None:
        for key in data:
            if key not in allowed:
                self._fail((*place, key), f"unknown key{nearest(key, list(allowed))}; allowed: {', '.join(allowed)}")

    def _fail(self, place: Place, text: str) -> NoReturn:
        """Raise the ConfigError of a mistake at the key ``place``, with the line of the nearest key around it."""
        key = ".".join(map(str, place))
        while place and place not in self._lines:
            place = place[:-1]
        raise ConfigError(f"{self.path}:{self._lines.get(place, 1)}: {key}: {text}")
