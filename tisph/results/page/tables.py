"""What a page says in tables: header and rows of texts."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from tisph.report.labels import number, scientific
from tisph.results._summary import SampleErrors

if TYPE_CHECKING:
    from tisph.results import Results
    from tisph.results.page.view import View

NOTHING = "\N{EN DASH}"

_MOST_SAMPLES = 12
_SUFFIX = "_exact"


@dataclass(frozen=True)
class Row:
    """A line of a table; ``marked`` where the runs differ in it."""

    cells: list[str]
    marked: bool = False


@dataclass(frozen=True)
class Table:
    """``header`` and ``rows``, the first cell of each of which names it; ``note`` says what is omitted."""

    title: str
    header: list[str]
    rows: list[Row]
    note: str = ""


def errors(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """Errors of the velocity, a row a sample."""
    rows = []
    for start, sample in _shown(runs, views):
        errors = [NOTHING if each is None else scientific(each) for each in (sample.l2, sample.rms, sample.linf)]
        resolved = "yes" if sample.resolved else f"no: {sample.reason}"
        rows.append(Row([*start, number(sample.t_star, 3), *errors, resolved]))
    header = ["run", "t", "t*", "L2, relative", "rms / U", "max / U", "resolved"]
    return _named_once(Table("Errors of the velocity", header, rows, _note(runs)), runs)


def measures(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """What the scene measures of a sample: wall forces, torques, fluxes, energies, with the exact ones beside them."""
    rows = [Row([*start, *texts]) for start, sample in _shown(runs, views) for texts in _measured(sample)]
    title = "Wall forces and other numbers at the samples"
    header = ["run", "t", "quantity", "run", "exact", "difference"]
    return _named_once(Table(title, header, rows, _note(runs)), runs)


def _measured(sample: SampleErrors) -> Iterator[list[str]]:
    known = {each.name for each in fields(SampleErrors)}
    for name, value in sample.measures.items():
        if name in known or name.endswith(_SUFFIX) or isinstance(value, str):
            continue
        exact = sample.measures.get(name + _SUFFIX)
        both = isinstance(value, float) and isinstance(exact, float)
        difference = scientific(value - exact) if both else NOTHING  # type: ignore[operator]
        yield [name.replace("_", " "), text(value), text(exact), difference]


def estimates(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """The errors that coarser runs tell of, of those that were asked for them (``--estimate-error``)."""
    rows = []
    for run, view in zip(runs, views, strict=True):
        found = run.summary.error_estimate or {}
        for sample in found.get("samples", []):
            time = f"{number(sample['t'])} {run.config.units.time}"
            for kind, words in (("fields", "relative, L2"), ("numbers", "absolute")):
                for name, each in sample[kind].items():
                    error = NOTHING if each["error"] is None else scientific(each["error"])
                    remark = each["reason"] if each["error"] is None else words
                    order = NOTHING if each["order"] is None else number(each["order"], 2)
                    rows.append(Row([view.title, time, name.replace("_", " "), error, order, remark]))
        if found.get("reason"):
            rows.append(Row([view.title, NOTHING, "none", NOTHING, NOTHING, found["reason"]]))
    header = ["run", "t", "quantity", "error", "order", "remark"]
    return _named_once(Table("Errors estimated from coarser runs", header, rows), runs)


def side_by_side(runs: "Sequence[Results]") -> list[Table]:
    """Numbers, balance of momentum, costs and provenance: a column a run."""
    summaries = [run.summary for run in runs]
    parts: list[tuple[str, list[Mapping[str, Any]]]] = [
        ("Numbers of the run", [each.numbers for each in summaries]),
        ("Balance of momentum along x", [each.momentum for each in summaries]),
        ("Costs", [vars(each.cost) for each in summaries]),
        ("Provenance", [{**vars(each.provenance), **_versions(each)} for each in summaries]),
    ]
    names = [each.name for each in summaries]
    return [Table(title, ["", *names], _columns(maps, in_words=True)) for title, maps in parts if any(maps)]


def config(runs: "Sequence[Results]") -> Table:
    """Every key of the configs, a column a run; marked where they differ."""
    maps = [dict(_flat(run.config.resolved())) for run in runs]
    return Table("Config", ["key", *(run.summary.name for run in runs)], _columns(maps))


def text(value: Any) -> str:
    """Return a value of a summary or a config as a reader wants it."""
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value, 6)
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _columns(maps: Sequence[Mapping[str, Any]], in_words: bool = False) -> list[Row]:
    """Return a row for each key, with what the maps have; names of measured numbers, which always differ, in words."""
    rows = []
    for key in dict.fromkeys(key for each in maps for key in each):
        values = [each.get(key) for each in maps]
        differ = not in_words and any(value != values[0] for value in values)
        rows.append(Row([key.replace("_", " ") if in_words else key, *map(text, values)], differ))
    return rows


def _named_once(table: Table, runs: "Sequence[Results]") -> Table:
    """Return ``table`` without its first column, the run, where there is only one."""
    if len(runs) > 1:
        return table
    return replace(table, header=table.header[1:], rows=[Row(row.cells[1:]) for row in table.rows])


def _flat(data: Any, before: str = "") -> Iterable[tuple[str, Any]]:
    """Yield dotted key and value of all that is in nested maps."""
    for key, value in data.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, f"{before}{key}.")
        else:
            yield before + key, value


def _versions(summary: Any) -> dict[str, Any]:
    return {"versions": ", ".join(f"{name} {version}" for name, version in summary.provenance.versions.items())}


def _shown(runs: "Sequence[Results]", views: "Sequence[View]") -> Iterator[tuple[list[str], SampleErrors]]:
    """Yield title and time of the samples with themselves: of many, the first and last ones of a run."""
    half = _MOST_SAMPLES // 2
    for run, view in zip(runs, views, strict=True):
        samples = run.summary.samples
        for sample in (*samples[:half], *samples[half:][-half:]):
            yield [view.title, f"{number(sample.t)} {run.config.units.time}"], sample


def _note(runs: "Sequence[Results]") -> str:
    left_out = sum(max(0, len(run.summary.samples) - _MOST_SAMPLES) for run in runs)
    if not left_out:
        return ""
    return f"{left_out} samples between the first and the last ones are left out; summary.json has them."
