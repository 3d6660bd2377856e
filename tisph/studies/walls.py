"""Compare all wall treatments in all flows: the table, its picture, and the treatment that it recommends.

Every run is a process on one thread. Two at a time give the errors, which do not depend on what else the machine
does; those that give the cost of a step run alone. All are kept in the folder of the results, so that an
interrupted comparison goes on where it was.
"""

import json
import platform
from contextlib import closing
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
        return _compare(folder, extent)


def _compare(folder, extent):
    treatments = registry.names("walls")
    columns = walls_table.Columns(extent.resolutions, extent.measured_at, treatments)
    print(f"finished runs are kept in {folder / 'runs'} and used again by the same command\n")
    print(format_header(columns.header, columns.widths), flush=True)
    rows, by_flow = [], [walls.cases(flow, treatments, extent) for flow in walls.FLOWS]
    names = [name for cases in by_flow for case in cases for name in case.configs(extent)]
    with Engine(Store(folder / "runs"), SIDE_BY_SIDE, dict.fromkeys(names, 0.0)) as engine:
        for cases in by_flow:
            for row in _flow_rows(cases, extent, engine):
                engine.say(format_row(columns.cells(row), columns.widths))
                rows.append(row)
    return _conclude(folder, rows, columns, extent)


def _flow_rows(cases, extent, engine):
    """Yield the rows of one flow in the order of ``cases``, each as soon as it and those before it are known."""
    alone = engine.outcomes(_interleaved([case.timing(extent) for case in cases]), processes=1)
    timed = {name: (result, message) for name, result, message in alone}
    by_case = {case: {name: timed[name] for name in case.timing(extent)} for case in cases}
    references = {
        case.arrangement: walls.step_seconds(by_case[case]) for case in cases if case.treatment == walls.REFERENCE
    }
    runs = {case.name(number): case.config(number) for case in cases for number in extent.resolutions}
    waiting, outcomes = list(cases), {}
    with closing(engine.outcomes(runs)) as finished:
        for name, result, message in finished:
            outcomes[name] = result, message
            while waiting and all(waiting[0].name(number) in outcomes for number in extent.resolutions):
                case = waiting.pop(0)
                results = {number: outcomes[case.name(number)] for number in extent.resolutions}
                yield walls.row(case, results, by_case[case], extent.measured_at, references[case.arrangement])


def _interleaved(groups):
    """One run of each group in turn, so that a slow minute of the machine meets all treatments."""
    longest = max(map(len, groups))
    return {
        name: config
        for place in range(longest)
        for group in groups
        for name, config in list(group.items())[place : place + 1]
    }


def _conclude(folder, rows, columns, extent):
    """Print what follows from the rows, write numbers and picture; True if there is a recommendation."""
    found = walls.standings(rows, extent.measured_at)
    name = walls.recommended(found)
    numbers = {**walls.as_data(rows, extent.measured_at), "version": __version__, "platform": platform.platform()}
    (folder / NUMBERS).write_text(json.dumps(numbers, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    plot_walls(folder / PICTURE, rows)
    texts = [
        columns.legend(),
        "\n".join(walls_table.stopped_lines(rows)),
        walls_table.standings_table(found),
        f"picture: {folder / PICTURE}; numbers: {folder / NUMBERS}",
        walls_table.recommendation(name, extent.measured_at),
    ]
    print("\n" + "\n\n".join(filter(None, texts)))
    return name is not None
