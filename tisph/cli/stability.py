"""``tisph stability``, or ``stress``: the stability matrix, a requirement for every cell."""

import json
from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import out_folder

FOLDER = Path("runs/stress")


def stability(
    quick: Annotated[bool, typer.Option("--quick", help="A few short cells of every kind, in three minutes.")] = False,
    only: Annotated[
        str | None, typer.Option("--only", metavar="TEXT", help="The sub-matrices with this text in their titles.")
    ] = None,
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Cells at a time [default: one a core].")
    ] = None,
    out: Annotated[Path | None, out_folder(f"Results [default: {FOLDER}].")] = None,
) -> None:
    """Run the stability matrix and say what becomes of every cell.

    A cell is stable, inaccurate, stopped (with a clear error), refused, or a silent failure: finished, and neither
    right nor warned of. Exit status 1 where one misses its requirement. Leaves maps, a picture and all numbers in DIR,
    where finished runs are kept: an interrupted matrix goes on with the same command.

    \b
    Examples:
      tisph stability --quick
      tisph stability
      tisph stability --processes 2 --out runs/stability-again
      tisph stability --only periodic --out runs/stability-periodic
    """
    from tisph import runtime
    from tisph.cli.check import forecast
    from tisph.studies import stability_report
    from tisph.studies.stability import sub_matrices

    try:
        parts = sub_matrices(quick, only)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--only") from None
    default = FOLDER.with_name("stress-quick") if quick else FOLDER.with_name("stress-part") if only else FOLDER
    folder = out or default
    passed = stability_report.run(folder, forecast, processes or runtime.available_threads(), parts)
    cells = json.loads((folder / stability_report.NUMBERS).read_text(encoding="utf-8"))["cells"]
    missed = [cell["name"] for cell in cells if not cell["met"]]
    failed = f"; FAIL: {', '.join(missed)}" if missed else ""
    print(f"\n{len(cells) - len(missed)} of {len(cells)} cells meet their requirement{failed}")
    if not passed:
        raise typer.Exit(1)
