"""Start-up measured in what the least Taichi program costs: the cases, and the bounds on them."""

from pathlib import Path

import pytest

from tisph.config import load
from tisph.study.bench.startup import COLD, MOVIE, WHOLE, cases, cells, kept

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize("case", cases(CONFIGS, quick=False), ids=lambda case: case.name)
def test_a_resized_case_differs_in_resolution_length_and_end_alone(case):
    usual, resized = (load(CONFIGS / case.config, (*case.settings, *more)) for more in ((), case.resized))
    for size in (usual.columns, usual.particles_across, usual.time.end, usual.geometry.length):
        assert size not in (resized.columns, resized.particles_across, resized.time.end, resized.geometry.length)
    kept_alike = ("scheme", "walls", "fluid", "drive", "initial", "runtime")
    assert all(getattr(usual, part) == getattr(resized, part) for part in kept_alike)


LEAST = 0.5
ROW = {"case": "flow", "least": LEAST, "warm": WHOLE * LEAST, "resized": WHOLE * LEAST, "compiled": 0}
ROW |= {"compile_cold": COLD * LEAST, "movie": MOVIE * LEAST}


def test_a_case_at_its_bounds_keeps_them(capsys):
    assert kept(ROW)
    assert capsys.readouterr().out.count("PASS") == 5


@pytest.mark.parametrize("kind", ["warm", "resized", "compiled", "compile_cold", "movie"])
def test_a_case_beyond_a_bound_fails(kind, capsys):
    assert not kept({**ROW, kind: 1.01 * ROW[kind] + 0.01})
    assert capsys.readouterr().out.count("FAIL") == 1


def test_the_cells_of_a_case_are_in_units_of_the_least_program():
    assert cells(ROW) == ("flow", "0.50", "2.20", "2.20", "0", f"{COLD:.2f}", "1.50")
    without = {key: value for key, value in ROW.items() if key != "movie"}
    assert cells(without)[-1] == ""
