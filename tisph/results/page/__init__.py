"""Runs as HTML: one page to mail, and the view in a notebook. Templates write it, and escape every text.

The page needs no network and no script: movie, pictures and tables with their words are in it.
"""

import json
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tisph import schemes
from tisph.folder import Folder
from tisph.measures.heat import dimensionless_numbers
from tisph.report.encoder import poster
from tisph.report.labels import number, scientific
from tisph.version import __version__

if TYPE_CHECKING:
    from jinja2 import Environment

    from tisph.results import Results
    from tisph.results._results import SampleErrors

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
    """``header`` and ``rows``, each named by its first cell; ``note`` lists omissions."""

    title: str
    header: list[str]
    rows: list[Row]
    note: str = ""


def error_table(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """Errors of the velocity, a row a sample."""
    rows = []
    for start, sample in _shown(runs, views):
        errors = [NOTHING if each is None else scientific(each) for each in (sample.l2, sample.rms, sample.linf)]
        resolved = "yes" if sample.resolved else f"no: {sample.reason}"
        rows.append(Row([*start, number(sample.t_star, 3), *errors, resolved]))
    header = ["run", "t", "t*", "L2, relative", "rms / U", "max / U", "resolved"]
    return _named_once(Table("Errors of the velocity", header, rows, _note(runs)), runs)


def measure_table(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """Measures of the scene at a sample: wall forces, torques, fluxes, energies, beside their exact values."""
    rows = [Row([*start, *texts]) for start, sample in _shown(runs, views) for texts in _measured(sample)]
    title = "Wall forces and other numbers at the samples"
    header = ["run", "t", "quantity", "run", "exact", "difference"]
    return _named_once(Table(title, header, rows, _note(runs)), runs)


def _measured(sample: "SampleErrors") -> Iterator[list[str]]:
    known = {each.name for each in fields(sample)}
    for name, value in sample.measures.items():
        if name in known or name.endswith(_SUFFIX) or isinstance(value, str):
            continue
        exact = sample.measures.get(name + _SUFFIX)
        both = isinstance(value, float) and isinstance(exact, float)
        difference = scientific(value - exact) if both else NOTHING  # type: ignore[operator]
        yield [name.replace("_", " "), cell_text(value), cell_text(exact), difference]


def estimate_table(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """Return the errors estimated from coarser runs, for runs with ``--estimate-error``."""
    rows = []
    for run, view in zip(runs, views, strict=True):
        found = run.summary.error_estimate or {}
        for sample in found.get("samples", []):
            time = f"{number(sample['t'])} {run.config.units.time}"
            for kind, words in (("fields", "relative, L2"), ("numbers", "absolute")):
                for name, each in sample[kind].items():
                    spread = each.get("spread")  # there is none in folders of older versions
                    error = NOTHING if spread is None else f"spread {scientific(spread)}"
                    error = error if each["error"] is None else scientific(each["error"])
                    remark = each["reason"] if each["error"] is None else words
                    order = NOTHING if each["order"] is None else number(each["order"], 2)
                    rows.append(Row([view.title, time, name.replace("_", " "), error, order, remark]))
        if found.get("reason"):
            rows.append(Row([view.title, NOTHING, "none", NOTHING, NOTHING, found["reason"]]))
    header = ["run", "t", "quantity", "error", "order", "remark"]
    return _named_once(Table("Errors estimated from coarser runs", header, rows), runs)


def accuracy_table(runs: "Sequence[Results]", views: "Sequence[View]") -> Table:
    """Return the error bars of runs with ``--until``, and their parts."""
    rows = []
    for run, view in zip(runs, views, strict=True):
        for name, each in run.accuracy.items():
            parts = ", ".join(f"{part} {scientific(size)}" for part, size in each["parts"].items() if size)
            sizes = (NOTHING if each[key] is None else scientific(each[key]) for key in ("bar", "goal"))
            value = cell_text(each["value"])
            remark = each["reason"] or ""
            reached = "yes" if each["reached"] else "no"
            rows.append(Row([view.title, name.replace("_", " "), value, *sizes, reached, parts, remark]))
    header = ["run", "number", "value", "error bar", "goal", "reached", "parts of the bar", "remark"]
    return _named_once(Table("Error bars, from a chain of runs", header, rows), runs)


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


def config_table(runs: "Sequence[Results]") -> Table:
    """Every key of the configs, a column a run; marked where they differ."""
    maps = [dict(_flat(run.config.resolved())) for run in runs]
    return Table("Config", ["key", *(run.summary.name for run in runs)], _columns(maps))


def cell_text(value: Any) -> str:
    """Return a value of a summary or a config as a reader wants it."""
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value, 6)
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _columns(maps: Sequence[Mapping[str, Any]], in_words: bool = False) -> list[Row]:
    """Return a row for each key of the maps, with their values; ``in_words`` for numbers, which always differ."""
    rows = []
    for key in dict.fromkeys(key for each in maps for key in each):
        values = [each.get(key) for each in maps]
        differ = not in_words and any(value != values[0] for value in values)
        rows.append(Row([key.replace("_", " ") if in_words else key, *map(cell_text, values)], differ))
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


def _shown(runs: "Sequence[Results]", views: "Sequence[View]") -> "Iterator[tuple[list[str], SampleErrors]]":
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


_TYPES = {".png": "image/png", ".mp4": "video/mp4", ".jpg": "image/jpeg"}
_TIMES_NAMED = 6


@dataclass(frozen=True)
class Element:
    """A picture or a movie: its file as a ``data:`` address, a description in words, and a still."""

    address: str
    words: str
    poster: str | None = None


@dataclass(frozen=True)
class View:
    """The parts of one run on a page; None where the run left no such file."""

    title: str
    folder: str
    status: str
    message: str | None
    facts: list[tuple[str, str]]
    movie: Element | None
    profiles: Element | None
    history: Element | None
    chain: Element | None

    @classmethod
    def of(cls, run: "Results", title: str) -> "View":
        """Of ``run``, which the page calls ``title``."""
        summary, files, time = run.summary, Folder(run.folder), run.config.units.time
        times = [f"{number(sample.t)} {time}" for sample in summary.samples]
        shown = ", ".join(times if len(times) <= _TIMES_NAMED else [*times[:_TIMES_NAMED], "..."])
        video = run.config.output.video
        film = f"particles coloured by {video.color_by}, with the profile beside them" if video else "the particles"
        series = run._scene.time_series(**run.config.time_series).content
        return cls(
            title=title,
            folder=str(run.folder),
            status=summary.status,
            message=summary.message,
            facts=_facts(run),
            movie=element(
                files.movie,
                f"Movie of {title} from t = {number(run.config.start_time)} to {number(run.config.time.end)} {time}: "
                f"{film}.",
            ),
            profiles=element(
                files.profiles_picture,
                f"Profiles of {title} at t = {shown}: particles, and the reference as lines where there is one. "
                f"{_error_words(run)}",
            ),
            history=element(
                files.history_picture,
                f"History of {title}: {series}. Markers are the run, lines the reference where there is one.",
            ),
            chain=element(
                files.accuracy_picture,
                f"Numbers of {title} against the spacing, with the goal around the finest run and its error bar.",
            ),
        )


def element(path: Path, words: str) -> Element | None:
    """Return the picture or movie in ``path``, None where there is no such file."""
    if not path.is_file():
        return None
    still = poster(path) if path.suffix == ".mp4" else None
    return Element(_address(path.suffix, path.read_bytes()), words, _address(".jpg", still) if still else None)


def _address(suffix: str, content: bytes) -> str:
    return f"data:{_TYPES[suffix]};base64,{b64encode(content).decode()}"


def _facts(run: "Results") -> list[tuple[str, str]]:
    """Return parameters of the flow, as ``tisph check`` prints them, scheme and number of particles."""
    numbers = run.summary.numbers
    facts = [
        *run._scene.parameters(),
        *dimensionless_numbers(run._scene),
        ("scene", run.config.scene),
        ("scheme", schemes.resolve(run.config)[1]),
    ]
    if "particles_fluid" in numbers:
        facts.append(("particles", str(numbers["particles_fluid"])))
    units = run.config.units
    return [*facts, ("units", f"{units.length}, {units.mass}, {units.time}")]


def _error_words(run: "Results") -> str:
    last = run.summary.samples[-1] if run.summary.samples else None
    if last is None or last.l2 is None:
        return ""
    return f"L2 error at the last one: {number(last.l2, 2)}."


_TEMPLATES = Path(__file__).parent / "templates"


def report(runs: "Sequence[Results]") -> str:
    """Return one page about ``runs``: side by side where there are several."""
    names = [run.summary.name for run in runs]
    same = len(set(names)) < len(names)  # then the folders tell them apart
    views = [View.of(run, str(run.folder) if same else run.summary.name) for run in runs]
    return (
        _environment()
        .get_template("report.html")
        .render(
            views=views,
            title=", ".join(view.title for view in views),
            tables=[
                error_table(runs, views),
                estimate_table(runs, views),
                accuracy_table(runs, views),
                measure_table(runs, views),
                *side_by_side(runs),
            ],
            config=config_table(runs),
            version=__version__,
        )
    )


def fragment(run: "Results") -> str:
    """Return movie, pictures and errors of a run, for a notebook."""
    view = View.of(run, run.summary.name)
    errors = error_table([run], [view])
    return _environment().get_template("fragment.html").render(view=view, errors=errors)


def movie_element(path: Path, title: str) -> str:
    """Return the movie in the file ``path`` as an element that a notebook plays."""
    return _environment().get_template("movie.html").render(movie=element(path, f"Movie of {title}"))


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(_TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
