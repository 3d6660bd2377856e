"""What is installed: Taichi, or Quadrants, its maintained fork, where there is no Taichi.

The two differ in their names alone: everything that tisph uses has the same name and meaning in both.
"""

import importlib
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

ti = importlib.import_module(NAME)  # it reads the environment


def version():
    """Return the version of the package that is installed."""
    return metadata.version(NAME)


def kernel_class():
    """Return the class of kernels, and the name of its dictionary of those that have been translated."""
    if NAME == "taichi":
        return importlib.import_module("taichi.lang.kernel_impl").Kernel, "compiled_kernels"
    return importlib.import_module("quadrants.lang.kernel").Kernel, "materialized_kernels"
