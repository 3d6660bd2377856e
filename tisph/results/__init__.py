"""The results of a run, each read when it is first used. Reading starts and writes nothing."""

from tisph.results._results import Results, open_run

__all__ = ["Results", "open_run"]
