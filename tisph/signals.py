"""The signals that end a run with all its results: Ctrl-C, a termination, and the hang-up of a terminal."""

import signal


def ending_signals() -> list[signal.Signals]:
    """Return them; a hang-up is not among them where this process was started to ignore it (nohup)."""
    hang_up = getattr(signal, "SIGHUP", None)  # Windows has none
    heard = hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN
    return [signal.SIGINT, signal.SIGTERM, *([hang_up] if heard else [])]
