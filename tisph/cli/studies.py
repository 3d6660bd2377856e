"""Commands that make many runs: ``tisph verify``, ``stability``, ``sweep``, ``fit`` and ``bench``."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from tisph.cli.terminal import Overrides, out_folder
from tisph.errors import DOUBTFUL, ConfigError, DoubtfulError

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
    """Compare runs with exact solutions, and with required values.

    Prints a table of case, error, bound, pass or FAIL; exit status 1 on a FAIL. A SUITE is one of ours or a YAML file
    (docs/how-to/acceptance-tests.md); with --out DIR its finished runs are kept, and an interrupted suite goes on with
    the same command. With --walls a table of wall treatments, with a picture and all numbers in DIR. The suite
    estimates compares the errors that runs state of themselves (tisph run --estimate-error) with the true ones, the
    suite bars the error bars of tisph run --until, the suite comparisons the verdicts of tisph compare, the suite
    references the sources of tisph references with one another.

    \b
    Examples:
      tisph verify --quick
      tisph verify
      tisph verify my_flow.yaml --json
      tisph verify manufactured
      tisph verify bars --out runs/bars
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


STABILITY_FOLDER = Path("runs/stability")


def stability(
    quick: Annotated[bool, typer.Option("--quick", help="A few short cells of every kind, in three minutes.")] = False,
    only: Annotated[
        str | None, typer.Option("--only", metavar="TEXT", help="The sub-matrices with this text in their titles.")
    ] = None,
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Cells at a time [default: one a core].")
    ] = None,
    out: Annotated[Path | None, out_folder(f"Results [default: {STABILITY_FOLDER}].")] = None,
) -> None:
    """Run the stability matrix and print the outcome of every cell.

    A cell is stable, inaccurate, stopped (with a clear error), refused, or a silent failure: finished, and neither
    right nor warned of. Exit status 1 where one misses its requirement. Leaves maps, a picture and all numbers in DIR,
    where finished runs are kept: an interrupted matrix goes on with the same command.

    \b
    Examples:
      tisph stability --quick
      tisph stability
      tisph stability --processes 2 --out runs/stability-again
      tisph stability --only periodic --out runs/stability-periodic
    """
    from tisph import runtime
    from tisph.studies import stability_report
    from tisph.studies.stability import sub_matrices

    try:
        parts = sub_matrices(quick, only)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--only") from None
    folder = out or STABILITY_FOLDER.with_name(
        "stability-quick" if quick else "stability-part" if only else "stability"
    )
    passed = stability_report.run(folder, processes or runtime.available_threads(), parts)
    cells = json.loads((folder / stability_report.NUMBERS).read_text(encoding="utf-8"))["cells"]
    missed = [cell["name"] for cell in cells if not cell["met"]]
    failed = f"; FAIL: {', '.join(missed)}" if missed else ""
    print(f"\n{len(cells) - len(missed)} of {len(cells)} cells meet their requirement{failed}")
    if not passed:
        raise typer.Exit(1)


def sweep(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="YAML file: base, vary, collect, error, bound.")],
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Runs at a time [default: one a core].")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Run on the workers of this Dask scheduler.")
    ] = None,
    part: Annotated[
        str | None,
        typer.Option("--part", metavar="K/N", help="One of N parts, beside commands that make the others in DIR."),
    ] = None,
    out: Annotated[Path | None, out_folder("Results [default: runs/NAME].")] = None,
) -> None:
    """Run a config with all values of some of its keys.

    Leaves a table (CSV and HDF5), costs and a picture in DIR, and names the cheapest run within the bound. Runs that
    have ended are kept: the same command goes on after Ctrl-C, and a larger study runs only new values. A run that
    fails is a row with its message; exit status 1 only where none succeeds. Parts, such as the tasks of a job array,
    share DIR at the same time; the part that ends last writes the table.

    \b
    Examples:
      tisph sweep study.yaml
      tisph sweep study.yaml --processes 2 --out runs/resolution
      tisph sweep study.yaml --scheduler tcp://machine:8786
      tisph sweep study.yaml --part 3/20 --out /shared/study
    """
    from tisph import runtime
    from tisph.studies.sweep import run

    rows = run(study, out, processes or runtime.available_threads(), scheduler, part)
    if rows and not any(row.status == "done" for row in rows):
        raise typer.Exit(1)


