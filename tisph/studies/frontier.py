"""Run time against error, ``tisph bench frontier``: every flow by every method, and by other codes (peers).

Flows, methods, resolutions, peers and bounds are data: ``suites/frontier.yaml``. Runs are separate processes, one at a
time, kept in the folder of the results: an interrupted benchmark continues where it stopped. The time of a run, unlike
its error, depends on the load of the machine. So each run is repeated in every round, interleaved with the others, and
medians of the times are compared.
"""

import json
import math
import os
import platform
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from rich.console import Console

from tisph.errors import TisphError
from tisph.report.style import MUTED, constrained_figure, plot_style
from tisph.studies import suites
from tisph.studies.expressions import Number, merged
from tisph.studies.store import Store
from tisph.text_table import format_header, format_row, format_table
from tisph.version import __version__

DATA = suites.study("frontier")


@dataclass(frozen=True)
class Flow:
    """A flow as ``frontier.yaml`` describes it; ``methods`` and ``quick`` are keys of its ``resolutions``."""

    title: str
    group: str
    config: str
    end: float
    methods: str
    quick: str | None = None
    finest_explicit: float = math.inf
    error: str = "l2"
    target_error: float | None = None
    at_explicit_errors: bool = False
    peers: dict[str, Any] = field(default_factory=dict)
    bounds: list[dict[str, Any]] = field(default_factory=list)
    equal_resolution_method: str | None = None
    quoted: list[dict[str, Any]] = field(default_factory=list)

    def error_of(self, sample: dict[str, Any] | None) -> float:
        """Return the error of a sample; NaN without a sample, or where the sample has no error."""
        return Number(self.error, "error")(None, sample)

    def bound(self, row: "Measured", key: str) -> float | None:
        """Return the bound ``speedup`` or ``accuracy_ratio`` of a peer's row; None without a bound."""
        asked = [
            bound
            for bound in self.bounds
            if row.method.startswith(bound["peer"]) and bound.get("across", row.across) == row.across
        ]
        return asked[0].get(key) if asked and not row.quoted else None


FLOWS = {key: Flow(**flow) for key, flow in DATA["flows"].items()}
GROUPS = tuple(dict.fromkeys(flow.group for flow in FLOWS.values()))
"""Names of the groups of flows; each group has its own picture."""


@dataclass(frozen=True)
class Point:
    """One flow computed by one method: a point of the picture."""

    flow: str
    method: str
    across: int

    @property
    def name(self) -> str:
        """Name of the runs of this point, without the number of the round."""
        method = "".join(letter if letter.isalnum() or letter == "." else "_" for letter in self.method)
        return f"{self.flow}_{method}_{self.across}"

    @property
    def config(self) -> dict[str, Any]:
        """The config of the run, a plain dict."""
        flow, across = FLOWS[self.flow], {"discretisation": {"particles_across": self.across}}
        end = {"time": {"end": flow.end}}
        return merged(DATA["configs"][flow.config], end, DATA["methods"][self.method], across)


def points(group: str, quick: bool) -> list[Point]:
    """Return all points of a group, flow by flow."""
    sets = {key: flow.quick if quick else flow.methods for key, flow in FLOWS.items() if flow.group == group}
    return [
        Point(key, method, across)
        for key, name in sets.items()
        for method, resolutions in DATA["resolutions"].get(name, {}).items()
        for across in resolutions
        if not (method.startswith("explicit") and across > FLOWS[key].finest_explicit)
    ]


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


def peer_runs(group: str, quick: bool = False) -> list[PeerRun]:
    """Return the runs of the peers of a group; ``quick``: only the coarsest runs, of flows in the quick benchmark."""
    return [
        PeerRun(label, key, **DATA["peers"][label], across=across, case=flow.peers["case"], end=flow.peers["end"])
        for key, flow in FLOWS.items()
        if flow.group == group and (flow.quick or not quick)
        for label, resolutions in flow.peers.get("across", {}).items()
        for across in (resolutions[:1] if quick else resolutions)
    ]


