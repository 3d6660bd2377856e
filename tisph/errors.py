"""Errors that a user sees as one message, each with an exit status, and the signals that end a run."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from signal import Signals

INTERRUPTED = 130
"""Exit status of a process that Ctrl-C ends, as shells report it."""


class TisphError(Exception):
    """A failure with one clear message and no traceback."""

    exit_status = 1


class ConfigError(TisphError):
    """Bad input; nothing was written. The message names file, line, key, value and the allowed values."""

    exit_status = 2


UNREACHED = "a goal is not reached: "
"""Beginning of the message of an ``UnreachedError``."""


class UnreachedError(TisphError):
    """No run has an error inside its goal; the message names the number and the reason. The best run is kept."""


DOUBTFUL = "the fit is doubtful: "
"""Beginning of the message of a ``DoubtfulError``."""


class DoubtfulError(TisphError):
    """A fit is a misfit, or the data do not determine a key; the message says which. All results are written."""


class UnsolvedError(TisphError, ArithmeticError):
    """The solution for a reference failed; the message names the time up to which there is one."""


class DivergedError(TisphError):
    """The run failed; partial results are kept. The message names field, particle, step and time."""

    exit_status = 3


def ending_signals() -> "list[Signals]":
    """Return the signals that end a run with all its results: Ctrl-C, a termination, and the hang-up of a terminal.

    A hang-up is left out where this process was started to ignore it (nohup).
    """
    import signal  # it takes milliseconds, during which an interrupt would end in a traceback

    signals = [signal.SIGINT, signal.SIGTERM]
    hang_up = getattr(signal, "SIGHUP", None)  # Windows has none
    if hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN:
        signals.append(hang_up)
    return signals
