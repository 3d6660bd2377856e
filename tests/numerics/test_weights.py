"""The table of pair weights against the kernel that it is made from."""

import math

import numpy as np
import pytest

from tisph import registry, runtime
from tisph.operators._pairs import WeightTable
from tisph.runtime import ti

pytestmark = pytest.mark.taichi


@pytest.mark.parametrize("name", registry.names("kernels"))
def test_the_table_follows_the_kernel(name):
    runtime.start("f64", 1)
    kernel = registry.load("kernels", name)
    length = 0.3
    table = WeightTable(kernel, length)
    q = np.linspace(0.3, kernel.SUPPORT, 1001)
    weights = ti.field(ti.f64, shape=q.size)
    squares = ti.field(ti.f64, shape=q.size)
    squares.from_numpy((q * length) ** 2)

    @ti.kernel
    def look_up():
        for i in weights:
            weights[i] = table.at(squares[i])

    look_up()
    exact = np.array([kernel.slope_over_q(distance) for distance in q])
    # linear interpolation: (interval)^2 / 8 times the second derivative in q^2, both of order 1e-3 and 1 to 10,
    # for distances from 0.3 h on: closer pairs do not occur
    assert np.abs(weights.to_numpy() - exact).max() < 1e-5 * kernel.slope_over_q(1e-3)


def test_no_weight_beyond_the_support_and_none_that_is_no_number():
    runtime.start("f64", 1)
    kernel = registry.load("kernels", "quintic_spline")
    table = WeightTable(kernel, 1.0)

    @ti.kernel
    def at(squared: float) -> float:
        return table.at(squared)

    # up to sqrt(2) times the support: with the least one (test_verlet.py) no pair of a list gets that far
    assert at(9.0) == at(13.0) == at(17.999) == 0.0
    assert math.isnan(at(math.nan))
