"""The error of a snapshot against the exact solution, in the words of the pictures."""

from tisph.report.labels import scientific
from tisph.snapshot import Snapshot
from tisph.verification.metrics import relative_error


def error_label(channel, snapshot: Snapshot) -> str:
    """Return the error in words, for example ``L2 error 1.5×10⁻³``."""
    error = relative_error(channel, snapshot)
    return "L2 error: none yet" if error is None else f"L2 error {scientific(error)}"
