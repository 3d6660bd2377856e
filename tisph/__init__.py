"""tisph: a Taichi particle simulator (SPH) for laminar, wall-bounded flow."""

import time

__version__ = "0.1.0"

PROCESS_START = time.perf_counter()
"""When the package was imported: the cost of start-up counts from here."""
