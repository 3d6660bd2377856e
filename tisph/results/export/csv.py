"""A line a particle and sample; lines before the header that begin with ``#`` say what the file is."""

from pathlib import Path
from typing import TYPE_CHECKING

from tisph.results.export._columns import columns

if TYPE_CHECKING:
    from tisph.results import Results


def write(path: Path, run: "Results") -> None:
    """Write the columns t, particle, x, y, u, v and so on, whose units are in the second line."""
    time = run.config.units.time
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for index, sample in enumerate(run.samples):
            found = columns(sample)
            if index == 0:
                units = {"t": time, "particle": "", **{name: sample.units[name] for name in found}}
                file.write(f"# {run.summary.name}: particles at the samples of a run of tisph\n")
                file.write(f"# units: {', '.join(f'{name} {unit}'.strip() for name, unit in units.items())}\n")
                file.write(",".join(units) + "\n")
            values = [array.tolist() for array in found.values()]  # repr of a float is exact
            for number, row in enumerate(zip(*values, strict=True)):
                file.write(f"{sample.t!r},{number}," + ",".join(map(repr, row)) + "\n")
