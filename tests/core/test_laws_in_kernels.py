"""The laws of polymers inside kernels: the numbers of the same lines on NumPy arrays."""

import warnings

import numpy as np
import pytest
from polymer_laws import LAWS, deviations

from tisph import runtime
from tisph.runtime import ti

COUNT = 5


def in_kernel(law, c):
    """Relaxation and stress of ``law`` at deviations ``c`` (components, points), by a kernel."""
    runtime.start("f64", 1)
    size = law.components
    state, rate, stress = (ti.Vector.field(size, ti.f64, shape=COUNT) for _ in range(3))
    state.from_numpy(np.ascontiguousarray(c.T))

    @ti.kernel
    def evaluate():
        for i in range(COUNT):
            rate[i] = ti.Vector(ti.static(law.relaxation([state[i][k] for k in range(size)])))
            stress[i] = ti.Vector(ti.static(law.stress([state[i][k] for k in range(size)])))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        evaluate()
    return rate.to_numpy().T, stress.to_numpy().T


@pytest.mark.parametrize("name", LAWS)
def test_a_kernel_gives_the_numbers_of_numpy(name):
    law = LAWS[name]
    c = deviations(law.components, COUNT)
    rate, stress = in_kernel(law, c)
    # the same operations: apart by rounding, which contracted multiplications and exp make differ
    assert np.allclose(rate, law.relaxation(c), rtol=1e-14, atol=1e-14)
    assert np.allclose(stress, law.stress(c), rtol=1e-14, atol=1e-14)