@dataclass(frozen=True)
class Measured:
    """Error and seconds of every round of the runs of one flow by one method.

    ``l2``: the L2 error, or the error that the ``Flow`` names; NaN where a run stopped. ``steps``: None if unknown.
    ``loops``: seconds of the time loop; ``processes``: seconds of the whole process, empty if unknown. ``code``: the
    program. ``quoted``: whether the row was measured elsewhere.
    """

    flow: str
    method: str
    across: int
    threads: int
    steps: int | None
    l2: float
    loops: tuple[float, ...]
    processes: tuple[float, ...] = ()
    code: str = "tisph"
    quoted: bool = False

    @property
    def loop(self) -> float:
        """Median loop time [s]."""
        return median(self.loops)

    @property
    def ours(self) -> bool:
        """Whether this program computed the row, and not a peer."""
        return self.code == "tisph"

    @property
    def numbers(self) -> dict[str, Any]:
        """The row as a dictionary for ``frontier.json``, whose keys users rely on."""
        found = asdict(self)
        return {**found, "way": found.pop("method"), "elsewhere": found.pop("quoted"), "loop": self.loop}

    def __str__(self) -> str:
        return f"{self.method}, {self.across} across: {self.l2:.1e} in {self.loop:.3f} s"


def run(folder: Path, quick: bool = False, peers_folder: Path | None = None, group: str = "channel") -> bool:
    """Measure the flows of a group, print the tables, and leave ``frontier.png`` and ``frontier.json`` in ``folder``.

    ``peers_folder``: folder of the peers' scripts; None to measure no peer. Returns False if a peer comes closer than
    its bound allows, else True.
    """
    folder.mkdir(parents=True, exist_ok=True)
    wanted, theirs = points(group, quick), peer_runs(group, quick)
    rounds: dict[Point, list] = {point: [] for point in wanted}
    store = Store(folder / "runs")
    print(f"finished runs are kept in {folder} and used again by the same command\n", flush=True)
    others = []
    for number in range(DATA["rounds"].get(group, 1)):
        for point in wanted:
            rounds[point].append(outcome(store, f"{point.name}_round_{number}", point.config))
        if peers_folder:
            others.append(measure_peers(peers_folder, folder / "peers", number, theirs))
    rows = [*(measured(point, summaries) for point, summaries in rounds.items()), *peer_rows(others, group)]
    return show(folder, rows)


def measure_peers(scripts: Path, folder: Path, number: int, wanted: Iterable[PeerRun]) -> dict[PeerRun, dict[str, Any]]:
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


def outcome(store: Store, name: str, config: dict[str, Any]) -> dict[str, Any]:
    """Return the summary of a run, kept or new. Raises TisphError where it could not even start."""
    with Console(stderr=True).status(name):
        result, message = store.outcome(name, config)
    if "cost" not in result.summary:
        raise TisphError(f"{name}: {message}")
    return result.summary


def measured(point: Point, summaries: list[dict[str, Any]]) -> Measured:
    """Return the row of a point from the summaries of its rounds."""
    costs, samples = [summary["cost"] for summary in summaries], summaries[0]["samples"]
    return Measured(
        flow=point.flow,
        method=point.method,
        across=point.across,
        threads=summaries[0]["provenance"]["threads"],
        steps=costs[0]["steps"],
        l2=FLOWS[point.flow].error_of(samples[-1] if samples else None),
        loops=tuple(cost["wall_loop_s"] for cost in costs),
        processes=tuple(cost["wall_total_s"] for cost in costs),
    )


def peer_rows(rounds: list[dict[PeerRun, dict]], group: str) -> list[Measured]:
    """Return the rows of the peers over all rounds, and the quoted rows of codes that were not measured here.

    A time that is a multiple of another peer's time is quoted only where that peer was measured.
    """
    rows = [
        Measured(
            flow=run.flow,
            method=run.label,
            across=run.across,
            threads=run.threads,
            steps=rounds[0][run]["steps"],
            l2=rounds[0][run]["l2"],
            loops=tuple(one[run]["loop_seconds"] for one in rounds),
            code=run.label.split()[0],
        )
        for run in (rounds[0] if rounds else ())
    ]
    loops, codes = {(row.flow, row.method, row.across): row.loop for row in rows}, {row.code for row in rows}
    for key in (key for key, flow in FLOWS.items() if flow.group == group):
        for numbers in FLOWS[key].quoted:
            quote = dict(numbers)
            label, times, of = quote.pop("method"), quote.pop("times"), quote.pop("of", None)
            unit = loops.get((key, of, quote["across"])) if of else 1.0
            if unit and label.split()[0] not in codes:
                names = {"method": f"{label}, quoted", "code": label.split()[0]}
                rows.append(Measured(flow=key, **names, **quote, loops=(times * unit,), quoted=True))
    return rows


