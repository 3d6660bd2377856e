"""``tisph rheometry``: what a rheologist reads from a run in a channel, between cylinders, in a pipe or a tube."""

from pathlib import Path
from typing import Annotated

import typer

from tisph.errors import ConfigError

PICTURE = "rheometry.png"


def rheometry(
    run_dirs: Annotated[list[Path], typer.Argument(metavar="RUN_DIR...", help="Folders of finished runs.")],
) -> None:
    """Read runs in a channel, between cylinders, in a pipe or of a falling ball as a rheometer, beside theory.

    Viscosity growth, N1, creep compliance, recovery, free oscillation, relaxation modulus, flow curve, moduli G'
    and G'', harmonics: what the walls of the run do. Effective viscosity, with its statistical error, where the flow
    carries bodies. Viscosity by a Couette viscometer, a falling ball or a capillary, of which three runs or more give
    the flow curve. The picture goes into the folder of the run, rheometry.png.

    \b
    Examples:
      tisph rheometry runs/creep_and_recovery
      tisph rheometry runs/oscillation_*
      tisph rheometry runs/falling_ball
    """
    from tisph import scenes
    from tisph.measures.rheometry import read
    from tisph.measures.viscometers import VISCOMETERS, rabinowitsch
    from tisph.report.plots import plot_reading
    from tisph.results import open_run

    capillaries = {}
    for run_dir in run_dirs:
        run = open_run(run_dir)
        config, history = run.config, run.history
        scene = scenes.of(config)
        readable = config.scene in ("annulus", *VISCOMETERS)
        if config.scene == "channel":
            readable = config.parallel or scene.has_free_bodies
        if not readable:
            raise ConfigError(
                f"{run_dir}: is no run in a channel, without bodies or with free ones, or between cylinders, in a pipe"
                " or of a falling ball"
            )
        try:
            last = run.summary.samples[-1] if run.summary.samples else None
            table = {name: history[name] for name in history.dtype.names}
            reading = read(config, scene, table, run.summary.numbers.get("contacts"), last)
        except ConfigError as error:
            raise ConfigError(f"{run_dir}: {error}") from None
        if reading.title == "capillary":
            capillaries.setdefault(repr(config.fluid), []).append(reading)
        print(f"{config.name}: {reading.title}")
        for line in reading.lines:
            print(f"  {line}")
        plot_reading(run_dir / PICTURE, config.name, reading, config.units)
        print(f"  picture {run_dir / PICTURE}")
    for readings in capillaries.values():
        for line in rabinowitsch(readings):
            print(line)
