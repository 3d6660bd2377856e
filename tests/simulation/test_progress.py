"""Progress on terminals of any width, and at sensible intervals where there is none."""

import importlib
import io
import re

import pytest

from tisph.simulation.run import RunProgress

MODULE = importlib.import_module("tisph.simulation.run")  # the package has the function of that name


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize("columns", [20, 30, 60, 120])
def test_a_bar_has_percentage_and_remaining_time_at_any_width(monkeypatch, columns):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr(MODULE, "REFRESH", -1.0)
    for name, value in (("COLUMNS", str(columns)), ("TERM", "xterm"), ("NO_COLOR", "1")):
        monkeypatch.setenv(name, value)
    with RunProgress(0.0, 2.0, 5000, "s") as bar:
        bar.update(0.5, 1)
        bar.update(1.0, 12345)
        bar.bar.refresh()
        lines = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", line) for line in re.split(r"[\r\n]", terminal.getvalue())]
        shown = next(line for line in reversed(lines) if "%" in line)
        assert re.search(r" 50% .*(-:--:--|\d:\d\d:\d\d)$", shown.rstrip())
        assert "…" not in shown
        assert ("step 12345" in shown) == (columns >= 60)
        assert "particle-steps/s" in shown or columns < 120
        assert all(len(line) <= columns for line in lines)


@pytest.fixture
def lines(monkeypatch):
    """Return a function that tells at which parts of a run of so many seconds a line is printed."""

    def run(seconds, steps=1000):
        clock = [0.0]
        monkeypatch.setattr(MODULE.time, "perf_counter", lambda: clock[0])
        stream = io.StringIO()
        monkeypatch.setattr("sys.stderr", stream)
        with RunProgress(0.0, 1.0, 100, "s") as shown:
            for step in range(1, steps + 1):
                clock[0] = seconds * step / steps
                shown.update(step / steps, step)
        return [int(line.partition("%")[0]) for line in stream.getvalue().splitlines()]

    return run


def test_a_long_run_has_a_line_a_minute(lines):
    shown = lines(10 * 3600.0, steps=36000)
    assert len(shown) == pytest.approx(600, rel=0.02)  # steps of a second
    assert shown[-1] == 100