def pareto_front(rows: Iterable[Measured]) -> list[Measured]:
    """Return the ``rows`` (of one flow) that no other row beats in both error and loop time."""
    rows = [row for row in rows if not math.isnan(row.l2)]
    return [row for row in rows if not any(other.l2 <= row.l2 and other.loop < row.loop for other in rows)]


def fastest(rows: Iterable[Measured], error: float, start: str = "") -> Measured | None:
    """Return our row of an L2 of at most ``error`` with the shortest loop; None without such a row.

    Only methods whose names begin with ``start`` count.
    """
    found = [row for row in rows if row.ours and row.l2 <= error and row.method.startswith(start)]
    return min(found, key=lambda row: row.loop, default=None)


@dataclass(frozen=True)
class Comparison:
    """A peer's run, and one of ours beside it; None where no run of ours reaches the peer's error.

    ``ratios`` (name -> the peer's value over ours). ``bound``: the least allowed value of the first ratio, None without
    a bound. ``faster``: whether our run must also be the faster one.
    """

    peer: Measured
    ours: Measured | None
    ratios: dict[str, float]
    bound: float | None
    faster: bool = False

    @property
    def passed(self) -> bool:
        """Whether the bound holds; True without one."""
        first, *_ = self.ratios.values()
        return self.bound is None or (first >= self.bound and not (self.faster and self.ratios["times"] <= 1))

    @property
    def numbers(self) -> dict[str, Any]:
        """The comparison as a dictionary for a file."""
        names = {"flow": self.peer.flow, "peer": self.peer.method, "across": self.peer.across}
        ours = str(self.ours) if self.ours else None
        return {**names, "tisph": ours, **self.ratios, "bound": self.bound, "passed": self.passed}

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of a table. A ratio of loop times is the ratio of the medians, with its range over the rounds."""
        if self.faster:
            ratios, bound = [f"{self.ratios['errors']:.0f}", f"{self.ratios['times']:.3g}"], "error >= {:g}, time > 1"
        else:
            ratios, bound = [f"{self.ratios['ratio']:.0f}"], ">= {:g}"
            if self.ours and len(self.peer.loops) > 1:
                rounds = [theirs / ours for theirs, ours in zip(self.peer.loops, self.ours.loops, strict=True)]
                ratios[0] += f" ({min(rounds):.0f}..{max(rounds):.0f})"
        return (
            self.peer.method,
            str(self.peer.across),
            f"{self.peer.l2:.1e}",
            f"{self.peer.loop:.3g}",
            str(self.ours or "not reached"),
            *ratios,
            *(("-", "-") if self.bound is None else (bound.format(self.bound), "PASS" if self.passed else "FAIL")),
        )


def comparisons(rows: list[Measured]) -> list[Comparison]:
    """Return each peer's row that has an error beside our fastest run whose error is no larger, flow by flow.

    The ratio is of loop times, 0 where no run reaches the error.
    """
    found = []
    for key, flow in FLOWS.items():
        of_flow = [row for row in rows if row.flow == key]
        for peer in (row for row in of_flow if not row.ours and not math.isnan(row.l2)):
            ours = fastest(of_flow, peer.l2)
            ratio = peer.loop / ours.loop if ours else 0.0
            found.append(Comparison(peer, ours, {"ratio": ratio}, flow.bound(peer, "speedup")))
    return found


def equal_resolution(rows: list[Measured]) -> list[Comparison]:
    """Return each peer's row with an error beside our method with as many particles, where that one ran."""
    rows = [row for row in rows if not math.isnan(row.l2)]
    ours = {
        (row.flow, row.across): row
        for row in rows
        if row.ours and row.method == FLOWS[row.flow].equal_resolution_method
    }
    found = []
    for peer in (row for row in rows if not row.ours and (row.flow, row.across) in ours):
        own, asked = ours[peer.flow, peer.across], FLOWS[peer.flow].bound(peer, "accuracy_ratio")
        ratios = {"errors": peer.l2 / own.l2, "times": peer.loop / own.loop}
        found.append(Comparison(peer, own, ratios, asked, faster=True))
    return found


