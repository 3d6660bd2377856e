"""Verdicts of the stability matrix, of channels and of two-dimensional flow."""

from dataclasses import replace

import pytest

from tisph.studies import stability_judge as judge
from tisph.studies.stability import Cell, Plan

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


VORTEX = Plan(Cell(flow="taylor_green", scheme="implicit 4", t_star=2.0), {}, t_star=2.0)
LAYER = replace(VORTEX, cell=replace(VORTEX.cell, flow="shear_layer"))
CYLINDERS = replace(VORTEX, cell=replace(VORTEX.cell, flow="annulus0.5", across=12))
BODY = replace(VORTEX, cell=replace(VORTEX.cell, flow="cylinder2", across=16))
GOOD = {"rms": 1e-3, "density_variation": 0.0, "max_void_radius": 0.8, "min_distance": 0.75}


def verdict_of(plan=VORTEX, energies=(0.25, 0.2, 0.15, 0.1), **last):
    samples = [{**GOOD, "kinetic_energy": energy} for energy in energies]
    samples[-1].update(last)
    found = {"status": "done", "samples": samples, "numbers": {"reference_velocity": 1.0}}
    return judge.judge(plan, found, "", found)


@pytest.mark.parametrize("plan", [VORTEX, LAYER])
@pytest.mark.parametrize(
    ("why", "values"),
    [
        ("a void has a radius of 1.16 spacings", {"max_void_radius": 1.16}),
        ("two particles are 0.54 spacings apart", {"min_distance": 0.54}),
        ("energy grows by 2.0e-03", {"kinetic_energy": 0.15 * 1.002}),
    ],
)
def test_two_dimensional_runs_beyond_one_bound_are_inaccurate_and_say_which(plan, why, values):
    found = verdict_of(plan, **values)
    assert (found.verdict, found.met) == ("inaccurate", False)
    assert why in found.reason
    assert ";" not in found.reason


@pytest.mark.parametrize(("across", "t_star", "largest"), [(25, 2.0, 2e-3), (50, 2.0, 2.5e-4), (25, 0.5, 1e-3)])
def test_errors_may_grow_with_time_and_have_to_fall_with_the_spacing(across, t_star, largest):
    plan = replace(VORTEX, cell=replace(VORTEX.cell, across=across, t_star=t_star), t_star=t_star)
    assert verdict_of(plan, rms=0.99 * largest).verdict == "stable"
    assert verdict_of(plan, rms=1.01 * largest).verdict == "inaccurate"


def compared(drags, resolved, fine=None):
    """Judgement of samples with these ``drags`` by number of the body, against ``fine``, all ones."""
    cell = Cell(flow="pair3", across=24, scheme="implicit 4")
    names = ("drag_0", "drag_1")
    own = [
        {**GOOD, **dict(zip(names, each, strict=True)), "drag_top": 9.0, "resolved": said}
        for each, said in zip(drags, resolved, strict=True)
    ]
    summary = {"status": "done", "samples": own, "numbers": {"reference_velocity": 1.0}}
    exact = {**summary, "samples": [dict.fromkeys((*names, "drag_top"), 1.0) for _ in own]}
    return judge.judge(replace(VORTEX, cell=cell), summary, "", exact)


def test_drags_are_compared_with_those_of_twice_the_particles():
    """Around bodies; the worst of them counts, above 2 % as a silent failure where a sample is resolved."""
    found = compared([(1.0, 1.0), (1.0, 0.981)], (True, True))
    assert (found.verdict, found.error) == ("stable", pytest.approx(0.019))
    found = compared([(1.0, 1.0), (1.021, 1.0)], (True, True))
    assert (found.verdict, found.met) == ("silent failure", False)
    assert compared([(1.0, 1.0), (1.5, 1.0)], (True, False)).verdict == "inaccurate"
    assert compared([(1.0, 1.021), (1.0, 1.0)], (True, True)).verdict == "silent failure"
    assert compared([(1.0, 1.021), (1.0, 1.0)], (False, True)).verdict == "stable"


