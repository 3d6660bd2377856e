"""Runs against exact solutions: the bounds of the verification suite, one test each.

The bounds and where they come from stand in ``tisph.verification.suite``. A run is simulated once, in a
process of its own, when the first test asks for it.
"""

import pytest

from tisph.study.verify import Runner
from tisph.verification import suite


def checks(quick):
    """The suite's criteria, with a readable test name each."""
    return [
        pytest.param(criterion, id=f"{criterion.case}: {criterion.quantity} {criterion.bound}")
        for criterion in suite.criteria(quick)
    ]


@pytest.fixture(scope="module")
def quick_runner(tmp_path_factory):
    return Runner(suite.runs(quick=True), tmp_path_factory.mktemp("quick"))


@pytest.fixture(scope="module")
def full_runner(tmp_path_factory):
    return Runner(suite.runs(quick=False), tmp_path_factory.mktemp("full"))


@pytest.mark.verification
@pytest.mark.parametrize("criterion", checks(quick=True))
def test_quick_suite(quick_runner, criterion):
    check = quick_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {quick_runner.failures}"


@pytest.mark.verification
@pytest.mark.slow
@pytest.mark.timeout(1800)  # the longest run has 110 000 steps of 5000 particles
@pytest.mark.parametrize("criterion", checks(quick=False))
def test_full_suite(full_runner, criterion):
    check = full_runner.judge(criterion)
    assert check.passed, f"{check.value:.3g} is not {check.bound} {full_runner.failures}"
