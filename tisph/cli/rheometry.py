"""``tisph rheometry``: what a rheologist reads from a run in a channel."""

import csv
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from tisph.errors import ConfigError

PICTURE = "rheometry.png"


def rheometry(
    run_dirs: Annotated[list[Path], typer.Argument(metavar="RUN_DIR...", help="Folders of finished runs.")],
) -> None:
    """Print and draw what a rheologist reads from runs in a channel, beside theory and reference.

    Viscosity growth, N1, creep compliance, recovery, ringing, moduli G' and G'', harmonics: what the walls of the run
    do. The picture goes into the folder of the run, rheometry.png.

    \b
    Examples:
      tisph rheometry runs/creep_and_recovery
      tisph rheometry runs/oscillation_*
    """
    from tisph import families
    from tisph.config import load
    from tisph.report.rheometry import plot_reading
    from tisph.verification.rheometry import read

    for run_dir in run_dirs:
        path = run_dir / "config.resolved.yaml"
        if not path.is_file():
            raise ConfigError(f"RUN_DIR {run_dir}: is no folder of results, it has no config.resolved.yaml")
        config = load(path)
        if config.scene != "channel" or not config.parallel:
            raise ConfigError(f"RUN_DIR {run_dir}: is no run in a channel without bodies")
        channel = families.load("scenes", config.scene).Scene.from_config(config)
        reading = read(config, channel, _columns(run_dir / "history.csv"))
        typer.echo(f"{config.name}: {reading.title}")
        for line in reading.lines:
            typer.echo(f"  {line}")
        plot_reading(run_dir / PICTURE, config.name, reading)
        typer.echo(f"  picture {run_dir / PICTURE}")


def _columns(path):
    """Columns of a history by name; an empty cell is NaN."""
    from tisph.observers._files import readable

    with readable(path):
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    names, *rows = csv.reader(lines)
    values = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return dict(zip(names, values.T, strict=True))
