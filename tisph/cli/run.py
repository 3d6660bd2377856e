"""``tisph check`` and ``tisph run``: validate a config; simulate, write numbers, pictures, a movie and a table."""

import json
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tisph.cli.terminal import ConfigFile, Overrides, held_back, out_folder
from tisph.errors import UNREACHED, ConfigError, DivergedError, UnreachedError
from tisph.folder import Folder, claimed
from tisph.text_table import format_table

if TYPE_CHECKING:  # which take half a second
    from tisph.config.schema import Config
    from tisph.scenes._scene import Scene

FORCES = ("drag", "lift", "torque", "wall_shear")
"""Beginnings of the names of numbers in the table; a scene without any shows other numbers of its flow."""

PARTS = {
    "loop": "in the steps",
    "compile": "compiling",
    "output": "for output",
    "import": "getting ready",
}
"""Part of the cost in ``summary.json`` -> words for it."""

MOST_NUMBERS = 4
MOST_SAMPLES = 10


def result_text(config: "Config", scene: "Scene", summary: Mapping[str, Any]) -> str:
    """Return a table of the last samples in ``summary`` (contents of ``summary.json``), and the time used, as text.

    The error is the error of the velocity against the reference; without a reference it is the estimate of
    ``--estimate-error``, if there is one. Numbers are in the units of the config.
    """
    texts, samples = [], summary["samples"]
    if samples:
        numbers = [name for name in scene.flow_quantities if name.startswith(FORCES)] or scene.flow_quantities
        numbers = [name for name in numbers if name in samples[0]][:MOST_NUMBERS]
        error = "rms error / U" if scene.vanishing_scale else "L2 error"
        titles = (name.replace("_", " ") for name in numbers)
        judged = ("change", "steady") if "steady" in samples[0] else ()
        header = ("sample", f"t [{config.units.time}]", error, *titles, "resolved", *judged)
        estimates = (summary.get("error_estimate") or {}).get("samples") or [None] * len(samples)
        rows = [
            (str(index), f"{sample['t']:g}", _error(scene, sample, estimate), *_cells(sample, numbers))
            for index, (sample, estimate) in enumerate(zip(samples, estimates, strict=True))
        ]
        texts.append(format_table(header, rows[-MOST_SAMPLES:]))
        if len(rows) > MOST_SAMPLES:
            texts.append(f"{len(rows) - MOST_SAMPLES} earlier samples are in summary.json")
        shown = list(enumerate(samples))[-MOST_SAMPLES:]
        texts += [f"sample {index} is not resolved: {each['reason']}" for index, each in shown if not each["resolved"]]
        zero = [(index, each["zero_within_error"]) for index, each in shown if each.get("zero_within_error")]
        texts += [f"sample {index}: zero within the error: {names}" for index, names in zero]
        if samples[-1].get("steady_reason"):
            texts.append(f"sample {len(samples) - 1} is not steady: {samples[-1]['steady_reason']}")
    met, cost = summary.get("numbers", {}), summary["cost"]
    if met.get("contacts"):
        times = "once" if met["contacts"] == 1 else f"{met['contacts']} times"
        texts.append(
            f"bodies touched {times}, for {met['contact_time']:.3g} {config.units.time} in all: a model keeps them "
            "apart then, and later motion depends on it"
        )
    parts = ", ".join(f"{cost[f'wall_{part}_s']:.2g} s {words}" for part, words in PARTS.items())
    return "\n".join([*texts, f"{cost['steps']} steps, {cost['wall_total_s']:.3g} s: {parts}"])


def _error(scene: "Scene", sample: Mapping[str, Any], estimate: Any) -> str:
    value = sample["rms" if scene.vanishing_scale else "l2"]
    if value is not None:
        return f"{value:.2e}"
    value = estimate and estimate["fields"].get("velocity", {}).get("error")
    return "none" if value is None else f"{value:.1e} (estimate)"


