"""``tisph bench``: run time against error, beside other codes."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from tisph.cli.options import out_folder
from tisph.errors import ConfigError

FOLDER = Path("runs/bench")

MOVED = {
    "throughput": "step.py",
    "scaling": "scaling.py",
    "features": "step.py --parts",
    "startup": "startup.py",
}
"""Script in ``benchmarks/`` of each benchmark that is no command any more, by its name."""

Name = Annotated[
    Literal["frontier", "throughput", "features", "startup", "scaling"],
    typer.Argument(help="Which benchmark; all but frontier are scripts in benchmarks/ of the repository."),
]

Quick = Annotated[bool, typer.Option("--quick", help="A small one, in two minutes.")]

Peers = Annotated[
    Path | None,
    typer.Option("--peers", metavar="DIR", help="Run the peers in DIR (benchmarks/peers) in the same call."),
]

Flow = Annotated[
    Literal["channel", "oldroyd_b", "taylor_green", "circular_couette", "cavity", "cylinder", "pipe"],
    typer.Option("--flow", help="Whose flows."),
]

Configs = Annotated[Path | None, typer.Option("--configs", hidden=True, help="Of the script startup.py.")]

Out = Annotated[
    Path | None,
    out_folder(f"Results [default: {FOLDER}/frontier, and {FOLDER}/frontier_FLOW of another flow than channel]."),
]


def bench(
    name: Name = "frontier",
    quick: Quick = False,
    peers: Peers = None,
    flow: Flow = "channel",
    configs: Configs = None,
    out: Out = None,
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

    folder = out or FOLDER / ("frontier" if flow == "channel" else f"frontier_{flow}")
    if not frontier.run(folder, quick=quick, peers_folder=peers, group=flow):
        raise typer.Exit(1)
