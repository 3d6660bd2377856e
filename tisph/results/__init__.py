"""What a run left behind, read when it is asked for. Starts nothing and writes nothing."""

from tisph.results._results import Results, open_run

__all__ = ["Results", "open_run"]
