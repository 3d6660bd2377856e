"""Oscillating wall in a gap: two forms, an independent solution, symmetries, limits, printed layers."""

import warnings

import numpy as np
import pytest
from exact_collocation import chebyshev_derivatives
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import oscillating_wall
from oracles.oscillating_wall import Oscillation
from scipy.linalg import expm
from scipy.special import erfc

from tisph.exact import couette

HEIGHTS = np.linspace(0.0, 1.0, 101)
FROM_REST = (oscillating_wall.velocity, oscillating_wall.shear_rate)
PERIODIC = (oscillating_wall.periodic_velocity, oscillating_wall.periodic_shear_rate)

times = st.floats(-4, 0).map(lambda exponent: 10.0**exponent)  # t* from 1e-4 to 1, both forms usable
frequencies = st.floats(-3, 3).map(lambda exponent: 10.0**exponent)  # w t <= 1000
# squares of speeds below 1e-150 underflow in the tolerance itself
speeds = st.floats(-10, 10).filter(lambda speed: speed == 0 or abs(speed) > 1e-150)


def unit(cosine, sine, frequency):
    """Arguments for a gap and a viscosity of 1; ``frequency`` is then w gap^2/nu."""
    return {"gap": 1.0, "kinematic_viscosity": 1.0, "wall": Oscillation(cosine, sine, frequency)}


@settings(max_examples=200, deadline=None)
@given(cosine=speeds, sine=speeds, frequency=frequencies, time=times)
def test_series_and_images_agree(cosine, sine, frequency, time):
    flow = unit(cosine, sine, frequency)
    # 1e-14 for the rounding of y/gap and of the terms, as in test_couette; the phase w t adds its own rounding
    allowed = (1e-14 + 4e-16 * frequency * time) * np.hypot(cosine, sine)
    steepest = 1 / np.sqrt(time) + np.sqrt(frequency) + 1
    for function, scale in zip(FROM_REST, (1.0, 2 * steepest), strict=True):
        results = []
        for switch_time in (np.inf, 0.0):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(couette, "SWITCH_TIME", switch_time)
                results.append(function(HEIGHTS, time, **flow))
        assert np.max(np.abs(results[0] - results[1])) <= allowed * scale


@pytest.mark.parametrize("t_star", [0.018, 0.09, 0.11, 0.4, 1.0])
@pytest.mark.parametrize(("cosine", "sine", "frequency"), [(1.0, 0.0, 3.0), (0.0, 1.0, 40.0), (-0.7, 0.4, 300.0)])
def test_against_an_independent_solution_of_the_equation(t_star, cosine, sine, frequency):
    """Chebyshev collocation in y; the wall's rotating pair (U, U'/w) is part of the state of a matrix exponential."""
    nodes, first, second = chebyshev_derivatives(48)
    matrix = np.zeros((49, 49))
    matrix[:47, :47] = second[1:-1, 1:-1]
    matrix[:47, 47] = second[1:-1, 0]
    matrix[47, 48], matrix[48, 47] = frequency, -frequency
    state = expm(t_star * matrix) @ np.concatenate([np.zeros(47), [cosine, sine]])
    reference = np.concatenate([[state[47]], state[:47], [0.0]])
    flow = unit(cosine, sine, frequency)
    # as in test_couette, for the same matrices and amplitudes of 1; at 300 the matrix exponential has the wall
    # itself wrong by 8e-13, of which the layer sqrt(2/300) makes 1e-11, and the Stokes flow at the wall twice that
    assert np.max(np.abs(oscillating_wall.velocity(nodes, t_star, **flow) - reference)) <= 2e-12
    assert np.max(np.abs(oscillating_wall.shear_rate(nodes, t_star, **flow) - first @ reference)) <= 4e-11


@pytest.mark.parametrize("frequency", [0.1, 20.0, 2000.0])
def test_periodic_flow_is_a_steady_oscillation_that_obeys_the_equation(frequency):
    """u(t) = C cos(w t) + D sin(w t): nu C'' = w D and nu D'' = -w C, by collocation on the whole gap."""
    nodes, first, second = chebyshev_derivatives(64)
    flow = unit(0.6, -0.8, frequency)
    u = oscillating_wall.periodic_velocity
    cosine, sine = u(nodes, 0.0, **flow), u(nodes, np.pi / (2 * frequency), **flow)
    # rounding in the second derivative: 1e-16 times the norm 6e6 of its matrix; a quarter of it inside
    scale = frequency + 1
    assert np.max(np.abs(second @ cosine - frequency * sine)[1:-1]) <= 3e-9 * scale
    assert np.max(np.abs(second @ sine + frequency * cosine)[1:-1]) <= 3e-9 * scale
    rate = oscillating_wall.periodic_shear_rate(nodes, 0.0, **flow)
    assert np.max(np.abs(first @ cosine - rate)) <= 1e-11 * scale


