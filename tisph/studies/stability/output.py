"""What the stability matrix says while it runs and at its end, on the screen and in files."""

import json
import os
import platform
import time
from datetime import datetime

from tisph.observers._storage import replaced
from tisph.studies.engine import START_SECONDS
from tisph.studies.stability import limits, maps
from tisph.studies.stability.judge import VERDICTS
from tisph.studies.stability.picture import plot_maps
from tisph.text_table import format_header, format_row
from tisph.version import __version__

NUMBERS_JUDGED = {
    "error": ("error", "{:.1e}", 7),
    "ratio": ("/ base", "{:.2g}", 6),
    "transverse": ("max |v|/U", "{:.1e}", 9),
    "density_variation": ("density", "{:.1e}", 7),
    "max_void_radius": ("void", "{:.2f}", 4),
    "min_distance": ("dist", "{:.2f}", 4),
}
"""Title, format and width of the numbers of a ``Judgement``; empty where there is none."""

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
"""Names under which the numbers of a cell were before, which it has as well."""

NUMBERS, TABLES, PICTURE = "stress.json", "stress.md", "stress.png"


class Output:
    """Prints and stores ``Row`` by ``Row`` of the ``plans`` of sub-matrices ``parts``, which ``engine`` runs."""

    def __init__(self, folder, parts, plans, engine):
        self.folder, self.parts, self.plans, self.engine = folder, parts, plans, engine
        self.rows = {}
        self.began = time.perf_counter()
        seconds = sum(plan.seconds + START_SECONDS for plan in plans.values() if not plan.refusal)
        minutes = seconds / 60 / engine.processes
        engine.say(f"{len(plans)} cells, about {minutes:.0f} minutes with {engine.processes} processes of one thread")
        engine.say(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
        engine.say(format_header(HEADER, WIDTHS))

    def add(self, row):
        """Print a row and store it with those before it."""
        self.rows[row.cell] = row
        self.engine.say(format_row(_cells(row), WIDTHS))
        self._write()

    def conclude(self):
        """Write maps and picture, print what is to be known; True if every requirement is met."""
        found = limits.limits(self.rows)
        text = f"{maps.tables(self.parts, self.rows)}\n\n### limits\n\n{limits.tables(found)}\n"
        (self.folder / TABLES).write_text(text, encoding="utf-8")
        plot_maps(self.folder / PICTURE, self.parts, self.rows)
        self._write(limits=found)
        print(f"\n{text}")
        missed = [row for row in self.rows.values() if not row.judgement.met]
        for row in missed:
            judgement = row.judgement
            print(f"{row.cell.name}: required {row.cell.requirement}, is {judgement.verdict}: {judgement.reason}")
        verdicts = [row.judgement.verdict for row in self.rows.values()]
        counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in VERDICTS)
        seconds = time.perf_counter() - self.began
        print(f"\n{len(self.rows)} cells: {counts}; {len(missed)} requirements missed; {seconds / 60:.1f} minutes")
        print(f"picture: {self.folder / PICTURE}; maps: {self.folder / TABLES}; numbers: {self.folder / NUMBERS}")
        return not missed

    def _write(self, **more):
        numbers = {
            "complete": len(self.rows) == len(self.plans),
            "written": datetime.now().astimezone().isoformat(timespec="seconds"),
            "version": __version__,
            "platform": platform.platform(),
            "cores": os.cpu_count(),
            "processes": self.engine.processes,
            **more,
            "cells": [_data(row) for row in self.rows.values()],
        }
        with replaced(self.folder / NUMBERS) as new:
            new.write_text(json.dumps(numbers, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _cells(row):
    found = row.judgement
    numbers = [getattr(found, name) for name in NUMBERS_JUDGED]
    texts = ["" if number is None else form.format(number) for number, form in zip(numbers, FORMATS, strict=True)]
    start = (row.cell.name, row.cell.requirement, found.verdict, f"{row.plan.t_star:.2g}")
    return (*start, *texts, str(row.steps), f"{row.seconds:.1f}", found.reason.partition("\n")[0])


def _data(row):
    plan, found = row.plan, row.judgement
    data = {
        "name": row.cell.name,
        **vars(row.cell),
        "cell_reynolds": row.cell.cell_reynolds,
        "requirement": row.cell.requirement,
        "verdict": found.verdict,
        "reason": found.reason,
        "met": found.met,
        "end_t_star": plan.t_star,
        "predicted_error": plan.predicted,
        "warnings": plan.warnings,
        "error": found.error,
        "baseline_error": found.baseline,
        "transverse_velocity": found.transverse,
        "density_variation": found.density_variation,
        "max_void_radius": found.max_void_radius,
        "min_distance": found.min_distance,
        "steps": row.steps,
        "seconds": row.seconds,
    }
    return {**data, **{old: data[new] for old, new in OLD_KEYS.items()}}
