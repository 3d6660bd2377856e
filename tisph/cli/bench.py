"""``tisph bench``: run time against error, and what parts of a run cost."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from tisph.errors import ConfigError

FOLDER = Path("runs/bench")


def bench(
    name: Annotated[Literal["frontier", "startup"], typer.Argument(help="Which benchmark.")] = "frontier",
    quick: Annotated[bool, typer.Option("--quick", help="A small one, in two minutes.")] = False,
    peers: Annotated[
        Path | None,
        typer.Option("--peers", metavar="DIR", help="Run the peers in DIR (benchmarks/peers) in the same call."),
    ] = None,
    configs: Annotated[Path, typer.Option("--configs", metavar="DIR", help="Configs of startup.")] = Path("configs"),
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help=f"Results [default: {FOLDER}/NAME].")] = None,
) -> None:
    """Measure run time against error, or what it takes to start.

    frontier: every flow in every way, three rounds, with a table, a picture and all numbers in DIR, where finished runs
    are kept: an interrupted benchmark goes on with the same command. startup: import, compiling and first frames of
    every config.

    \b
    Examples:
      tisph bench frontier --quick
      tisph bench frontier --peers benchmarks/peers
      tisph bench startup --quick
    """
    folder = out or FOLDER / name
    if name == "startup":
        from tisph.study.bench import startup

        startup.run(folder, sorted(configs.glob("*.yaml"))[: 3 if quick else None])
        return
    if peers and not (peers / "measure.py").is_file():
        raise ConfigError(f"--peers {peers}: there is no measure.py; the peers' scripts are in benchmarks/peers")
    from tisph.study.bench import frontier

    frontier.run(folder, quick=quick, peers_folder=peers)
