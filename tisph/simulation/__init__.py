"""The run itself: from a config to a folder of results."""

from tisph.simulation.recording import render
from tisph.simulation.run import run

__all__ = ["render", "run"]
