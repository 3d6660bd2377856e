"""``tisph render``: movie and pictures again from a finished run."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.errors import ConfigError


def render(
    run_dir: Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Folder of a finished run.")],
) -> None:
    """Make the movie and the pictures of a finished run again.

    \b
    Examples:
      tisph render runs/couette
    """
    if not (run_dir / "config.resolved.yaml").is_file():
        raise ConfigError(f"RUN_DIR {run_dir}: is no folder of results, it has no config.resolved.yaml")

    from tisph import simulation

    for path in simulation.render(run_dir):
        typer.echo(path)
