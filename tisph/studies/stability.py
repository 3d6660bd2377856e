"""Cells of the stability matrix, their configs, and the plan of each run.

The data are in ``suites/stability.yaml``. The unit of time is length over reference velocity; t* = 1 is at t = Re in a
channel, at t = 1 in all other flows.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np

from tisph.config import load
from tisph.errors import ConfigError
from tisph.schemes._forecast import forecast
from tisph.schemes.auto import ELASTIC_STEPS
from tisph.schemes.implicit import LARGEST_STRAIN
from tisph.schemes.implicit.channel.walls import TREATMENTS
from tisph.schemes.wcsph._time_step import AUTO_CFL
from tisph.schemes.wcsph.equation_of_state import SCALE_RATIO, Tait, sound_speed
from tisph.studies.expressions import digits, filled, merged
from tisph.studies.store import config_text
from tisph.studies.suites import study

DATA = study("stability")
AXES = DATA["covering"]

TOLERANCE, STRAIN = 3e-7, 0.5
"""Defaults of scheme ``implicit``, which ``Cell.step`` multiplies."""

ELASTIC_TOLERANCE, ELASTIC_STRAIN = ELASTIC_STEPS["balanced"]
"""Defaults of ``auto`` for viscoelastic fluids, whose steps are three times as long."""

TWO_DIMENSIONAL_TOLERANCE, COURANT = 2e-6, 0.3
"""Defaults of ``implicit`` for two-dimensional flow."""

SCHEMES = {"explicit": "exp", "implicit 2": "imp2", "implicit 4": "imp4"}
"""Schemes and orders, and their short names."""

STABLE, FINISHED, FLAGGED, REFUSED = "stable", "finished", "flagged", "refused"
"""Requirements. ``STABLE``: a stable run. ``FINISHED``: a run that finishes without growth, with its error in the map.
``FLAGGED``: anything but a silent failure, that is a wrong result without a warning. ``REFUSED``: ``tisph check``
refuses the config."""

UNBALANCED, FINER, BOTH_STRESSES, EXACT = "unbalanced", "finer", "both_stresses", "exact"
"""Errors that are computed from several numbers of a sample. ``UNBALANCED``: the sum of the forces on all bodies and
walls over the largest force. ``FINER``: the difference to a run with twice the particles across, of the drag, of free
bodies' velocities, or of the torque and the radial velocity of Taylor's vortices. ``BOTH_STRESSES``: the relative
difference between the shear stresses by the bodies and on the walls. ``EXACT``: the largest of the errors of the
velocity (L2) and of the loads on the walls."""

PREDICTABLE = 5.0
"""Time [length/speed] up to which vortices can be compared at Reynolds numbers above 1000. Undamped disturbances of
their size grow by a factor e in a time of 2, so that no run can follow the exact flow for longer."""

COMPARED_ACROSS, FINER_JITTER = 24, 0.3
"""Particles across up to which a run is compared with a finer one, and the jitter of the finer one."""

RESOLVED = 10.0
"""Cell Reynolds number up to which a flow between curved walls must be stable with 12 particles across or more."""

LEAST_COLUMNS = 10
"""Particles along the channel that the neighbour search of the explicit scheme needs."""

LARGEST_REYNOLDS = 1000.0
"""Largest Reynolds number of a cell of given elasticity number; the steps, limited by strain, are about as many."""

WAVES = 3
"""Times that an elastic wave crosses the gap in such a cell; a crossing takes sqrt(E) viscous times, E the elasticity
number."""


@dataclass(frozen=True)
class Flow:
    """A flow of a ``family`` of ``stability.yaml``: its ``kind`` and ``config``, and the values of ``names`` in it.

    ``measure``: the error that is judged, None without a reference; ``peak``: bound of the speed over the reference
    velocity, see ``Scene.peak_velocity``; ``largest``: largest error of a stable run between curved walls, 12 across.
    """

    family: str
    config: dict[str, Any]
    names: dict[str, Any]
    kind: str = "channel"
    measure: str | None = "l2"
    peak: float = 1.0
    largest: float = 0.0

    def unit_time(self, reynolds: float) -> float:
        """Return the time t* = 1 in lengths over reference velocity: in a channel the viscous time."""
        return reynolds if self.kind == "channel" else 1.0


@cache
def flow_of(name: str) -> Flow:
    """Return the ``Flow`` of the first family that the name fits."""
    for family in DATA["flows"]:
        data = _family(family)
        names = data.pop("let", {})
        parameters = _parameters(family, name, names)
        if parameters is not None:
            return Flow(family, names=names | parameters, **data)
    raise KeyError(name)


def _family(name: str) -> dict[str, Any]:
    data = dict(DATA["flows"][name])
    return merged(_family(data.pop("like")), data) if "like" in data else data


def _parameters(family: str, name: str, names: dict[str, Any]) -> dict[str, Any] | None:
    """Return the values of the parameters in the braces of a family's name; None if ``name`` is in another family."""

    def group(braces: re.Match) -> str:
        words = names.get(braces[1])
        choices = "|".join(map(re.escape, words)) if isinstance(words, dict) else r"[\d.]+"
        return f"(?P<{braces[1]}>{choices})"

    found = re.fullmatch(re.sub(r"\\\{(\w+)\\\}", group, re.escape(family)), name)
    if found is None:
        return None
    return {key: names[key][text] if key in names else float(text) for key, text in found.groupdict().items()}


