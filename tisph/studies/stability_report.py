"""``tisph stability``: runs of the matrix, a line as each cell ends, then maps, limits, picture and all numbers.

Every cell is a separate process on one thread, so that no cell can affect another. Runs are kept in the folder of the
results: an interrupted matrix continues where it stopped.
"""

import json
import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from datetime import datetime
from itertools import product
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle
from rich.console import Console

from tisph.folder import replaced
from tisph.report.style import constrained_figure, plot_style
from tisph.schemes.wcsph.equation_of_state import SCALE_RATIO
from tisph.studies.stability import AXES, DATA, Cell, Plan, SubMatrix, cells, plan
from tisph.studies.stability_judge import SILENT_FAILURE, VERDICTS, Judgement, judge, refused
from tisph.studies.store import START_SECONDS, Engine, Store, claimed
from tisph.text_table import format_header, format_row, format_table
from tisph.version import __version__

NUMBERS, TABLES, PICTURE = "stability.json", "stability.md", "stability.png"

NUMBERS_JUDGED = {
    "error": ("error", "{:.1e}", 7),
    "ratio": ("/ base", "{:.2g}", 6),
    "transverse_velocity": ("max |v|/U", "{:.1e}", 9),
    "density_variation": ("density", "{:.1e}", 7),
    "max_void_radius": ("void", "{:.2f}", 4),
    "min_distance": ("dist", "{:.2f}", 4),
}
"""Number of a ``Judgement`` -> title, format and width of its column."""

TITLES, FORMATS, NUMBER_WIDTHS = zip(*NUMBERS_JUDGED.values(), strict=True)
HEADER = ("cell", "required", "verdict", "t*", *TITLES, "steps", "s", "why")
WIDTHS = (57, 8, 14, 7, *NUMBER_WIDTHS, 8, 5, 0)

OLD_KEYS = {
    "promise": "requirement",
    "kept": "met",
    "stated_error": "predicted_error",
    "calm_error": "baseline_error",
    "hole": "max_void_radius",
    "nearest_two": "min_distance",
}
"""Former key of a number of a cell, which stability.json still has -> its key."""

LABELS = {
    "reynolds": "Re {:g}",
    "jitter": "jitter {:g}",
    "across": "{} across",
    "step": "steps x {:g}",
    "sound": "c = {:g}",
    "aspect": "length {:g}",
    "solvent": "solvent {:g}",
    "elasticity": "E = {:g}",
    "t_star": "t* = {:g}",
}
"""Axis -> format of its values in labels; values of other axes are shown alone."""

FLUIDS: dict[str, Callable[[Cell], bool]] = {
    "": lambda cell: not (cell.has_polymer or cell.two_dimensional),
    ", Oldroyd-B (of the solvent)": lambda cell: cell.has_polymer,
    ", doubly periodic": lambda cell: cell.kind == "doubly_periodic",
    ", curved walls": lambda cell: cell.kind == "curved_walls",
}
ARRANGEMENTS = {"lattice": False, "disordered": True}

COLOURS = dict(zip(VERDICTS, ("#56b4e9", "#f0e442", "#999999", "#dddddd", "#d55e00"), strict=True))
"""Okabe and Ito's colours, which colour-blind people can distinguish; every field also has its verdict in words."""

FIELD, PANEL_HEADER = 0.32, 0.75
"""Height of a field, and of the title and the labels of a panel [inches]."""

Rows = dict[Cell, Judgement]
Fields = dict[tuple[str, str], tuple[str, str, bool]]
"""(Row, column) of a map -> text, verdict, and whether the run must be stable or finish."""