def speedups(rows: list[Measured]) -> list[str]:
    """Return lines: how much faster than the explicit scheme the implicit one reaches the target error of each flow."""
    lines = []
    for key, flow in FLOWS.items():
        of_flow = [row for row in rows if row.flow == key]
        errors = [row.l2 for row in of_flow if flow.at_explicit_errors and row.method == "explicit"]
        for error in errors if flow.target_error is None else [flow.target_error]:
            explicit, implicit = fastest(of_flow, error, "explicit"), fastest(of_flow, error, "implicit")
            if explicit and implicit:
                lines.append(
                    f"{flow.title}, {'error' if flow.at_explicit_errors else 'L2'} <= {error:.2g}: {implicit} is "
                    f"{explicit.loop / implicit.loop:.3g} times faster than {explicit}"
                )
    return lines


def comparison_table(found: list[Comparison]) -> str:
    """Return Markdown of comparisons: a table for each flow, under its title."""
    header = ("peer", "across", "its L2", "its time [s]", "tisph to the same or smaller L2", "ratio", "bound", "")
    tables = {key: [one.cells for one in found if one.peer.flow == key] for key in FLOWS}
    return "\n\n".join(f"{FLOWS[key].title}:\n\n{format_table(header, rows)}" for key, rows in tables.items() if rows)


def equal_resolution_table(found: list[Comparison]) -> str:
    """Return Markdown of comparisons at equal resolution."""
    names = ("peer", "across", "its L2", "its time [s]", "tisph with as many particles", "error", "time", "bound", "")
    title = "At an equal number of particles, ratios of the peer's error and time to ours"
    return f"{title}:\n\n{format_table(names, [one.cells for one in found])}"


HEADER = ("flow", "method", "across", "threads", "steps", "error", "loop [s]", "process [s]", "front")
WIDTHS = (25, 6, 7, 5, 7, 26, 23, 5)


def show(folder: Path, rows: list[Measured]) -> bool:
    """Print the tables of ``rows``, write picture and numbers into ``folder``; False if a bound is missed."""
    fronts = {flow: pareto_front(row for row in rows if row.flow == flow and row.ours) for flow in FLOWS}
    _print_points(rows, fronts)
    found, same = comparisons(rows), equal_resolution(rows)
    print("", *speedups(rows), "", comparison_table(found), sep="\n")
    if same:
        print("", equal_resolution_table(same), sep="\n")
    place = machine()
    numbers = {
        "machine": place,
        "points": [row.numbers for row in rows],
        "comparisons": [one.numbers for one in found],
        "equal_number": [one.numbers for one in same],
    }
    (folder / "frontier.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    with plot_style():
        figure_of(rows, fronts).savefig(folder / "frontier.png")
    print(f"\n{place['processor']}, {place['cores']} cores, {place['platform']}")
    print(f"picture: {folder / 'frontier.png'}; numbers: {folder / 'frontier.json'}")
    return all(one.passed for one in (*found, *same))


def _print_points(rows: list[Measured], fronts: dict[str, list[Measured]]) -> None:
    def median_and_range(seconds: tuple[float, ...]) -> str:
        text = f"{median(seconds):.3f}"
        return f"{text} ({min(seconds):.3f}..{max(seconds):.3f})" if len(seconds) > 1 else text

    rounds = max(len(row.loops) for row in rows)
    print(f"{rounds} interleaved rounds, median (smallest..largest)\n" if rounds > 1 else "one round\n")
    widths = (max(len(FLOWS[row.flow].title) for row in rows), *WIDTHS)
    print(format_header(HEADER, widths))
    for row in rows:
        cells = (
            FLOWS[row.flow].title,
            row.method,
            str(row.across),
            str(row.threads),
            "" if row.steps is None else str(row.steps),
            f"{row.l2:.1e}",
            "quoted " * row.quoted + median_and_range(row.loops),
            median_and_range(row.processes) if row.processes else "",
            "*" if row in fronts[row.flow] else "",
        )
        print(format_row(cells, widths))


CPUINFO = Path("/proc/cpuinfo")
"""File in which Linux names the processor; elsewhere Python knows it."""


def machine() -> dict[str, Any]:
    """Return ``processor``, ``cores``, ``platform``, and ``version`` of this program."""
    lines = CPUINFO.read_text(encoding="utf-8").splitlines() if CPUINFO.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": names[0] if names else platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "platform": platform.platform(),
        "version": __version__,
    }


