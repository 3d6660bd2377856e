"""The stability matrix, small: every requirement is met and no run fails silently."""

import json

import pytest

from tisph.studies import stability_report
from tisph.studies.stability import sub_matrices


@pytest.mark.slow
@pytest.mark.timeout(900)  # three minutes on two idle cores
def test_quick_matrix(tmp_path):
    met = stability_report.run(tmp_path, processes=2, parts=sub_matrices(quick=True))
    cells = json.loads((tmp_path / "stability.json").read_text())["cells"]
    broken = {cell["name"]: (cell["verdict"], cell["reason"]) for cell in cells if not cell["met"]}
    assert met, broken
    assert not [cell["name"] for cell in cells if cell["verdict"] == "silent failure"]
