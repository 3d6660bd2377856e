"""Scaling of the implicit scheme: the cases, and the bounds on them."""

import pytest

from tisph.config import load
from tisph.study.bench.scaling import CHANNEL_COST, COST, ITERATIONS, cases, kept


def rows(**changes):
    """What would be found where every bound is just kept; ``changes`` by case and key, as ``vortex_1000__key``."""
    found = {}
    for case in cases(quick=False):
        row = {"particles": case.across**2, "step_us": 4.0, "assembly_us": 1.0, "iterations": 2.0}
        row |= {"peak_mb": 200.0 + 3.5e-3 * case.across**2, "estimated_mb": 3.5e-3 * case.across**2}
        if (case.flow, case.across) == ("vortex", 1000):
            row |= {"step_us": 4.0 * COST, "iterations": 2.0 * ITERATIONS}
        if (case.flow, case.across) == ("channel", 200):
            row["step_us"] = 4.0 * CHANNEL_COST
        found[case] = {**row, **changes.get(f"{case.flow}_{case.across}", {})}
    return found


@pytest.mark.parametrize("case", cases(quick=False), ids=lambda case: f"{case.flow}-{case.across}-{case.threads}")
def test_the_cases_are_configs_of_as_many_particles_and_threads(case, tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(case.text)
    config = load(path, ())
    assert (config.particles_across, config.runtime.threads) == (case.across, case.threads)


def test_what_is_at_its_bounds_is_kept(capsys):
    assert kept(rows())
    assert "FAIL" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "change",
    [
        {"vortex_1000": {"iterations": 3.1}},
        {"vortex_1000": {"step_us": 6.1}},
        {"vortex_316": {"step_us": 4.1}},
        {"channel_200": {"step_us": 4.9}},
        {"vortex_1000": {"peak_mb": 3800.0, "estimated_mb": 3600.0}},
        {"vortex_1000": {"estimated_mb": 2600.0}},
    ],
    ids=str,
)
def test_what_is_beyond_a_bound_fails(change, capsys):
    assert not kept(rows(**change))
    assert capsys.readouterr().out.count("FAIL") >= 1
