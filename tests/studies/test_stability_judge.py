"""Verdicts of the stability matrix, of channels and of two-dimensional flow."""

from dataclasses import replace

import pytest

from tisph.studies import stability_judge as judge
from tisph.studies.stability import Cell, Plan

CHANNEL = Plan(Cell(jitter=0.3), {}, t_star=1.0)
ERRORS = (4e-4, 3e-4, 2e-4, 1e-4)
GOOD = {"rms": 1e-3, "density_variation": 0.0, "max_void_radius": 0.8, "min_distance": 0.75}
ENERGIES = (0.25, 0.2, 0.15, 0.1)
EARLY = replace(CHANNEL, t_star=0.1, warnings=("may go wrong",))
PREDICTED = replace(CHANNEL, cell=Cell(scheme="implicit 4"), predicted=1e-3)


def summary(errors=ERRORS, transverse=(1e-5,) * 4, density=(1e-5,) * 4, status="done"):
    """A run in a channel whose walls have the speed 2."""
    samples = [
        {"l2": error, "rms": 0.5 * error, "max_transverse_velocity": 2.0 * cross, "density_variation": vary}
        for error, cross, vary in zip(errors, transverse, density, strict=True)
    ]
    return {"status": status, "samples": samples, "numbers": {"reference_velocity": 2.0}}


def times(factor, errors=ERRORS):
    return tuple(factor * error for error in errors)


def of(flow, across=25, t_star=2.0, **others):
    """The plan of a two-dimensional flow."""
    return Plan(Cell(flow=flow, scheme="implicit 4", across=across, t_star=t_star, **others), {}, t_star=t_star)


def planar(before=None, **sample):
    """A two-dimensional run of speed 1 with this last sample, others ``before`` it, or four alike."""
    early = {**GOOD, **(sample if before is None else before)}
    samples = [early, early, early, {**GOOD, **sample}]
    return {"status": "done", "samples": samples, "numbers": {"reference_velocity": 1.0}}


def decaying(energies=ENERGIES, **last):
    samples = [{**GOOD, "kinetic_energy": energy} for energy in energies]
    return {"status": "done", "samples": [*samples[:3], {**samples[3], **last}], "numbers": {"reference_velocity": 1.0}}


def with_f32(plan):
    return replace(plan, cell=replace(plan.cell, precision="f32"))


STILL, IMPLICIT = (1e-8,) * 4, replace(CHANNEL, cell=replace(CHANNEL.cell, scheme="implicit 4"))
JUDGED_IN_CHANNELS = [
    # plan, run, baseline, verdict, the one reason
    (CHANNEL, summary(times(1.5)), summary(), "stable", ""),
    (CHANNEL, summary(times(3.0)), summary(), "inaccurate", "times that of the baseline"),
    (CHANNEL, summary(transverse=(2e-3,) * 4), summary(), "inaccurate", "transverse velocity 2.0e-03"),
    (CHANNEL, summary(density=(2e-2,) * 4), summary(), "inaccurate", "density varies"),
    (CHANNEL, summary(transverse=(1e-5, 1e-5, 1e-4, 5e-4)), summary(), "inaccurate", "transverse velocity grows"),
    (CHANNEL, summary((1e-4, 1e-4, 0.5e-4, 1.5e-4)), summary(), "inaccurate", "baseline grows"),
    # before the flow has forgotten the disorder more is allowed
    (EARLY, summary(transverse=(5e-3,) * 4), summary(), "stable", ""),
    (EARLY, summary(transverse=(2e-2,) * 4), summary(), "inaccurate", ""),
    (EARLY, summary((0.029,) * 4), summary((3e-3,) * 4), "stable", ""),
    (EARLY, summary((0.0301,) * 4), summary((3e-3,) * 4), "inaccurate", ""),
    (EARLY, summary((0.009,) * 4), summary((1e-5,) * 4), "stable", ""),
    (EARLY, summary((0.011,) * 4), summary((1e-5,) * 4), "inaccurate", ""),
    # errors below the floor, higher of the explicit scheme and of single precision, are not compared
    (CHANNEL, summary((3.9e-5,) * 4), summary(STILL), "stable", ""),
    (CHANNEL, summary((4.1e-5,) * 4), summary(STILL), "inaccurate", ""),
    (IMPLICIT, summary((1.1e-6,) * 4), summary(STILL), "inaccurate", ""),
    (with_f32(CHANNEL), summary(times(1e4, STILL)), summary(STILL), "stable", ""),
    # a baseline is held to the predicted error
    (PREDICTED, summary((2e-3,) * 4), None, "stable", ""),
    (PREDICTED, summary((4e-3,) * 4), None, "inaccurate", ""),
    (replace(PREDICTED, predicted=None), summary((4e-3,) * 4), None, "stable", ""),
    (CHANNEL, summary((0.03,) * 4), summary(), "silent failure", "no warning"),
]

