"""Run suites, or the verification page's case, and print their tables.

Each run is a fresh process, one at a time, so that no run can touch another.
"""

import json
import math
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.studies import page as page_case
from tisph.studies import suites
from tisph.studies.checks import Check, Criterion
from tisph.studies.processes import Result, run_config, run_resumed
from tisph.studies.store import Store, claimed
from tisph.studies.suites import Suite
from tisph.text_table import format_header, format_row

HEADER = ("case", "quantity", "value", "bound", "verdict")

MANUFACTURED = "manufactured"
"""The suite whose runs are built in Python; it needs sympy, and does not run with the others."""


def run(name=None, quick=False, long=False, out=None, as_json=False):
    """Print the table of a suite, one of ours by ``name`` or a file; without a name, of all of ours but manufactured.

    With ``out``, a folder, finished runs stay there and are not run again. ``as_json``: print one JSON document of all
    checks in place of the table. Returns True if every check passed. Raises ConfigError where there is no such suite,
    it has a mistake, or the folder cannot be used.
    """
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


def run_page():
    """Print the table of all readings of the page; return True if every one reached its end.

    Raises ConfigError where the page's configs are not found.
    """
    with tempfile.TemporaryDirectory(prefix="tisph-verify-") as folder:
        return _conclude(_verify_page(Path(folder)), "readings reached their end")


def suite_of(name, quick=False, long=False):
    """Return a ``Suite`` by name, or by file; all of ours without a name. Raises ConfigError where there is none."""
    if name is None:
        return suites.whole(quick)
    if name == MANUFACTURED and not long:
        from tisph.studies import manufactured

        return Suite("Manufactured solutions", manufactured.runs(quick), manufactured.criteria(quick))
    if name in suites.PARTS:
        return suites.ours(name, quick, long)
    if Path(name).suffix in (".yaml", ".yml"):
        return suites.read(Path(name), quick, long)
    names = (*suites.PARTS, MANUFACTURED)
    if name in names:
        raise ConfigError(f"--long: {name} has no long section")
    raise ConfigError(
        f"no suite {name!r}{nearest(name, names)}; there are {', '.join(names)}, and files that end in .yaml"
    )


class Runner:
    """Runs the configs of a suite when their results are first asked for, and keeps the results.

    A run of ``suite`` is a config as a plain dict, or a function that runs it in this process and returns ``Result``
    and message. Runs are kept in subfolders of ``folder``; those that an earlier command finished are taken from there,
    except resumed ones. ``failures``: messages of runs that stopped early, and of numbers that samples do not have, by
    name of the run.
    """

    def __init__(self, suite: Suite, folder: Path):
        self.suite = suite
        self.failures: dict[str, str] = {}
        self.store = Store(folder)
        self._results: dict[str, Result] = {}

    def result(self, name: str) -> Result:
        """``Result`` of a run. Where it stopped early, ``failures[name]`` has its message."""
        if name not in self._results:
            config = self.suite.runs[name]
            self._results[name], message = config() if callable(config) else self.outcome(name, config)
            if message:
                self.failures[name] = f"did not finish: {message}"
        return self._results[name]

    def outcome(self, name: str, config: dict[str, Any]) -> tuple[Result, str]:
        """``Result`` and message of a run, new or kept."""
        if name in self.suite.resumed:
            return run_resumed(self.store.write(name, config), self.store.folder / name)
        if name in self.suite.estimated:
            return run_config(self.store.write(name, config), self.store.folder / name, estimated=True)
        return self.store.outcome(name, config)

    def checks(self) -> Iterator[Check]:
        """Yield the ``Check`` of each criterion, as soon as its runs are done; standard error says how far it is."""
        console = Console(stderr=True)
        for criterion in self.suite.criteria:
            done = f"{len(self._results)} of {len(self.suite.runs)} runs are done"
            with console.status(f"running {' and '.join(criterion.runs)}; {done}"):
                check = self.judge(criterion)
            yield check

    def judge(self, criterion: Criterion) -> Check:
        """``Check`` of a criterion, after running its runs."""
        results = [self.result(name) for name in criterion.runs]
        try:
            return criterion.judge(*results)
        except ConfigError as error:
            self.failures[criterion.runs[0]] = str(error)
            return Check(criterion.case, criterion.quantity, math.nan, criterion.bound, passed=False)


def _print_table(runner):
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


def _print_json(runner):
    """Print one JSON document of all checks; return True if all passed."""
    checks = list(runner.checks())
    rows = [{**asdict(check), "value": check.value if math.isfinite(check.value) else None} for check in checks]
    passed = all(check.passed for check in checks)
    title = runner.suite.title
    print(json.dumps({"title": title, "passed": passed, "checks": rows, "failures": runner.failures}, indent=2))
    return passed


def _conclude(rows, words):
    """Print one line of verdict on ``rows``, pairs of a name and whether it passed; True if all did."""
    failed = [name for name, passed in rows if not passed]
    print(f"\n{len(rows) - len(failed)} of {len(rows)} {words}{'; FAIL: ' if failed else ''}{', '.join(failed)}")
    return not failed


def _verify_page(folder):
    """Run every reading of the page and print their table; return the name of each and whether it reached its end."""
    summaries, rows = {}, []
    for name, remark in page_case.READINGS.items():
        path = _page_config(name)
        print(f"running {path.name}: {remark}{page_case.COSTS.get(name, '')}", flush=True)
        result, message = run_config(path, folder / name)
        summaries[name] = result.summary
        rows.append((name, not message))
        if message:
            print(f"{name} did not finish: {message}", flush=True)
    print(f"\n{page_case.page_table(summaries)}")
    return rows


def _page_config(name):
    """Config of a reading, in ``configs`` of the working directory or of the checkout with this file."""
    for root in (Path.cwd(), Path(__file__).resolve().parents[2]):
        path = root / "configs" / f"vm_sph_001_{name}.yaml"
        if path.is_file():
            return path
    raise ConfigError(f"configs/vm_sph_001_{name}.yaml not found: run this from a checkout of the source")
