"""Files that LAMMPS and PySPH have written, judged as ``tisph bench`` judges the runs that they are of."""

from pathlib import Path

import numpy as np
import pytest
from assessment_case import TIME, l2, loaded

from tisph.assessment import judge, readers
from tisph.errors import ConfigError

LAMMPS = Path(__file__).parent / "data/lammps_couette.dump"
"""Written by LAMMPS (22 Jul 2025, Update 4), liquid and walls:
``benchmarks/peers/lammps_couette.py --across 20 --steps 1188 --end 2.7 --threads 1 --dump lammps_couette.dump``."""

PYSPH = Path(__file__).parent / "data/pysph_couette.npz"
"""Written by PySPH (1.0b2), in the same way: ``pysph_couette.py --across 20 --steps 1188 --end 2.7 --dump FILE``."""

LAMMPS_BENCH, PYSPH_BENCH = 1.465e-01, 8.440e-03
"""What ``tisph bench`` measures of these runs: ``measure.py --code CODE --threads 1 --across 20 --until 2.7``."""

PRINTED = 5e-4
"""The numbers above are printed to four digits."""


@pytest.fixture
def config(tmp_path):
    return loaded(tmp_path)


def lammps_l2(t, rows):
    """``l2`` from the lines of a time, of atoms of type 1, by columns as the file has them."""
    kind, y, u = np.loadtxt(rows, usecols=(1, 3, 4), unpack=True)
    return l2(y[kind == 1], u[kind == 1], t)


def test_a_dump_of_lammps_is_judged_as_the_bench_judges_the_run(config):
    lines = LAMMPS.read_text().splitlines()
    starts = [index + 1 for index, line in enumerate(lines) if line.startswith("ITEM: ATOMS id type x y vx vy")]
    found = judge.judge(config, [LAMMPS], judge.Question(select="1")).samples
    assert [each.numbers["t"] for each in found] == pytest.approx([0.9, 1.8, 2.7], rel=1e-12)
    for each, start in zip(found, starts, strict=True):
        assert len(each.aligned.snapshot.u) == 800
        assert each.aligned.notes == ()
        own = lammps_l2(each.numbers["t"], lines[start : start + 1040])
        assert each.numbers["l2"] == pytest.approx(own, rel=1e-9)  # sums in another order
    assert found[-1].numbers["l2"] == pytest.approx(LAMMPS_BENCH, rel=PRINTED)


def test_a_file_of_pysph_is_judged_as_the_bench_judges_the_run(config):
    (found,) = judge.judge(config, [PYSPH], judge.Question()).samples
    assert found.numbers["t"] == pytest.approx(TIME, rel=1e-12)
    assert len(found.aligned.snapshot.u) == 800
    assert found.numbers["l2"] == pytest.approx(PYSPH_BENCH, rel=PRINTED)
    (frame,) = readers.frames(PYSPH)
    assert found.numbers["l2"] == pytest.approx(
        l2(frame.columns["y"], frame.columns["u"]), rel=1e-9
    )  # sums in another order


def test_walls_of_lammps_that_do_not_hold_the_fluid_are_found(config):
    """Its SPH package extrapolates no velocity into the walls."""
    found = judge.judge(config, [LAMMPS], judge.Question(times=(1.8, 2.7), select="1"))
    (diagnosis,) = found.diagnoses.values()
    assert "top_wall" in {each.fault.name for each in diagnosis.explaining}
    assert "outside the fluid" in diagnosis.explaining[0].words


@pytest.mark.parametrize(("select", "says"), [(None, "which types are the fluid"), ("4", "no atoms of type 4")])
def test_a_dump_with_several_types_needs_a_choice_of_the_fluid(config, select, says):
    with pytest.raises(ConfigError, match=says):
        judge.judge(config, [LAMMPS], judge.Question(select=select))
