"""What happens to a run when Ctrl-C or another signal that ends it comes."""

import signal
import sys
from contextlib import contextmanager

from tisph.signals import ending_signals


@contextmanager
def interrupts_to(job):
    """Let any of the ``ending_signals`` end the run after its step, with all results; a second one stops it at once.

    Where there is a state to go on from, that is after the step, the checkpoint and the summary.
    """

    def handle(number, frame):
        job.interrupts += 1
        if job.interrupts > 1 and not job.unsaved:
            raise KeyboardInterrupt

    def unraisable(failure):
        if failure.exc_type is not KeyboardInterrupt:  # where Python cannot raise it, it was counted at least
            report(failure)

    report = sys.unraisablehook
    try:
        previous = {number: signal.signal(number, handle) for number in ending_signals()}
    except ValueError:  # not in the main thread: the caller decides
        yield
        return
    sys.unraisablehook = unraisable
    try:
        yield
    finally:
        sys.unraisablehook = report
        for number, handler in previous.items():
            signal.signal(number, handler)
