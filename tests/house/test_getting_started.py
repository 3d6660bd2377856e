"""The commands of docs/getting-started.md work in the order in which they stand there, and leave what it says."""

import json
import re
import shutil
from pathlib import Path

import pytest
from shell import pasted
from typer.testing import CliRunner

from tisph import cli

pytestmark = pytest.mark.taichi

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "getting-started.md").read_text(encoding="utf-8")
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
