"""The error that `tisph check` states of every sample: how layers of the lattice tell it, and its limits.

That it is right is held by ``tests/cli/test_check.py``, against runs.
"""

import math

import numpy as np
import pytest

from tisph import scenes
from tisph.schemes._estimate import EXPLICIT_COST, IMPLICIT_COST, IMPLICIT_OVERHEAD, least_squares, profile_lost
from tisph.schemes._forecast import estimates

EXPLICIT, IMPLICIT = "scheme={type: wcsph}", "scheme={type: implicit}"
COARSE = "discretisation.particles_across=25"
DISORDER = "initial.jitter=0.3"
OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.1}"
"""The flow of the case: gap 1, wall speed 0.5, nu = 0.01, 50 across, one sample at the end, t = 2."""


@pytest.fixture
def last(case):
    """Return a function that gives the estimates of the last sample of the case with overrides."""
    return lambda *overrides: estimates(case(*overrides))["samples"][-1]


@pytest.mark.parametrize("order", [2, 4])
def test_least_squares_weights_are_exact_up_to_their_order(order):
    laplacian, across = least_squares(order)
    y = np.arange(len(laplacian)) - len(laplacian) // 2
    for power in range(1, order + 1):
        assert laplacian @ y**power == pytest.approx(2.0 * (power == 2), abs=1e-12)
        assert across @ y**power == pytest.approx(float(power == 1), abs=1e-12)


def test_of_a_long_run_steps_are_counted_and_no_error_is_stated(case):
    """The flow of a wall that oscillates is never steady; steps go on as before."""
    wall = "walls.top={amplitude: 0.5, angular_frequency: 1.0, phase: sin}"
    first, last = estimates(case(IMPLICIT, COARSE, wall, "time.end=1e6", "time.samples=[10, 1e6]"))["samples"]
    assert first.rms is not None
    assert last.rms is None
    assert last.steps > 1e5


def test_a_flow_that_is_steady_keeps_its_error(case):
    numbers = estimates(case(IMPLICIT, COARSE, "time.samples=[1e4, 1e8]", "time.end=1e8"))
    before, after = numbers["samples"]
    assert (before.l2, before.at_most) == (after.l2, after.at_most)
    assert after.at_most  # the layers' own is round-off, and linear systems are solved to a part of the tolerance


@pytest.mark.timeout(120)  # it takes a tenth of a second, or weeks
def test_the_end_of_a_long_run_is_told_at_once(case):
    """Steps are not taken one by one."""
    for scheme in (EXPLICIT, IMPLICIT):
        assert estimates(case(scheme, "time.end=1e12"))["steps"] > 1e11


def test_the_error_falls_with_the_order_of_the_operators(last):
    """In the spacing, where no other error counts; 4 and 2 for a layer of five spacings and more."""
    tight = ("time.tolerance=1e-8", "time.samples=[2]", "time.end=2")
    for scheme, order in ((IMPLICIT, 4), (IMPLICIT.replace("}", ", operators: {order: 2}}"), 2)):
        coarse, fine = (last(scheme, *tight, f"discretisation.particles_across={n}").rms for n in (25, 50))
        assert math.log2(coarse / fine) == pytest.approx(order, abs=0.5)


def test_the_error_of_finer_layers_is_the_error_of_the_steps(last, monkeypatch):
    late = (IMPLICIT, "time.samples=[10]", "time.end=10", "time.tolerance=1e-4")
    full = last(*late)
    monkeypatch.setattr("tisph.schemes._estimate.MOST_LAYERS", {"newtonian": 25})
    assert last(*late).rms == pytest.approx(full.rms, rel=0.5)  # steps differ with the layers


@pytest.mark.parametrize("overrides", [(EXPLICIT,), (IMPLICIT, DISORDER), (IMPLICIT, "discretisation.precision=f32")])
def test_no_error_is_stated_of_what_layers_do_not_know(last, overrides):
    sample = last(*overrides)
    assert (sample.l2, sample.rms) == (None, None)
    assert sample.steps > 0


@pytest.mark.parametrize(("reynolds", "t", "lost"), [(60.6, 0.1, True), (59.4, 0.1, False), (60.6, 1.0, False)])
def test_the_profile_is_lost_where_layers_mix_too_much(case, reynolds, t, lost):
    """Cell Reynolds numbers around STABLE_CELL_RE; layers of a seventh of a spacing, or half of one."""
    config = case(EXPLICIT, COARSE, f"fluid.kinematic_viscosity={0.5 * 0.04 / reynolds}", f"time={{end: {t}}}")
    channel = scenes.of(config)
    assert profile_lost(config, channel) == lost


@pytest.mark.parametrize(
    ("scheme", "cost", "overhead"), [(EXPLICIT, EXPLICIT_COST, 0.0), (IMPLICIT, IMPLICIT_COST, IMPLICIT_OVERHEAD)]
)
def test_steps_and_cost_of_a_run_end_at_its_last_sample(case, scheme, cost, overhead):
    numbers = estimates(case(scheme, COARSE, "time.end=2", "time.samples=[0, 1, 2]"))
    assert numbers["samples"][-1].steps == numbers["steps"]
    assert numbers["run_time"] == pytest.approx(numbers["steps"] * (overhead + 25 * 50 * cost), rel=1e-14)
    assert numbers["samples"][0].steps == 0
    if scheme == IMPLICIT:
        assert numbers["samples"][0].rms == 0.0
        brief = case(scheme, COARSE, "time={end: 1.0e-3}")
        assert 0.0 < estimates(brief)["time_step"] <= 1e-3  # the longest of the run


@pytest.mark.parametrize(("viscosity", "known"), [(0.0205, True), (0.0195, False)])  # 9.8, 10.3
def test_steps_of_disordered_polymer_in_a_thin_solvent_are_a_guess(case, viscosity, known):
    flow = case(IMPLICIT, COARSE, OLDROYD_B, f"fluid.kinematic_viscosity={viscosity}", DISORDER)
    assert estimates(flow)["samples"][-1].steps_reliable == known
