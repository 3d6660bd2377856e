"""Command line: one function for each command, which imports the other rooms when it runs, so that help is quick."""

import gc
import sys
from collections.abc import Callable
from importlib import metadata
from typing import Annotated

import typer

from tisph.cli import finished, menu, run, studies, terminal
from tisph.cli.terminal import reported
from tisph.version import __version__

HELP = """Laminar, wall-bounded flow by smoothed particles: a YAML file describes a run, one command runs it.

\b
Examples:
  tisph new couette
  tisph check couette.yaml
  tisph run couette.yaml
  tisph run couette.yaml --set walls.top.velocity=0.01 --out runs/faster
  tisph report runs/couette runs/faster

Exit status: 0 done, 1 a check failed, 2 bad input, 3 the run diverged, 130 interrupted.
"""

app = typer.Typer(
    help=HELP,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from tisph import runtime

        print(f"tisph {__version__} ({runtime.PACKAGE.capitalize()} {metadata.version(runtime.PACKAGE)})")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    pass


COMMANDS: dict[str, Callable[..., None]] = {
    "run": run.run,
    "check": run.check,
    "list": menu.list_families,
    "keys": menu.keys,
    "references": menu.references,
    "verify": studies.verify,
    "bench": studies.bench,
    "stability": studies.stability,
    "new": menu.new,
    "render": finished.render,
    "report": finished.report,
    "export": finished.export,
    "compare": finished.compare,
    "sweep": studies.sweep,
    "fit": studies.fit,
    "rheometry": finished.rheometry,
}
for _name, _command in COMMANDS.items():
    app.command(_name)(reported(_command))
app.command("stress", hidden=True)(reported(studies.stability))  # its name in version 0.1


def main() -> None:
    """Run the command line on the arguments of this process.

    Kernels are translated to millions of small objects. Python's collector would search them repeatedly, and once more
    at the end, and free none: a fifth of the time of a short run.
    """
    gc.set_threshold(200_000, 20, 20)
    terminal.outlive_readers()
    try:
        app(prog_name="tisph")
    except SystemExit as leaving:
        lost = terminal.output_lost()
        if lost and not leaving.code:
            sys.exit(f"error: standard output cannot be written: {lost.strerror}")
        raise
    finally:
        gc.freeze()