def test_flow_from_rest_becomes_periodic():
    """At t* = 4 the slowest mode is exp(-39) = 7e-18."""
    for rest, periodic in zip(FROM_REST, PERIODIC, strict=True):
        difference = rest(HEIGHTS, 4.0, **unit(0.6, -0.8, 50.0)) - periodic(HEIGHTS, 4.0, **unit(0.6, -0.8, 50.0))
        # the phase 200 is rounded by 3e-14, and gradients are 10 times the amplitude
        assert np.max(np.abs(difference)) <= 3e-13


def test_walls_have_their_velocity_at_every_time():
    t = np.array([0.0, 1e-6, 0.01, 0.1, 1.0])
    flow = unit(-0.3, 0.5, 7.0)
    wall = -0.3 * np.cos(7 * t) + 0.5 * np.sin(7 * t)
    for function in (oscillating_wall.velocity, oscillating_wall.periodic_velocity):
        assert np.max(np.abs(function(1.0, t, **flow) - wall)) <= 2e-15
        assert np.max(np.abs(function(0.0, t, **flow))) <= 1e-15


@given(cosine=speeds, sine=speeds, time=times)
def test_cosine_and_sine_superpose(cosine, sine, time):
    for function in (*FROM_REST, *PERIODIC):
        parts = cosine * function(HEIGHTS, time, **unit(1.0, 0.0, 30.0))
        parts += sine * function(HEIGHTS, time, **unit(0.0, 1.0, 30.0))
        both = function(HEIGHTS, time, **unit(cosine, sine, 30.0))
        steepest = 10 + 1 / np.sqrt(time)
        assert np.max(np.abs(both - parts)) <= 4e-15 * steepest * (abs(cosine) + abs(sine))


def test_periodic_sine_is_the_cosine_a_quarter_period_later():
    quarter = np.pi / 2 / 30.0
    for function in PERIODIC:
        sine = function(HEIGHTS, 0.02 + quarter, **unit(0.0, 1.0, 30.0))
        # phases of the order of 2 and gradients of the order of 10, each rounded to 4e-16
        assert np.max(np.abs(sine - function(HEIGHTS, 0.02, **unit(1.0, 0.0, 30.0)))) <= 2e-14


def test_slow_oscillation_is_quasi_steady():
    """For W = w H^2/nu -> 0 u = U(t) y/H + (W/6) (U'(t)/w) (y^3/H^3 - y/H) + O(W^2)."""
    frequency, phase = 1e-3, 0.9
    velocity = np.cos(phase) * HEIGHTS - frequency / 6 * np.sin(phase) * (HEIGHTS**3 - HEIGHTS)
    computed = oscillating_wall.periodic_velocity(HEIGHTS, phase / frequency, **unit(1.0, 0.0, frequency))
    assert np.max(np.abs(computed - velocity)) <= frequency**2


def test_slow_cosine_starts_as_a_wall_of_constant_velocity():
    """A wall cos(w t), 1 to rounding while w t < 1e-8, drives start-up Couette flow."""
    steady = {"gap": 1.0, "kinematic_viscosity": 1.0, "bottom": 0.0, "top": 1.0}
    for t in (0.01, 0.05, 0.2):
        for ours, theirs in zip(FROM_REST, (couette.velocity, couette.shear_rate), strict=True):
            difference = ours(HEIGHTS, t, **unit(1.0, 0.0, 1e-8)) - theirs(HEIGHTS, t, **steady)
            assert np.max(np.abs(difference)) <= 1e-14