@dataclass(frozen=True)
class Cell:
    """One run of the matrix.

    ``flow``: one of ``stability.yaml``; ``jitter`` in spacings; ``scheme``: a key of ``SCHEMES``; ``step``: length of
    the steps over the default; ``sound``: sound speed over the fastest velocity scale (explicit scheme only);
    ``aspect``: length of a channel over its gap; ``solvent``: solvent viscosity over the viscosity of an Oldroyd-B
    fluid, by default the smallest for which the explicit scheme is verified; ``t_star``: end of the run, if the budget
    of seconds allows it.
    """

    flow: str = "couette"
    reynolds: float = 50.0
    jitter: float = 0.0
    across: int = 25
    scheme: str = "explicit"
    treatment: str = "consistent_image"
    step: float = 1.0
    sound: float = SCALE_RATIO
    precision: str = "f64"
    aspect: float = 2.0
    solvent: float = 0.1
    t_star: float = 1.0

    @property
    def name(self) -> str:
        """Name of the run: flow, Reynolds number, jitter, resolution and scheme, then values that are not defaults."""
        parts = [self.flow, f"re{self.reynolds:g}", f"j{self.jitter:g}", f"n{self.across}", SCHEMES[self.scheme]]
        usual = Cell()
        special = {
            "treatment": self.treatment.removesuffix("_image"),
            "step": f"s{self.step:g}",
            "sound": f"c{self.sound:g}",
            "precision": self.precision,
            "aspect": f"l{self.aspect:g}",
            "solvent": f"b{self.solvent:g}",
            "t_star": f"t{self.t_star:g}",
        }
        return "-".join(parts + [text for key, text in special.items() if getattr(self, key) != getattr(usual, key)])

    @property
    def baseline(self) -> "Cell":
        """The cell with which this one is compared: the same one from the lattice.

        In two-dimensional flow, where a run from the lattice is no calmer, it is the cell itself. The baseline of an
        error ``FINER`` has twice the particles across, and is the same for every jitter.
        """
        if self.measure == FINER and self.across <= COMPARED_ACROSS and self.flow not in DATA["refused"]:
            return replace(self, across=2 * self.across, jitter=FINER_JITTER)
        return self if self.two_dimensional else replace(self, jitter=0.0)

    @property
    def cell_reynolds(self) -> float:
        """Reynolds number of a particle spacing, U dx / nu, by the viscosity of the solvent."""
        return self.reynolds / self.across / (self.solvent if self.has_polymer else 1.0)

    @property
    def usual(self) -> bool:
        """Whether walls, steps and sound speed are the defaults."""
        defaults = Cell()
        return all(getattr(self, key) == getattr(defaults, key) for key in ("treatment", "step", "sound"))

    @property
    def weissenberg(self) -> Any:
        """Relaxation time * wall speed / gap of an Oldroyd-B fluid in a channel, a float; else None."""
        return None if self.two_dimensional else flow_of(self.flow).names.get("weissenberg")

    @property
    def has_polymer(self) -> bool:
        """Whether the fluid is an Oldroyd-B fluid in a channel."""
        return self.weissenberg is not None

    @property
    def elasticity(self) -> float:
        """Relaxation time over viscous time of an Oldroyd-B fluid."""
        return digits(self.weissenberg / self.reynolds)

    @property
    def kind(self) -> str:
        """``channel``, ``doubly_periodic`` (a square), or ``curved_walls`` (also a cavity, and bodies in the flow)."""
        return flow_of(self.flow).kind

    @property
    def two_dimensional(self) -> bool:
        """Whether the flow is two-dimensional: particles leave their layers."""
        return self.kind != "channel"

    @property
    def measure(self) -> str | None:
        """Error that is judged; None where there is none, or where the flow cannot be predicted."""
        lost = self.kind == "doubly_periodic" and self.reynolds > 1000 and self.t_star > PREDICTABLE
        return None if lost else flow_of(self.flow).measure

    @property
    def requirement(self) -> str:
        """``STABLE``, ``FINISHED``, ``FLAGGED`` or ``REFUSED``."""
        if self.flow in DATA["refused"] or (self.kind == "doubly_periodic" and self.scheme == "implicit 2"):
            return REFUSED
        if not (self.usual and self.flow in DATA["required"] and self.jitter <= 0.3):
            return FLAGGED
        if self.kind == "curved_walls":
            return STABLE if self.across >= 12 and self.cell_reynolds <= RESOLVED else FLAGGED
        if self.across < 25 or self.scheme == "implicit 2":
            return FLAGGED
        if self.kind == "doubly_periodic" and self.scheme == "implicit 4":
            return STABLE
        if self.reynolds <= 1000:
            return FINISHED if self.kind == "doubly_periodic" else STABLE
        return FINISHED if self.flow == "couette" else FLAGGED

    @property
    def required(self) -> bool:
        """Whether the run must be stable, or finish."""
        return self.requirement in (STABLE, FINISHED)

    def config(self, t_star: float) -> dict[str, Any]:
        """Config of the run to ``t_star``, a plain dict without a name."""
        flow = flow_of(self.flow)
        end = t_star * flow.unit_time(self.reynolds)
        names = {**flow.names, **vars(self), "nu": 1.0 / self.reynolds, "end": end}
        return filled(merged(DATA["config"], DATA["kinds"][flow.kind], flow.config, self._scheme_change()), names)

    def _scheme_change(self) -> dict[str, Any]:
        if self.scheme == "explicit":
            state = {"sound_speed": "auto" if self.sound == SCALE_RATIO else self._sound_speed()}
            change = {"scheme": {"type": "wcsph", "equation_of_state": state}}
            return merged(change, {"time": {"cfl": AUTO_CFL * self.step}} if self.step != 1.0 else {})
        scheme: dict[str, Any] = {"type": "implicit", "operators": {"order": int(self.scheme[-1])}}
        if self.two_dimensional:  # other steps than the default are not controlled by their error
            usual = {} if self.kind == "curved_walls" else {"tolerance": TWO_DIMENSIONAL_TOLERANCE}
            steps = usual if self.step == 1.0 else {"cfl": digits(COURANT * self.step)}
            return {"scheme": {**scheme, "largest_courant": COURANT}, "time": steps}
        # the error of a step scales with the third power of its length
        tolerance, strain = (ELASTIC_TOLERANCE, ELASTIC_STRAIN) if self.has_polymer else (TOLERANCE, STRAIN)
        return {
            "scheme": {**scheme, "largest_strain": digits(min(strain * self.step, LARGEST_STRAIN))},
            "time": {"tolerance": digits(tolerance * self.step**3)},
        }

    def _sound_speed(self) -> float:
        """Return the sound speed: ``sound`` times the velocity scale that sets an automatic sound speed."""
        nu = 1.0 / self.reynolds
        relaxation = self.weissenberg
        automatic = sound_speed(
            Tait(),
            reference_velocity=flow_of(self.flow).peak,
            kinematic_viscosity=nu,
            length=1.0,
            density=1.0,
            elastic_speed=((1.0 - self.solvent) * nu / relaxation) ** 0.5 if relaxation else 0.0,
        )
        return digits(automatic * self.sound / SCALE_RATIO)