# Okabe and Ito's colours, which colour-blind people can distinguish; the marks distinguish the methods without colour.
FAMILIES = {
    "explicit": ("#0072b2", "os<^"),
    "implicit": ("#d55e00", "v>DpP"),
    "LAMMPS": ("#009e73", "X"),
    "PySPH TVF": ("#cc79a7", "*d"),
    "PySPH EDAC": ("#56b4e9", "hX"),
    "": ("#000000", "s^o"),
}
"""Start of a method's name -> colour and marks; the first start that fits counts."""

OURS, PEERS, QUOTED = "tisph", "peers, same machine", "quoted, measured elsewhere"
LEGENDS: dict[str, Any] = {OURS: "outside lower left", PEERS: "outside lower center", QUOTED: "outside lower right"}
"""Title of the legend of each kind of methods -> its place."""


def figure_of(rows: list[Measured], fronts: dict[str, list[Measured]]) -> Figure:
    """Return the picture: one panel a flow, both axes logarithmic, the Pareto front of each flow as a line."""
    flows = [flow for flow in FLOWS if any(row.flow == flow for row in rows)]
    styles = styles_of(rows)
    figure = constrained_figure((max(3.7 * len(flows), 10.0), 6.2), dpi=130)
    panels = figure.subplots(1, len(flows), squeeze=False)[0]
    for panel, flow in zip(panels, flows, strict=True):
        line = sorted(fronts[flow], key=lambda row: row.loop)
        panel.plot([row.loop for row in line], [row.l2 for row in line], color=MUTED, linewidth=3, alpha=0.4, zorder=0)
        for method in dict.fromkeys(row.method for row in rows if row.flow == flow):
            own = sorted((row for row in rows if (row.flow, row.method) == (flow, method)), key=lambda row: row.across)
            panel.plot([row.loop for row in own], [row.l2 for row in own], **styles[method][1])
        panel.set(xscale="log", yscale="log", title=FLOWS[flow].title, xlabel="time loop [s]")
        panel.grid(True, which="major")
    panels[0].set_ylabel("L2 error of the velocity" if FLOWS[flows[0]].error == "l2" else "relative error")
    for title, place in LEGENDS.items():
        handles = [Line2D([], [], label=name, **options) for name, (kind, options) in styles.items() if kind == title]
        if title == OURS:
            handles.append(Line2D([], [], color=MUTED, linewidth=3, alpha=0.4, label="front"))
        if handles:
            columns = 2 if len(handles) > 5 else 1
            figure.legend(handles=handles, title=title, loc=place, ncols=columns, fontsize=9, frameon=False)
    return figure


def styles_of(rows: list[Measured]) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return method -> (title of the legend, options of a matplotlib line), for every method in ``rows``.

    Thin lines join the points, which are large for a peer and hollow if measured elsewhere.
    """
    styles: dict[str, tuple[str, dict[str, Any]]] = {}
    for row in rows:
        colour, marks = next(style for start, style in FAMILIES.items() if row.method.startswith(start))
        kind = OURS if row.ours else QUOTED if row.quoted else PEERS
        before = sum(options["color"] == colour for _, options in styles.values())
        options = {
            "color": colour,
            "marker": marks[before % len(marks)],
            "markersize": 7 if row.ours else 11,
            "markerfacecolor": "none" if row.quoted else colour,
            "markeredgecolor": colour if row.quoted else "white",
            "markeredgewidth": 1.4 if row.quoted else 0.6,
            "linewidth": 0.6,
        }
        styles.setdefault(row.method, (kind, options))
    return styles
