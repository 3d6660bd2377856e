"""What rows of the axisymmetric suite read from runs. Nothing is simulated."""

from pathlib import Path

import numpy as np
import pytest

from tisph.config import loader
from tisph.studies.processes import Result
from tisph.studies.store import config_text
from tisph.studies.verification import axisymmetric

STOPPED = Result(Path(), {"status": "diverged", "samples": []})


def ends(**numbers):
    return Result(Path(), {"status": "done", "samples": [{"t_star": 0.05, **numbers}]})


def row(case):
    (found,) = [each for each in axisymmetric.criteria(False) if each.case == case]
    return found


def test_critical_reynolds_number_is_where_the_rate_is_zero():
    exact = [ends(growth_rate=0.3 * e - 0.5 * e**2) for e in np.subtract(axisymmetric.AROUND, 1.0)]
    assert row("ratio 0.5").judge(*exact).value == pytest.approx(0.0, abs=1e-12)
    off = [ends(growth_rate=0.3 * (part - 1.003)) for part in axisymmetric.AROUND]
    assert row("ratio 0.5").judge(*off).value == pytest.approx(3e-3, rel=1e-6)
    assert not row("ratio 0.5").judge(*off).passed


def test_order_in_a_pipe_is_the_power_of_its_error():
    runs = [ends(l2=number**-4.0) for number in axisymmetric.FINE]
    assert row("pipe 14/20/28").judge(*runs).value == pytest.approx(4.0, rel=1e-9)


def test_runs_that_stopped_pass_nothing():
    for criterion in axisymmetric.criteria(False):
        assert not criterion.judge(*[STOPPED] * len(criterion.runs)).passed


def test_every_run_has_a_row_and_a_sound_config(tmp_path):
    for quick in (True, False):
        runs = axisymmetric.runs(quick)
        assert {name for criterion in axisymmetric.criteria(quick) for name in criterion.runs} == runs.keys()
        for name, config in runs.items():
            path = tmp_path / f"{name}.yaml"
            path.write_text(config_text(name, config))
            loader.load(path)