@pytest.mark.parametrize("frequency", [2e4, 2e8, 2e12])
def test_fast_oscillation_is_a_stokes_layer(frequency):
    """exp(-d/delta) cos(w t - d/delta), delta = sqrt(2 nu/w) down to 1e-6 gap; no overflow on the way."""
    delta, phase = np.sqrt(2 / frequency), 0.4
    distance = np.concatenate([delta * np.linspace(0, 8, 41), [0.5, 1.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        u, rate = (function(1 - distance, phase / frequency, **unit(1.0, 0.0, frequency)) for function in PERIODIC)
        for function in FROM_REST:
            assert np.all(
                np.isfinite(function(1 - distance, 3.3 / np.array([[frequency], [1.0]]), **unit(1, 1, frequency)))
            )
    depth = distance / delta
    # y/gap = 1 - distance is rounded by 1.1e-16, and the layer's slope is 1.4/delta
    assert np.max(np.abs(u - np.exp(-depth) * np.cos(phase - depth))) <= 1e-14 + 2e-16 / delta
    expected = np.sqrt(2) / delta * np.exp(-depth) * np.cos(phase - depth + np.pi / 4)
    assert np.max(np.abs(rate - expected)) * delta <= 2e-14 + 4e-16 / delta


def test_early_sine_is_a_wall_that_accelerates_uniformly():
    """While w t << 1 the wall has w t, in a half space w t 4 i2erfc(x), x = d/(2 sqrt(nu t)); next order (w t)^3."""
    frequency, t = 1.0, 1e-5
    x = np.linspace(0, 3, 31)
    expected = frequency * t * ((1 + 2 * x**2) * erfc(x) - 2 / np.sqrt(np.pi) * x * np.exp(-(x**2)))
    computed = oscillating_wall.velocity(1 - 2 * np.sqrt(t) * x, t, **unit(0.0, 1.0, frequency))
    # rounding: images are sums of terms of the size 1, of which the real part keeps sqrt(w t) = 3e-3, w t = 1e-5
    assert np.max(np.abs(computed - expected)) <= 1e-15


def test_start_is_at_rest_and_only_a_jump_is_infinitely_steep():
    y = np.array([0.0, 0.5, 1.0])
    assert oscillating_wall.velocity(y, 0.0, **unit(-0.3, 2.0, 5.0)).tolist() == [0.0, 0.0, -0.3]
    assert oscillating_wall.shear_rate(y, 0.0, **unit(-0.3, 2.0, 5.0)).tolist() == [0.0, 0.0, -np.inf]
    assert oscillating_wall.shear_rate(y, 0.0, **unit(0.0, 2.0, 5.0)).tolist() == [0.0, 0.0, 0.0]


def test_shear_rate_is_the_derivative_of_the_velocity():
    y, step = np.linspace(0.1, 0.9, 41), 1e-4
    for t in (0.01, 0.05, 0.2, 1.0):
        for velocity, rate in zip(*zip(FROM_REST, PERIODIC, strict=True), strict=True):
            central = velocity(y + step, t, **unit(0.6, -0.8, 9.0)) - velocity(y - step, t, **unit(0.6, -0.8, 9.0))
            # truncation u_yyy step^2/6 with |u_yyy| < 1000 at t* = 0.01, rounding 1e-16/step
            assert np.allclose(rate(y, t, **unit(0.6, -0.8, 9.0)), central / (2 * step), rtol=0, atol=2e-6)


def test_times_and_heights_broadcast():
    """One call over a grid of heights and times, across both forms and the start, equals the single calls."""
    t, flow = np.array([0.0, 0.02, 0.1, 0.3]), unit(0.6, -0.8, 9.0)
    for function in (*FROM_REST, *PERIODIC):
        grid = function(HEIGHTS[1:-1, None], t[None, :], **flow)
        assert grid.shape == (99, 4)
        for column, time in enumerate(t):
            # the number of terms is that of the earliest or latest time: what is left out is below rounding
            assert np.allclose(grid[:, column], function(HEIGHTS[1:-1], time, **flow), rtol=0, atol=1e-15)
        assert np.ndim(function(0.5, 0.02, **flow)) == 0


def test_units_drop_out():
    """u/U depends on y/H, nu t/H^2 and w H^2/nu alone."""
    gap, viscosity = 0.01, 1e-6
    small = {
        "gap": gap,
        "kinematic_viscosity": viscosity,
        "wall": Oscillation(0.003, -0.004, 9.0 * viscosity / gap**2),
    }
    for function, scale in zip((*FROM_REST, *PERIODIC), (0.005, 0.5, 0.005, 0.5), strict=True):
        scaled = function(gap * HEIGHTS, 0.027 * gap**2 / viscosity, **small) / scale
        # as in test_couette; the gradient's slope is 10 times larger
        assert np.max(np.abs(scaled - function(HEIGHTS, 0.027, **unit(0.6, -0.8, 9.0)))) <= 1e-13


def test_times_and_frequencies_without_a_solution_are_refused():
    with pytest.raises(ValueError, match="t >= 0"):
        oscillating_wall.velocity(0.5, -1.0, **unit(1.0, 0.0, 1.0))
    for function in (*FROM_REST, *PERIODIC):
        with pytest.raises(ValueError, match=r"angular frequency above 0, not 0\.0"):
            function(0.5, 1.0, **unit(1.0, 0.0, 0.0))