@dataclass(frozen=True)
class SubMatrix:
    """Cells under a title, and the axes of the columns and rows of their map; without axes they are counted by axis."""

    title: str
    cells: tuple[Cell, ...]
    columns: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()


def sub_matrices(quick: bool = False, only: str | None = None) -> list[SubMatrix]:
    """Return all sub-matrices, or if ``quick`` a few short cells of every kind, in a fixed order.

    A cell may be in several of them. ``only``: text in the titles; ValueError where no title has it.
    """
    parts = _parts("quick" if quick else "full")
    chosen = [part for part in parts if only is None or only in part.title]
    if not chosen:
        titles = ", ".join(part.title for part in parts)
        raise ValueError(f"no sub-matrix has {only!r} in its title; there are {titles}")
    return chosen


def cells(chosen: Iterable[SubMatrix]) -> list[Cell]:
    """Return every cell of sub-matrices once, each after its baseline."""
    return list(dict.fromkeys(each for part in chosen for cell in part.cells for each in (cell.baseline, cell)))


@cache  # the covering set is a second of work
def _parts(extent: str) -> list[SubMatrix]:
    """Return the sub-matrices of ``stability.yaml``; the one without grids is the covering set."""
    parts = []
    for data in DATA[extent]:
        if "grids" in data:
            found = sum((grid(**values) for values in data["grids"]), ())
        else:
            found = tuple(Cell(**row) for row in covering_set(AXES, covered))
        parts.append(SubMatrix(data["title"], found, tuple(data.get("columns", ())), tuple(data.get("rows", ()))))
    return parts