FREE = {"u_0": 0.01, "v_0": 0.0, "angular_velocity_0": 0.2, "superficial_velocity": 0.5}
ROLLS = {"torque_inner": -2.0, "radial_velocity": 0.1}
ONES = dict.fromkeys(("drag_0", "drag_1", "drag_top"), 1.0)


def loads(l2, torque, said):
    exact = {"torque_outer_exact": 10.0, "force_outer": 0.0, "force_outer_exact": 0.0}
    return planar(l2=l2, torque_outer=torque, resolved=said, **exact)


def drags(first, last, said=(True, True)):
    """Drags of two bodies, and of a wall, which does not count, at first and at last."""
    names = ("drag_0", "drag_1")
    early, late = (
        {**dict(zip(names, each, strict=True)), "drag_top": 9.0, "resolved": resolved}
        for each, resolved in zip((first, last), said, strict=True)
    )
    return planar(early, **late)


def stresses(bodies, said):
    return planar(shear_stress_walls=1.0, shear_stress_bodies=bodies, resolved=said)


SUSPENSION, PIPE = of("suspension1_0.2_4", 24), of("swirl0.5", 12, reynolds=1.0)
PAIR, SHEARED, ANNULUS = of("pair3", 24), of("sheared1000_4", 24), of("annulus0.5", 12)
GROWN = (0.1, 0.2, 0.3, 0.4)
JUDGED_IN_TWO_DIMENSIONS = [
    *[
        (of(flow), decaying(**{key: value}), None, "inaccurate", why)
        for flow in ("taylor_green", "shear_layer")
        for key, value, why in (
            ("max_void_radius", 1.16, "a void has a radius of 1.16 spacings"),
            ("min_distance", 0.54, "two particles are 0.54 spacings apart"),
            ("kinetic_energy", 0.15 * 1.002, "energy grows by 2.0e-03"),
        )
    ],
    # errors may grow with time and have to fall with the spacing
    *[
        (of("taylor_green", across, t_star), decaying(rms=factor * largest), None, verdict, "")
        for across, t_star, largest in ((25, 2.0, 2e-3), (50, 2.0, 2.5e-4), (25, 0.5, 1e-3))
        for factor, verdict in ((0.99, "stable"), (1.01, "inaccurate"))
    ],
    # between walls energy may grow
    (ANNULUS, decaying(GROWN, l2=0.9e-3), None, "stable", ""),
    (ANNULUS, decaying(l2=1.1e-3), None, "inaccurate", "error 1.1e-03 U"),
    (of("annulus0.5", 24), decaying(l2=1.1e-3 / 8), None, "inaccurate", ""),
    (ANNULUS, decaying(l2=0.21), None, "silent failure", ""),
    # drags are compared with those of twice the particles; the worst one of bodies counts
    (PAIR, drags((1.0, 1.0), (1.0, 0.981)), planar(**ONES), "stable", ""),
    (PAIR, drags((1.0, 1.0), (1.021, 1.0)), planar(**ONES), "silent failure", ""),
    (PAIR, drags((1.0, 1.0), (1.5, 1.0), (True, False)), planar(**ONES), "inaccurate", ""),
    (PAIR, drags((1.0, 1.021), (1.0, 1.0)), planar(**ONES), "silent failure", ""),
    (PAIR, drags((1.0, 1.021), (1.0, 1.0), (False, True)), planar(**ONES), "stable", ""),
    # velocities of free bodies with the fastest flow, here the mean one, 0.5
    (SHEARED, planar(FREE, **{**FREE, "u_0": 0.019}), planar(**FREE), "stable", ""),
    (SHEARED, planar(FREE, **{**FREE, "u_0": 0.021}), planar(**FREE), "silent failure", ""),
    # both stresses of a suspension have to agree
    (SUSPENSION, stresses(1.019, True), None, "stable", ""),
    (SUSPENSION, stresses(1.021, True), None, "silent failure", ""),
    (SUSPENSION, stresses(1.1, False), None, "inaccurate", ""),
    # velocity and loads in a pipe have to be exact where a sample says that it is resolved
    (PIPE, loads(9e-3, 10.09, True), None, "stable", ""),
    (PIPE, loads(1.9e-2, 10.0, True), None, "inaccurate", ""),
    (PIPE, loads(2.1e-2, 10.0, True), None, "silent failure", ""),
    (PIPE, loads(1e-3, 10.21, True), None, "silent failure", ""),
    (PIPE, loads(1e-3, 10.21, False), None, "inaccurate", ""),
    # torque, and radial velocity, of vortices
    (of("vortices0.5", 13), planar(ROLLS, **{**ROLLS, "torque_inner": -2.02}), planar(**ROLLS), "stable", ""),
    (of("vortices0.5", 13), planar(ROLLS, **{**ROLLS, "radial_velocity": 0.13}), planar(**ROLLS), "silent failure", ""),
]


