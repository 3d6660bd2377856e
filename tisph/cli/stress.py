"""``tisph stress``: the stability matrix, a promise for every cell."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import folder_name

FOLDER = Path("runs/stress")


def stress(
    quick: Annotated[bool, typer.Option("--quick", help="A few short cells of every kind, in three minutes.")] = False,
    only: Annotated[
        str | None, typer.Option("--only", metavar="TEXT", help="The sub-matrices with this text in their titles.")
    ] = None,
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Cells at a time [default: one a core].")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", parser=folder_name, help=f"Results [default: {FOLDER}].")
    ] = None,
) -> None:
    """Run the stability matrix and say what becomes of every cell.

    A cell is stable, inaccurate, stopped (with a clear error), refused, or WRONG: finished, and neither right nor
    warned of. Exit status 1 where one is WRONG or breaks its promise. Leaves maps, a picture and all numbers in DIR,
    where finished runs are kept: an interrupted matrix goes on with the same command.

    \b
    Examples:
      tisph stress --quick
      tisph stress
      tisph stress --processes 2 --out runs/stress-again
      tisph stress --only turns --out runs/stress-turns
    """
    from tisph import runtime
    from tisph.cli.check import forecast
    from tisph.studies.stability import matrix, run

    try:
        parts = matrix.sub_matrices(quick, only)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--only") from None
    default = FOLDER.with_name("stress-quick") if quick else FOLDER.with_name("stress-part") if only else FOLDER
    if not run.run(out or default, forecast, processes or runtime.available_threads(), parts):
        raise typer.Exit(1)
