"""Verdicts of the stability matrix, from summaries as runs leave them."""

from dataclasses import replace

import pytest

from tisph.studies import stability_judge as judge
from tisph.studies.stability import REFUSED, Cell, Plan

PLAN = Plan(Cell(jitter=0.3), {}, t_star=1.0)
BASELINE = (4e-4, 3e-4, 2e-4, 1e-4)
SOUND = {"transverse": (1e-5,) * 4, "density": (1e-5,) * 4}


def summary(errors=BASELINE, status="done", transverse=SOUND["transverse"], density=SOUND["density"], speed=2.0):
    samples = [
        {"l2": error, "rms": 0.5 * error, "max_transverse_velocity": speed * cross, "density_variation": vary}
        for error, cross, vary in zip(errors, transverse, density, strict=True)
    ]
    return {"status": status, "samples": samples, "numbers": {"reference_velocity": speed}}


def verdict(found=None, plan=PLAN, message="", baseline=None, **values):
    return judge.judge(plan, found or summary(**values), message, baseline or summary())


def times(factor, errors=BASELINE):
    return tuple(factor * error for error in errors)


def test_a_run_like_its_baseline_is_stable():
    found = verdict(errors=times(1.5))
    assert (found.verdict, found.reason, found.met) == ("stable", "", True)
    assert found.ratio == pytest.approx(1.5, rel=1e-12)
    assert found.transverse_velocity == pytest.approx(1e-5, rel=1e-12)


@pytest.mark.parametrize(
    ("why", "values"),
    [
        ("times that of the baseline", {"errors": times(3.0)}),
        ("transverse velocity 2.0e-03", {"transverse": (2e-3,) * 4}),
        ("density varies", {"density": (2e-2,) * 4}),
        ("transverse velocity grows", {"transverse": (1e-5, 1e-5, 1e-4, 5e-4)}),
        ("baseline grows", {"errors": (1e-4, 1e-4, 0.5e-4, 1.5e-4)}),
    ],
)
def test_a_run_beyond_one_bound_is_inaccurate_and_says_which(why, values):
    found = verdict(**values)
    assert (found.verdict, found.met) == ("inaccurate", False)
    assert why in found.reason
    assert ";" not in found.reason  # nothing but that


def test_a_transverse_velocity_that_falls_is_no_growth():
    assert verdict(transverse=(9e-3, 7e-3, 2e-3, 9e-4)).verdict == "stable"


def test_before_the_flow_has_forgotten_the_disorder_more_is_allowed():
    early = replace(PLAN, t_star=0.1, warnings=("may go wrong",))
    assert verdict(plan=early, transverse=(5e-3,) * 4).verdict == "stable"
    assert verdict(plan=early, transverse=(2e-2,) * 4).verdict == "inaccurate"
    baseline = summary(errors=(3e-3,) * 4)
    for errors, wanted in ((0.029, "stable"), (0.0301, "inaccurate")):
        assert verdict(plan=early, errors=(errors,) * 4, baseline=baseline).verdict == wanted
    tiny = summary(errors=(1e-5,) * 4)
    for errors, wanted in ((0.009, "stable"), (0.011, "inaccurate")):
        assert verdict(plan=early, errors=(errors,) * 4, baseline=tiny).verdict == wanted


def test_errors_below_the_floor_are_not_compared():
    """A flow that the baseline run has exactly; the floor of the explicit scheme and of single precision is higher."""
    tiny = (1e-8,) * 4
    implicit = replace(PLAN, cell=replace(PLAN.cell, scheme="implicit 4"))
    for plan, error, wanted in (
        (PLAN, 3.9e-5, "stable"),
        (PLAN, 4.1e-5, "inaccurate"),
        (implicit, 1.1e-6, "inaccurate"),
    ):
        assert verdict(errors=(error,) * 4, baseline=summary(errors=tiny), plan=plan).verdict == wanted
    single = replace(PLAN, cell=replace(PLAN.cell, precision="f32"))
    assert verdict(errors=times(1e4, tiny), baseline=summary(errors=tiny), plan=single).verdict == "stable"