def run(folder: Path, processes: int, parts: list[SubMatrix]) -> bool:
    """Run sub-matrices ``parts``, ``processes`` cells at a time, and leave all results in ``folder``.

    Returns True if every requirement is met. Raises ConfigError where ``folder`` cannot be used.
    """
    folder = Path(folder)
    rows: Rows = {}
    with claimed(folder, "another matrix is running there"):
        with tempfile.TemporaryDirectory() as scratch, Console(stderr=True).status("checking the configs"):
            plans = {cell: plan(cell, Path(scratch)) for cell in cells(parts)}
        began = time.perf_counter()
        seconds = {cell.name: each.seconds for cell, each in plans.items() if not each.refusal}
        with Engine(Store(folder / "runs"), processes, seconds) as engine:
            minutes = sum(each + START_SECONDS for each in seconds.values()) / 60 / processes
            engine.say(f"{len(plans)} cells, about {minutes:.0f} minutes with {processes} processes of one thread")
            engine.say(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
            engine.say(format_header(HEADER, WIDTHS))
            for row in _judgements(plans, engine):
                rows[row.cell] = row
                engine.say(format_row(_line(row), WIDTHS))
                _write(folder, rows, processes, complete=len(rows) == len(plans))
        found = limits(rows)
        text = f"{_tables(parts, rows)}\n\n### limits\n\n{_limits_tables(found)}\n"
        (folder / TABLES).write_text(text, encoding="utf-8")
        _plot(folder / PICTURE, parts, rows)
        _write(folder, rows, processes, complete=True, limits=found)
    print(f"\n{text}")
    missed = [row for row in rows.values() if not row.met]
    for row in missed:
        print(f"{row.cell.name}: required {row.cell.requirement}, is {row.verdict}: {row.reason}")
    verdicts = [row.verdict for row in rows.values()]
    counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in VERDICTS)
    took = (time.perf_counter() - began) / 60
    print(f"\n{len(rows)} cells: {counts}; {len(missed)} requirements missed; {took:.1f} minutes")
    print(f"picture: {folder / PICTURE}; maps: {folder / TABLES}; numbers: {folder / NUMBERS}")
    return not missed


def _judgements(plans: dict[Cell, Plan], engine: Engine) -> Iterator[Judgement]:
    """Yield the judgement of every plan as soon as its run and its baseline are known."""
    for each in plans.values():
        if each.refusal:
            yield refused(each)
    valid = {cell.name: each for cell, each in plans.items() if not each.refusal}
    ended: dict[Cell, tuple[dict[str, Any], str]] = {}
    with closing(engine.outcomes({name: each.config for name, each in valid.items()}, limited=True)) as outcomes:
        for name, result, message in outcomes:
            found = valid[name].cell
            ended[found] = result.summary, message
            for cell in [cell for cell in ended if cell == found or cell.baseline == found]:
                if cell.baseline in ended:
                    yield judge(plans[cell], *ended[cell], ended[cell.baseline][0])


def _line(row: Judgement) -> tuple[str, ...]:
    """Return the cells of a line of the table that is printed as runs end."""
    numbers = [getattr(row, name) for name in NUMBERS_JUDGED]
    texts = ["" if number is None else form.format(number) for number, form in zip(numbers, FORMATS, strict=True)]
    start = (row.cell.name, row.cell.requirement, row.verdict, f"{row.plan.t_star:.2g}")
    return (*start, *texts, str(row.steps), f"{row.seconds:.1f}", row.reason.partition("\n")[0])