@pytest.mark.parametrize(
    ("plan", "run", "baseline", "verdict", "why"),
    JUDGED_IN_CHANNELS + JUDGED_IN_TWO_DIMENSIONS,
    ids=[
        f"{plan.cell.flow}-{k}-{verdict}"
        for k, (plan, _, _, verdict, _) in enumerate(JUDGED_IN_CHANNELS + JUDGED_IN_TWO_DIMENSIONS)
    ],
)
def test_a_run_has_its_verdict_and_one_reason(plan, run, baseline, verdict, why):
    found = judge.judge(plan, run, "", baseline or run)
    assert found.verdict == verdict
    assert found.met or verdict != "stable"
    if why:
        assert (why in found.reason, ";" in found.reason, found.met) == (True, False, False)


def test_the_numbers_of_a_judgement():
    found = judge.judge(CHANNEL, summary(times(1.5)), "", summary())
    assert (found.ratio, found.transverse_velocity) == (pytest.approx(1.5), pytest.approx(1e-5))
    assert judge.judge(PAIR, drags((1.0, 1.0), (1.0, 0.981)), "", planar(**ONES)).error == pytest.approx(0.019)
    moved = planar(FREE, **{**FREE, "u_0": 0.019})
    assert judge.judge(SHEARED, moved, "", planar(**FREE)).error == pytest.approx(9e-3 / 0.5)
    slower = planar(ROLLS, **{**ROLLS, "torque_inner": -2.02})
    assert judge.judge(of("vortices0.5", 13), slower, "", planar(**ROLLS)).error == pytest.approx(0.01)


FLAGGED, FINISHED = (Plan(Cell(jitter=0.3, across=8), {}, 1.0), Plan(Cell(reynolds=10000.0, jitter=0.1), {}, 1.0))


@pytest.mark.parametrize(
    ("plan", "run", "message", "verdict", "met"),
    [
        (CHANNEL, summary(ERRORS[:2], (0,) * 2, (0,) * 2, "diverged"), "y of particle 7", "stopped", False),
        (FLAGGED, summary(status="diverged"), "y", "stopped", True),
        (CHANNEL, {"status": "failed", "samples": []}, "Segmentation fault", "silent failure", False),
        (CHANNEL, {"status": "interrupted", "samples": []}, "", "silent failure", False),
        (CHANNEL, {"status": "diverged", "samples": []}, "", "silent failure", False),
        # what has to finish may be inaccurate and not grow
        (FINISHED, summary(transverse=(5e-3,) * 4), "", "inaccurate", True),
        (FINISHED, summary(transverse=(1e-5, 1e-5, 1e-4, 5e-4)), "", "inaccurate", False),
        (FINISHED, summary(status="diverged"), "y", "stopped", False),
    ],
)
def test_what_a_cell_requires_of_a_run(plan, run, message, verdict, met):
    found = judge.judge(plan, run, message, summary())
    assert (found.verdict, found.met) == (verdict, met)
    assert (message or run["status"] if "failure" in verdict else message) in found.reason
    if len(run["samples"]) == 2:
        assert found.baseline_error == ERRORS[1]  # of the last sample that there is


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


@pytest.mark.parametrize(("before", "expected"), [(0.5, 0.1 / 0.9), (0.48, None)])
def test_forces_that_are_steady_have_to_balance(before, expected):
    forces = {"drag_bottom": 0.5, "drag_top": -0.9, "drag_pressure": 7.0, "drag_pressure_top": 7.0}
    samples = [{**GOOD, "t": t, "drag": drag, **forces} for t, drag in zip((1.0, 2.0), (before, 0.5), strict=True)]
    run = {"status": "done", "samples": samples, "numbers": {}}
    found = judge.judge(of("cylinder2", 16), run, "", run)
    assert found.error == (expected and pytest.approx(expected))
    assert found.verdict == ("inaccurate" if expected else "stable")
