"""Runs of other codes beside ours: what the scripts in ``benchmarks/peers`` measure."""

import json
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from tisph.errors import TisphError


@dataclass(frozen=True)
class PeerRun:
    """One run of a peer: label, flow, code, threads and particles across, the case of ``measure.py`` and its end."""

    label: str
    flow: str
    code: str
    threads: int
    across: int
    case: str
    end: float

    @property
    def words(self) -> list[str]:
        """Options for ``measure.py``."""
        options = {"case": self.case, "code": self.code, "threads": self.threads, "across": self.across}
        return [str(word) for key, value in (options | {"until": self.end}).items() for word in (f"--{key}", value)]


def measure(scripts: Path, folder: Path, number: int, wanted: Iterable[PeerRun]) -> dict[PeerRun, dict[str, Any]]:
    """Return the dictionary that ``measure.py`` in ``scripts`` prints for each of the runs ``wanted``, in one round.

    Files that an earlier call left in ``folder`` are used again unless a script is newer. Raises TisphError where a run
    fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    changed = max(path.stat().st_mtime for path in scripts.iterdir() if path.is_file())
    found = {}
    for run in wanted:
        kept = folder / f"{run.code}_{run.threads}_{run.flow}_{run.across}_round_{number}.json"
        if not kept.is_file() or kept.stat().st_mtime < changed:
            command = [sys.executable, str(scripts / "measure.py"), *run.words]
            with Console(stderr=True).status(kept.stem):
                done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                raise TisphError(f"{' '.join(command)}: {done.stderr.strip()[-500:]}")
            kept.write_text(done.stdout, encoding="utf-8")
        found[run] = json.loads(kept.read_text(encoding="utf-8"))
    return found