def grid(**values: Any) -> tuple[Cell, ...]:
    """Return all existing cells with one of the values of every named axis, the last axis varying fastest.

    A cell of a given ``elasticity`` runs until waves have crossed the gap ``WAVES`` times.
    """
    choices = [each if isinstance(each, list | tuple) else [each] for each in values.values()]
    rows = [dict(zip(values, chosen, strict=True)) for chosen in product(*choices)]
    found = []
    for row in rows:
        if not exists(row):
            continue
        elasticity = row.pop("elasticity", None)
        if elasticity is not None:
            row["reynolds"] = digits(Cell(flow=row["flow"]).weissenberg / elasticity)
            row["t_star"] = max(1.0, round(WAVES * elasticity**0.5))
        if elasticity is None or row["reynolds"] <= LARGEST_REYNOLDS:
            found.append(Cell(**row))
    return tuple(found)


def exists(values: dict[str, Any]) -> bool:
    """Return whether a config can have these ``values`` (axis -> value) together; axes may be missing."""
    across, aspect = values.get("across"), values.get("aspect")
    if across and aspect and (across * aspect % 1 or across * aspect < LEAST_COLUMNS):
        return False
    if values.get("scheme", "explicit") == "explicit":
        return True
    return values.get("sound", SCALE_RATIO) == SCALE_RATIO and values.get("treatment", "consistent_image") in TREATMENTS


def covered(values: dict[str, Any]) -> bool:
    """Return whether the covering set has these values together; viscoelastic fluids have their own sub-matrices."""
    viscoelastic = Cell(flow=values.get("flow", "couette")).has_polymer
    return exists(values) and not (viscoelastic and values.get("scheme", "explicit") != "explicit")


