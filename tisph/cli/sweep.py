"""``tisph sweep``: one config with some of its keys varied, as one table."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import out_folder


def sweep(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="YAML file: base, vary, collect, error, bound.")],
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Runs at a time [default: one a core].")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Run on the workers of this Dask scheduler.")
    ] = None,
    out: Annotated[Path | None, out_folder("Results [default: runs/NAME].")] = None,
) -> None:
    """Run a config with all values of some of its keys.

    Leaves a table (CSV and HDF5), costs and a picture in DIR, and names the cheapest run within the bound. Runs that
    have ended are kept: the same command goes on after Ctrl-C, and a larger study runs only what is new. A run that
    fails is a row with its message; exit status 1 only where none succeeds.

    \b
    Examples:
      tisph sweep study.yaml
      tisph sweep study.yaml --processes 2 --out runs/resolution
      tisph sweep study.yaml --scheduler tcp://machine:8786
    """
    from tisph import runtime
    from tisph.cli.check import forecast
    from tisph.studies.sweep import run

    rows = run(study, out, forecast, processes or runtime.available_threads(), scheduler)
    if not any(row.status == "done" for row in rows):
        raise typer.Exit(1)