def _cells(sample: Mapping[str, Any], numbers: Sequence[str]) -> Iterator[str]:
    yield from ("none" if sample[name] is None else f"{sample[name]:.5g}" for name in numbers)
    yield "yes" if sample["resolved"] else "no"
    if "steady" in sample:
        change = sample["steady_change"]
        yield from ("none" if change is None else f"{change:.1e}", "yes" if sample["steady"] else "no")


SHOWN = {
    "movie": "movie.mp4",
    "profiles": "profiles.png",
    "history": "history.png",
    "summary": "summary.json",
}

PRINTED = ("name", "status", "samples", "cost", "error_estimate")
"""Keys of ``summary.json`` that ``--json`` prints."""


def check(
    config: ConfigFile,
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="PNG file of --picture [NAME.png].")] = None,
    overrides: Overrides = None,
    picture: Annotated[
        bool, typer.Option("--picture", help="Draw the config: walls, bodies, ends, particles.")
    ] = False,
) -> None:
    """Validate a config; print its numbers and cost.

    Nothing is run, and nothing is written but the picture.

    \b
    Examples:
      tisph check configs/couette.yaml
      tisph check configs/couette.yaml --set discretisation.particles_across=100
      tisph check configs/cylinder_in_channel.yaml --picture
    """
    from tisph.config import load
    from tisph.schemes._forecast import described, forecast

    if file and not picture:
        raise ConfigError(f"{file}: one config is checked; a picture of it needs --picture")
    loaded = load(config, overrides or ())
    for line in described(loaded, *forecast(loaded)):
        print(line)
    if picture:
        from tisph import scenes
        from tisph.report.preview import save_preview

        path = file or Path(f"{loaded.name}.png")
        save_preview(path, loaded, scenes.of(loaded))
        print(f"  {'picture':22} {path}")


def run(
    config: ConfigFile,
    out: Annotated[Path | None, out_folder("Folder of the results [default: runs/NAME].")] = None,
    overrides: Overrides = None,
    no_video: Annotated[bool, typer.Option("--no-video", help="Make no movie.")] = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Make no movie and no plots.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint in DIR.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in DIR.")] = False,
    estimate_error: Annotated[
        bool,
        typer.Option("--estimate-error", help="Run two coarser runs, too, and state the error that they tell of."),
    ] = False,
    until: Annotated[
        list[str] | None,
        typer.Option("--until", metavar="NUMBER=GOAL", help="Refine until the error of a number is, e.g., 0.1%."),
    ] = None,
    at_most: Annotated[
        str | None, typer.Option("--at-most", metavar="TIME", help="Longest time of --until, such as 10min.")
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="KEY=FACTOR", help="Let bars count another length, geometry.length=1.25."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the samples and the cost of summary.json, and nothing else.")
    ] = False,
) -> None:
    """Run a config and leave its results in DIR.

    It ends with a table of errors and forces at the samples, the time used, and the files. With --until, or the key
    accuracy, it makes finer and finer runs until the error bar of each number is inside its goal; exit status 1 where
    one is not. Runs that have ended are kept: the same command goes on after Ctrl-C.

    \b
    Examples:
      tisph run configs/couette.yaml
      tisph run configs/couette.yaml --out runs/fine --set discretisation.particles_across=100
      tisph run configs/couette.yaml --no-video --overwrite
      tisph run configs/couette.yaml --resume
      tisph run configs/shear_layer.yaml --estimate-error
      tisph run configs/pipe.yaml --until force_outer=0.1% --at-most 10min
      tisph run configs/couette.yaml --quiet --json > couette.json
    """
    with held_back():
        from tisph.config import load
        from tisph.schemes._forecast import forecast

        loaded = load(config, overrides or ())
        _, warnings = forecast(loaded)
    folder = out or Path("runs") / loaded.name
    if until or loaded.accuracy:
        if estimate_error or resume:
            option = "--estimate-error" if estimate_error else "--resume"
            raise ConfigError(f"{option}: is not for --until and accuracy, whose runs go on by the same command")
        _run_until(loaded, folder, until, at_most, vary, overwrite, quiet, as_json)
        return
    if at_most or vary:
        option = "--at-most" if at_most else "--vary"
        raise ConfigError(f"{option}: is for --until, or a config with the key accuracy")
    coarser = None
    if estimate_error:
        from tisph.studies.error_estimate import Coarser

        if loaded.discretisation.refine == "auto":
            text = "the coarser runs need the places of this run: run it without, and then its config.resolved.yaml"
            raise ConfigError(f"--estimate-error: is not for discretisation.refine = auto: {text}")
        coarser = Coarser(loaded, folder)
    with ExitStack() as stack:
        stack.enter_context(claimed(folder, overwrite=overwrite, resume=resume))
        stack.enter_context(_partial_results_named(folder, coarser))
        if quiet:  # drop progress and warnings; errors are raised, and printed later
            stack.enter_context(redirect_stderr(stack.enter_context(open(os.devnull, "w", encoding="utf-8"))))
        for text in warnings:
            print(f"warning: {text}", file=sys.stderr)
        drawn = {"pictures": not no_pictures, "video": not (no_video or no_pictures)}
        _simulate(loaded, folder, coarser, resume=resume, **drawn)
        estimate = coarser.report() if coarser else None
    if as_json:
        summary = Folder(folder).read_summary()
        print(json.dumps({key: summary[key] for key in PRINTED if key in summary}, indent=2))
    elif not quiet:
        from tisph import scenes

        print(result_text(loaded, scenes.of(loaded), Folder(folder).read_summary()))
        print(f"results in {folder}")
        for what, name in SHOWN.items():
            if (folder / name).is_file():
                print(f"  {what:9} {folder / name}")
        if estimate:
            print(f"\n{estimate}")


