"""Start-up Couette flow: two forms, an independent solution, and limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.special import erfc

from tisph.exact import couette
from tisph.exact.couette import SWITCH_TIME

# For t* >= 1e-4: the rounding 1.1e-16 of y/gap times the steepest slope 1/sqrt(pi t*) = 56 is 6e-15, and the
# 200 terms of the series, each rounded to 1.1e-16 with a random sign, add 2e-15.
ROUNDING = 1e-14
UNIT = {"gap": 1.0, "kinematic_viscosity": 1.0, "bottom": 0.0, "top": 1.0}
HEIGHTS = np.linspace(0.0, 1.0, 101)

speeds = st.floats(-10, 10, allow_subnormal=False)
times = st.floats(-4, 0.3).map(lambda exponent: 10.0**exponent)  # t* from 1e-4 to 2, both forms usable
fractions = st.floats(0, 1)


def both_forms(function, y, t, **flow):
    """Images and series of one quantity at the time t."""
    found = []
    for switch_time in (np.inf, 0.0):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(couette, "SWITCH_TIME", switch_time)
            found.append(function(y, t, **flow))
    return found


@settings(max_examples=200, deadline=None)
@given(bottom=speeds, top=speeds, time=times, fraction=fractions)
def test_series_and_images_agree(bottom, top, time, fraction):
    flow = {"gap": 0.02, "kinematic_viscosity": 3e-6, "bottom": bottom, "top": top}
    y, t = 0.02 * fraction, time * 0.02**2 / 3e-6
    scale = abs(bottom) + abs(top)
    images, series = both_forms(couette.velocity, y, t, **flow)
    assert abs(images - series) <= ROUNDING * scale
    steepest = scale / np.sqrt(np.pi * 3e-6 * t) + scale / 0.02
    images, series = both_forms(couette.shear_rate, y, t, **flow)
    # the gradient's own slope is 1/sqrt(t*) of it: again 1.1e-16 / sqrt(1e-4), relative to the steepest
    assert abs(images - series) <= 2 * ROUNDING * steepest


@pytest.mark.parametrize("factor", [0.999, 1.0, 1.001])
def test_the_switch_is_invisible(factor):
    """On both sides of the switch the forms differ by rounding."""
    for function, rounding in ((couette.velocity, 2e-15), (couette.shear_rate, 8e-15)):
        images, series = both_forms(function, HEIGHTS, factor * SWITCH_TIME, **UNIT)
        assert np.max(np.abs(images - series)) <= rounding


def chebyshev_derivatives(count):
    """Nodes from 1 down to 0, and the collocation matrices of d/dy and d2/dy2 on them."""
    nodes = np.cos(np.pi * np.arange(count + 1) / count)
    weights = np.ones(count + 1)
    weights[[0, -1]] = 2.0
    weights *= (-1.0) ** np.arange(count + 1)
    gaps = nodes[:, None] - nodes[None, :] + np.eye(count + 1)
    first = np.outer(weights, 1 / weights) / gaps
    first -= np.diag(first.sum(axis=1))
    return (nodes + 1) / 2, 2 * first, 4 * first @ first


@pytest.mark.parametrize("t_star", [0.018, 0.027, 0.09, 0.11, 0.4, 1.0, 4.0])
@pytest.mark.parametrize(("bottom", "top"), [(0.0, 1.0), (-0.7, 0.4)])
def test_against_an_independent_solution_of_the_equation(t_star, bottom, top):
    """Chebyshev collocation in y, matrix exponential in t: no series and no error function in it."""
    nodes, first, second = chebyshev_derivatives(48)
    inner = second[1:-1, 1:-1]
    forcing = second[1:-1, 0] * top + second[1:-1, -1] * bottom
    steady = -np.linalg.solve(inner, forcing)
    reference = np.concatenate([[top], steady - expm(t_star * inner) @ steady, [bottom]])
    flow = {**UNIT, "bottom": bottom, "top": top}
    # 32 nodes resolve these profiles; what is left is rounding in the reference, which grows with the norm of the
    # matrix (2e5, 1e6, 3e6): 7e-14, 4e-13, 1e-12 at 32, 48, 64 nodes. Allowed: five times that at 48.
    assert np.max(np.abs(couette.velocity(nodes, t_star, **flow) - reference)) <= 2e-12
    # likewise 7e-13, 2e-12, 8e-12 after one more differentiation
    assert np.max(np.abs(couette.shear_rate(nodes, t_star, **flow) - first @ reference)) <= 1e-11


def test_early_flow_is_that_of_a_half_space():
    """At t* = 1e-3 the other wall's image is erfc(1/(2 sqrt(1e-3))) = 8e-112: Stokes' first problem."""
    distance = 1 - HEIGHTS
    expected = erfc(distance / (2 * np.sqrt(1e-3)))
    assert np.max(np.abs(couette.velocity(HEIGHTS, 1e-3, **UNIT) - expected)) <= 1e-15
    assert couette.shear_rate(1.0, 1e-3, **UNIT) == pytest.approx(1 / np.sqrt(np.pi * 1e-3), rel=1e-14)


def test_start_is_at_rest_between_walls_that_move_already():
    flow = {**UNIT, "bottom": -1.0, "top": 0.0}
    assert couette.velocity(np.array([0.0, 0.01, 0.99, 1.0]), 0.0, **flow).tolist() == [-1.0, 0.0, 0.0, 0.0]
    assert couette.shear_rate(np.array([0.0, 0.5, 1.0]), 0.0, **flow).tolist() == [np.inf, 0.0, 0.0]


def test_times_and_heights_broadcast():
    """One call over a grid of heights and times, across both forms and the start, equals the single calls."""
    t = np.array([0.0, 0.02, 0.1, 0.3])
    for function in (couette.velocity, couette.shear_rate):
        grid = function(HEIGHTS[1:-1, None], t[None, :], **UNIT)
        assert grid.shape == (99, 4)
        for column, time in enumerate(t):
            assert np.array_equal(grid[:, column], function(HEIGHTS[1:-1], time, **UNIT))
    assert np.ndim(couette.velocity(0.5, 0.02, **UNIT)) == 0


def test_units_drop_out():
    """u/U depends on y/H and nu t/H^2 alone."""
    small = {"gap": 0.01, "kinematic_viscosity": 1e-6, "bottom": 0.0, "top": 0.005}
    scaled = couette.velocity(0.01 * HEIGHTS, 0.027 * 0.01**2 / 1e-6, **small) / 0.005
    # y/gap and nu t/gap^2 each carry two roundings, amplified by the steepest slope 3.4 and rate 30
    assert np.max(np.abs(scaled - couette.velocity(HEIGHTS, 0.027, **UNIT))) <= ROUNDING


def test_times_without_a_solution_are_refused():
    with pytest.raises(ValueError, match="t >"):
        couette.velocity(0.5, -1.0, **UNIT)
