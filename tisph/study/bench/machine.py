"""What a benchmark ran on: without that its times say nothing."""

import os
import platform
from pathlib import Path

import tisph

CPUINFO = Path("/proc/cpuinfo")
"""Where Linux tells the name of the processor; elsewhere Python knows it."""


def describe():
    """``processor``, ``cores``, ``platform``, and ``version`` of this program, as a dictionary."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "platform": platform.platform(),
        "version": tisph.__version__,
    }


def _processor():
    lines = CPUINFO.read_text(encoding="utf-8").splitlines() if CPUINFO.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
