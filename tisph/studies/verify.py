"""``tisph verify``: run suites and print a line for each check; or run the verification page's case.

Each run is a fresh process, one at a time, so that no run can affect another.

``tisph verify --page`` runs the case VM-LSDYNA-SPH-001, "2D Laminar Couette Flow Simulation (SPH)". The page gives
fitted slopes of 0.49 and 0.48 1/s at 1.8 and 2.7 s, errors of 2 % and 4 % against the steady slope U/H = 0.5 1/s that
it calls reached. Its numbers fit no single flow: water's viscosity is printed as ten times itself, Re = 100 belongs to
neither value, and from rest the steady state is far away at 2.7 s. So each reading of the page is run, and compared
with the exact solution of that reading.
"""

import json
import math
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.studies import suites
from tisph.studies.checks import Check, Criterion, of_references
from tisph.studies.processes import Result, run_config, run_resumed
from tisph.studies.store import Store, claimed
from tisph.studies.suites import Suite
from tisph.text_table import format_header, format_row, format_table

HEADER = ("case", "quantity", "value", "bound", "verdict")

BARS = "bars"
"""The study of error bars, in ``bars.py``; it does not run with the others."""

COMPARISONS = "comparisons"
"""The study of the verdicts of ``tisph compare``, in ``comparisons.py``; it does not run with the others."""

MANUFACTURED = "manufactured"
"""The suite whose runs are built in Python; it needs sympy, and does not run with the others."""

REFERENCES = "references"
"""The suite without runs: each value of the table of references beside the others of the same number."""


def run(
    name: str | None = None, quick: bool = False, long: bool = False, out: Path | None = None, as_json: bool = False
) -> bool:
    """Print the table of a suite, one of ours by ``name`` or a file; without a name, of all of ours but manufactured.

    With ``out``, a folder, finished runs stay there and are not run again. ``as_json``: print one JSON document of all
    checks in place of the table. Returns True if every check passed. Raises ConfigError where there is no such suite,
    it has a mistake, or the folder cannot be used.
    """
    if name == BARS:
        from tisph.studies import bars

        return bars.run(out, as_json)
    if name == COMPARISONS:
        from tisph.studies import comparisons

        return comparisons.run(out, as_json)
    suite = suite_of(name, quick, long)
    with ExitStack() as stack:
        if out:
            stack.enter_context(claimed(Path(out), "another verification is writing there"))
        folder = Path(out or stack.enter_context(tempfile.TemporaryDirectory(prefix="tisph-verify-")))
        runner = Runner(suite, folder)
        if as_json:
            return _print_json(runner)
        checks = _print_table(runner)
    return _conclude([(f"{each.case} {each.quantity}", each.passed) for each in checks], "rows passed")


def suite_of(name: str | None, quick: bool = False, long: bool = False) -> Suite:
    """Return a ``Suite`` by name, or by file; all of ours without a name. Raises ConfigError where there is none."""
    if name is None:
        return suites.whole(quick)
    if name == MANUFACTURED and not long:
        from tisph.studies import manufactured

        return Suite("Manufactured solutions", manufactured.runs(quick), manufactured.criteria(quick))
    if name == REFERENCES and not long:
        return Suite("References", {}, list(of_references()))
    if name in suites.PARTS:
        return suites.ours(name, quick, long)
    if Path(name).suffix in (".yaml", ".yml"):
        return suites.read(Path(name), quick, long)
    names = (*suites.PARTS, MANUFACTURED, REFERENCES, BARS, COMPARISONS)
    if name in names:
        raise ConfigError(f"--long: {name} has no long section")
    raise ConfigError(
        f"no suite {name!r}{nearest(name, names)}; there are {', '.join(names)}, and files that end in .yaml"
    )


