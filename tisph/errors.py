"""Errors that a user sees as one message, with the exit status that each stands for."""

INTERRUPTED = 130
"""Exit status of a process that Ctrl-C ends, as shells report it."""


class TisphError(Exception):
    """A failure with one clear message and no traceback."""

    exit_status = 1


class ConfigError(TisphError):
    """Bad input: the message names file, line, key, value and what is allowed. Nothing was written."""

    exit_status = 2


class UnsolvedError(TisphError, ArithmeticError):
    """A reference could not be solved for: the message says how far it came."""


class DivergedError(TisphError):
    """The run went wrong: the message names field, particle, step and time. Partial results are kept."""

    exit_status = 3
