"""The version of the package, as in ``pyproject.toml``, and the time at which this process has imported it."""

import time

__version__ = "1.0.0"

PROCESS_START = time.perf_counter()
"""Time at which the package was imported, by ``time.perf_counter`` [s]: the cost of start-up counts from here."""
