"""Step plans: every target is hit exactly, by equal steps no longer than the limit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tisph.schemes._step_control import StepPlan


def walk(plan, limit):
    times, lengths = [], []
    while length := plan.next(limit):
        times.append(plan.time)
        lengths.append(length)
    return times, lengths


@given(st.lists(st.floats(0.01, 10.0), min_size=1, max_size=5, unique=True).map(sorted), st.floats(0.01, 3.0))
def test_hits_every_target_exactly_within_the_limit(targets, limit):
    times, lengths = walk(StepPlan(0.0, targets), limit)
    assert set(targets) <= set(times)
    assert times[-1] == targets[-1]
    assert max(lengths) <= limit * (1 + 1e-12)  # the slack that saves a step of rounding size


def test_a_remainder_of_round_off_size_costs_no_step():
    times, _ = walk(StepPlan(0.0, [0.3]), 0.1)
    assert len(times) == 3


def test_targets_at_or_before_the_start_are_passed():
    times, _ = walk(StepPlan(1.0, [0.5, 1.0, 2.0]), 10.0)
    assert times == [2.0]


def test_a_new_limit_changes_the_steps_left():
    plan = StepPlan(0.0, [1.0])
    assert plan.next(0.5) == 0.5
    assert plan.next(0.1) == pytest.approx(0.1)


def test_zero_once_finished():
    plan = StepPlan(0.0, [1.0])
    assert plan.next(2.0) == 1.0
    assert plan.next(2.0) == 0.0


@pytest.mark.parametrize(("taken", "same"), [(2, True), (3, True), (4, False), (9, False), (10, False)])
def test_new_targets_report_whether_steps_aimed_at_old_ones(taken, same):
    # three steps to 0.3, which is a target in both, and seven to the old end
    plan, fresh = StepPlan(0.0, [0.3, 1.0]), StepPlan(0.0, [0.3, 5.01])
    first = [(plan.next(0.1), fresh.next(0.1)) for _ in range(taken)]
    assert plan.aim([0.3, 5.01]) == same
    assert all(one == other for one, other in first) == same
    rest = walk(plan, 0.1)
    assert rest[0][-1] == 5.01
    assert max(rest[1]) <= 0.1 * (1 + 1e-12)  # the slack that saves a step of rounding size
    if same:
        assert rest == walk(fresh, 0.1)
