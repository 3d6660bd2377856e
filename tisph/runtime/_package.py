"""What is installed: Taichi, or Quadrants, its maintained fork, where there is no Taichi.

The two differ in their names alone: everything that tisph uses has the same name and meaning in both.
"""

import os
from importlib import metadata
from importlib.util import find_spec

from tisph.runtime import _cache  # noqa: F401 (it finds a folder for Taichi, too, before that is imported)

NAME = "taichi" if find_spec("taichi") else "quadrants"

PREFIX = {"taichi": "TI", "quadrants": "QD"}[NAME]
"""Of the environment variables that the package reads."""

os.environ.update(
    {
        f"ENABLE_{NAME.upper()}_HEADER_PRINT": "0",  # no banner
        f"{PREFIX}_ENABLE_TORCH": "0",  # no import of what happens to be installed
        f"{PREFIX}_ENABLE_PADDLE": "0",
        f"{PREFIX}_SKIP_VERSION_CHECK": "ON",  # no request to a server
    }
)

KNOWN = NAME == "taichi" and metadata.version(NAME) == "1.7.4"
"""Whether the package is the one whose inner parts this program knows (``_inner``)."""
