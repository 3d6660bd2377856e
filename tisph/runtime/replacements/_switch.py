"""Whether parts of Taichi are replaced."""

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
