"""The Runge-Kutta method of the channel, and the Taylor series that its walls prescribe to images."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.geometry.motion import WallMotion
from tisph.schemes.implicit.channel import stages
from tisph.schemes.implicit.channel.stages import GAMMA
from tisph.schemes.implicit.channel.walls import CoupledWall, PrescribedWall

A, B, C, B_HAT = (np.array(numbers) for numbers in (stages.A, stages.B, stages.C, stages.B_HAT))

ROUNDING = 1e-14  # fractions of 13 digits each carry about 25; what is left is the rounding of sums of four terms


def growth(z):
    """Return R(z), the factor by which one step of y' = z y grows: 1 + z b (1 - z A)^-1 (1, 1, 1, 1)."""
    return 1 + z * B @ np.linalg.solve(np.eye(4) - z * A, np.ones(4))


def test_stages_are_evaluated_at_the_times_that_their_weights_add_up_to():
    assert np.allclose(A.sum(axis=1), C, rtol=0, atol=ROUNDING)


def test_one_explicit_stage_and_three_implicit_ones_with_one_matrix():
    assert np.array_equal(np.diag(A), [0.0, GAMMA, GAMMA, GAMMA])
    assert np.array_equal(np.triu(A, 1), np.zeros((4, 4)))


# (sum of weights times ..., what it must be for the order)
CONDITIONS = [
    (1, np.ones(4), 1),
    (2, C, 1 / 2),
    (3, C**2, 1 / 3),
    (3, A @ C, 1 / 6),
]


@pytest.mark.parametrize(("order", "vector", "value"), CONDITIONS, ids=["1", "c", "c^2", "A c"])
def test_order_conditions_up_to_three(order, vector, value):
    assert pytest.approx(value, rel=0, abs=ROUNDING) == B @ vector


@pytest.mark.parametrize(("order", "vector", "value"), CONDITIONS[:2], ids=["1", "c"])
def test_order_conditions_of_the_embedded_result_up_to_two(order, vector, value):
    assert pytest.approx(value, rel=0, abs=ROUNDING) == B_HAT @ vector


@pytest.mark.parametrize(("order", "vector", "value"), CONDITIONS[2:], ids=["c^2", "A c"])
def test_the_embedded_result_misses_third_order(order, vector, value):
    # or the difference of the two results would not estimate the error
    assert abs(B_HAT @ vector - value) > 1e-3


def test_the_last_stage_is_the_result():
    assert np.array_equal(A[3], B)
    assert C[3] == 1.0


def test_every_stage_is_of_second_order():
    # walls that accelerate act through stiff terms, whose errors follow the order of the stages
    assert np.allclose(A @ C, C**2 / 2, rtol=0, atol=ROUNDING)


def test_the_stiffest_modes_vanish_in_one_step():
    # the limit of R for z to minus infinity: that of the implicit stages alone, driven by the explicit one
    limit = -np.linalg.solve(A[1:, 1:], A[1:, 0])[-1]
    assert abs(limit) < 10 * ROUNDING  # the solution of a system with entries up to 1/gamma^3 = 12
    assert abs(growth(-1e6)) < 1e-5  # R falls off as 1/z


def test_no_oscillation_or_decay_grows():
    axis = 1j * np.concatenate([np.linspace(0, 20, 400), np.logspace(1.3, 6, 200)])
    # along the imaginary axis, and by the maximum principle in the whole left half-plane
    assert max(abs(growth(z)) for z in axis) <= 1 + ROUNDING


def test_a_stage_is_predicted_from_the_polynomial_of_the_rates_before_it():
    weights = stages.stage_predictors()
    assert not np.triu(weights).any()
    for stage in range(1, 4):
        for power in range(stage):
            way = C[stage] ** (power + 1) / (power + 1)
            assert weights[stage, :stage] @ C[:stage] ** power == pytest.approx(way, rel=1e-12)


NU, FREQUENCY, TIME = 0.02, 3.0, 0.7
SWINGING, STILL = WallMotion(1.0, 0.5, FREQUENCY), WallMotion(0.0)


def channel():
    numbers = {"kinematic_viscosity": NU, "solvent_viscosity": NU, "acceleration": 0.0, "start_time": 0.0}
    return SimpleNamespace(bottom=SWINGING, top=STILL, wall_jumps=(1.0, 0.0), starts_developed=False, **numbers)


def even_part(depth):
    """Twice that of the layer at a swinging wall (Stokes), whose waves cosh have no odd one."""
    wave = (1.0 - 0.5j) * np.exp(1j * FREQUENCY * TIME)
    return 2.0 * np.real(wave * np.cosh(np.sqrt(1j * FREQUENCY / NU) * depth))


def test_the_series_is_that_of_the_layer_at_a_swinging_wall():
    errors = []
    for depth in (0.02, 0.01):
        found = np.polyval(PrescribedWall(channel(), 0, True).series_at(TIME)[::-1], depth**2)
        errors.append(abs(found - even_part(depth)))
    # what the series leaves is of the sixth power of the depth: 64, less the eighth's part of some per cent
    assert errors[0] / errors[1] == pytest.approx(64.0, rel=0.05)


def test_viscoelastic_wall_derivatives_are_those_of_a_taylor_series():
    wall = SimpleNamespace(obeys_momentum=True, series=[], stress_series=[])
    second, fourth, depth = 3.0, -40.0, 0.1
    CoupledWall.prescribe(wall, SWINGING.velocity(TIME), 0.0, 0.0, second, fourth, 0.0, 0.0)
    (found,) = wall.series
    exact = 2.0 * (SWINGING.velocity(TIME) + second * depth**2 / 2.0 + fourth * depth**4 / 24.0)
    assert np.polyval(found[::-1], depth**2) == pytest.approx(exact, rel=1e-14)
