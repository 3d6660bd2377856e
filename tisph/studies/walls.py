"""Compare all wall treatments in all flows: tables, their picture, and the treatment that they recommend.

Every run is a process on one thread, two at a time. All are kept in the folder of the results, so that an interrupted
comparison goes on where it was. The discrete Laplacians need no runs.
"""

import json
import platform
from pathlib import Path

from tisph import registry
from tisph.studies import walls_cases as walls
from tisph.studies import walls_laplacian, walls_table
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
        rows = list(_rows(folder, extent))
        laplacians = list(walls_laplacian.laplacians(registry.names("walls"), extent.resolutions))
        return _conclude(folder, rows, laplacians, extent)


def _rows(folder, extent):
    """Yield the ``Row`` s of all flows, and print each."""
    treatments = registry.names("walls")
    by_flow = [walls.cases(flow, treatments, extent) for flow in walls.FLOWS]
    header, widths = walls_table.header(extent), walls_table.widths(extent, treatments)
    print(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
    print(format_header(header, widths), flush=True)
    names = [name for cases in by_flow for name in walls.runs(cases, extent)]
    with Engine(Store(folder / "runs"), SIDE_BY_SIDE, dict.fromkeys(names, 0.0)) as engine:
        for cases in by_flow:
            ended = engine.outcomes(walls.runs(cases, extent))
            outcomes = {name: (result, message) for name, result, message in ended}
            for row in walls.rows(cases, outcomes, extent):
                engine.say(format_row(walls_table.cells(row), widths))
                yield row


def _conclude(folder, rows, laplacians, extent):
    """Print what follows from the rows, write numbers and picture; True if there is a recommendation."""
    found = walls.standings(rows, extent.measured_at)
    name = walls.recommended(found)
    numbers = {
        **walls.as_data(rows, laplacians, extent.measured_at),
        "version": __version__,
        "platform": platform.platform(),
    }
    (folder / NUMBERS).write_text(json.dumps(numbers, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    plot_walls(folder / PICTURE, rows, laplacians)
    texts = [
        walls_table.legend(extent.measured_at),
        "\n".join(walls_table.stopped_lines(rows)),
        walls_table.standings_table(found),
        walls_table.laplacian_table(laplacians),
        f"picture: {folder / PICTURE}; numbers: {folder / NUMBERS}",
        walls_table.recommendation(name, extent.measured_at),
    ]
    print("\n" + "\n\n".join(filter(None, texts)))
    return name is not None
