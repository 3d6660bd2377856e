"""The suite of docs/how-to/acceptance-tests.md, copied from the page: it passes, and fails when it should."""

import json
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "acceptance-tests.md"
(SUITE,) = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def verify(folder, text):
    """Exit status of the page's command, and the JSON document that it prints."""
    (folder / "my_flow.yaml").write_text(text)
    command = [sys.executable, "-m", "tisph", "verify", "my_flow.yaml", "--json", "--out", "kept"]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return ended.returncode, json.loads(ended.stdout)


def test_the_suite_of_the_page_passes_and_fails_when_it_should(tmp_path):
    status, printed = verify(tmp_path, SUITE)
    assert (status, printed["passed"], printed["failures"]) == (0, True, {})
    assert len(printed["checks"]) == 9
    status, printed = verify(tmp_path, SUITE.replace("expected: 1.0,", "expected: 1.1,"))
    assert (status, printed["passed"]) == (1, False)
    failed = [row["quantity"] for row in printed["checks"] if not row["passed"]]
    assert failed == ["stress of the upper wall off 1.1"]
