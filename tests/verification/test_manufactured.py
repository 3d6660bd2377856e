"""Manufactured solutions: the quick part of ``tisph verify manufactured``, and what it asks for."""

import sys

import pytest

from tisph import registry
from tisph.errors import ConfigError
from tisph.schemes import AROUND_BODIES
from tisph.studies import manufactured, verify
from tisph.studies.suites import Suite
from tisph.studies.verify import Runner

pytestmark = pytest.mark.verification


LONG = ("annulus_oldroyd_b",)
"""What takes a minute: the stress of a polymer is compared with its reference in tests/schemes."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in manufactured.QUICK]
)
def test_errors_fall_with_the_order_of_the_scheme(name, tmp_path):
    """Least orders are those of operators of order 4, and of the explicit scheme's."""
    runner = Runner(Suite("", manufactured.runs(quick=True)), tmp_path)
    checks = [runner.judge(criterion) for criterion in manufactured.bounds(name, quick=True)]
    assert not [check for check in checks if not check.passed], runner.failures


def test_every_case_is_in_the_whole_suite_and_every_run_is_needed():
    suite = verify.suite_of("manufactured")
    assert {name for criterion in suite.criteria for name in criterion.runs} == set(suite.runs)
    assert {run.rpartition("_")[0] for run in suite.runs} == set(manufactured.CASES)


@pytest.mark.parametrize("name", ["moving_circle", "pipe", "sphere", "eccentric"])
def test_solutions_have_no_divergence(name):
    """Exactly, but for rounding, which the largest of the slopes has some 1e-14 of."""
    solution = manufactured.Solution(name)
    (u, v, _), (x, y, t) = solution.velocity, solution.symbols
    slopes = [u.diff(x), v.diff(y), v / y if solution.axisymmetric else 0]
    along, *others = (
        float(manufactured.sympy().N(each.subs({x: 1.03, y: 0.66, t: 0.4})))
        for each in map(manufactured.sympy().sympify, slopes)
    )
    assert abs(along + sum(others)) < 1e-12 * abs(along)


def test_every_wall_treatment_of_the_explicit_scheme_has_its_cases():
    treatments = {f"wcsph_channel_{name}" for name in registry.names("walls")}
    treatments |= {f"wcsph_annulus_{name}" for name in AROUND_BODIES}
    assert treatments == {name for name in manufactured.CASES if name.startswith("wcsph")}


def test_without_sympy_the_suite_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(ConfigError, match=r"pip install 'tisph\[test\]'"):
        manufactured.criteria(quick=True)
