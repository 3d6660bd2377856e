"""Commands for results: ``tisph compare``, ``render``, ``report``, ``export`` and ``rheometry``."""

import json
import math
from contextlib import nullcontext
from csv import DictWriter
from pathlib import Path
from typing import Annotated

import typer

from tisph.cli.terminal import Overrides, out_folder
from tisph.errors import ConfigError
from tisph.folder import extended, replaced


def compare(
    data: Annotated[
        list[Path], typer.Argument(metavar="DATA...", help="Results: CSV, npz, HDF5, JSON, LAMMPS dump, VTK, a run.")
    ],
    config: Annotated[str, typer.Option("--config", metavar="CONFIG", help="YAML file of the same flow.")],
    time: Annotated[
        list[float] | None,
        typer.Option("--time", help="Time of the data [default: what the file says]; repeat for several."),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--columns", metavar="x=1,y=2,u=3", help="Names or numbers of columns, where they are unusual."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="QUANTITY=UNIT", help="Unit of the data, a name or a factor; repeat."),
    ] = None,
    origin: Annotated[
        str | None, typer.Option("--origin", metavar="X,Y", help="Place in the data of the config's point (0, 0).")
    ] = None,
    orientation: Annotated[
        str | None,
        typer.Option("--orientation", metavar="x,y", help="Axes of the data along x and y of the config, as y,-x."),
    ] = None,
    select: Annotated[str | None, typer.Option("--select", help="The group of particles that is the fluid.")] = None,
    bound: Annotated[float | None, typer.Option("--bound", help="Exit status 1 if an error is larger.")] = None,
    at_most: Annotated[
        str | None, typer.Option("--at-most", metavar="TIME", help="Longest time of the runs of a reference: 10min.")
    ] = None,
    out: Annotated[Path | None, out_folder("Numbers and picture [default: runs/compare-NAME].")] = None,
    overrides: Overrides = None,
) -> None:
    """Judge the result of any code against the exact solution, or against runs that refine until they can tell.

    Prints and stores errors, lines through the probes, centreline, wall shear, the place of the largest error, the
    order for several resolutions, and the fault, if a single one explains the errors. --bound is for the L2 error, or
    for the rms error over U in flows that cross zero.

    Without an exact solution runs are made, and kept, in NAME_reference beside DATA, until their error bar is a tenth
    of the difference. The verdict is agrees (to 0.1 %, or to --bound), differs, or undecided, with both numbers. DATA
    may also be numbers of samples over t, such as drag_coefficient.

    \b
    Examples:
      tisph compare profile.csv --config couette.yaml --time 2.7
      tisph compare out.dat --config couette.yaml --time 2.7 --columns y=2,u=4 --unit length=cm --unit velocity=cm/s
      tisph compare couette_100.hdf5 couette_200.hdf5 --config couette.yaml --bound 1e-3
      tisph compare couette.dump --config couette.yaml --time 20 --origin 0,0.06
      tisph compare drag.csv --config cylinder_lattice.yaml --at-most 5min
    """
    from tisph.assessment import judge
    from tisph.config import load
    from tisph.folder import Folder

    loaded = load(config, overrides or ())
    place = None
    if origin is not None:
        try:
            x, y = map(float, origin.split(","))
        except ValueError:
            raise ConfigError(f"--origin {origin}: must be two numbers, such as 0,0.5") from None
        place = x, y
    question = judge.Question(time or (), columns or (), unit or (), orientation, place, select)
    results = out or Path("runs") / f"compare-{data[0].stem or data[0].name}"
    beside = data[0].parent / f"{loaded.name}_reference"
    data = [Folder(each).samples if each.is_dir() else each for each in data]
    if not judge.has_reference(loaded):
        from tisph.studies import referee

        compared = referee.compare(loaded, data, question, beside, at_most, bound)
        print(referee.text(compared, loaded.name, beside))
        print(referee.write(compared, results))
        if bound is not None and not compared.agrees:
            raise typer.Exit(1)
        return
    if at_most:
        raise ConfigError("--at-most: is for flows without an exact solution; this one needs no runs")
    found = judge.judge(loaded, data, question)
    print(judge.text(found, loaded.name))
    for path in judge.write(found, results):
        print(f"{path}")
    if bound is not None:
        over = [each for each in found.samples if each.error is None or each.error > bound]
        print(f"{len(over)} of {len(found.samples)} errors above {bound:g}: {'FAIL' if over else 'pass'}")
        if over:
            raise typer.Exit(1)


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
    from tisph.results import open_run
    from tisph.results.page import report as page

    text = page([open_run(folder) for folder in run_dirs])
    path = out or Path(run_dirs[0] if len(run_dirs) == 1 else ".") / "report.html"
    with extended(path.parent) if path.parent in run_dirs else nullcontext(), replaced(path) as new:
        new.write_text(text, encoding="utf-8")
    print(path)