def test_errors_are_compared_only_where_stability_is_required():
    tiny = (1e-8,) * 4
    for across, wanted in ((25, "inaccurate"), (8, "stable")):
        plan = replace(PLAN, cell=replace(PLAN.cell, across=across))
        assert verdict(errors=times(1e5, tiny), baseline=summary(errors=tiny), plan=plan).verdict == wanted


def test_a_baseline_is_held_to_the_predicted_error():
    baseline = replace(PLAN, cell=Cell(scheme="implicit 4"), predicted=1e-3)
    for factor, wanted in ((2.0, "stable"), (4.0, "inaccurate")):
        own = summary(errors=(factor * baseline.predicted,) * 4)
        assert verdict(own, plan=baseline, baseline=own).verdict == wanted
        assert verdict(own, plan=replace(baseline, predicted=None), baseline=own).verdict == "stable"


def test_a_large_error_without_warning_is_a_silent_failure():
    found = verdict(errors=(0.03,) * 4)
    assert (found.verdict, found.met) == ("silent failure", False)
    assert "no warning" in found.reason


def test_a_warning_excuses_more_but_not_everything():
    warned = replace(PLAN, warnings=("may go wrong",))
    assert verdict(errors=(0.19,) * 4, plan=warned).verdict == "inaccurate"
    assert verdict(errors=(0.21,) * 4, plan=warned).verdict == "silent failure"


def test_a_run_that_diverged_with_a_message_is_stopped():
    found = verdict(
        errors=BASELINE[:2], status="diverged", message="y of particle 7", transverse=(0,) * 2, density=(0,) * 2
    )
    assert (found.verdict, found.reason, found.met) == ("stopped", "y of particle 7", False)
    assert found.baseline_error == BASELINE[1]  # of the last sample that there is
    flagged = replace(PLAN, cell=replace(PLAN.cell, across=8))
    assert verdict(found=summary(status="diverged"), plan=flagged, message="y").met is True


@pytest.mark.parametrize(
    ("status", "message"), [("failed", "Segmentation fault"), ("interrupted", ""), ("diverged", "")]
)
def test_a_run_that_ends_without_a_clear_error_is_a_silent_failure(status, message):
    found = verdict({"status": status, "samples": []}, message=message)
    assert (found.verdict, found.met) == ("silent failure", False)
    assert (message or status) in found.reason


def test_a_run_whose_baseline_stopped_is_judged_alone():
    found = verdict(baseline={"status": "diverged", "samples": []})
    assert (found.verdict, found.baseline_error, found.ratio) == ("stable", None, None)


def test_flows_that_cross_zero_are_judged_by_the_rms():
    found = verdict(plan=replace(PLAN, cell=Cell(flow="backflow", jitter=0.1)))
    assert found.error == 0.5 * BASELINE[-1]


def test_what_has_to_finish_may_be_inaccurate_and_not_grow():
    plan = replace(PLAN, cell=Cell(reynolds=10000.0, jitter=0.1))
    steady = verdict(transverse=(5e-3,) * 4, plan=plan)
    assert (steady.verdict, steady.met) == ("inaccurate", True)
    growing = verdict(transverse=(1e-5, 1e-5, 1e-4, 5e-4), plan=plan)
    assert (growing.verdict, growing.met) == ("inaccurate", False)
    assert verdict(found=summary(status="diverged"), plan=plan, message="y").met is False


@pytest.mark.parametrize(
    ("cell", "kept"),
    [
        (Cell(), False),
        (Cell(reynolds=10000.0), False),
        (Cell(across=8), True),
        (Cell(flow="taylor_green", scheme="implicit 2"), True),
    ],
)
def test_a_refusal_misses_only_the_requirement_of_a_stable_run(cell, kept):
    found = judge.refused(Plan(cell, {}, 1.0, refusal="too small"))
    assert (found.verdict, found.reason, found.met) == ("refused", "too small", kept)


class Refused(Cell):
    """A cell that should be refused."""

    requirement = REFUSED


def test_what_should_have_been_refused_and_ran_misses_its_requirement():
    plan = replace(PLAN, cell=Refused())
    own = summary()
    assert verdict(own, plan=plan, baseline=own).met is False
