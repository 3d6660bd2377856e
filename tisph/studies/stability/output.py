"""What the stability matrix says while it runs and at its end, on the screen and in files."""

import json
import os
import platform
import time
from datetime import datetime

import tisph
from tisph.observers._files import replaced
from tisph.report.terminal_bar import study_bar
from tisph.studies.stability import limits, maps
from tisph.studies.stability.judge import VERDICTS
from tisph.studies.stability.picture import plot_maps
from tisph.text_table import format_header, format_row

NUMBERS_JUDGED = {
    "error": ("error", "{:.1e}", 7),
    "ratio": ("/ calm", "{:.2g}", 6),
    "transverse": ("max |v|/U", "{:.1e}", 9),
    "density_variation": ("density", "{:.1e}", 7),
    "hole": ("hole", "{:.2f}", 4),
    "nearest": ("near", "{:.2f}", 4),
}
"""Title, format and width of the numbers of a ``Judgement``; empty where there is none."""

TITLES, FORMATS, NUMBER_WIDTHS = zip(*NUMBERS_JUDGED.values(), strict=True)
HEADER = ("cell", "promise", "verdict", "t*", *TITLES, "steps", "s", "why")
WIDTHS = (57, 8, 10, 7, *NUMBER_WIDTHS, 8, 5, 0)

START_SECONDS = 3.0
"""Rough time of a run besides its steps, for the time that is left."""

NUMBERS, TABLES, PICTURE = "stress.json", "stress.md", "stress.png"


class Output:
    """Prints and stores ``Row`` by ``Row``; a context that shows progress on standard error, if that is a terminal."""

    def __init__(self, folder, parts, plans, processes):
        self.folder, self.parts, self.plans = folder, parts, plans
        self.rows = {}
        self.began = time.perf_counter()
        self.processes = processes
        self._running = []
        seconds = sum(plan.seconds + START_SECONDS for plan in plans.values() if not plan.refusal)
        self._progress = study_bar()
        self._task = self._progress.add_task("", total=seconds)
        minutes = seconds / 60 / processes
        print(f"{len(plans)} cells, about {minutes:.0f} minutes with {processes} processes of one thread")
        print(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
        print(format_header(HEADER, WIDTHS), flush=True)

    def __enter__(self):
        self._progress.start()
        return self

    def __exit__(self, *_):
        self._progress.stop()

    def started(self, name):
        """Note that the run of a cell has started."""
        self._running.append(name)
        self._show()

    def ended(self, name):
        """Note that it has ended, or had before."""
        self._running = [each for each in self._running if each != name]
        self._show()

    def add(self, row):
        """Print a row and store it with those before it."""
        self.rows[row.cell] = row
        self._progress.stop()  # while it shows, the two would write into one another
        print(format_row(_cells(row), WIDTHS), flush=True)
        self._progress.start()
        self._progress.advance(self._task, 0.0 if row.plan.refusal else row.plan.seconds + START_SECONDS)
        self._show()
        self._write()

    def conclude(self):
        """Write maps and picture, print what is to be known; True if every promise is kept and nothing is WRONG."""
        found = limits.limits(self.rows)
        text = f"{maps.tables(self.parts, self.rows)}\n\n### limits\n\n{limits.tables(found)}\n"
        (self.folder / TABLES).write_text(text, encoding="utf-8")
        plot_maps(self.folder / PICTURE, self.parts, self.rows)
        self._write(limits=found)
        print(f"\n{text}")
        broken = [row for row in self.rows.values() if not row.judgement.kept]
        for row in broken:
            print(f"{row.cell.name}: promised {row.cell.promise}, is {row.judgement.verdict}: {row.judgement.reason}")
        verdicts = [row.judgement.verdict for row in self.rows.values()]
        counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in VERDICTS)
        seconds = time.perf_counter() - self.began
        print(f"\n{len(self.rows)} cells: {counts}; {len(broken)} promises broken; {seconds / 60:.1f} minutes")
        print(f"picture: {self.folder / PICTURE}; maps: {self.folder / TABLES}; numbers: {self.folder / NUMBERS}")
        return not broken

    def _show(self):
        text = f"{len(self.rows)} of {len(self.plans)} cells; " + "; ".join(self._running)
        self._progress.update(self._task, description=text)

    def _write(self, **more):
        numbers = {
            "complete": len(self.rows) == len(self.plans),
            "written": datetime.now().astimezone().isoformat(timespec="seconds"),
            "version": tisph.__version__,
            "platform": platform.platform(),
            "cores": os.cpu_count(),
            "processes": self.processes,
            **more,
            "cells": [_data(row) for row in self.rows.values()],
        }
        with replaced(self.folder / NUMBERS) as new:
            new.write_text(json.dumps(numbers, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _cells(row):
    found = row.judgement
    numbers = [getattr(found, name) for name in NUMBERS_JUDGED]
    texts = ["" if number is None else form.format(number) for number, form in zip(numbers, FORMATS, strict=True)]
    start = (row.cell.name, row.cell.promise, found.verdict, f"{row.plan.t_star:.2g}")
    return (*start, *texts, str(row.steps), f"{row.seconds:.1f}", found.reason.partition("\n")[0])


def _data(row):
    plan, found = row.plan, row.judgement
    return {
        "name": row.cell.name,
        **vars(row.cell),
        "cell_reynolds": row.cell.cell_reynolds,
        "promise": row.cell.promise,
        "verdict": found.verdict,
        "reason": found.reason,
        "kept": found.kept,
        "end_t_star": plan.t_star,
        "stated_error": plan.stated,
        "warnings": plan.warnings,
        "error": found.error,
        "calm_error": found.calm,
        "transverse_velocity": found.transverse,
        "density_variation": found.density_variation,
        "hole": found.hole,
        "nearest_two": found.nearest,
        "steps": row.steps,
        "seconds": row.seconds,
    }
