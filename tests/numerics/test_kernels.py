"""Smoothing kernels: normalisation, slope and support, for every member of the family."""

from math import pi

import numpy as np
import pytest

from tisph import registry

KERNELS = registry.names("kernels")


@pytest.fixture(params=KERNELS)
def kernel(request):
    return registry.load("kernels", request.param)


def test_integral_over_the_plane_is_one(kernel):
    # midpoint rule on 1e5 intervals: error of order (support / 1e5)^2, far below 1e-8
    width = kernel.SUPPORT / 100_000
    q = (np.arange(100_000) + 0.5) * width
    values = np.array([kernel.value(distance) for distance in q])
    assert 2 * pi * np.sum(values * q) * width == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("q", [0.1, 0.5, 0.99, 1.01, 1.5, 1.9, 2.2, 2.9])
def test_slope_over_q_is_minus_the_derivative_over_the_distance(kernel, q):
    # central difference of step 1e-5: error 1e-10 times the third derivative, below 1e-8
    derivative = (kernel.value(q + 1e-5) - kernel.value(q - 1e-5)) / 2e-5
    assert kernel.slope_over_q(q) == pytest.approx(-derivative / q, abs=1e-8)


def test_zero_beyond_the_support(kernel):
    for q in (kernel.SUPPORT, kernel.SUPPORT + 0.1, 1e6):
        assert kernel.value(q) == 0.0
        assert kernel.slope_over_q(q) == 0.0


def test_positive_and_falling_inside(kernel):
    q = np.linspace(0.01, kernel.SUPPORT - 0.01, 200)
    values = [kernel.value(distance) for distance in q]
    assert min(values) > 0
    assert all(kernel.slope_over_q(distance) > 0 for distance in q)
