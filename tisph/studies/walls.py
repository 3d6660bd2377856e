"""Compare all wall treatments in all flows: the table, its picture, and the treatment that it recommends.

Every run is a process on one thread. Two at a time give the errors, which do not depend on what else the machine
does; those that give the cost of a step run alone. All are kept in the folder of the results, so that an
interrupted comparison goes on where it was.
"""

import json
import platform
from pathlib import Path

from tisph import registry
from tisph.studies import walls_cases as walls
from tisph.studies import walls_table
from tisph.studies.engine import Engine
from tisph.studies.store import Store, claimed
from tisph.studies.walls_picture import plot_walls
from tisph.text_table import format_header, format_row
from tisph.version import __version__

PICTURE = "verify_walls.png"
NUMBERS = "walls.json"

SIDE_BY_SIDE = 2


def run(folder, quick=False):
    """Print the comparison (``quick``: a small one) and leave its picture and numbers in ``folder``.

    Returns True if a treatment can be recommended. Raises ConfigError where ``folder`` cannot be used.
    """
    folder = Path(folder)
    extent = walls.QUICK if quick else walls.FULL
    with claimed(folder, "another comparison is writing there"):
        return _conclude(folder, list(_rows(folder, extent)), extent)


def _rows(folder, extent):
    """Yield the ``Row`` s of all flows, and print each."""
    treatments = registry.names("walls")
    by_flow = [walls.cases(flow, treatments, extent) for flow in walls.FLOWS]
    header, widths = walls_table.header(extent), walls_table.widths(extent, treatments)
    print(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
    print(format_header(header, widths), flush=True)
    names = [name for cases in by_flow for name in (*walls.timing(cases, extent), *walls.runs(cases, extent))]
    with Engine(Store(folder / "runs"), SIDE_BY_SIDE, dict.fromkeys(names, 0.0)) as engine:
        for cases in by_flow:
            outcomes = _outcomes(engine, walls.timing(cases, extent), processes=1)
            outcomes |= _outcomes(engine, walls.runs(cases, extent))
            for row in walls.rows(cases, outcomes, extent):
                engine.say(format_row(walls_table.cells(row), widths))
                yield row


def _outcomes(engine, configs, **options):
    """(``Result``, message) of all runs of ``configs``, by name."""
    return {name: (result, message) for name, result, message in engine.outcomes(configs, **options)}


def _conclude(folder, rows, extent):
    """Print what follows from the rows, write numbers and picture; True if there is a recommendation."""
    found = walls.standings(rows, extent.measured_at)
    name = walls.recommended(found)
    numbers = {**walls.as_data(rows, extent.measured_at), "version": __version__, "platform": platform.platform()}
    (folder / NUMBERS).write_text(json.dumps(numbers, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    plot_walls(folder / PICTURE, rows)
    texts = [
        walls_table.legend(extent.measured_at),
        "\n".join(walls_table.stopped_lines(rows)),
        walls_table.standings_table(found),
        f"picture: {folder / PICTURE}; numbers: {folder / NUMBERS}",
        walls_table.recommendation(name, extent.measured_at),
    ]
    print("\n" + "\n\n".join(filter(None, texts)))
    return name is not None
