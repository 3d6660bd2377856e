"""Extrapolation to spacing zero: exact on powers of the spacing, and silent where there is no order."""

import numpy as np
import pytest

from tisph.studies.error_estimate import of_norms, of_number

SPACINGS = 1 / 25, 1 / 35, 1 / 50
BELIEVED = 1.0, 6.0


def norms(errors):
    """Norms of the differences 1-2, 2-3 and 1-3 of fields, arrays."""
    return [np.linalg.norm(errors[one] - errors[other]) for one, other in ((0, 1), (1, 2), (0, 2))]


@pytest.mark.parametrize("spacings", [SPACINGS, (0.5, 0.5**0.5, 1.0)[::-1], (0.2, 0.11, 0.1)])
@pytest.mark.parametrize("order", [1.5, 3.0, 4.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_number_with_an_order_is_extrapolated_exactly(spacings, order, sign):
    found = of_number(spacings, [7.0 + sign * 0.3 * h**order for h in spacings], BELIEVED)
    # the minimum of a sum of squares is found to the root of the rounding error, 1e-8, of differences of 1e-4 of 7
    assert found.order == pytest.approx(order, rel=1e-5)
    assert found.error == pytest.approx(0.3 * spacings[2] ** order, rel=1e-5)
    assert found.reason is None


@pytest.mark.parametrize("order", [2.0, 4.0])
def test_a_field_with_errors_of_one_shape_is_extrapolated_exactly(order):
    shape = np.random.default_rng(0).normal(size=500)
    found = of_norms(SPACINGS, norms([h**order * shape for h in SPACINGS]), BELIEVED)
    assert found.order == pytest.approx(order, rel=1e-5)
    assert found.error == pytest.approx(SPACINGS[2] ** order * np.linalg.norm(shape), rel=1e-5)


def test_independent_errors_are_told_from_those_of_one_shape():
    shapes = np.random.default_rng(0).normal(size=(3, 100_000))
    errors = [h**3 * shape for h, shape in zip(SPACINGS, shapes, strict=True)]
    found = of_norms(SPACINGS, norms(errors), BELIEVED)
    # shapes are orthogonal to 1/sqrt(100000) = 0.3 %
    assert found.order == pytest.approx(3.0, rel=0.01)
    assert found.error == pytest.approx(np.linalg.norm(errors[2]), rel=0.01)


def test_a_given_order_takes_the_place_of_the_observed_one():
    found = of_norms(SPACINGS, norms([h**3 * np.ones(4) for h in SPACINGS]), BELIEVED, order=4.0)
    assert found.order == pytest.approx(3.0, rel=1e-5)
    assert found.error < 2 * SPACINGS[2] ** 3


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ([1.0, 0.9, 0.95], "not monotone"),
        ([1.0, 0.9, 0.9], "not monotone"),
        ([1.0, 0.9, 0.7], "does not converge"),
        ([1.0 + h**0.5 for h in SPACINGS], "order 0.5 where 1 to 6"),
        ([1.0 + h**8 for h in SPACINGS], "order 8 where 1 to 6"),
        ([1.0, 1.0, 1.0], "agree but for rounding"),
        ([1.0, np.nan, 1.0], "not a number"),
    ],
)
def test_no_error_without_an_order(values, reason):
    found = of_number(SPACINGS, values, BELIEVED)
    assert found.error is None
    assert reason in found.reason
    spread = max(values) - min(values)
    assert found.spread == (pytest.approx(spread, rel=1e-12) if spread > 0.0 else None)


def test_mixed_orders_and_an_odd_middle_run_have_no_order():
    assert "not monotone" in of_number(SPACINGS, [h**4 - 3.3e-2 * h**2 * 0.04 for h in SPACINGS], BELIEVED).reason
    assert "no one order" in of_norms(SPACINGS, [1.0, 0.9, 0.05], BELIEVED).reason
