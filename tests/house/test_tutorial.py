"""docs/tutorials/1-couette.ipynb runs from top to bottom."""

from pathlib import Path

import pytest

import tisph

pytestmark = pytest.mark.taichi

ROOT = Path(tisph.__file__).parents[1]


@pytest.mark.slow  # make docs-draft, a part of .ci/run, executes all tutorials
def test_the_tutorial_runs(tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat", reason="there is no nbformat, which the test extra brings")
    nbclient = pytest.importorskip("nbclient", reason="there is no nbclient, which the test extra brings")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))  # the kernel is a process of its own
    notebook = nbformat.read(ROOT / "docs/tutorials/1-couette.ipynb", as_version=4)
    assert all(not cell.outputs for cell in notebook.cells if cell.cell_type == "code")  # it is kept without them
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("<video" in output.get("data", {}).get("text/html", "") for output in shown)
    assert any("image/png" in output.get("data", {}) for output in shown)
    assert any("100%" in output.get("data", {}).get("text/html", "") for output in shown)  # the bar
    assert not [output for output in shown if output.get("name") == "stderr"]
