"""``tisph verify``: suites of runs and checks, as tables."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import out_folder
from tisph.errors import ConfigError

WALLS_FOLDER = Path("runs/verify-walls")


def verify(
    suite: Annotated[
        str | None,
        typer.Argument(
            metavar="[SUITE]",
            help="One suite alone, such as free_bodies, or a YAML file of yours; all but manufactured without it.",
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and shorter runs.")] = False,
    long: Annotated[
        bool, typer.Option("--long", help="The long section of a SUITE: runs of minutes, or hours.")
    ] = False,
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
    as_json: Annotated[bool, typer.Option("--json", help="Print all checks as JSON, and nothing else.")] = False,
) -> None:
    """Compare runs with exact solutions, and with what they have to be.

    Prints a table of case, error, bound, pass or FAIL; exit status 1 on a FAIL. A SUITE is one of ours or a YAML file
    (docs/how-to/acceptance-tests.md); with --out DIR its finished runs are kept, and an interrupted suite goes on with
    the same command. With --walls a table of wall treatments, with a picture and all numbers in DIR. The suite
    estimates compares the errors that runs state of themselves (tisph run --estimate-error) with the true ones.

    \b
    Examples:
      tisph verify --quick
      tisph verify
      tisph verify my_flow.yaml --json
      tisph verify manufactured
      tisph verify free_bodies --long --out runs/free-bodies
      tisph verify --page
      tisph verify --walls
    """
    if walls and page:
        raise ConfigError("--walls and --page exclude one another")
    if suite and (walls or page):
        raise ConfigError("a SUITE is not for --walls and --page, which have runs of their own")
    if long and (quick or not suite):
        raise ConfigError("--long is for a SUITE, without --quick: tisph verify free_bodies --long")
    if out and not (walls or suite):
        raise ConfigError("--out is for --walls and for a SUITE: nothing else leaves results")
    if as_json and (walls or page):
        raise ConfigError("--json is for suites; --walls leaves walls.json in its folder")
    if walls:
        from tisph.studies import walls as comparison

        passed = comparison.run(out or WALLS_FOLDER, quick=quick)
    else:
        from tisph.studies import verify as suites

        passed = suites.run_page() if page else suites.run(suite, quick, long, out, as_json)
    if not passed:
        raise typer.Exit(1)
