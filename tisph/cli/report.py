"""``tisph report``: one page about one run, or several side by side."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    run_dirs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The page [default: report.html in RUN, of several here]."),
    ] = None,
) -> None:
    """Make one HTML page of runs, side by side.

    It has movie, plots, errors, wall forces, costs, config and provenance, in one file that needs no network.

    \b
    Examples:
      tisph report runs/couette
      tisph report runs/couette runs/fine --out couette.html
    """
    from tisph.observers._storage import replaced
    from tisph.results import open_run
    from tisph.results.page import report as page

    text = page([open_run(folder) for folder in run_dirs])
    path = out or Path(run_dirs[0] if len(run_dirs) == 1 else ".") / "report.html"
    with replaced(path) as new:
        new.write_text(text, encoding="utf-8")
    print(path)
