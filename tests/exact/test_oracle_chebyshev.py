"""Interpolation through Chebyshev points, which exact solutions at many heights use."""

import numpy as np
from oracles import _chebyshev


def test_interpolation_passes_through_any_values_at_its_points():
    """A polynomial of full degree: every coefficient counts, the last one too."""
    values = np.random.default_rng(0).uniform(-1, 1, (2, 33))
    series = _chebyshev.coefficients(values)
    # 33 coefficients, each with the rounding of a sum of 33 values
    assert np.max(np.abs(_chebyshev.evaluate(series, _chebyshev.points(33)) - values)) <= 1e-14


def test_a_polynomial_is_reproduced_between_the_points():
    points, between = _chebyshev.points(9), np.linspace(0, 1, 50)
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, 5.0])
    series = _chebyshev.coefficients(cubic(points))
    assert np.max(np.abs(_chebyshev.evaluate(series, between) - cubic(between))) <= 1e-14


def test_resolved_tells_a_smooth_profile_from_a_layer_thinner_than_the_points():
    points = _chebyshev.points(65)
    smooth, thin = np.exp(-points / 0.1), np.exp(-points / 1e-4)
    assert _chebyshev.resolved(_chebyshev.coefficients(smooth), 1e-12)
    assert not _chebyshev.resolved(_chebyshev.coefficients(thin), 1e-2)
    assert not _chebyshev.resolved(_chebyshev.coefficients(np.stack([smooth, thin])), 1e-2)
