"""Commands of docs/getting-started.md work in their order and leave what it says; acceptance-tests.md, too."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from shell import pasted
from typer.testing import CliRunner

from tisph import cli

pytestmark = pytest.mark.taichi

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "getting-started.md").read_text(encoding="utf-8")
ACCEPTANCE = (ROOT / "docs" / "how-to" / "acceptance-tests.md").read_text(encoding="utf-8")
(SUITE,) = re.findall(r"```yaml\n(.*?)```", ACCEPTANCE, re.DOTALL)
SHORT = "time={end: 0.05, samples: [0.05]}"
COARSE = ["discretisation.particles_across=15", "output.video.frames=2", "runtime.threads=1", SHORT]


def commands():
    """Command lines of the page that are tisph's."""
    blocks = re.findall(r"^```\w*\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines() if line.startswith("tisph ")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, kept_program):
    """Return a folder in which all commands of the page were run, with fewer particles and for a short time.

    In this process: what a process of its own adds is in the tests of other files, test_run.py first.
    """
    folder = tmp_path_factory.mktemp("clone")
    shutil.copytree(ROOT / "configs", folder / "configs")
    name, text = re.search(r"`(\w+\.yaml)`[^`]*```yaml\n(.*?)```", PAGE, flags=re.DOTALL).groups()
    (folder / name).write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(folder)
        monkeypatch.setattr("tisph.observers.history.RECORDS", 21)  # the page reads none
        for words in pasted(commands(), folder):
            coarse = [word for change in COARSE for word in ("--set", change)] if words[0] == "run" else []
            done = CliRunner().invoke(cli.app, [*words, *coarse])
            assert done.exit_code == 0, f"{words}: {done.stderr}"
    return folder


def test_commands_leave_the_files_that_the_page_names(folder):
    named = re.findall(r"`(runs/[\w/]+\.\w+)`", PAGE)
    assert named
    assert [name for name in named if not (folder / name).is_file()] == []
    assert (folder / "report.html").is_file()


def test_the_summary_has_the_numbers_that_the_page_reads(folder):
    sample = json.loads((folder / "runs/two_cylinders/summary.json").read_text())["samples"][-1]
    named = re.findall(r"`(drag_\w+|superficial_velocity)`", PAGE)
    assert {*named} <= {*sample}
    assert len({*named}) == 5


def test_the_suite_of_the_page_passes_and_names_the_row_that_fails(tmp_path):
    """Beside the row of the page with the expected stress of the wall, 1.0, stands another one with 1.1."""
    (row,) = (line for line in SUITE.splitlines() if "expected: 1.0," in line)
    (tmp_path / "my_flow.yaml").write_text(
        SUITE.replace(row, f"{row}\n{row.replace('expected: 1.0,', 'expected: 1.1,')}")
    )
    command = [sys.executable, "-m", "tisph", "verify", "my_flow.yaml", "--json", "--out", "kept"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    printed = json.loads(ended.stdout)
    assert (ended.returncode, printed["passed"], printed["failures"]) == (1, False, {})
    assert len(printed["checks"]) == 10
    assert [check["quantity"] for check in printed["checks"] if not check["passed"]] == [
        "stress of the upper wall off 1.1"
    ]
