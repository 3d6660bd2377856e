"""Step control and step plans: targets, remainders, errors, limits; one-step and multistep methods."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tisph.schemes._step_control import (
    LARGEST_FACTOR,
    LARGEST_MULTISTEP_FACTOR,
    MOST_ATTEMPTS,
    REJECTED,
    SAFETY,
    SHARE,
    SMALLEST_FACTOR,
    StepControl,
    StepPlan,
)
from tisph.schemes.implicit.planar.step_limits import (
    SPACING_ERROR,
    TIME_ERROR,
    TIME_POWER,
    TOLERANCE,
    balanced_tolerance,
)


def make(start=0.0, targets=(10.0,), first=1.0, largest_strain=1.0, fixed=None):
    """A control of steps of order 2 whose errors are over 1, limited by the strain of a step, or fixed."""
    limit = lambda gradient: fixed or (largest_strain / gradient if gradient > 0.0 else math.inf)  # noqa: E731
    control = StepControl(1.0, limit, fixed=fixed is not None)
    control.dt_next = fixed or first
    control.set_targets(targets, start)
    return control


def make_multistep(targets, first, tolerance, jump_times=()):
    control = StepControl(tolerance, lambda dt: dt, fixed=tolerance is None, multistep=True, jump_times=jump_times)
    control.dt_next = first
    control.set_targets(targets, 0.0)
    return control


def walk(control, time=0.0, natural=1e9, gradient=0.0):
    """Take steps to the last target; return the ends and lengths of those accepted.

    ``natural``: length of the step that has the error asked for; the error grows as the cube of the length.
    """
    times, lengths = [], []
    while not control.finished:
        length = control.choose_dt(time)
        if control.accepts((length / natural) ** 3, 2, length):
            time = control.end(time, length)
            control.step_taken(time, gradient)
            times.append(time)
            lengths.append(length)
    return times, lengths


TARGETS = st.lists(st.floats(0.01, 10.0), min_size=1, max_size=5, unique=True).map(sorted)


@given(TARGETS, st.floats(0.01, 3.0), st.floats(0.01, 3.0), st.floats(0.1, 2.0))
def test_hits_every_target_exactly(targets, first, natural, strain):
    control = make(targets=targets, first=first, largest_strain=strain)
    times, lengths = walk(control, natural=natural, gradient=2.0)
    assert set(targets) <= set(times)
    assert times[-1] == targets[-1]
    assert times == sorted(set(times))  # no step of no length
    assert min(lengths) > 0


@given(TARGETS, st.floats(0.01, 3.0))
def test_hits_every_target_exactly_with_fixed_steps(targets, fixed):
    times, lengths = walk(make(targets=targets, fixed=fixed))
    assert set(targets) <= set(times)
    # at most a thousandth longer, which saves a step of the length of a thousandth
    assert max(lengths) <= fixed / 0.999 * (1 + 1e-12)


def test_targets_at_or_before_the_start_are_passed():
    assert walk(make(start=1.0, targets=(0.5, 1.0, 1.25)), time=1.0)[0] == [1.25]
    assert walk_plan(StepPlan(1.0, [0.5, 1.0, 2.0]), 10.0)[0] == [2.0]


@pytest.mark.parametrize(
    ("wish", "expected"),
    [
        (2.5, 1.0),  # all: the wish reaches beyond the target
        (1.0, 1.0),
        (0.9995, 1.0),  # all: what would be left is no step worth taking
        (0.99, 0.5),  # half: the wish would leave a small remainder
        (0.51, 0.5),
        (0.5, 0.5),
        (0.3, 0.3),  # none of it: the target is more than two steps away
    ],
)
def test_takes_all_half_or_none_of_what_is_left(wish, expected):
    assert make(start=2.0, targets=(3.0,), first=wish).choose_dt(2.0) == expected


@pytest.mark.parametrize("error", [1.01 * REJECTED, 10.0, 1e9, math.inf])
def test_rejected_steps_shrink_the_more_the_larger_their_error(error):
    control, lengths = make(), [1.0]
    for _ in range(5):
        assert not control.accepts(error, 2, lengths[-1])
        lengths.append(control.choose_dt(0.0))
    factors = [later / earlier for earlier, later in itertools.pairwise(lengths)]
    expected = 0.7 if error < 2.0 else max(SMALLEST_FACTOR, SAFETY * error ** (-1 / 3))
    assert factors == pytest.approx([expected] * 5, rel=1e-12)  # rounding of a root


@pytest.mark.parametrize(("error", "factor"), [
    *((error, LARGEST_FACTOR) for error in (0.0, 1e-30, 1e-9)),
    # the error of a step grows as the cube of its length: the next one would meet the tolerance with a margin
    *((error, SAFETY * error ** (-1 / 3)) for error in (0.2, 0.5, 1.0, REJECTED)),
])  # fmt: skip
def test_accepted_steps_grow_within_bounds(error, factor):
    control = make()
    assert control.accepts(error, 2, 1.0)
    assert control.dt_next == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(("left", "parts"), [(0.3, 1), (0.6, 1), (1.5, 2)])
def test_a_step_cut_for_a_target_does_not_shorten_the_next(left, parts):
    control, time = make(targets=(left, 9.0), first=1.0), 0.0
    for _ in range(parts):
        length = control.choose_dt(time)
        assert length == pytest.approx(left / parts, rel=1e-12)
        assert control.accepts(1e-9, 2, length)
        time = control.end(time, length)
        control.step_taken(time, 0.0)
    assert time == left
    assert control.choose_dt(time) >= 1.0


@pytest.mark.parametrize(("error", "accepted"), [(1.4, True), (2.0, False)])
def test_a_cut_step_with_a_large_error_shortens_the_next(error, accepted):
    control = make(targets=(0.3, 5.0), first=1.0)
    assert control.choose_dt(0.0) == 0.3
    assert control.accepts(error, 2, 0.3) == accepted
    assert control.dt_next < 0.3


def test_the_strain_of_a_step_is_limited():
    control = make(largest_strain=0.5)
    control.step_taken(0.5, 0.0)
    assert control.dt_next == 1.0  # a uniform flow has no strain
    control.step_taken(1.0, 10.0)
    assert control.dt_next == 0.5 / 10.0
    control.step_taken(2.0, 1.0)
    assert control.dt_next == 0.5 / 10.0  # a limit: steps do not grow with it at once


def test_fixed_steps_heed_neither_error_nor_strain():
    control = make(fixed=0.25, targets=(1.0, 1.9, 2.4), largest_strain=1e-3)
    times, lengths = walk(control, natural=1e-3, gradient=100.0)
    assert times[:4] == [0.25, 0.5, 0.75, 1.0]
    # on the way to a target they are as given, but for the last two: 0.9 is 3 steps and a remainder
    assert lengths[4:] == pytest.approx([0.25, 0.25, 0.2, 0.2, 0.25, 0.25], rel=1e-12)  # rounding of the times


@pytest.mark.parametrize(("taken", "same"), [(0, True), (10, True), (19, True), (20, False), (21, False)])
def test_new_targets_report_whether_old_ones_have_cut_a_step(taken, same):
    # steps of 0.1 to a target at 1 in both, then to the old end at 2.05, where the last two are cut
    old, fresh = make(targets=(1.0, 2.05), fixed=0.1), make(targets=(1.0, 5.0), fixed=0.1)
    times = [0.0, 0.0]
    for _ in range(taken):
        for k, control in enumerate((old, fresh)):
            times[k] = control.end(times[k], control.choose_dt(times[k]))
            control.step_taken(times[k], 0.0)
    assert (times[0] == times[1]) == same
    assert old.set_targets((1.0, 5.0), times[0]) == same
    if same:
        assert old.host_state() == fresh.host_state()
    assert walk(old, times[0])[0][-1] == 5.0


def test_multistep_steps_grow_by_half_at_most_and_land_on_every_target():
    control = make_multistep([0.33, 1.0, 1.5], 0.002, 1e-3)
    time, met, before = 0.0, [], math.inf
    while not control.finished:
        dt = control.choose_dt(time)
        assert dt <= LARGEST_MULTISTEP_FACTOR * before * (1 + 1e-12)
        assert dt <= 0.1 * (1 + 1e-12)
        assert control.accepts(0.0, 3, dt, 0.0)
        time, before, left = control.end(time, dt), dt, len(control.targets)
        control.step_taken(time, 0.1)
        if len(control.targets) < left:
            met.append(time)
    assert met == [0.33, 1.0, 1.5]


def test_steps_end_where_walls_jump_whatever_the_targets():
    control = make_multistep([1.0], 0.2, None, jump_times=(0.4, 3.0))
    assert control.targets == [0.4, 1.0]
    assert control.choose_dt(0.0) == pytest.approx(0.4 / 2)
    assert control.set_targets([2.0, 4.0], 1.0)  # what cut steps was no end of the run
    assert control.targets == [2.0, 3.0, 4.0]


def test_a_multistep_step_with_a_large_error_is_repeated_shorter():
    control = make_multistep([10.0], 0.02, 1e-3)
    dt = control.choose_dt(0.0)
    assert not control.accepts(1.6e-2, 3, dt, 0.0)
    assert control.choose_dt(0.0) == pytest.approx(0.9 * 0.5 * dt, rel=1e-12)
    control.fixed = True
    assert control.accepts(1e3, 3, dt, 0.0)


def test_an_error_due_to_the_spacing_is_accepted():
    control = make_multistep([10.0], 0.02, 1e-3)
    for error, accepted in ((1e-2, False), (9e-3, True)):
        assert control.accepts(error, 3, control.choose_dt(0.0), 0.0) == accepted
    assert not control.accepts(9e-3, 3, control.choose_dt(0.0))


def test_the_tolerance_is_at_least_a_share_of_the_spatial_error():
    control = make_multistep([10.0], 0.02, 1e-6)
    dt = control.choose_dt(0.0)
    assert control.accepts(1e-3, 3, dt, 1e-3 / SHARE)
    assert control.choose_dt(0.0) == pytest.approx(0.9 * dt, rel=0.1)  # steps of one length up to the target
    assert not control.accepts(1e-3, 3, dt, 0.0)


def test_balanced_tolerances_follow_the_spatial_error():
    control = make_multistep([1000.0], 1.0, 1e-3)
    control.balanced = lambda unresolved: unresolved**2
    for unresolved, accepted in ((1e-3, False), (1e-2, True)):  # tolerances of 1e-6 and 1e-4
        assert control.accepts(1e-4, 3, control.choose_dt(0.0), unresolved) == accepted


@pytest.mark.parametrize(("most", "least"), [(TOLERANCE, 0.1 * TOLERANCE), (3e-5, 0.1 * TOLERANCE), (6e-8, 6e-9)])
def test_balanced_steps_have_the_wanted_part_of_the_spatial_error(most, least):
    balanced = balanced_tolerance(most, 0.5)
    middle = math.sqrt(most * least)
    unresolved = TIME_ERROR * middle**TIME_POWER / (0.5 * SPACING_ERROR)
    assert balanced(unresolved) == pytest.approx(middle)
    assert (balanced(0.0), balanced(1.0)) == pytest.approx((least, most))


def test_attempts_are_taken_until_one_is_accepted():
    control, lengths = make(targets=(100.0,)), []

    def attempt(dt):
        lengths.append(dt)
        return (math.inf if dt > 0.9 else 8.0 * dt**3), 2

    dt, error = control.take(0.0, attempt)
    # half the length after an infinite error
    assert lengths == [1.0, 0.5]
    assert (dt, error, control.rejected) == (0.5, 1.0, 1)


def test_a_step_that_is_never_short_enough_has_no_length():
    control = make(targets=(100.0,))
    assert control.take(0.0, lambda dt: (1e3, 2)) == (None, 1e3)
    assert control.rejected == MOST_ATTEMPTS


def walk_plan(plan, limit):
    times, lengths = [], []
    while length := plan.next(limit):
        times.append(plan.time)
        lengths.append(length)
    return times, lengths


@given(TARGETS, st.floats(0.01, 3.0))
def test_plans_hit_every_target_exactly_within_the_limit(targets, limit):
    times, lengths = walk_plan(StepPlan(0.0, targets), limit)
    assert set(targets) <= set(times)
    assert times[-1] == targets[-1]
    assert max(lengths) <= limit * (1 + 1e-12)  # the slack that saves a step of rounding size


def test_a_new_limit_changes_the_steps_left_and_round_off_costs_none():
    assert len(walk_plan(StepPlan(0.0, [0.3]), 0.1)[0]) == 3
    plan = StepPlan(0.0, [1.0])
    assert plan.next(0.5) == 0.5
    assert plan.next(0.1) == pytest.approx(0.1)
    assert plan.next(2.0) == pytest.approx(0.4)
    assert plan.next(2.0) == 0.0


@pytest.mark.parametrize(("taken", "same"), [(2, True), (3, True), (4, False), (9, False), (10, False)])
def test_new_targets_report_whether_steps_aimed_at_old_ones(taken, same):
    # three steps to 0.3, which is a target in both, and seven to the old end
    plan, fresh = StepPlan(0.0, [0.3, 1.0]), StepPlan(0.0, [0.3, 5.01])
    first = [(plan.next(0.1), fresh.next(0.1)) for _ in range(taken)]
    assert plan.aim([0.3, 5.01]) == same
    assert all(one == other for one, other in first) == same
    rest = walk_plan(plan, 0.1)
    assert rest[0][-1] == 5.01
    assert max(rest[1]) <= 0.1 * (1 + 1e-12)  # the slack that saves a step of rounding size
    if same:
        assert rest == walk_plan(fresh, 0.1)
