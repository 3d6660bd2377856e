"""Start-up by a stress on a wall: against the series of a Newtonian liquid and the transform of a linear one."""

import numpy as np
import pytest

from tisph import registry
from tisph.exact.start_up import Flow, InelasticFluid, StartUp, ViscoelasticFluid
from tisph.geometry.motion import StressControlledWall

HEIGHTS = np.linspace(0.1, 1.0, 10)
ACCURACY = 1e-9
"""That the module promises a wall without a jump, relative to the largest value; the series have more digits."""


def newtonian(plate):
    law = registry.load("rheology", "newtonian").Law(1.0)
    return StartUp(InelasticFluid(law, 1.0), Flow(1.0, top=plate))


def creep(y, t):
    """Velocity under the stress 1 from t = 0 on: y less the even modes of a wall at rest and a free one."""
    k = (np.arange(400)[:, None] + 0.5) * np.pi
    return y - np.sum(2.0 * (-1.0) ** np.arange(400)[:, None] / k**2 * np.sin(k * y) * np.exp(-k * k * t), axis=0)


def test_a_massless_wall_and_a_newtonian_fluid():
    found = newtonian(StressControlledWall(1.0))
    for t in (1e-3, 0.1, 1.0):
        assert np.max(np.abs(found.velocity(HEIGHTS, t) - creep(HEIGHTS, t))) < ACCURACY * creep(1.0, t)
        assert found.shear_stress(1.0, t) == pytest.approx(1.0, abs=ACCURACY)


def test_stress_is_taken_away_again():
    found = newtonian(StressControlledWall(0.0, steps=((0.0, 1.0), (0.5, 0.0))))
    for t in (0.51, 1.0):
        expected = creep(HEIGHTS, t) - creep(HEIGHTS, t - 0.5)
        assert np.max(np.abs(found.velocity(HEIGHTS, t) - expected)) < ACCURACY * expected.max()


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_stress_controlled_wall_on_an_oldroyd_b_fluid(mass):
    # Laplace transform of the linear problem, inverted by Talbot's contour: 1e-13 before the waves of a cycle add up
    fraction, t = 0.1, 0.1
    member = registry.load("rheology", "oldroyd_b")
    laws = member.Parameters(relaxation_time=1.0, solvent_fraction=fraction).laws(1.0)
    found = StartUp(ViscoelasticFluid(fraction, laws), Flow(1.0, top=StressControlledWall(1.0, mass_per_area=mass)))

    def transform(p):
        nu = fraction + (1.0 - fraction) / (1.0 + p)
        q = np.sqrt(p / nu)
        return np.sinh(q) / (p * (mass * p * np.sinh(q) + nu * q * np.cosh(q)))

    terms = 24
    angle = np.arange(1, terms) * np.pi / terms
    cotangent = 1.0 / np.tan(angle)
    delta = 0.4 * terms * np.concatenate([[1.0], angle * (cotangent + 1j)])
    weight = np.exp(delta) * np.concatenate([[0.5], 1.0 + 1j * angle * (1.0 + cotangent**2) - 1j * cotangent])
    expected = 0.4 / t * np.sum((weight * transform(delta / t)).real)
    assert found.velocity(1.0, t) == pytest.approx(expected, rel=ACCURACY)
