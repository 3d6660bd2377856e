"""Predictions of ``tisph check`` beside runs: error, steps and resolution of every sample, of configs and cells.

    python benchmarks/estimates.py [--quick] [--only TEXT] [--out DIR]

prints a line for each run, of the sample that is predicted worst, and ends with status 1 where one is off: errors are
to be within a factor of 3 (10 where the sample is not resolved), steps within the range that is stated, and a sample is
to be resolved, or not, where that is said. Seconds are printed beside their range, but not judged: they depend on the
machine. Every run is a process of its own on one thread; the cells are the runs of ``tisph stability``, kept in the
same folder.
"""

import argparse
import json
import math
import sys
import tempfile
from contextlib import closing
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from rich.console import Console
from ruamel.yaml import YAML

from tisph import runtime
from tisph.cli import studies
from tisph.config import load
from tisph.errors import ConfigError
from tisph.schemes._forecast import ERROR_FACTORS, forecast
from tisph.studies import stability as matrix
from tisph.studies.store import Engine, Store, claimed, config_text
from tisph.text_table import format_header, format_row

HEADER = ("case", "t", "rms predicted", "found", "factor", "steps predicted", "found", "resolved", "seconds", "verdict")
NUMBERS = "estimates.json"
VERDICTS = ("pass", "FAIL", "no estimate", "stopped", "refused")


@dataclass(frozen=True)
class Comparison:
    """A sample as it was predicted (a ``SampleEstimate``) and as it was found, a dict of ``summary.json``.

    The error is the root mean square over the reference velocity, which there is at every time. ``resolved``: what was
    said about that before the run, None where nothing was.
    """

    predicted: object
    found: dict
    resolved: bool | None = None

    @property
    def error(self):
        """Error found over the predicted one; None where none is, 1 where less was found than a predicted bound."""
        if self.predicted.rms is None:
            return None
        factor = self.found["rms"] / self.predicted.rms
        return 1.0 if self.predicted.at_most and factor < 1.0 else factor

    @property
    def steps(self):
        """Least and largest number of steps that was predicted."""
        return self.predicted.steps_range(self.predicted.steps)

    @property
    def verdict(self):
        """``pass``, ``FAIL`` or ``no estimate``: of the error; steps and resolution may fail all the same."""
        least, most = self.steps
        largest = ERROR_FACTORS[self.found["resolved"]]
        right = least <= self.found["step"] <= most and self.resolved in (None, self.found["resolved"])
        if not right or not (self.error is None or 1.0 / largest <= self.error <= largest):
            return "FAIL"
        return "pass" if self.error is not None else "no estimate"

    @property
    def badness(self):
        """What the worst sample of a case has most of."""
        error = 0.0 if self.error is None else abs(math.log(max(self.error, 1e-9)))
        steps = abs(math.log(self.found["step"] / self.predicted.steps))
        return (self.verdict == "FAIL", self.verdict == "no estimate", error, steps)


def compare(numbers, samples):
    """Return a ``Comparison`` of every sample that a run took steps to; a run that was stopped has fewer.

    ``numbers`` are those of ``tisph check``.
    """
    parts = zip(numbers["samples"], samples, numbers["resolved"], strict=False)
    return [Comparison(*each) for each in parts if each[0].steps and each[1]["step"]]


@dataclass(frozen=True)
class Case:
    """A run: its ``name`` and config, a plain dict, the ``numbers`` of ``tisph check``, its refusal, if any."""

    name: str
    config: dict
    numbers: dict
    refusal: str | None = None


