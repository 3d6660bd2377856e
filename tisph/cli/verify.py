"""``tisph verify``: runs against exact solutions, as a table."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import folder_name
from tisph.errors import ConfigError

WALLS_FOLDER = Path("runs/verify-walls")


def verify(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and shorter runs.")] = False,
    page: Annotated[
        bool, typer.Option("--page", help="The readings of VM-LSDYNA-SPH-001 next to its printed numbers.")
    ] = False,
    walls: Annotated[
        bool, typer.Option("--walls", help="All wall treatments in all flows, and which one is recommended.")
    ] = False,
    estimates: Annotated[
        bool,
        typer.Option("--estimates", help="What tisph check predicts, against runs: all configs, stability cells."),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            parser=folder_name,
            help=f"With --walls: folder of its results [default: {WALLS_FOLDER}]; with --estimates [default: that of "
            "tisph stability].",
        ),
    ] = None,
) -> None:
    """Compare runs with exact solutions.

    Prints a table of case, error, bound, pass or FAIL; exit status 1 on a FAIL. With --walls a table of wall
    treatments, with a picture and all numbers in DIR, where finished runs are kept: an interrupted comparison goes
    on with the same command. With --estimates a line for each run, of the sample whose error is predicted worst: errors
    within a factor of 3 (10 where the sample is not resolved), steps within 1.5. The whole suite ends with the errors
    that runs state of themselves (tisph run --estimate-error), over the true ones.

    \b
    Examples:
      tisph verify --quick
      tisph verify
      tisph verify --page
      tisph verify --walls
      tisph verify --estimates --quick
    """
    if walls + page + estimates > 1:
        raise ConfigError("--walls, --page and --estimates exclude one another")
    if out and not (walls or estimates):
        raise ConfigError("--out is for --walls and --estimates only: nothing else leaves results")
    if estimates:
        passed = _estimates(out, quick)
    elif walls:
        from tisph.studies import walls as comparison

        passed = comparison.run(out or WALLS_FOLDER, quick=quick)
    else:
        from tisph.studies import verify as suite

        passed = suite.run(quick=quick, page=page)
    if not passed:
        raise typer.Exit(1)


def _estimates(out: Path | None, quick: bool) -> bool:
    from tisph import runtime
    from tisph.cli.check import forecast
    from tisph.cli.stability import FOLDER
    from tisph.studies import estimates as comparison

    default = FOLDER.with_name("stress-quick") if quick else FOLDER
    return comparison.run(out or default, forecast, runtime.available_threads(), quick=quick)
