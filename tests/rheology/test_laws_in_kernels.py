"""The laws inside kernels: the numbers of the same lines on NumPy arrays."""

import warnings

import numpy as np
import pytest
from polymer_laws import LAWS, conformation_excess

from tisph import registry, runtime
from tisph.runtime import ti

pytestmark = pytest.mark.taichi

COUNT = 5
VISCOUS = {
    "power_law": {"index": 0.5, "reference_rate": 2.0, "least_rate": 1e-3},
    "carreau_yasuda": {"time": 2.0, "index": 0.4, "transition": 1.5},
    "herschel_bulkley": {"yield_stress": 3.0, "index": 0.7, "reference_rate": 2.0, "regularisation": 50.0},
}


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
    c = conformation_excess(law.components, COUNT)
    rate, stress = in_kernel(law, c)
    # the same operations: apart by rounding, which contracted multiplications and exp make differ
    assert np.allclose(rate, law.relaxation(c), rtol=1e-14, atol=1e-14)
    assert np.allclose(stress, law.stress(c), rtol=1e-14, atol=1e-14)


def test_viscosities_in_a_kernel():
    runtime.start("f64", 1)
    rates = np.array([0.0, 1e-3, 0.7, 40.0]) ** 2
    laws = [
        (registry.load("rheology", name).Law(registry.load("rheology", name).Parameters(**numbers), 0.8))
        for name, numbers in VISCOUS.items()
    ]
    squared, found = ti.field(ti.f64, 4), ti.Vector.field(3, ti.f64, 4)
    squared.from_numpy(rates)

    @ti.kernel
    def evaluate():
        for i in range(4):
            found[i] = ti.Vector(ti.static([law.viscosity(squared[i]) for law in laws]))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        evaluate()
    # 1 - exp(-x) loses what x lacks to 1: x is 0.001 at least
    assert np.allclose(found.to_numpy().T, [law.viscosity(rates) for law in laws], rtol=1e-12)