def main():
    """Read the arguments, compare, and tell by the exit status whether nothing fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the cells of tisph stability --quick")
    parser.add_argument("--only", metavar="TEXT", default="", help="cases with this text in their names")
    parser.add_argument("--out", metavar="DIR", help="results [default: the folder of tisph stability]")
    given = parser.parse_args()
    default = studies.STABILITY_FOLDER.with_name("stability-quick") if given.quick else studies.STABILITY_FOLDER
    try:
        passed = run(given.out or default, runtime.available_threads(), given.quick, given.only)
    except ConfigError as error:
        sys.exit(f"error: {error}")
    sys.exit(not passed)


def run(folder, processes, quick=False, only=""):
    """Print the table of all cases (``quick``: those of ``tisph stability --quick``) and leave numbers in ``folder``.

    ``only``: part of the names of the cases. Returns True if nothing fails. Raises ConfigError where ``folder`` cannot
    be used, and where the configs are not found.
    """
    folder = Path(folder)
    with claimed(folder, "another command keeps its runs there"):
        return _run(folder, processes, quick, only)


def _run(folder, processes, quick, only):
    with tempfile.TemporaryDirectory() as scratch, Console(stderr=True).status("checking the configs"):
        found = [*_configs(only), *_cells(Path(scratch), quick, only)]
    cases = {case.name: case for case in found}
    widths = [max(map(len, cases)), *(max(len(title), 12) for title in HEADER[1:-1]), len("no estimate")]
    print(format_header(HEADER, widths))
    counts, numbers = dict.fromkeys(VERDICTS, 0), {}
    configs = {name: case.config for name, case in cases.items() if not case.refusal}
    engine = Engine(Store(folder / "runs"), processes, dict.fromkeys(configs, 0.0))
    with engine, closing(engine.outcomes(configs)) as outcomes:
        refused = ((name, None) for name in cases if name not in configs)
        ended = ((name, result.summary) for name, result, _ in outcomes)
        for name, summary in chain(refused, ended):
            verdict, cells = _line(cases[name], summary)
            engine.say(format_row(cells, widths))
            counts[verdict] += 1
            if summary:
                numbers[name] = _measured(cases[name], summary)
    (folder / NUMBERS).write_text(json.dumps(numbers, indent=0), encoding="utf-8")
    print(f"\n{len(cases)} cases: {', '.join(f'{count} {verdict}' for verdict, count in counts.items())}")
    return counts["FAIL"] == 0


def _configs(only):
    """Yield a ``Case`` for every config in ``configs`` of the working directory or of the checkout with this file."""
    roots = (Path.cwd(), Path(__file__).resolve().parents[1])
    paths = next((found for root in roots if (found := sorted((root / "configs").glob("*.yaml")))), None)
    if not paths:
        raise ConfigError("configs/*.yaml not found: run this from a checkout of the source")
    for path in paths:
        if only not in f"configs-{path.stem}":
            continue
        config = YAML(typ="safe", pure=True).load(path)
        config.pop("name", None)
        yield Case(f"configs-{path.stem}", config, forecast(load(path))[0])


def _cells(scratch, quick, only=""):
    """Yield a ``Case`` for every cell of the stability matrix."""
    for cell in matrix.cells(matrix.sub_matrices(quick)):
        if only not in cell.name:
            continue
        found, numbers = matrix.plan(cell, scratch), {}
        if found.refusal is None:  # the plan is about the last sample only, by which the cell is judged
            path = scratch / "config.yaml"
            path.write_text(config_text(cell.name, found.config), encoding="utf-8")
            numbers = forecast(load(path))[0]
        yield Case(cell.name, found.config, numbers, found.refusal)


def _line(case, summary):
    """Return the verdict of a case, and its line of the table: of its worst sample."""
    if summary is None or summary["status"] != "done":
        verdict = "refused" if summary is None else "stopped"
        return verdict, (case.name, *[""] * (len(HEADER) - 2), verdict)
    worst = max(compare(case.numbers, summary["samples"]), key=lambda each: each.badness)
    predicted, found = worst.predicted, worst.found
    error = ("-", "-" if found["rms"] is None else f"{found['rms']:.1e}", "-")
    if predicted.rms is not None:
        sign = "< " if predicted.at_most else ""
        error = (f"{sign}{predicted.rms:.1e}", error[1], f"{found['rms'] / predicted.rms:.2g}")
    steps = "{} to {}".format(*worst.steps), str(found["step"])
    said = {True: "yes", False: "no", None: "unknown"}[worst.resolved]
    resolved = f"{said}: {'yes' if found['resolved'] else 'no'}"
    seconds = "{:.0f} to {:.0f}: ".format(*case.numbers["total_time_range"]) + f"{summary['cost']['wall_total_s']:.0f}"
    return worst.verdict, (case.name, f"{predicted.t:.3g}", *error, *steps, resolved, seconds, worst.verdict)


def _measured(case, summary):
    """What is kept of a run: its end, which for a cell depends on its cost, and numbers of its samples."""
    kept = ("t", "step", "rms", "resolved")
    samples = [{key: each[key] for key in kept} for each in summary["samples"]]
    return {"end": case.config["time"]["end"], "status": summary["status"], "samples": samples}


if __name__ == "__main__":
    main()