def _write(folder: Path, rows: Rows, processes: int, complete: bool, **more: Any) -> None:
    """Write the numbers of all ``rows`` into ``stability.json``, with ``more`` keys."""
    cells = []
    for row in rows.values():
        data = {
            "name": row.cell.name,
            **vars(row.cell),
            "cell_reynolds": row.cell.cell_reynolds,
            "requirement": row.cell.requirement,
            "end_t_star": row.plan.t_star,
            "predicted_error": row.plan.predicted,
            "warnings": row.plan.warnings,
            **{key: value for key, value in vars(row).items() if key != "plan"},
        }
        cells.append({**data, **{old: data[new] for old, new in OLD_KEYS.items()}})
    numbers = {
        "complete": complete,
        "written": datetime.now().astimezone().isoformat(timespec="seconds"),
        "version": __version__,
        "platform": platform.platform(),
        "cores": os.cpu_count(),
        "processes": processes,
        **more,
        "cells": cells,
    }
    with replaced(folder / NUMBERS) as new:
        new.write_text(json.dumps(numbers, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def layout(part: SubMatrix) -> tuple[list[str], list[str], dict[tuple[str, str], Cell]]:
    """Return the labels of the columns and of the rows of the map of a sub-matrix, and its cells by (row, column).

    Columns and rows are in the order in which the values of each axis first appear.
    """

    def labels(axes: tuple[str, ...]) -> list[str]:
        order = {axis: list(dict.fromkeys(getattr(cell, axis) for cell in part.cells)) for axis in axes}
        found = sorted(part.cells, key=lambda cell: [order[axis].index(getattr(cell, axis)) for axis in axes])
        return list(dict.fromkeys(_label(cell, axes) for cell in found))

    positions = {(_label(cell, part.rows), _label(cell, part.columns)): cell for cell in part.cells}
    return labels(part.columns), labels(part.rows), positions


def _label(cell: Cell, axes: Sequence[str]) -> str:
    """Return the text for the values of ``axes`` of a cell."""
    return ", ".join(LABELS.get(axis, "{}").format(getattr(cell, axis)) for axis in axes)


def _map(part: SubMatrix, rows: Rows) -> tuple[list[str], list[str], Fields]:
    """Return columns, rows and fields of the map of a sub-matrix.

    Without axes, as for the covering set, the map has a row for each value of an axis, and counts cells by verdict.
    """
    if part.columns:
        columns, names, positions = layout(part)
        judged = {place: rows[cell] for place, cell in positions.items()}
        return columns, names, {place: (row.short, row.verdict, row.cell.required) for place, row in judged.items()}
    fields: Fields = {}
    for axis, values in AXES.items():
        for value in values if isinstance(values[0], str) else sorted(values):
            own = [cell for cell in part.cells if getattr(cell, axis) == value]
            verdicts = [rows[cell].verdict for cell in own]
            for verdict in VERDICTS if own else ():
                count = verdicts.count(verdict)
                fields[f"{axis}: {_label(own[0], [axis])}", verdict] = str(count), verdict if count else "", False
    return list(VERDICTS), list(dict.fromkeys(name for name, _ in fields)), fields


def _tables(parts: list[SubMatrix], rows: Rows) -> str:
    """Return all maps as Markdown; a stable cell shows its error alone, a cell with a requirement a star."""
    lines: list[tuple[str, ...]] = []
    for part in parts:
        verdicts = [rows[cell].verdict for cell in part.cells]
        met = [rows[cell].met for cell in part.cells if cell.required]
        lines.append((part.title, *(str(verdicts.count(each)) for each in VERDICTS), f"{sum(met)} of {len(met)}"))
    texts = [format_table(("sub-matrix", *VERDICTS, "requirements met"), lines)]
    for part in parts:
        columns, names, fields = _map(part, rows)
        texts_of = {key: text + "*" * required for key, (text, _, required) in fields.items()}
        lines = [(name, *(texts_of.get((name, column), "") for column in columns)) for name in names]
        texts.append(f"### {part.title}\n\n{format_table((', '.join(part.rows) or 'axis: value', *columns), lines)}")
    return "\n\n".join(texts)


def limits(rows: Rows) -> dict[str, list[dict[str, Any]]]:
    """Return the limits of stability in ``rows``, from which defaults, warnings and guards can be derived.

    ``ranges``: for a quantity, ``not``: the smallest value at which a run failed, and ``fine``: the largest value below
    it; None where there is no such value. Two quantities have ranges. Time steps over the default: every run that is
    not stable failed. Cell Reynolds number U dx / nu, nu of the solvent, in runs with the default walls, steps and
    sound speed: runs failed that stopped, and silent failures. ``largest``: by scheme and verdict, the largest density
    variation and transverse velocity at the end of runs in channels that finished. Density variations are converted to
    the default sound speed: they are proportional to the square of the Mach number.
    """
    tried: list[tuple[str, list[tuple[float, bool]]]] = []
    largest: list[dict[str, Any]] = []
    for sound, jitter in product(DATA["values"]["sound"], DATA["values"]["jitter"]):
        own = [Cell(jitter=jitter, sound=sound, step=step) for step in DATA["values"]["step"]]
        known = [(cell.step, rows[cell].verdict != "stable") for cell in own if cell in rows]
        tried.append((f"steps over the default, explicit, c = {sound:g}, jitter {jitter:g}", known))
    usual = [row for row in rows.values() if row.cell.usual and row.verdict != "refused"]
    for scheme in dict.fromkeys(row.cell.scheme for row in usual):
        for (fluid, of), (name, disordered) in product(FLUIDS.items(), ARRANGEMENTS.items()):
            known = [
                (row.cell.cell_reynolds, row.verdict in ("stopped", SILENT_FAILURE))
                for row in usual
                if row.cell.scheme == scheme and of(row.cell) and (row.cell.jitter > 0) == disordered
            ]
            tried.append((f"cell Reynolds number{fluid}, {scheme}, {name}", known))
    for scheme, verdict in product(dict.fromkeys(cell.scheme for cell in rows), VERDICTS):
        ended = [row for row in rows.values() if (row.cell.scheme, row.verdict) == (scheme, verdict)]
        finished = [row for row in ended if row.transverse_velocity is not None and verdict != "stopped"]
        if finished:
            densities = [(row.density_variation or 0.0) * (row.cell.sound / SCALE_RATIO) ** 2 for row in finished]
            speeds = [row.transverse_velocity or 0.0 for row in finished]
            numbers = {"density_variation": max(densities), "transverse_velocity": max(speeds)}
            largest.append({"what": f"{scheme}, {verdict}", **numbers})
    ranges = []
    for what, known in tried:
        first = min((value for value, failed in known if failed), default=None)
        fine = [value for value, _ in known if first is None or value < first]
        if known:
            ranges.append({"what": what, "fine": max(fine, default=None), "not": first})
    return {"ranges": ranges, "largest": largest}


def _limits_tables(found: dict[str, list[dict[str, Any]]]) -> str:
    def text(number: float | None) -> str:
        return "-" if number is None else f"{number:.3g}"

    ranges = [(each["what"], text(each["fine"]), text(each["not"])) for each in found["ranges"]]
    largest = [
        (each["what"], f"{each['density_variation']:.1e}", f"{each['transverse_velocity']:.1e}")
        for each in found["largest"]
    ]
    header = ("largest at the end", "density variation (c = 10)", "max abs(v) / U")
    return (
        f"{format_table(('limit', 'no failure up to', 'first failure at'), ranges)}\n\n{format_table(header, largest)}"
    )


def _plot(path: Path, parts: list[SubMatrix], rows: Rows) -> None:
    """Draw a panel for each sub-matrix, in two columns; a field for each cell is coloured by its verdict."""
    stacks: tuple[list, list] = ([], [])  # titles, heights and maps of the panels, each in the shorter column
    for part in parts:
        found = _map(part, rows)
        shorter = min(stacks, key=lambda stack: sum(height for _, height, _ in stack))
        shorter.append((part.title, FIELD * len(found[1]) + PANEL_HEADER, found))
    filled = [stack for stack in stacks if stack]
    tallest = max(sum(height for _, height, _ in stack) for stack in filled)
    with plot_style():
        figure = constrained_figure((14.0, tallest + 0.4), dpi=110)
        for stack, half in zip(filled, figure.subfigures(1, len(filled), squeeze=False)[0], strict=True):
            heights = [height for _, height, _ in stack]
            empty = [tallest - sum(heights)] if sum(heights) < tallest else []
            panels = half.subplots(len(heights + empty), 1, squeeze=False, height_ratios=heights + empty)[:, 0]
            for (title, _, found), panel in zip(stack, panels, strict=False):
                panel.set_title(title, fontsize=11)
                _draw(panel, *found)
            for panel in panels[len(stack) :]:
                panel.axis("off")
        handles = [Patch(facecolor=COLOURS[verdict], edgecolor="0.4", label=verdict) for verdict in VERDICTS]
        framed = "required to be stable, or to finish"
        handles.append(Patch(facecolor="none", edgecolor="black", linewidth=2.0, label=framed))
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
        figure.savefig(path)


def _draw(panel: Axes, columns: list[str], names: list[str], fields: Fields) -> None:
    for (name, column), (text, verdict, required) in fields.items():
        x, y = columns.index(column), names.index(name)
        colour = COLOURS.get(verdict, "none")
        panel.add_patch(Rectangle((x, y), 1, 1, facecolor=colour, edgecolor="white", linewidth=1.0))
        if required:
            panel.add_patch(Rectangle((x + 0.03, y + 0.06), 0.94, 0.88, fill=False, edgecolor="black", linewidth=1.4))
        text = text.replace(" ", "\n")
        panel.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=7, linespacing=0.9)
    panel.set(xlim=(0, len(columns)), ylim=(len(names), 0))
    panel.set_xticks([place + 0.5 for place in range(len(columns))], columns, fontsize=8)
    panel.set_yticks([place + 0.5 for place in range(len(names))], names, fontsize=8)
    panel.tick_params(length=0)
    panel.grid(False)
    for spine in panel.spines.values():
        spine.set_visible(False)
