"""The peers' points of the frontier: measured by the scripts in ``benchmarks/peers``, or quoted.

Codes that the package index does not have are quoted from measurements of the same case on another machine of two
cores, as multiples of what LAMMPS took with two processes (docs/evidence/performance.md). pySPlisHSPlasH (2.19.0) is
in the index, but knows no periodic boundary, so that it cannot run the case. Of the vortex there are quoted seconds for
all peers, which stand where a code was not measured.
"""

import json
import subprocess
import sys
from dataclasses import dataclass

from rich.console import Console

from tisph.errors import TisphError
from tisph.studies.frontier.cases import BENCHMARKS
from tisph.studies.frontier.pareto import Measured


@dataclass(frozen=True)
class PeerRun:
    """One run of a peer: its label, what ``measure.py`` calls it, threads, flow, and particles across."""

    label: str
    code: str
    threads: int
    flow: str
    across: int

    @property
    def words(self):
        """Options for ``measure.py``."""
        case, end = CASES[self.flow]
        options = {"case": case, "code": self.code, "threads": self.threads, "across": self.across, "until": end}
        return [str(word) for key, value in options.items() for word in (f"--{key}", value)]


CASES = {
    "couette_2.7": ("couette", 2.7),
    "couette_20": ("couette", 20.0),
    "taylor_green_2": ("taylor_green", 2.0),
    "cavity_10": ("cavity", 10.0),
    "cylinder": ("cylinder", 12.5),
}
"""What ``measure.py`` calls the case of a flow, and its end."""

LAMMPS = ("LAMMPS SPH, 2 processes", "lammps", 2)
TVF_SERIAL = ("PySPH TVF, 1 thread", "pysph", 1)
TVF = ("PySPH TVF, 2 threads", "pysph", 2)
EDAC = ("PySPH EDAC, 2 threads", "pysph-edac", 2)
EDAC_SERIAL = ("PySPH EDAC, 1 thread", "pysph-edac", 1)

SCALE = PeerRun(*LAMMPS, "couette_20", 50)
"""The run that quoted times are multiples of."""

RUNS = (
    *(PeerRun(*LAMMPS, "couette_2.7", across) for across in (25, 50, 100)),
    *(PeerRun(*peer, "couette_2.7", across) for peer in (TVF_SERIAL, TVF, EDAC) for across in (25, 50)),
    SCALE,
    PeerRun(*TVF, "couette_20", 25),
    *(PeerRun(*peer, "taylor_green_2", across) for peer in (TVF_SERIAL, EDAC_SERIAL) for across in (25, 50)),
    *(PeerRun(*peer, "cavity_10", across) for peer in (TVF_SERIAL, EDAC_SERIAL) for across in (25, 50)),
    *(PeerRun(*TVF_SERIAL, "cylinder", across) for across in (24, 48)),
)
"""A round of a group takes two to four minutes on two quiet cores; PySPH at 50 across to t = 20 would double that."""

QUICK_RUNS = tuple(run for run in RUNS if run.flow != "couette_20" and run.across in (24, 25))

QUOTED = {
    "SPHinXsys": (0.57, 2.3e-3, 7038),
    "DualSPHysics mDBC": (5.3, 4.1e-3, 17738),
    "JAX-SPH": (52.0, 3.0e-4, 22000),
}
"""Loop time over that of ``SCALE``, L2, and steps, by label."""

QUOTED_VORTICES = (
    ("JAX-SPH TVF", 25, 23.0, 0.252),
    ("PySPH TVF", 25, 16.0, 0.238),
    ("PySPH TVF", 50, 74.0, 0.122),
    ("PySPH EDAC", 25, 18.0, 0.0333),
    ("PySPH EDAC", 50, 91.0, 0.0219),
)
"""Label, particles across, seconds of the processor (of the whole process for JAX-SPH) and L2 at t = 2 that were
measured of the vortex once, on one thread of another busy machine; times good to a fifth. Not scaled."""


def runs(group, quick=False):
    """Return the runs of a group's flows."""
    return [run for run in (QUICK_RUNS if quick else RUNS) if BENCHMARKS[run.flow].group == group]


def measure(scripts, folder, number, wanted):
    """One round of the runs ``wanted``: the dictionary that ``measure.py`` in ``scripts`` printed, by ``PeerRun``.

    What an earlier call left in ``folder`` is used again unless a script is newer. Raises TisphError where one fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    changed = max(path.stat().st_mtime for path in scripts.iterdir() if path.is_file())
    found = {}
    for run in wanted:
        kept = folder / f"{run.code}_{run.threads}_{run.flow}_{run.across}_round_{number}.json"
        if not kept.is_file() or kept.stat().st_mtime < changed:
            with Console(stderr=True).status(kept.stem):
                kept.write_text(_call([sys.executable, scripts / "measure.py", *run.words]), encoding="utf-8")
        found[run] = json.loads(kept.read_text(encoding="utf-8"))
    return found


def _call(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise TisphError(f"{' '.join(map(str, command))}: {done.stderr.strip()[-500:]}")
    return done.stdout


def merged(rounds, group):
    """``Measured`` of every peer over all rounds, and the quoted ones that a group has beside them."""
    rows = {}
    for run in rounds[0] if rounds else ():
        ones = [one[run] for one in rounds]
        rows[run] = Measured(
            flow=run.flow,
            method=run.label,
            across=run.across,
            threads=run.threads,
            steps=ones[0]["steps"],
            l2=ones[0]["l2"],
            loops=tuple(one["loop_seconds"] for one in ones),
            code=run.label.split()[0],
        )
    measured = list(rows.values())
    if group == "taylor_green":
        return [*measured, *quoted_vortices({row.code for row in measured})]
    return [*measured, *(quoted(rows[SCALE]) if SCALE in rows else ())]


def quoted_vortices(codes):
    """``Measured`` of the vortex as quoted, of codes that are not among ``codes``, those measured here."""
    rows = [
        _quoted(label, flow="taylor_green_2", across=across, threads=1, steps=None, l2=l2, loops=(seconds,))
        for label, across, seconds, l2 in QUOTED_VORTICES
    ]
    return [row for row in rows if row.code not in codes]


def quoted(scale):
    """``Measured`` of the codes that were measured elsewhere, from that of the run ``SCALE``."""
    case = {"flow": SCALE.flow, "across": SCALE.across, "threads": SCALE.threads}
    return [
        _quoted(label, **case, steps=steps, l2=l2, loops=(factor * scale.loop,))
        for label, (factor, l2, steps) in QUOTED.items()
    ]


def _quoted(label, **numbers):
    return Measured(method=f"{label}, quoted", code=label.split()[0], quoted=True, **numbers)
