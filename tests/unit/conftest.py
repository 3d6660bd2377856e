"""What several test files of this folder start from."""

import pytest
from fake_runs import FakeRuns, make_result

from tisph.study import processes


@pytest.fixture
def fake_process(monkeypatch):
    """Stands in for `tisph run`: leaves a summary with an l2 of the test's choice, or stops with an error."""
    l2_by_name = {}

    def summary(config):
        l2 = l2_by_name.get(config["name"], 1e-3)
        return l2 if isinstance(l2, str) else make_result(t18=l2).summary

    runs = FakeRuns(summary)
    monkeypatch.setattr(processes.subprocess, "Popen", runs)
    return runs.configs, l2_by_name