def _run_until(
    config: "Config",
    folder: Path,
    asked: Sequence[str] | None,
    at_most: str | None,
    vary: Sequence[str] | None,
    overwrite: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Run the chain of ``--until``; UnreachedError where a goal is not reached."""
    from tisph.studies import until

    wanted, factors = (dict(text.rpartition("=")[::2] for text in given or ()) for given in (asked, vary))
    with ExitStack() as stack:
        if quiet:
            stack.enter_context(redirect_stderr(stack.enter_context(open(os.devnull, "w", encoding="utf-8"))))
        found = until.run(config, folder, wanted, at_most, overwrite, factors)
    if as_json:
        print(json.dumps(found, indent=2))
    elif not quiet:
        print(f"{until.table(found)}\nresults in {folder}")
        for path in (Folder(folder).accuracy, Folder(folder).accuracy_picture):
            print(f"  {path}")
    missed = [f"{name}: {entry['reason']}" for name, entry in found.items() if not entry["reached"]]
    if missed:
        raise UnreachedError(UNREACHED + "; ".join(missed))


def _simulate(config: "Config", folder: Path, coarser: Any, *, pictures: bool, video: bool, resume: bool) -> None:
    with held_back():
        if pictures:
            from tisph.report import drawing_process

            drawing_process.shared()  # it imports matplotlib while this process imports Taichi
        from tisph import simulation

    if coarser:
        coarser.run()
    simulation.run(config, folder, pictures=pictures, video=video, resume=resume)


@contextmanager
def _partial_results_named(folder: Path, coarser: Any) -> Iterator[None]:
    """Name the folder of the results of a run that ends early, or whose ``coarser`` runs do, and the way to resume."""
    try:
        yield
    except KeyboardInterrupt:
        if coarser or any(path.is_file() for path in Folder(folder).files()):
            how = "--resume goes on" if Folder(folder).checkpoint.is_file() else "--overwrite begins again"
            print(f"partial results are in {folder}; the same command with {how}", file=sys.stderr)
        raise
    except DivergedError as error:
        raise DivergedError(f"{error}\npartial results are in {folder}") from None
