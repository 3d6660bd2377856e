"""What happens to a run when Ctrl-C or another signal that ends it comes."""

import signal
import sys
import threading
from contextlib import contextmanager

from tisph.signals import ending_signals


class Interrupts:
    """Their ``count``; with ``wait`` there is a state to go on from which is not written yet."""

    def __init__(self, wait=False):
        self.count, self.wait = 0, wait

    @contextmanager
    def counted(self):
        """Let any of the ``ending_signals`` be counted, for a run that ends after its step; a second one stops it.

        Where there is a state to go on from, that is after the step, the checkpoint and the summary.
        """

        def handle(number, frame):
            self.count += 1
            if self.count > 1 and not self.wait:
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


@contextmanager
def interrupts_after():
    """Let Ctrl-C, which may come at any time in a notebook, take effect after what is done inside."""
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler) or threading.current_thread() is not threading.main_thread():
        yield
        return
    heard = []
    signal.signal(signal.SIGINT, lambda number, frame: heard.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    for each in heard:
        handler(*each)
