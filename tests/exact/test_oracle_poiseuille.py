"""Start-up Poiseuille flow: two forms, an independent solution, momentum, limits, printed values."""

import numpy as np
import pytest
from exact_collocation import chebyshev_derivatives
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import poiseuille
from scipy.linalg import expm

from tisph.exact import couette

UNIT = {"gap": 1.0, "kinematic_viscosity": 1.0, "acceleration": 1.0}
HEIGHTS = np.linspace(0.0, 1.0, 101)

times = st.floats(-4, 0.3).map(lambda exponent: 10.0**exponent)  # t* from 1e-4 to 2, both forms usable


def both_forms(function, time, switch):
    """(Images, series) of one quantity at ``time``; ``switch`` is pytest's MonkeyPatch class."""
    results = []
    for switch_time in (np.inf, 0.0):
        with switch.context() as patch:
            patch.setattr(couette, "SWITCH_TIME", switch_time)
            results.append(function(HEIGHTS, time, **UNIT))
    return results


@settings(max_examples=100, deadline=None)
@given(time=times)
def test_series_and_images_agree(time):
    images, series = both_forms(poiseuille.velocity, time, pytest.MonkeyPatch)
    # terms of the series are at most 4/pi^3, and 1/n^3 makes their rounding that of the first: 1e-16; the images
    # are 1e-16 of t* each, of which 2 + 4 sqrt(EXPONENT t*) = 37 are summed at t* = 2
    assert np.max(np.abs(images - series)) <= 2e-16 + 20 * 1.1e-16 * time
    images, series = both_forms(poiseuille.shear_rate, time, pytest.MonkeyPatch)
    # likewise, with terms of the size 4/pi^2/n^2 and sqrt(t*)
    assert np.max(np.abs(images - series)) <= 4e-16 + 20 * 1.1e-16 * np.sqrt(time)


@pytest.mark.parametrize("t_star", [0.018, 0.09, 0.11, 0.4, 1.0])
def test_against_an_independent_solution_of_the_equation(t_star):
    """Chebyshev collocation in y, matrix exponential in t: no series and no error function in it."""
    nodes, first, second = chebyshev_derivatives(48)
    inner = second[1:-1, 1:-1]
    steady = -np.linalg.solve(inner, np.ones(47))
    reference = np.concatenate([[0.0], steady - expm(t_star * inner) @ steady, [0.0]])
    # an eighth of what test_couette allows for the same matrices, since max u = 1/8 (likewise max u_y = 1/2)
    assert np.max(np.abs(poiseuille.velocity(nodes, t_star, **UNIT) - reference)) <= 2e-12 / 8
    assert np.max(np.abs(poiseuille.shear_rate(nodes, t_star, **UNIT) - first @ reference)) <= 1e-11 / 2


TABLE = {  # gap = viscosity = acceleration = 1, at y = .1 .3 .5, eight decimals
    0.1: (0.03014143, 0.06610096, 0.07691906),
    1.0: (0.04499794, 0.10499460, 0.12499333),
}


@pytest.mark.parametrize("t_star", TABLE)
def test_printed_values(t_star):
    """Values of an independent solution to eight decimals: half a unit of the last one."""
    y = np.array([0.1, 0.3, 0.5])
    assert np.max(np.abs(poiseuille.velocity(y, t_star, **UNIT) - TABLE[t_star])) <= 0.51e-8


COUETTE_POISEUILLE = {  # acceleration -8, top wall 1, at y = .1 .3 .5 .7 .9, eight decimals
    0.1: (-0.21086641, -0.41493328, -0.35259624, -0.02661642, 0.58191295),
    1.0: (-0.25999368, -0.53998345, -0.49997955, -0.13998345, 0.54000632),
}


@pytest.mark.parametrize("t_star", COUETTE_POISEUILLE)
def test_printed_values_with_a_moving_wall_and_backflow(t_star):
    """The two start-up flows superpose: half a unit of the last decimal of an independent solution."""
    y, unit = np.array([0.1, 0.3, 0.5, 0.7, 0.9]), {"gap": 1.0, "kinematic_viscosity": 1.0}
    velocity = poiseuille.velocity(y, t_star, **unit, acceleration=-8.0)
    velocity += couette.velocity(y, t_star, **unit, bottom=0.0, top=1.0)
    assert np.max(np.abs(velocity - COUETTE_POISEUILLE[t_star])) <= 0.51e-8


