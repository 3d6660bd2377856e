"""Scaling: what a particle and a step of the implicit scheme cost, and how many iterations, from 2500 to a million.

Every case is a process of its own. ``iterations`` are those of the pressure where the flow turns, else those of all
linear systems of a step.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from tisph.errors import TisphError
from tisph.study.bench import machine
from tisph.verification.table import format_header, format_row

SECONDS = {"vortex": {False: 4.0, True: 1.0}, "channel": {False: 600.0, True: 600.0}}
"""Seconds of steps in every process, by flow and by whether the benchmark is a quick one: channels run to their end,
since their steps become longer on the way."""

VORTEX = """\
scene: taylor_green
fluid: {{density: 1.0, kinematic_viscosity: 0.01}}
geometry: {{length: 1.0}}
initial: {{velocity: 1.0, jitter: 0.2}}
discretisation: {{particles_across: {across}}}
time: {{end: 2.0}}
runtime: {{threads: {threads}}}
"""

CHANNEL = """\
scene: channel
fluid: {{density: 1000.0, dynamic_viscosity: 1.0e-3}}
geometry: {{gap: 0.01, length: 0.02}}
walls: {{bottom: {{velocity: 0.0}}, top: {{velocity: 0.005}}}}
initial: {{jitter: 0.2}}
discretisation: {{particles_across: {across}}}
time: {{end: 2.7}}
runtime: {{threads: {threads}}}
"""

ITERATIONS, COST, ASSEMBLIES, CHANNEL_COST, BYTES, STATED = 1.5, 1.5, 4.0, 1.2, 3500.0, 0.2
"""Bounds: growth of the iterations for the pressure and of the cost of a particle, a step over the assembly of its
rows, growth of the cost in the channel, bytes a particle, and how far ``tisph check`` may be off them."""

HEADER = ("flow", "particles", "threads", "step [us]", "assembly [us]", "step/assembly", "iterations", "memory [MB]")


class Case(NamedTuple):
    """A flow, particles across it, and threads; ``text`` is its config without these two."""

    flow: str
    across: int
    threads: int

    @property
    def text(self):
        """The config."""
        template = {"vortex": VORTEX, "channel": CHANNEL}[self.flow]
        return template.format(across=self.across, threads=self.threads)


def cases(quick):
    """Return the cases, the smallest of each flow first."""
    vortex = [(50, 1), (100, 1)] if quick else [(50, 1), (100, 1), (316, 1), (100, 2), (316, 2), (1000, 2)]
    channel = [(50, 1), (100, 1)] if quick else [(50, 1), (100, 1), (200, 1)]
    return [Case("vortex", *size) for size in vortex] + [Case("channel", *size) for size in channel]


def run(folder, quick=False):
    """Print a line for each case and the bounds; leave ``scaling.json`` in ``folder``; return whether all are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    widths = [max(7, len(name)) for name in HEADER]
    print(format_header(HEADER, widths), flush=True)
    rows = {}
    with tempfile.TemporaryDirectory() as scratch:
        for case in cases(quick):
            rows[case] = measured(case, Path(scratch), SECONDS[case.flow][quick])
            print(format_row(cells(case, rows[case]), widths), flush=True)
    content = {"machine": machine.describe(), "cases": [{**case._asdict(), **row} for case, row in rows.items()]}
    (folder / "scaling.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    print(f"\nnumbers: {folder / 'scaling.json'}")
    return kept(rows)


def measured(case, scratch, seconds):
    """Return what the process of a case has found."""
    path = scratch / "case.yaml"
    path.write_text(case.text, encoding="utf-8")
    command = [sys.executable, "-m", "tisph.study.bench._scaling_process", path, str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise TisphError(f"{case}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def cells(case, row):
    """Return the cells of the line of a case."""
    ratio = row["step_us"] / row["assembly_us"]
    costs = f"{row['step_us']:.2f}", f"{row['assembly_us']:.2f}", f"{ratio:.2f}", f"{row['iterations']:.2f}"
    return (case.flow, str(row["particles"]), str(case.threads), *costs, f"{row['peak_mb']:.0f}")


def kept(rows):
    """Print the bounds; return whether they are kept. ``rows``: what was found by case."""
    checks = []
    vortex = {case: row for case, row in rows.items() if case.flow == "vortex"}
    first, *others = [row["iterations"] for row in vortex.values()]
    checks.append(("iterations for the pressure, most over those of 2500", max(others) / first, ITERATIONS))
    threads = max(case.threads for case in vortex)
    small, *_, large = [row for case, row in vortex.items() if case.threads == threads]
    growth = large["step_us"] / small["step_us"]
    checks.append((f"cost of a particle, {large['particles']} over {small['particles']}", growth, COST))
    for case, row in vortex.items():
        if case.across in (100, 316):
            what = f"a step over its assembly, {row['particles']} particles, {case.threads} threads"
            checks.append((what, row["step_us"] / row["assembly_us"], ASSEMBLIES))
    first, *_, last = [row for case, row in rows.items() if case.flow == "channel"]
    growth = last["step_us"] / first["step_us"]
    checks.append((f"channel, cost of a particle, {last['particles']} over {first['particles']}", growth, CHANNEL_COST))
    if large["particles"] > 10 * small["particles"]:  # or rungs of the ladder of sizes are all that is seen
        checks += _memory(small, large)
    for what, value, bound in checks:
        print(f"{'PASS' if value <= bound else 'FAIL'}: {what}: {value:.3g} (<= {bound:g})")
    return all(value <= bound for _, value, bound in checks)


def _memory(small, large):
    """Bytes of a particle by the growth of the process, and how far ``tisph check`` is off that growth."""
    more = large["particles"] - small["particles"]
    grown, stated = ((large[key] - small[key]) * 1e6 / more for key in ("peak_mb", "estimated_mb"))
    yield "bytes a particle, by the growth of the process", grown, BYTES
    yield "what tisph check states of it, off by", abs(stated / grown - 1), STATED
