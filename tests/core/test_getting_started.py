"""The commands of docs/getting-started.md work in the order in which they stand there, and leave what it says."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "getting-started.md").read_text(encoding="utf-8")
SHORT = "time={end: 0.05, samples: [0.05]}"
COARSE = ["discretisation.particles_across=15", "output.video.frames=2", "runtime.threads=1", SHORT]
ELSEWHERE = ("estimate-error", "verify")  # they have tests of their own, and take longer


def commands():
    """Command lines of the page that are tisph's."""
    blocks = re.findall(r"^```\w*\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines() if line.startswith("tisph ")]
    return [line for line in lines if not any(word in line for word in ELSEWHERE)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder in which all commands of the page were run, with fewer particles and for a short time."""
    folder = tmp_path_factory.mktemp("clone")
    shutil.copytree(ROOT / "configs", folder / "configs")
    name, text = re.search(r"`(\w+\.yaml)`[^`]*```yaml\n(.*?)```", PAGE, flags=re.DOTALL).groups()
    (folder / name).write_text(text, encoding="utf-8")
    for line in commands():
        coarse = [word for change in COARSE for word in ("--set", change)] if line.startswith("tisph run") else []
        command = [sys.executable, "-m", *shlex.split(line), *coarse]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8")
        assert done.returncode == 0, f"{line}: {done.stderr}"
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