def covering_set(axes: dict[str, list], exists: Callable[[dict], bool]) -> list[dict[str, Any]]:
    """Return rows, dicts with a value of every axis, that together contain every possible pair of values.

    ``axes`` (name -> values). ``exists(values)``: whether two values, a dict of two axes, can occur together. The
    algorithm is greedy and deterministic: each row is the first one with the most new pairs. Two libraries were tried:
    allpairspy 2.5 misses 19 of 622 pairs of the matrix, because some values exclude one another; covertable 3.2 finds
    all pairs in 45 rows, this function in 48.
    """
    values = [(name, value) for name, choices in axes.items() for value in choices]
    sizes = [len(choices) for choices in axes.values()]
    first = np.cumsum([0, *sizes[:-1]])
    rows = np.indices(sizes).reshape(len(sizes), -1).T + first  # every row there is, as positions in ``values``
    possible = np.array([[exists(dict([one, other])) for other in values] for one in values])
    columns = list(combinations(range(len(sizes)), 2))
    pairs = np.stack([rows[:, one] * len(values) + rows[:, other] for one, other in columns], axis=1)
    whole = possible.ravel()[pairs].all(axis=1)
    rows, pairs = rows[whole], pairs[whole]
    missing = np.zeros(possible.size, dtype=bool)
    missing[pairs] = True
    chosen = []
    while missing.any():
        best = int(np.argmax(missing[pairs].sum(axis=1)))
        missing[pairs[best]] = False
        chosen.append(dict(values[position] for position in rows[best]))
    return chosen


@dataclass(frozen=True)
class Plan:
    """The run of a cell: its config, its end t*, its estimated ``seconds``, and the forecast of ``tisph check``.

    ``predicted``: the predicted error, None without a prediction; ``warnings``: texts; ``refusal``: why the config is
    refused, else None.
    """

    cell: Cell
    config: dict[str, Any]
    t_star: float
    seconds: float = 0.0
    predicted: float | None = None
    warnings: tuple[str, ...] = ()
    refusal: str | None = None


def plan(cell: Cell, folder: Path) -> Plan:
    """Return the ``Plan`` of a cell; ``folder`` is for a config file to be checked."""
    t_star = cell.t_star
    try:
        numbers, warnings = _checked(cell, t_star, folder)
        seconds, budget = _seconds(cell, numbers), _budget(cell)
        if seconds > budget:
            t_star = float(f"{t_star * budget / seconds:.1e}")
            numbers, warnings = _checked(cell, t_star, folder)
    except ConfigError as error:
        return Plan(cell, cell.config(t_star), t_star, refusal=str(error).partition(": ")[2])
    stated = getattr(numbers["samples"][-1], cell.measure, None) if cell.measure else None
    return Plan(cell, cell.config(t_star), t_star, _seconds(cell, numbers), stated, tuple(warnings))


def _checked(cell: Cell, t_star: float, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Return the forecast of the last sample, by which the cell is judged."""
    config = cell.config(t_star)
    last = {**config, "time": {**config["time"], "samples": config["time"]["samples"][-1:]}}
    path = folder / "config.yaml"
    path.write_text(config_text(cell.name, last), encoding="utf-8")
    return forecast(load(path))


def _seconds(cell: Cell, numbers: dict[str, Any]) -> float:
    step, particle = DATA["seconds"][cell.scheme]
    return numbers["steps"] * (step + numbers["particles"] * particle)


def _budget(cell: Cell) -> float:
    """Return the longest run time of a cell [s]; a longer run ends at an earlier t*."""
    budget = DATA["budget"]
    if cell.measure == FINER:
        return budget[STABLE]  # both runs that are compared must end at the same time
    double = cell.precision == "f64" or cell.requirement == FINISHED
    compared = (cell.across == 25 or cell.kind == "curved_walls") and double
    return budget.get(cell.requirement, budget[FLAGGED]) if compared else budget[FLAGGED]
