"""``tisph export``: the samples of a run in the files of other programs."""

from pathlib import Path
from typing import Annotated

import typer


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
