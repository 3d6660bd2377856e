"""Parts of Taichi 1.7.4 that are replaced by faster ones; a run with them is bitwise the same as one without.

Each file here tells what it replaces, why, and how much that saves. They stay off by themselves with any other version
than the one they were written for, with Quadrants, and with the environment variable ``TISPH_PLAIN_TAICHI=1``, which
changes how long a run takes and nothing else.
"""

import os

from tisph.runtime import _package

VERSION = "1.7.4"
"""Of Taichi, for which they were written."""

SWITCH = "TISPH_PLAIN_TAICHI"


def _reason():
    """Tell why nothing is replaced; None where the replacements are on."""
    if os.environ.get(SWITCH, "0") not in ("", "0"):
        return f"no part of it is replaced, by {SWITCH}"
    if _package.NAME != "taichi" or _package.version() != VERSION:
        return f"no part of it is replaced: what starts sooner was written for taichi {VERSION}; results are the same"
    return None


OFF = _reason()
"""Why nothing is replaced; None where the replacements are on."""


def install():
    """Put all replacements in their places."""
    if OFF:
        return
    from tisph.runtime.replacements import _launches, _loops, _memory, _sources, _translation

    for part in (_launches, _loops, _memory, _sources, _translation):
        part.install()


def begin():
    """Let the replacements begin with the program that was just started."""
    if OFF:
        return
    from tisph.runtime.replacements import _loops, _memory

    _memory.begin()
    _loops.begin()