@pytest.mark.parametrize("t_star", [1e-3, 0.05, 0.2, 1.0])
def test_momentum_balance(t_star):
    """d/dt int u dy = nu (u_y(H) - u_y(0)) + g H."""
    points, weights = np.polynomial.legendre.leggauss(40)
    y, step = (points + 1) / 2, 1e-3 * t_star
    later, earlier = (weights @ poiseuille.velocity(y, t_star + sign * step, **UNIT) / 2 for sign in (1, -1))
    bottom, top = poiseuille.shear_rate(np.array([0.0, 1.0]), t_star, **UNIT)
    # early, int u dy = t - (8/3) t^(3/2)/sqrt(pi), and the central difference misses step^2 t^(-3/2)/(6 sqrt(pi)),
    # 1e-7 sqrt(t); 40 points resolve the layers at 1e-3 to the same
    assert (later - earlier) / (2 * step) == pytest.approx(top - bottom + 1, abs=1e-7)


def test_shear_rate_is_the_derivative_of_the_velocity():
    y, step = np.linspace(0.1, 0.9, 41), 1e-4
    for t in (0.01, 0.05, 0.2, 1.0):
        central = poiseuille.velocity(y + step, t, **UNIT) - poiseuille.velocity(y - step, t, **UNIT)
        # truncation u_yyy step^2/6 with |u_yyy| < 10 at t* = 0.01, rounding 1e-16/step
        assert np.allclose(poiseuille.shear_rate(y, t, **UNIT), central / (2 * step), rtol=0, atol=2e-8)


@given(time=times)
def test_flow_is_symmetric_about_mid_gap_and_at_rest_on_the_walls(time):
    u, rate = (function(HEIGHTS, time, **UNIT) for function in (poiseuille.velocity, poiseuille.shear_rate))
    # y/gap is rounded by 1.1e-16, times the slope rate[0] <= 113 max u at t* = 1e-4 (for rate: 89 max rate)
    assert np.max(np.abs(u - u[::-1])) <= 2e-14 * u.max()
    assert np.max(np.abs(rate + rate[::-1])) <= 2e-14 * rate[0]
    assert np.max(np.abs(u[[0, -1]])) <= 1e-15 * u.max()


def test_early_flow_is_free_fall_with_a_layer_at_each_wall():
    """At t* = 1e-4 the walls are 50 layers from mid gap; one half space gives 2 g sqrt(t/(pi nu)) at its wall."""
    assert poiseuille.velocity(0.5, 1e-4, **UNIT) == pytest.approx(1e-4, rel=1e-15)
    assert poiseuille.shear_rate(0.0, 1e-4, **UNIT) == pytest.approx(2 * np.sqrt(1e-4 / np.pi), rel=1e-14)


def test_late_flow_is_the_developed_parabola():
    """At t* = 4 the slowest mode is exp(-39) = 7e-18."""
    flow = {"gap": 0.02, "kinematic_viscosity": 3e-6, "acceleration": -0.4}
    y, t = 0.02 * HEIGHTS, 4.0 * 0.02**2 / 3e-6
    largest = 0.4 * 0.02**2 / (8 * 3e-6)
    assert poiseuille.developed_velocity(0.01, **flow) == pytest.approx(-largest, rel=1e-15)
    for moving, developed, scale in (
        (poiseuille.velocity, poiseuille.developed_velocity, largest),
        (poiseuille.shear_rate, poiseuille.developed_shear_rate, 4 * largest / 0.02),
    ):
        assert np.max(np.abs(moving(y, t, **flow) - developed(y, **flow))) <= 1e-15 * scale


def test_start_is_at_rest():
    assert poiseuille.velocity(HEIGHTS, 0.0, **UNIT).tolist() == [0.0] * 101
    assert poiseuille.shear_rate(HEIGHTS, 0.0, **UNIT).tolist() == [0.0] * 101


def test_times_and_heights_broadcast():
    """One call over a grid of heights and times, across both forms and the start, equals the single calls."""
    t = np.array([0.0, 0.02, 0.1, 0.3])
    for function in (poiseuille.velocity, poiseuille.shear_rate):
        grid = function(HEIGHTS[:, None], t[None, :], **UNIT)
        assert grid.shape == (101, 4)
        for column, time in enumerate(t):
            # the number of terms is that of the earliest or latest time: what is left out is below rounding
            assert np.allclose(grid[:, column], function(HEIGHTS, time, **UNIT), rtol=0, atol=1e-16)
        assert np.ndim(function(0.5, 0.02, **UNIT)) == 0


def test_units_drop_out():
    """u nu/(g H^2) depends on y/H and nu t/H^2 alone."""
    flow = {"gap": 0.01, "kinematic_viscosity": 1e-6, "acceleration": 3e-5}
    scaled = poiseuille.velocity(0.01 * HEIGHTS, 0.027 * 0.01**2 / 1e-6, **flow) / (3e-5 * 0.01**2 / 1e-6)
    assert np.max(np.abs(scaled - poiseuille.velocity(HEIGHTS, 0.027, **UNIT))) <= 1e-16


def test_negative_times_are_refused():
    with pytest.raises(ValueError, match="t >= 0"):
        poiseuille.velocity(0.5, -1.0, **UNIT)