def fit(
    data: Annotated[
        list[Path],
        typer.Argument(metavar="DATA...", help="Velocities (as for compare, also a run), or columns of a rheometer."),
    ],
    config: Annotated[str, typer.Option("--config", metavar="CONFIG", help="YAML file of the flow and its fluid.")],
    free: Annotated[
        list[str], typer.Option("--free", metavar="KEY=LOW..HIGH", help="A key to fit, and its bounds; repeat.")
    ],
    law: Annotated[
        list[str] | None,
        typer.Option(
            "--law", metavar="LAW", help="Fit this law, a name or a map, in place of that of the config; repeat."
        ),
    ] = None,
    sigma: Annotated[
        float | None,
        typer.Option("--sigma", help="Noise, a part of the data [default: of replicates, else of the residuals]."),
    ] = None,
    time: Annotated[
        list[float] | None,
        typer.Option("--time", help="Time of velocities [default: what the file says]; repeat for several."),
    ] = None,
    columns: Annotated[
        list[str] | None, typer.Option("--columns", metavar="x=1,y=2,u=3", help="Columns of velocities, if unusual.")
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option("--unit", metavar="QUANTITY=UNIT", help="Unit of velocities or places; repeat.")
    ] = None,
    overrides: Overrides = None,
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="Runs at a time [default: one a core].")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")] = False,
    out: Annotated[Path | None, out_folder("Results [default: runs/fit-NAME].")] = None,
) -> None:
    """Find values of keys of a config, such as those of the fluid, from measurements.

    Prints and stores each value with its 95 % interval, correlations, and the noise; names keys that the data do not
    determine, and says where the fit is a misfit: exit status 1. Leaves numbers, a table, a picture and the fitted
    config in DIR. Exact solutions predict the data where there are any, else runs do, which are kept: the same command
    goes on after Ctrl-C.

    DATA are velocities at places and times, or columns with headings such as shear rate [1/s] and viscosity [Pa s];
    angular frequency [rad/s], G' [Pa] and G'' [Pa]; time [s] and stress [Pa], torque, force or speed.

    \b
    Examples:
      tisph fit curve.csv --config fluid.yaml --free fluid.dynamic_viscosity=0.1..10 --free fluid.rheology.index=0.3..1
      tisph fit piv.csv --config couette.yaml --free fluid.rheology.relaxation_time=0.1..10 --sigma 0.01
      tisph fit moduli.csv --config fluid.yaml --free fluid.rheology.relaxation_time=0.1..10 --law oldroyd_b --json
    """
    from tisph import runtime
    from tisph.assessment.judge import Question
    from tisph.folder import Folder
    from tisph.studies import fit as fits

    question = Question(time or (), columns or (), unit or ())
    data = [Folder(each).samples if each.is_dir() else each for each in data]
    say = (lambda *words, **options: None) if as_json else print
    count = processes or runtime.available_threads()
    found, folder = fits.fit(config, data, free, law or (), sigma, question, overrides or (), out, count, say)
    if as_json:
        print((folder / fits.NUMBERS).read_text(encoding="utf-8"), end="")
    for name in (fits.NUMBERS, fits.TABLE, fits.PICTURE, fits.FITTED):
        say(folder / name)
    if complaints := found[0].complaints:
        raise DoubtfulError(DOUBTFUL + "; ".join(complaints))


BENCH_FOLDER = Path("runs/bench")

MOVED = {
    "throughput": "step.py",
    "scaling": "scaling.py",
    "features": "step.py --parts",
    "startup": "startup.py",
}
"""Former benchmark of the command -> script in ``benchmarks/``."""


def bench(
    name: Annotated[
        Literal["frontier", "throughput", "features", "startup", "scaling"],
        typer.Argument(help="Which benchmark; all but frontier are scripts in benchmarks/ of the repository."),
    ] = "frontier",
    quick: Annotated[bool, typer.Option("--quick", help="A small one, in two minutes.")] = False,
    peers: Annotated[
        Path | None,
        typer.Option("--peers", metavar="DIR", help="Run the peers in DIR (benchmarks/peers) in the same call."),
    ] = None,
    flow: Annotated[
        Literal["channel", "oldroyd_b", "taylor_green", "circular_couette", "cavity", "cylinder", "pipe"],
        typer.Option("--flow", help="Whose flows."),
    ] = "channel",
    configs: Annotated[Path | None, typer.Option("--configs", hidden=True, help="Of the script startup.py.")] = None,
    out: Annotated[
        Path | None,
        out_folder(f"Results [default: {BENCH_FOLDER}/frontier, of another flow than channel frontier_FLOW there]."),
    ] = None,
) -> None:
    """Measure run time against error, of this program and of others.

    Tables, a picture and all numbers are left in DIR, with finished runs: an interrupted benchmark goes on with the
    same command. Exit status 1 if a bound is missed.

    \b
    frontier: every flow by every method, in interleaved rounds: of the
      channel, Oldroyd-B fluids in it, Taylor-Green vortices, circular
      Couette flow, the cavity, cylinders in a channel, or starting pipes

    \b
    Examples:
      tisph bench frontier --quick
      tisph bench frontier --peers benchmarks/peers
      tisph bench frontier --flow oldroyd_b
      tisph bench frontier --flow cavity --peers benchmarks/peers
    """
    if name in MOVED:
        raise ConfigError(f"bench {name}: it is a script of the repository now: python benchmarks/{MOVED[name]}")
    if peers and not (peers / "measure.py").is_file():
        raise ConfigError(f"--peers {peers}: there is no measure.py; the peers' scripts are in benchmarks/peers")
    from tisph.studies import frontier

    folder = out or BENCH_FOLDER / ("frontier" if flow == "channel" else f"frontier_{flow}")
    if not frontier.run(folder, quick=quick, peers_folder=peers, group=flow):
        raise typer.Exit(1)
