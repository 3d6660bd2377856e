"""Compare numbers of the documents with their sources: ``make numbers``.

docs/_numbers.yaml lists texts of pages, with their numbers in {braces}, and for each number the run, the row of a suite
or the other page from which it comes. A number agrees if its source, rounded to as many digits, is the same number. The
exit status is 1 if one does not agree. ``python docs/_numbers.py TEXT...`` compares the entries with these texts in the
name of their page or source. Runs are kept in runs/numbers/ and used again as long as config and package are the same.

At the end the share of the numbers of each page that have a source is printed. Every decimal, power of ten and
percentage of a page counts as a number, except in blocks of YAML and Python.
"""

import contextlib
import csv
import io
import re
import runpy
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from _gallery import value as entry_of_summary
from ruamel.yaml import YAML
from typer.testing import CliRunner

from tisph import cli
from tisph.config import load
from tisph.references import table
from tisph.studies.expressions import Number
from tisph.studies.processes import run_config
from tisph.studies.store import Store
from tisph.studies.verify import Runner, suite_of

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT / "docs" / "_numbers.yaml"
RUNS = ROOT / "runs" / "numbers"
PAGES = ["README.md", *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md"))]
BRACED = re.compile(r"\{([^{}]*)\}")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+|\s?%)|(?<![\w.])\d+\.\d+(?![\w.])")
IN_A_LIST = re.compile(r"\.-?\d+\.")


@dataclass(frozen=True)
class Entry:
    """An entry of docs/_numbers.yaml: texts of a ``page`` and the source of their numbers.

    ``run`` is a config, or the name of a config that a page shows, run with the overrides ``set`` and, with
    ``estimate``, with coarser runs. ``verify`` is a suite, or ``quick`` for ``tisph verify --quick``. ``sweep`` is the
    file of a sweep. ``prints`` is a command, ``tisph ...`` or ``python FILE``, that prints the texts. ``quotes`` is a
    page with the same numbers. ``references``: the keys are names of ``tisph references``. ``quick``: a test compares
    it, too.
    ``numbers``: text -> keys of its numbers. A key is an expression of numbers of the last sample, or at a time
    (``l2 @ 2.7``), or the largest of all samples (``largest l2``); a dotted path into summary.json; a row of the suite
    (``case: quantity``), or the largest of all rows that match (``case: l2 .+``, in which ``*`` is a star); ``rows``,
    their number; or row and column in the table of a sweep (``2: l2``).
    """

    page: str
    numbers: dict
    run: str = ""
    set: tuple = ()
    estimate: bool = False
    verify: str = ""
    sweep: str = ""
    prints: str = ""
    quotes: str = ""
    references: bool = False
    quick: bool = False

    @property
    def source(self):
        """Return the command, or the page, from which the numbers come."""
        words = [f"--set {text}" for text in self.set] + ["--estimate-error"] * self.estimate
        run = self.run and " ".join(["tisph run", self.run, *words])
        many = (self.verify and f"tisph verify {self.verify}") or (self.sweep and f"tisph sweep {self.sweep}")
        return run or many or self.prints or self.quotes or "tisph references"

    @cached_property
    def found(self):
        """Return the function key -> value of the source, after running it."""
        if self.references:
            return table.number
        if self.verify or self.sweep:
            return self.row if self.verify else self.swept
        return self.number_of(*self.result())

    def config(self):
        """Return the config that is run; ConfigError where it has a mistake."""
        path = ROOT / self.run
        if path.is_file():
            return load(path, self.set)
        block = re.compile(rf"`{self.run}`[^`]*```yaml\n(.*?)```", re.DOTALL)
        shown = next(found[1] for page in PAGES if (found := block.search(text_of(page))))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / self.run
            path.write_text(shown, encoding="utf-8")
            return load(path, self.set)

    def result(self):
        """Return the ``Result`` of the run, new or kept, and its message."""
        RUNS.mkdir(parents=True, exist_ok=True)
        store, config = Store(RUNS), self.config().resolved()
        name = re.sub(r"[^\w.-]+", "_", " ".join([Path(self.run).stem, *self.set, *["estimate"] * self.estimate]))[:120]
        kept = store.kept(name, config)
        if self.estimate and not (kept and "error_estimate" in kept[0].summary):
            return run_config(store.write(name, config), RUNS / name, estimated=True)
        return kept or store.outcome(name, config)

    def number_of(self, result, message):
        """Return the function key -> number of a ``Result``; RuntimeError where the run did not end."""
        if message:
            raise RuntimeError(f"{self.source}: {message}")

        def number(key):
            if IN_A_LIST.search(f".{key}"):
                return entry_of_summary(result.summary, key)
            text, _, time = key.removeprefix("largest ").partition(" @ ")
            chosen = [result.sample(float(time), "t") if time else result.last]
            samples = result.summary["samples"] if key.startswith("largest ") else chosen
            return max(Number(text, key)(result, sample) for sample in samples)

        return number

    def criteria(self, key):
        """Return the criteria of the suite whose rows match a key."""
        criteria = runner_of(self.verify).suite.criteria
        return [one for one in criteria if re.fullmatch(key.replace("*", r"\*"), f"{one.case}: {one.quantity}")]

    def row(self, key):
        """Return the value in a row of the suite, or the largest in several."""
        runner = runner_of(self.verify)
        if key == "rows":
            return len(runner.suite.criteria)
        return max(runner.judge(one).value for one in self.criteria(key))

    def swept(self, key):
        """Return a number in a row of the table of the sweep."""
        row, _, column = key.partition(": ")
        return float(table_of(self.sweep)[int(row) - 1][column])

    def printed(self):
        """Return what the command ``prints`` prints."""
        program, *words = self.prints.split()
        if program == "tisph":
            return CliRunner().invoke(cli.app, words).stdout
        with contextlib.redirect_stdout(io.StringIO()) as output:
            runpy.run_path(str(ROOT / words[0]))
        return output.getvalue()

    def wrong(self):
        """Return a line for each number that its source does not have."""
        if self.prints:
            printed = self.printed()
            return [
                f"{self.page}: {self.prints} does not print {text!r}" for text in self.numbers if text not in printed
            ]
        lines = []
        for text, keys in self.numbers.items():
            shown = BRACED.findall(text)
            if self.quotes:
                there = set(re.findall(r"[\w.-]*\w", text_of(self.quotes)))
                lines += [f"{self.page}: {one} is not on {self.quotes}" for one in shown if one not in there]
                continue
            for one, key in zip(shown, keys if isinstance(keys, list) else [keys], strict=True):
                found = self.found(key)
                if not agrees(one, found):
                    lines.append(f"{self.page}: {one} in {plain(text)!r} is {found:.6g} by {self.source} ({key})")
        return lines


