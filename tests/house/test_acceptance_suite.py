"""The suite of docs/how-to/acceptance-tests.md, copied from the page: it passes, and fails when it should."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.taichi

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "acceptance-tests.md"
(SUITE,) = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


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