def export(
    run_dir: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    to: Annotated[str, typer.Option("--to", metavar="FORMAT", help="vtkhdf, csv, npz or extxyz.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The file [default: samples.FORMAT in RUN].")
    ] = None,
    frames: Annotated[bool, typer.Option("--frames", help="The frames of the movie, for vtkhdf.")] = False,
) -> None:
    """Write the samples of a run for another program.

    \b
    vtkhdf   ParaView: File > Open, then play; bodies are in ..._bodies.vtkhdf
    csv      a line a particle and sample
    npz      NumPy arrays (samples, particles)
    extxyz   OVITO, ASE
    \b
    Examples:
      tisph export runs/couette --to vtkhdf
      tisph export runs/cylinder_lattice --to vtkhdf --frames
      tisph export runs/couette --to csv --out couette.csv
    """
    from tisph.results import open_run
    from tisph.results.export import export as write

    print(write(open_run(run_dir), to, out, frames=frames))


PICTURE, NUMBERS, MODULI, STEADY = "rheometry.png", "rheometry.json", "moduli.png", "steady_shear.png"


def rheometry(
    run_dirs: Annotated[list[Path], typer.Argument(metavar="RUN_DIR...", help="Folders of finished runs.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")] = False,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write the numbers, one run a row.")] = None,
) -> None:
    """Read runs in a channel, between cylinders, in a pipe or of a falling ball as a rheometer, beside theory.

    By the motion of the walls: viscosity growth, N1, creep compliance, recovery, free oscillation, relaxation modulus,
    flow curve, moduli G' and G'', harmonics. With free bodies: effective viscosity and its statistical error.
    Viscosity by a Couette viscometer, a falling ball or a capillary; three capillary runs or more give the flow curve,
    two oscillations or more G' and G'' over the frequency (moduli.png beside their folders), two start-ups or more
    viscosity and N1 over the shear rate (steady_shear.png there). The picture is rheometry.png in the folder of the
    run, the numbers are in rheometry.json.

    \b
    Examples:
      tisph rheometry runs/creep_and_recovery
      tisph rheometry runs/oscillation_* --csv moduli.csv
      tisph rheometry runs/rate_*
      tisph rheometry runs/falling_ball --json
    """
    from tisph import scenes
    from tisph.report.plots import plot_reading
    from tisph.results import open_run
    from tisph.rheometry.rheometers import steady_shear, together, uniform_shear
    from tisph.rheometry.viscometers import rabinowitsch

    runs = [open_run(run_dir) for run_dir in run_dirs]
    readings, fluids = [run.rheometry() for run in runs], {repr(run.config.fluid) for run in runs}
    rows = []

    def say(*lines: str) -> None:
        if not as_json:
            print(*lines, sep="\n  ")

    for run, reading in zip(runs, readings, strict=True):
        name = run.config.title or run.config.name
        say(f"{name}: {reading.title}", *reading.lines)
        finite = {key: float(value) if math.isfinite(value) else None for key, value in reading.numbers.items()}
        rows.append({"run": str(run.folder), "title": reading.title, **finite})
        with extended(run.folder):
            with replaced(run.folder / NUMBERS) as new:
                new.write_text(json.dumps(rows[-1], indent=1) + "\n")
            plot_reading(run.folder / PICTURE, name, reading, run.config.units)
        say(f"  picture {run.folder / PICTURE}")
    oscillations = [reading for reading in readings if reading.title == "oscillation"]
    sheared = [reading for reading in readings if reading.title == "start-up"]
    joined = []
    if len(fluids) == 1 and len(oscillations) > 1:
        joined.append((together(oscillations), MODULI))
    if len(fluids) == 1 and len({abs(reading.numbers["shear_rate"]) for reading in sheared}) > 1:
        law = uniform_shear(runs[0].config.fluid.rheology, scenes.of(runs[0].config))
        joined.append((steady_shear(sheared, law), STEADY))
    for curve, picture_name in joined:
        picture = runs[0].folder.parent / picture_name
        say(curve.title, *curve.lines, f"picture {picture}")
        plot_reading(picture, runs[0].folder.parent.name, curve, runs[0].config.units)
    for fluid in sorted(fluids):
        same = [each for each, run in zip(readings, runs, strict=True) if repr(run.config.fluid) == fluid]
        for line in rabinowitsch([reading for reading in same if reading.title == "capillary"]):
            say(line)
    if as_json:
        print(json.dumps(rows, indent=1))
    if csv:
        names = dict.fromkeys(key for row in rows for key in row)
        with replaced(csv) as new, new.open("w", newline="") as file:
            writer = DictWriter(file, names)
            writer.writeheader()
            writer.writerows(rows)
        say(f"numbers {csv}")
