"""``tisph render``: movie and pictures again from a finished run."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.options import Overrides
from tisph.errors import ConfigError


def render(
    run_dir: Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Folder of a finished run.")],
    overrides: Overrides = None,
    gif: Annotated[bool, typer.Option("--gif", help="Also write movie.gif, and poster.jpg, the last frame.")] = False,
) -> None:
    """Make the movie and the pictures of a finished run again.

    With --set the movie is another one of the same frames; keys of output.video can be set, but for frames.

    \b
    Examples:
      tisph render runs/couette
      tisph render runs/taylor_green --set output.video.overlay=streamlines --gif
      tisph render runs/cavity --set output.video.color_by=dye --set output.video.dye=checkerboard
    """
    if not (run_dir / "config.resolved.yaml").is_file():
        raise ConfigError(f"{run_dir}: is no folder of results, it has no config.resolved.yaml")

    from tisph import simulation

    for path in simulation.render(run_dir, overrides or (), gif):
        print(path)
