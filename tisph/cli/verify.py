"""``tisph verify``: runs against exact solutions, as a table."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import out_folder
from tisph.errors import ConfigError

WALLS_FOLDER = Path("runs/verify-walls")


def verify(
    part: Annotated[
        str | None,
        typer.Argument(metavar="[SUITE]", help="One part alone, such as free_bodies; all but manufactured without it."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and shorter runs.")] = False,
    long: Annotated[bool, typer.Option("--long", help="Of cavity or free_bodies: runs of minutes, or hours.")] = False,
    page: Annotated[
        bool, typer.Option("--page", help="The readings of VM-LSDYNA-SPH-001 next to its printed numbers.")
    ] = False,
    walls: Annotated[
        bool, typer.Option("--walls", help="All wall treatments in all flows, and which one is recommended.")
    ] = False,
    out: Annotated[
        Path | None,
        out_folder(f"Folder where finished runs stay, of a SUITE, and of --walls [default: {WALLS_FOLDER}]."),
    ] = None,
) -> None:
    """Compare runs with exact solutions.

    Prints a table of case, error, bound, pass or FAIL; exit status 1 on a FAIL. With --walls a table of wall
    treatments, with a picture and all numbers in DIR, where finished runs are kept: an interrupted comparison goes
    on with the same command. The whole suite ends with the errors that runs state of themselves (tisph run
    --estimate-error), over the true ones. A SUITE with --out DIR keeps its finished runs there likewise.

    \b
    Examples:
      tisph verify --quick
      tisph verify
      tisph verify free_bodies
      tisph verify manufactured
      tisph verify free_bodies --long --out runs/free-bodies
      tisph verify --page
      tisph verify --walls
    """
    if walls and page:
        raise ConfigError("--walls and --page exclude one another")
    if part and (walls or page):
        raise ConfigError("a SUITE is not for --walls and --page, which have runs of their own")
    if long and (quick or not part):
        raise ConfigError("--long is for a SUITE, without --quick: tisph verify free_bodies --long")
    if out and not (walls or part):
        raise ConfigError("--out is for --walls and for a SUITE: nothing else leaves results")
    if walls:
        from tisph.studies import walls as comparison

        passed = comparison.run(out or WALLS_FOLDER, quick=quick)
    else:
        from tisph.studies import verify as suite

        passed = suite.run_part(part, quick, long, out) if part else suite.run(quick, page)
    if not passed:
        raise typer.Exit(1)
