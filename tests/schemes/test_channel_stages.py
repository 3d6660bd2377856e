"""The Runge-Kutta method of the channel: order, stability and what its stages begin from."""

import numpy as np
import pytest

from tisph.schemes.implicit.channel import stages
from tisph.schemes.implicit.channel.stages import GAMMA

A, B, C, B_HAT = (np.array(numbers) for numbers in (stages.A, stages.B, stages.C, stages.B_HAT))

ROUNDING = 1e-14  # fractions of 13 digits each carry about 25; what is left is the rounding of sums of four terms

CONDITIONS = {
    # the vector whose weighted sum has a value for the order of a method, and the order
    "1": (np.ones(4), 1, 1),
    "c": (C, 1 / 2, 2),
    "c^2": (C**2, 1 / 3, 3),
    "A c": (A @ C, 1 / 6, 3),
}


@pytest.mark.parametrize("name", CONDITIONS)
def test_the_result_is_of_third_order_and_the_embedded_one_of_second(name):
    vector, value, order = CONDITIONS[name]
    assert pytest.approx(value, rel=0, abs=ROUNDING) == B @ vector
    # or the difference of the two results would not estimate the error
    assert (abs(B_HAT @ vector - value) <= ROUNDING) == (order < 3)
    assert abs(B_HAT @ vector - value) <= ROUNDING or abs(B_HAT @ vector - value) > 1e-3


def test_one_explicit_stage_and_three_implicit_ones_with_one_matrix():
    assert np.allclose(A.sum(axis=1), C, rtol=0, atol=ROUNDING)
    assert np.array_equal(np.diag(A), [0.0, GAMMA, GAMMA, GAMMA])
    assert np.array_equal(np.triu(A, 1), np.zeros((4, 4)))
    assert np.array_equal(A[3], B)  # the last stage is the result
    # every stage is of second order: walls that accelerate act through stiff terms, whose errors follow that
    assert np.allclose(A @ C, C**2 / 2, rtol=0, atol=ROUNDING)


def test_no_oscillation_or_decay_grows_and_the_stiffest_modes_vanish():
    def growth(z):
        """R(z), the factor by which one step of y' = z y grows: 1 + z b (1 - z A)^-1 (1, 1, 1, 1)."""
        return 1 + z * B @ np.linalg.solve(np.eye(4) - z * A, np.ones(4))

    # along the imaginary axis, and by the maximum principle in the whole left half-plane
    axis = 1j * np.concatenate([np.linspace(0, 20, 400), np.logspace(1.3, 6, 200)])
    assert max(abs(growth(z)) for z in axis) <= 1 + ROUNDING
    assert abs(growth(-1e6)) < 1e-5  # R falls off as 1/z


def test_a_stage_is_predicted_from_the_polynomial_of_the_rates_before_it():
    weights = stages.stage_predictors()
    assert not np.triu(weights).any()
    for stage in range(1, 4):
        for power in range(stage):
            way = C[stage] ** (power + 1) / (power + 1)
            assert weights[stage, :stage] @ C[:stage] ** power == pytest.approx(way, rel=1e-12)
