"""The table of a sweep: a row a run, as CSV and HDF5; what was computed apart from what it took.

``table.csv`` depends on the configs alone, and is the same to the last byte however, where and in how many attempts the
runs were made; ``costs.csv`` has the seconds, which are not. ``table.h5`` has the columns of both.
"""

import csv
import statistics
from dataclasses import dataclass

import h5py
import numpy as np

from tisph.measures.metrics import fitted_order
from tisph.observers._storage import hdf5_file, replaced

TABLE, COSTS, ARRAYS = "table.csv", "costs.csv", "table.h5"


@dataclass(frozen=True)
class Row:
    """A case and what became of it: ``numbers`` by name of what is collected, None where there is none."""

    case: object
    status: str
    message: str
    numbers: dict
    steps: int | None = None
    particles: int | None = None
    seconds: float | None = None
    total: float | None = None


def row(study, case, summary, message):
    """``Row`` of a run that left a ``summary``; of a config that is refused ``summary`` is None."""
    if summary is None:
        return Row(case, "refused", message, dict.fromkeys(study.collect))
    cost, numbers = summary.get("cost", {}), summary.get("numbers", {})
    return Row(
        case,
        summary["status"],
        message,
        {name: _collected(summary, name) for name in study.collect},
        cost.get("steps"),
        numbers.get("particles_fluid"),
        cost.get("wall_loop_s"),
        cost.get("wall_total_s"),
    )


def _collected(summary, name):
    """Number of the last sample if the run reached it, else of ``numbers`` or ``cost``."""
    last = summary["samples"][-1] if summary["status"] == "done" and summary.get("samples") else {}
    for place in (last, summary.get("numbers", {}), summary.get("cost", {})):
        if isinstance(place.get(name), int | float):
            return place[name]
    return None


def write(study, rows, folder):
    """Write all files from ``rows``, in the order of the cases."""
    names = [each.case.name for each in rows]
    computed = {
        "run": names,
        **{key: [each.case.values[key] for each in rows] for key in study.keys},
        "status": [each.status for each in rows],
        "particles": [each.particles for each in rows],
        "steps": [each.steps for each in rows],
        **{name: [each.numbers[name] for each in rows] for name in study.collect},
        "message": [each.message for each in rows],
    }
    costs = {"run": names, "loop_s": [each.seconds for each in rows], "total_s": [each.total for each in rows]}
    for name, columns in ((TABLE, computed), (COSTS, costs)):
        with replaced(folder / name) as new, new.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*(map(_text, column) for column in columns.values()), strict=True))
    with replaced(folder / ARRAYS) as new, hdf5_file(new) as file:
        _fill(file, {**computed, **costs})


def _text(value):
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def _fill(file, columns):
    for name, column in columns.items():
        numeric = all(value is None or isinstance(value, int | float) for value in column)
        kind = float if numeric else h5py.string_dtype()
        values = [np.nan if value is None else value for value in column] if numeric else map(_text, column)
        file.create_dataset(name, data=np.array(list(values), dtype=object).astype(kind))


def orders(study, rows):
    """Powers with which the error scales with each varied number: median over the runs that agree in all else.

    Pairs (key, (power, groups)); none where an error does not exist or is zero.
    """
    found = {}
    for key in study.keys:
        slopes = [_power(points) for points in groups(study, rows, key).values() if len(points) > 1]
        if slopes:
            found[key] = statistics.median(slopes), len(slopes)
    return found


def _power(points):
    values, errors = zip(*points, strict=True)
    return -fitted_order(values, errors)


def groups(study, rows, key, of=None):
    """Pairs (value of ``key``, ``of(row)``, or else the error) by the values of all other keys; positive ones only."""
    found = {}
    for each in rows:
        value, number = each.case.values[key], of(each) if of else each.numbers[study.error]
        if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0 or not number or number <= 0:
            continue
        others = tuple((name, str(other)) for name, other in each.case.values.items() if name != key)
        found.setdefault(others, []).append((value, number))
    return {others: sorted(points) for others, points in found.items()}


def cheapest(study, rows):
    """The run of the shortest loop whose error is within the bound; None without one."""
    within = [each for each in rows if each.status == "done" and each.numbers[study.error] is not None]
    within = [each for each in within if study.bound is None or each.numbers[study.error] <= study.bound]
    return min(within, key=lambda each: each.seconds or np.inf, default=None)