def entries():
    """Return all entries of docs/_numbers.yaml."""
    return [Entry(**one) for one in YAML(typ="safe").load(LIST.read_text(encoding="utf-8"))]


def agrees(shown, value):
    """Return whether a value, rounded to as many digits, is the number that is shown; % counts hundredths."""
    digits, percent = shown.rstrip(" %"), shown.endswith("%")
    mantissa, _, exponent = digits.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(value * (100.0 if percent else 1.0) - float(digits)) <= 0.5 * unit * (1.0 + 1e-6)


def plain(text):
    """Return a text as it stands on the page, without braces."""
    return BRACED.sub(r"\1", text)


@cache
def text_of(page):
    """Return the text of a page."""
    return (ROOT / page).read_text(encoding="utf-8")


@cache
def runner_of(suite):
    """Return the runner of a suite, which keeps its runs."""
    folder = RUNS / f"verify-{suite}"
    folder.mkdir(parents=True, exist_ok=True)
    return Runner(suite_of(None, quick=True) if suite == "quick" else suite_of(suite), folder)


@cache
def table_of(study):
    """Return the rows of the table of a sweep, after running it; it keeps its runs."""
    RUNS.mkdir(parents=True, exist_ok=True)
    folder = RUNS / Path(study).stem
    CliRunner().invoke(cli.app, ["sweep", str(ROOT / study), "--processes", "1", "--out", str(folder)])
    with (folder / "table.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def shares():
    """Yield page, numbers that have a source, and all numbers of the page."""
    known = Counter()
    for entry in entries():
        known[entry.page] += sum(
            len(NUMBER.findall(text) if entry.prints else BRACED.findall(text)) for text in entry.numbers
        )
    for page in PAGES:
        text = re.sub(r"^```(?:yaml|python)$.*?^```$", "", text_of(page), flags=re.DOTALL | re.MULTILINE)
        yield page, known[page], max(known[page], len(NUMBER.findall(text)))


def main(words):
    """Print each entry with its numbers that do not agree; exit with 1 if there are any."""
    chosen = [entry for entry in entries() if all(word in f"{entry.page} {entry.source}" for word in words)]
    wrong = 0
    for entry in chosen:
        lines = entry.wrong()
        print(f"{entry.page}: {entry.source}: {len(lines) or 'no'} wrong", *lines, sep="\n  ", flush=True)
        wrong += len(lines)
    counts = list(shares())
    print("\nnumbers with a source, of all:")
    for page, with_source, numbers in counts:
        if with_source:
            print(f"  {page:40} {with_source:4} of {numbers}")
    print(f"  {'all pages':40} {sum(one[1] for one in counts):4} of {sum(one[2] for one in counts)}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main(sys.argv[1:])