def test_velocities_of_free_bodies_are_compared_with_the_fastest_flow():
    """Here that is the mean one: a heavy body hardly moves."""
    cell = Cell(flow="sheared1000_4", across=24, scheme="implicit 4")
    fine = {**GOOD, "u_0": 0.01, "v_0": 0.0, "angular_velocity_0": 0.2, "superficial_velocity": 0.5}
    baseline = {"status": "done", "samples": [fine] * 4, "numbers": {"reference_velocity": 1.0}}
    for off, wanted in ((9e-3, "stable"), (11e-3, "silent failure")):
        own = {**baseline, "samples": [fine, fine, fine, {**fine, "u_0": 0.01 + off}]}
        found = judge.judge(replace(VORTEX, cell=cell), own, "", baseline)
        assert (found.verdict, found.error) == (wanted, pytest.approx(off / 0.5))


def test_both_stresses_of_a_suspension_have_to_agree():
    cell = Cell(flow="suspension1_0.2_4", across=24, scheme="implicit 4")
    for stress, said, wanted in ((1.019, True, "stable"), (1.021, True, "silent failure"), (1.1, False, "inaccurate")):
        sample = {**GOOD, "shear_stress_walls": 1.0, "shear_stress_bodies": stress, "resolved": said}
        run = {"status": "done", "samples": [sample] * 4, "numbers": {"reference_velocity": 1.0}}
        assert judge.judge(replace(VORTEX, cell=cell), run, "", run).verdict == wanted


def test_velocity_and_loads_in_a_pipe_have_to_be_exact():
    """Where a sample says that it is resolved; loads by a shear rate of 1 over a period of 1, or the largest."""
    cell = Cell(flow="swirl0.5", reynolds=1.0, across=12, scheme="implicit 4")
    for l2, torque, said, wanted in (
        (9e-3, 10.09, True, "stable"),
        (1.9e-2, 10.0, True, "inaccurate"),
        (2.1e-2, 10.0, True, "silent failure"),
        (1e-3, 10.21, True, "silent failure"),
        (1e-3, 10.21, False, "inaccurate"),
    ):
        loads = {"torque_outer": torque, "torque_outer_exact": 10.0, "force_outer": 0.0, "force_outer_exact": 0.0}
        sample = {**GOOD, **loads, "l2": l2, "resolved": said}
        run = {"status": "done", "samples": [sample] * 4, "numbers": {"reference_velocity": 1.0}}
        assert judge.judge(replace(VORTEX, cell=cell), run, "", run).verdict == wanted


def test_torque_and_radial_velocity_of_vortices_are_compared():
    cell = Cell(flow="vortices0.5", across=13, scheme="implicit 4")
    fine = {**GOOD, "torque_inner": -2.0, "radial_velocity": 0.1}
    baseline = {"status": "done", "samples": [fine] * 4, "numbers": {"reference_velocity": 1.0}}
    for changes, error in (({"torque_inner": -2.02}, 0.01), ({"radial_velocity": 0.13}, 0.03)):
        own = {**baseline, "samples": [fine, fine, fine, {**fine, **changes}]}
        found = judge.judge(replace(VORTEX, cell=cell), own, "", baseline)
        assert (found.verdict, found.error) == ("stable" if error < 0.02 else "silent failure", pytest.approx(error))


def test_between_walls_energy_may_grow_and_errors_fall_with_spacing():
    assert verdict_of(CYLINDERS, energies=(0.1, 0.2, 0.3, 0.4), l2=0.9e-3).verdict == "stable"
    found = verdict_of(CYLINDERS, l2=1.1e-3)
    assert (found.verdict, found.reason) == ("inaccurate", "error 1.1e-03 U")
    fine = replace(CYLINDERS, cell=replace(CYLINDERS.cell, across=24))
    assert verdict_of(fine, l2=1.1e-3 / 8).verdict == "inaccurate"
    assert verdict_of(CYLINDERS, l2=0.21).verdict == "silent failure"


@pytest.mark.parametrize(("before", "expected"), [(0.5, 0.1 / 0.9), (0.48, None)])
def test_forces_that_are_steady_have_to_balance(before, expected):
    drags = {"drag_bottom": 0.5, "drag_top": -0.9, "drag_pressure": 7.0, "drag_pressure_top": 7.0}
    samples = [{**GOOD, "t": t, "drag": drag, **drags} for t, drag in zip((1.0, 2.0), (before, 0.5), strict=True)]
    summary = {"status": "done", "samples": samples, "numbers": {}}
    found = judge.judge(BODY, summary, "", summary)
    assert found.error == (expected and pytest.approx(expected))
    assert found.verdict == ("inaccurate" if expected else "stable")