class Runner:
    """Runs the configs of a ``suite`` when their results are first asked for, and stores the results.

    A run is a config as a plain dict, or a function that runs it in this process and returns ``Result`` and message.
    Runs are kept in subfolders of ``folder``; runs that an earlier command finished are read from there, except resumed
    ones. ``failures`` (name of the run -> message): runs that stopped early, and numbers that samples do not have.
    """

    def __init__(self, suite: Suite, folder: Path):
        self.suite = suite
        self.failures: dict[str, str] = {}
        self.store = Store(folder)
        self._results: dict[str, Result] = {}

    def result(self, name: str) -> Result:
        """Return the ``Result`` of a run. If it stopped early, ``failures[name]`` has its message."""
        if name not in self._results:
            config = self.suite.runs[name]
            self._results[name], message = config() if callable(config) else self.outcome(name, config)
            if message:
                self.failures[name] = f"did not finish: {message}"
        return self._results[name]

    def outcome(self, name: str, config: dict[str, Any]) -> tuple[Result, str]:
        """Return ``Result`` and message of a run, new or kept."""
        if name in self.suite.resumed:
            return run_resumed(self.store.write(name, config), self.store.folder / name)
        if name in self.suite.estimated:
            return run_config(self.store.write(name, config), self.store.folder / name, estimated=True)
        return self.store.outcome(name, config)

    def checks(self) -> Iterator[Check]:
        """Yield the ``Check`` of each criterion as soon as its runs are done; print the progress on standard error."""
        console = Console(stderr=True)
        for criterion in self.suite.criteria:
            done = f"{len(self._results)} of {len(self.suite.runs)} runs are done"
            with console.status(f"running {' and '.join(criterion.runs)}; {done}"):
                check = self.judge(criterion)
            yield check

    def judge(self, criterion: Criterion) -> Check:
        """Return the ``Check`` of a criterion, after running its runs."""
        results = [self.result(name) for name in criterion.runs]
        try:
            return criterion.judge(*results)
        except ConfigError as error:
            self.failures[criterion.runs[0]] = str(error)
            return Check(criterion.case, criterion.quantity, math.nan, criterion.bound, passed=False)


def _print_table(runner: Runner) -> list[Check]:
    """Print a line as soon as its runs are done; return the checks."""
    criteria = runner.suite.criteria
    labels = [(criterion.case, criterion.quantity, "1.23e-06", criterion.bound, "pass") for criterion in criteria]
    widths = [max(map(len, column)) for column in zip(HEADER, *labels, strict=True)]
    if runner.suite.title:
        print(f"{runner.suite.title}\n")
    print(format_header(HEADER, widths))
    checks = []
    for check in runner.checks():
        verdict = "pass" if check.passed else "FAIL"
        print(format_row((check.case, check.quantity, f"{check.value:.3g}", check.bound, verdict), widths), flush=True)
        checks.append(check)
    for name, message in runner.failures.items():
        print(f"{name}: {message}")
    return checks


def _print_json(runner: Runner) -> bool:
    """Print one JSON document of all checks; return True if all passed."""
    checks = list(runner.checks())
    rows = [{**asdict(check), "value": check.value if math.isfinite(check.value) else None} for check in checks]
    passed = all(check.passed for check in checks)
    title = runner.suite.title
    print(json.dumps({"title": title, "passed": passed, "checks": rows, "failures": runner.failures}, indent=2))
    return passed


def _conclude(rows: Iterable[tuple[str, bool]], words: str) -> bool:
    """Print how many of ``rows`` (name, whether it passed) passed, and the names of the others; True if all did."""
    rows = list(rows)
    failed = [name for name, passed in rows if not passed]
    print(f"\n{len(rows) - len(failed)} of {len(rows)} {words}{'; FAIL: ' if failed else ''}{', '.join(failed)}")
    return not failed


READINGS = {
    "re50": "water, from rest",
    "re5": "viscosity as typed, from rest",
    "developed": "water, from the linear profile",
    "steady": "water, from rest to t* = 1",
    "re100": "Re as printed, from rest",
    "as_printed": "water, linear profile, bulk modulus as printed",
}
"""Readings of the page, each a config ``configs/vm_sph_001_NAME.yaml``."""

COSTS = {
    "steady": " (110 000 steps: a minute or two)",
    "as_printed": " (660 000 steps of 4 microseconds: about six minutes)",
}
"""Why a reading takes long."""

TARGET_SLOPE = 0.5
"""Steady slope U/H [1/s], the page's target."""

