"""How busy other programs kept the machine while one was measured.

A throughput from a shared machine cannot be trusted without it: PySPH's threads, which wait for each other at
every loop, lose up to a factor of 40 to a busy neighbour, and a peer that is slowed flatters tisph.
"""

import os
import time
from pathlib import Path

STATISTICS = Path("/proc/stat")
"""Linux' processor times since the start of the system; elsewhere the load stays unknown."""

IDLE_COLUMNS = (3, 4)
"""Idle, and waiting for a disk."""

GUEST_COLUMN = 8
"""From here on times are listed twice: they are part of the user's."""


class OtherLoad:
    """Context manager whose ``cores`` is then the mean number of cores busy with other programs.

    None where it cannot be known. The programs measured must have ended within the context.
    """

    cores: float | None = None

    def __enter__(self):
        self._start = _seconds()
        return self

    def __exit__(self, *error):
        if STATISTICS.exists():
            elapsed, busy, own = (after - before for before, after in zip(self._start, _seconds(), strict=True))
            self.cores = max(0.0, (busy - own) / elapsed)


def _seconds():
    """Clock, busy time of all cores, and processor time of this program with those it started [s]."""
    busy = 0.0
    if STATISTICS.exists():
        columns = STATISTICS.read_text(encoding="ascii").splitlines()[0].split()[1:]
        ticks = sum(int(columns[index]) for index in range(GUEST_COLUMN) if index not in IDLE_COLUMNS)
        busy = ticks / os.sysconf("SC_CLK_TCK")
    return time.perf_counter(), busy, sum(os.times()[:4])
