"""``tisph verify``: runs against exact solutions, as a table."""

from typing import Annotated

import typer


def verify(
    quick: Annotated[bool, typer.Option("--quick", help="Only the cases that take seconds.")] = False,
    page: Annotated[
        bool, typer.Option("--page", help="The readings of VM-LSDYNA-SPH-001 next to its printed numbers.")
    ] = False,
) -> None:
    """Compare runs with exact solutions.

    Prints a table of case, error, bound, pass or FAIL; exit status 1 on a FAIL.

    \b
    Examples:
      tisph verify --quick
      tisph verify
      tisph verify --page
    """
    from tisph.study import verify as suite

    if not suite.run(quick=quick, page=page):
        raise typer.Exit(1)