PAGE_SLOPES = {1.8: "0.49 (2 %)", 2.7: "0.48 (4 %)"}
"""Slopes on the page [1/s] and their errors against its target, by output time [s]."""

PAGE_HEADER = (
    "reading",
    "Re",
    "Mach",
    "t [s]",
    "t*",
    "page: slope (error)",
    "slope",
    "exact slope",
    "off exact",
    "off 0.5",
    "intercept [cm/s]",
    "L2",
    "centreline (exact) [cm/s]",
    "bottom shear (exact) [Pa]",
    "top shear (exact) [Pa]",
    "density off",
)

PASCAL = 100.0
"""1 kg/(cm s^2), the unit of stress in the page's system of units, in Pa."""


def run_page() -> bool:
    """Print the table of all readings of the page; return True if every one reached its end.

    Raises ConfigError where the page's configs, in ``configs`` of the working directory or of the checkout with this
    file, are not found.
    """
    summaries, finished = {}, {}
    with tempfile.TemporaryDirectory(prefix="tisph-verify-") as folder:
        for name, remark in READINGS.items():
            file = Path("configs") / f"vm_sph_001_{name}.yaml"
            paths = [root / file for root in (Path.cwd(), Path(__file__).resolve().parents[2])]
            path = next((path for path in paths if path.is_file()), None)
            if path is None:
                raise ConfigError(f"{file.as_posix()} not found: run this from a checkout of the source")
            print(f"running {path.name}: {remark}{COSTS.get(name, '')}", flush=True)
            result, message = run_config(path, Path(folder) / name)
            summaries[name], finished[name] = result.summary, not message
            if message:
                print(f"{name} did not finish: {message}", flush=True)
    print(f"\n{page_table(summaries)}")
    return _conclude(finished.items(), "readings reached their end")


def page_table(summaries: dict[str, dict[str, Any]]) -> str:
    """Return a Markdown table with a row for each sample of each reading, and a legend of the readings.

    ``summaries`` maps names of ``READINGS`` to the contents of their ``summary.json``, in kg, cm and s. A
    run that stopped early shows its status.
    """
    rows = []
    for name, summary in summaries.items():
        stopped = "" if summary["status"] == "done" else f" ({summary['status']})"
        samples = summary.get("samples", [])
        rows += [_page_row(name + stopped, summary["numbers"], sample) for sample in samples]
        if not samples:
            rows.append([name + stopped] + [""] * (len(PAGE_HEADER) - 1))
    legend = "; ".join(f"{name}: {READINGS[name]}" for name in summaries)
    return f"{format_table(PAGE_HEADER, rows)}\n\n{legend}."


def _page_row(label: str, numbers: dict[str, Any], sample: dict[str, Any]) -> list[str]:
    def number(key: str, style: str, scale: float = 1.0) -> str:
        """Return a number of the sample as text; a dash where a run that went wrong has none."""
        if sample[key] is None:
            return "-"
        text = format(scale * sample[key], style)
        return text.lstrip("-") if float(text) == 0 else text

    def error(reference: float) -> str:
        """Return the relative error of the slope in per cent, without a sign."""
        if sample["slope"] is None:
            return "-"
        percent = 100 * abs(sample["slope"] / reference - 1)
        return "< 1e-6 %" if percent < 1e-6 else f"{percent:.2g} %"

    with_exact = (("centreline", ".5f", 1.0), ("wall_shear_bottom", ".3g", PASCAL), ("wall_shear_top", ".3g", PASCAL))
    return [
        label,
        f"{numbers['reynolds']:.4g}",
        f"{numbers['mach']:.3g}",
        f"{sample['t']:g}",
        f"{sample['t_star']:.4g}",
        PAGE_SLOPES.get(round(sample["t"], 6), ""),
        number("slope", ".5f"),
        number("slope_exact", ".5f"),
        error(sample["slope_exact"]),
        error(TARGET_SLOPE),
        number("intercept", ".5f"),
        number("l2", ".1e"),
        *(f"{number(key, style, scale)} ({number(f'{key}_exact', style, scale)})" for key, style, scale in with_exact),
        number("density_variation", ".1e"),
    ]
