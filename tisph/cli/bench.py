"""``tisph bench``: run time against error, and what parts of a run cost."""

from importlib import import_module
from pathlib import Path
from typing import Annotated, Literal

import typer

from tisph.cli.options import folder_name
from tisph.errors import ConfigError

FOLDER = Path("runs/bench")


Name = Annotated[
    Literal["frontier", "throughput", "features", "startup", "scaling"], typer.Argument(help="Which benchmark.")
]

Quick = Annotated[bool, typer.Option("--quick", help="A small one, in two minutes.")]

Peers = Annotated[
    Path | None,
    typer.Option(
        "--peers",
        metavar="DIR",
        help="With frontier or throughput: run the peers in DIR (benchmarks/peers) in the same call.",
    ),
]

Flow = Annotated[
    Literal["channel", "oldroyd_b", "taylor_green", "circular_couette", "cavity", "cylinder"],
    typer.Option("--flow", help="With frontier: whose flows."),
]

Configs = Annotated[Path, typer.Option("--configs", metavar="DIR", help="With startup: where the configs are.")]

Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="DIR",
        parser=folder_name,
        help=f"Results [default: {FOLDER}/NAME, and {FOLDER}/frontier_FLOW of another flow than channel].",
    ),
]


def bench(
    name: Name = "frontier",
    quick: Quick = False,
    peers: Peers = None,
    flow: Flow = "channel",
    configs: Configs = Path("configs"),
    out: Out = None,
) -> None:
    """Measure run time against error, or what parts of a run cost.

    Tables, a picture where there is one, and all numbers are left in DIR, with finished measurements: an interrupted
    benchmark goes on with the same command. Exit status 1 if a bound is missed.

    \b
    frontier: every flow in every way, in rounds: run time against error, of
      the channel, Oldroyd-B liquids in it, Taylor-Green vortices, circular
      Couette flow, the cavity, or cylinders in a channel
    throughput: what a particle and a step cost, part by part, and bytes a
      particle, from 5 thousand to a million particles
    features: what each part costs, and that a scene pays for none that it
      does not use
    scaling: cost of a particle and iterations of the implicit scheme, from
      2500 particles to a million
    startup: what a run costs beside its loop, with kernels in the cache, for
      another resolution, and with an empty cache; what a movie adds

    \b
    Examples:
      tisph bench frontier --quick
      tisph bench frontier --peers benchmarks/peers
      tisph bench frontier --flow oldroyd_b
      tisph bench frontier --flow cavity --peers benchmarks/peers
      tisph bench throughput --quick
      tisph bench features
      tisph bench startup --quick
    """
    options = _options(name, peers, flow, configs)
    folder = out or FOLDER / (f"{name}_{flow}" if name == "frontier" and flow != "channel" else name)
    if not import_module(f"tisph.study.bench.{name}").run(folder, quick=quick, **options):
        raise typer.Exit(1)


def _options(name, peers, flow, configs):
    """Return what a benchmark takes beside its folder."""
    if peers and not (peers / "measure.py").is_file():
        raise ConfigError(f"--peers {peers}: there is no measure.py; the peers' scripts are in benchmarks/peers")
    options = {
        "frontier": {"peers_folder": peers, "group": flow},
        "throughput": {"peers_folder": peers},
        "startup": {"configs": sorted(configs.glob("*.yaml"))},
    }
    return options.get(name, {})
