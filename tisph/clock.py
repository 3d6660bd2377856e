"""When the process began."""

import time

PROCESS_START = time.perf_counter()
"""When the process began, or rather the package was imported: the cost of start-up counts from here."""
