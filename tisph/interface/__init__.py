"""What ``import tisph`` offers, beside what it reads (``tisph.results``): start a run, and check a config."""

from tisph.interface.checking import RunEstimate, check
from tisph.interface.running import run

__all__ = ["RunEstimate", "check", "run"]
