"""Run the verification suite, or the verification page's case, and print the table.

Each case is a fresh process, one at a time, so that no run can touch another.
"""

import tempfile
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console

from tisph.errors import ConfigError
from tisph.studies import estimate_quality
from tisph.studies.processes import run_config, run_resumed
from tisph.studies.store import Store, claimed, config_text
from tisph.studies.verification import page as page_case
from tisph.studies.verification import suite
from tisph.text_table import format_header, format_row, format_table

HEADER = ("case", "quantity", "value", "bound", "verdict")


def run(quick=False, page=False):
    """Print the table of the suite (``quick``: of its short runs), or with ``page`` that of the page's case.

    Returns True if every check passed, for the page if every run reached its end. Raises ConfigError where the page's
    configs are not found.
    """
    with tempfile.TemporaryDirectory(prefix="tisph-verify-") as folder:
        if page:
            rows = _verify_page(Path(folder))
            return _conclude(rows, "readings reached their end")
        rows = _verify_suite(Runner(suite.runs(quick), Path(folder)), suite.criteria(quick))
        return _conclude(rows if quick else rows + _verify_estimates(Path(folder)), "rows passed")


def run_part(part, quick=False, long=False, out=None):
    """Print the table of one ``part`` of the suite; ``long``: its runs of minutes. Returns True if every check passed.

    With ``out``, a folder, finished runs stay there and are not run again. Raises ConfigError where there is no such
    part, and where the folder cannot be used.
    """
    configs, criteria = suite.one(part, quick, long)
    with ExitStack() as stack:
        if out:
            stack.enter_context(claimed(Path(out), "another verification is writing there"))
        folder = Path(out or stack.enter_context(tempfile.TemporaryDirectory(prefix="tisph-verify-")))
        runner = Runner(configs, folder, Store(folder) if out else None)
        return _conclude(_verify_suite(runner, criteria), "rows passed")


def _conclude(rows, words):
    """Print one line of verdict on ``rows``, pairs of a name and whether it passed; True if all did."""
    failed = [name for name, passed in rows if not passed]
    print(f"\n{len(rows) - len(failed)} of {len(rows)} {words}{'; FAIL: ' if failed else ''}{', '.join(failed)}")
    return not failed


class Runner:
    """Runs cases when their results are first asked for, and keeps the results.

    ``configs`` maps case names to configs as plain dicts, or to functions that run a case in this process and return
    its ``Result`` and message. Results are kept in subfolders of ``folder``. With a ``store`` of that folder, runs of
    configs that an earlier command finished are taken from it.
    """

    def __init__(self, configs, folder, store=None):
        self._store = store
        self.failures = {}
        self._configs = configs
        self._folder = folder
        self._results = {}

    def result(self, name):
        """``Result`` of a case. Where the run stopped early, ``failures[name]`` has its message."""
        if name not in self._results:
            config = self._configs[name]
            self._results[name], message = config() if callable(config) else self._outcome(name, config)
            if message:
                self.failures[name] = message
        return self._results[name]

    def _outcome(self, name, config):
        resumed = name.endswith(suite.RESUMED)
        if self._store and not resumed:
            [(_, result, message)] = self._store.outcomes({name: config}, 1)
            return result, message
        config_path = self._folder / f"{name}.yaml"
        config_path.write_text(config_text(name, config), encoding="utf-8")
        return (run_resumed if resumed else run_config)(config_path, self._folder / name)

    def judge(self, criterion):
        """``Check`` of a criterion, after running what it needs."""
        return criterion.judge(*(self.result(name) for name in criterion.runs))


def _verify_suite(runner, criteria):
    """Print a line as soon as its runs are done; return the name of each row and whether it passed."""
    console = Console()
    labels = [(criterion.case, criterion.quantity, "1.23e-06", criterion.bound, "pass") for criterion in criteria]
    widths = [max(map(len, column)) for column in zip(HEADER, *labels, strict=True)]
    print(format_header(HEADER, widths))
    rows = []
    for criterion in criteria:
        with console.status(f"running {' and '.join(criterion.runs)}"):
            check = runner.judge(criterion)
        verdict = "pass" if check.passed else "FAIL"
        line = (check.case, check.quantity, f"{check.value:.3g}", check.bound, verdict)
        print(format_row(line, widths), flush=True)
        rows.append((f"{check.case} {check.quantity}", check.passed))
    for name, message in runner.failures.items():
        print(f"{name} did not finish: {message}")
    return rows


def _verify_estimates(folder):
    """Print how good the errors are that runs state of themselves; return rows as ``_verify_suite`` does."""
    print("\nErrors that runs state of themselves (tisph run --estimate-error), over the true ones:\n")
    with Console(stderr=True).status("running the cases and their coarser runs"):
        found = list(estimate_quality.checks(folder))
    lines = [
        (each.case, each.quantity, f"{each.value:.2g}", each.bound, "pass" if each.passed else "FAIL") for each in found
    ]
    print(format_table(HEADER, lines))
    return [(f"{each.case} {each.quantity}", each.passed) for each in found]


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
