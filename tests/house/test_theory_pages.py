"""The pages of docs/theory/ number their equations in order, and the modules that they name exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "theory").glob("*.md"))
MODULES = {path.relative_to(ROOT).as_posix() for folder in ("tisph", "tests") for path in (ROOT / folder).rglob("*")}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_equations_are_numbered_in_order(path):
    equations = re.findall(r"^\$\$.*\$\$$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    tags = [re.search(r"\\tag\{(\d+)([a-z]?)\}\$\$$", equation) for equation in equations]
    assert all(tags)
    expected, number = [], 0
    for letter in [tag[2] for tag in tags]:
        number += letter in ("", "a")  # 3a, 3b are the parts of one
        expected.append(f"{number}{letter}")
    assert [tag[1] + tag[2] for tag in tags] == expected


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_modules_exist(path):
    named = re.findall(r"`((?:\w+/)*\w+\.py|tisph/[\w/]*\w)/?`", path.read_text(encoding="utf-8"))
    assert [name for name in named if not any(("/" + module).endswith("/" + name) for module in MODULES)] == []
