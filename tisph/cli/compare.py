"""``tisph compare``: judge the result of any code against the reference of a config."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tisph.cli.terminal import Overrides, out_folder
from tisph.errors import ConfigError

if TYPE_CHECKING:
    from tisph.assessment.judge import Sample


Data = Annotated[list[Path], typer.Argument(metavar="DATA...", help="Results: CSV, npz, HDF5, JSON, LAMMPS dump, VTK.")]
SameFlow = Annotated[str, typer.Option("--config", metavar="CONFIG", help="YAML file of the same flow.")]
Times = Annotated[
    list[float] | None,
    typer.Option("--time", help="Time of the data [default: what the file says]; repeat for several."),
]
Columns = Annotated[
    list[str] | None,
    typer.Option("--columns", metavar="x=1,y=2,u=3", help="Names or numbers of columns, where they are unusual."),
]
Units = Annotated[
    list[str] | None,
    typer.Option("--unit", metavar="QUANTITY=UNIT", help="Unit of the data, a name or a factor; repeat."),
]
Origin = Annotated[
    str | None, typer.Option("--origin", metavar="X,Y", help="Place in the data of the config's point (0, 0).")
]
Orientation = Annotated[
    str | None,
    typer.Option("--orientation", metavar="x,y", help="Axes of the data along x and y of the config, as y,-x."),
]
Select = Annotated[str | None, typer.Option("--select", help="The group of particles that is the fluid.")]
Bound = Annotated[float | None, typer.Option("--bound", help="Exit status 1 if an error is larger.")]
Out = Annotated[Path | None, out_folder("Numbers and picture [default: runs/compare-NAME].")]


def compare(  # an argument an option
    data: Data,
    config: SameFlow,
    time: Times = None,
    columns: Columns = None,
    unit: Units = None,
    origin: Origin = None,
    orientation: Orientation = None,
    select: Select = None,
    bound: Bound = None,
    out: Out = None,
    overrides: Overrides = None,
) -> None:
    """Judge the result of any code against the exact solution.

    Prints and stores errors, lines through the probes, centreline, wall shear, where the error is largest, the order if
    resolutions are several, and what is wrong if one fault explains it. --bound is of the L2 error, or of the rms
    error over U in flows that cross zero.

    \b
    Examples:
      tisph compare profile.csv --config couette.yaml --time 2.7
      tisph compare out.dat --config couette.yaml --time 2.7 --columns y=2,u=4 --unit length=cm --unit velocity=cm/s
      tisph compare couette_100.hdf5 couette_200.hdf5 --config couette.yaml --bound 1e-3
      tisph compare couette.dump --config couette.yaml --time 20 --origin 0,0.06
    """
    from tisph.assessment import judge
    from tisph.config import load

    loaded = load(config, overrides or ())
    question = judge.Question(time or (), columns or (), unit or (), orientation, _place(origin), select)
    found = judge.judge(loaded, data, question)
    print(judge.text(found, loaded.name))
    for path in judge.write(found, out or Path("runs") / f"compare-{data[0].stem or data[0].name}"):
        print(f"{path}")
    if bound is not None and not _within(bound, found.samples):
        raise typer.Exit(1)


def _within(bound: float, samples: "list[Sample]") -> bool:
    """Say and return whether all errors are known and no larger than ``bound``."""
    over = [each for each in samples if each.error is None or each.error > bound]
    print(f"{len(over)} of {len(samples)} errors above {bound:g}: {'FAIL' if over else 'pass'}")
    return not over


def _place(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise ConfigError(f"--origin {text}: must be two numbers, such as 0,0.5") from None
    return x, y
