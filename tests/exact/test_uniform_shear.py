"""Laws in uniform shear: shared/reference/viscoelastic.md, part F, whose closed forms and integration agree to 1e-12.

Stresses are in units of the modulus, times in relaxation times; tolerances are the last digit of the table.
"""

import numpy as np
import pytest

from tisph import registry
from tisph.exact.uniform_shear import UniformShear

PARAMETERS = {
    "giesekus": {"type": "giesekus", "mobility": 0.15},
    "linear PTT": {"type": "phan_thien_tanner", "extensibility": 0.02},
    "exponential PTT": {"type": "phan_thien_tanner", "extensibility": 0.05, "form": "exponential"},
    "FENE-P": {"type": "fene_p", "maximum_extension": 60.0},
}

STEADY = {  # viscosity at the rates 0.1, 1, 10, 100; N1 over the square of the rate
    "giesekus": ([0.99598793, 0.77567455, 0.17715453, 0.02183623], [1.98694112, 1.32454689, 0.12802617, 0.00514985]),
    "linear PTT": ([0.99960048, 0.96414965, 0.5, 0.12958521], [1.99840224, 1.85916911, 0.5, 0.03358465]),
    "exponential PTT": (
        [0.99900249, 0.91901027, 0.3320394, 0.0540219],
        [1.99601196, 1.68915973, 0.22050033, 0.00583673],
    ),
    "FENE-P": ([0.999667, 0.96961388, 0.52303956, 0.13729694], [1.99866822, 1.88030216, 0.54714076, 0.0377009]),
}

LARGEST = {  # largest shear stress and its strain, the same of N1, at the rate 5; shear stress at the rate 20; at t = 1
    "giesekus": ((2.0073299, 4.01223), (8.2620125, 6.70618), (3.6020939, 6.05028), 1.95180306),
    "linear PTT": ((3.4726235, 10.89906), (23.3259684, 18.96806), (7.3203081, 15.66499), 2.96787236),
    "exponential PTT": ((2.7121203, 6.33153), (13.3779175, 10.29219), (4.5783405, 7.39076), 2.65292818),
    "FENE-P": ((4.3454956, 8.27806), (27.8891015, 11.06236), (19.9465895, 9.62427), 3.63000838),
}

STEP = {  # shear stress after a strain of 3: at once, after 0.5 and after 2
    "giesekus": [3.0, 1.21319644, 0.20140186],
    "linear PTT": [3.0, 1.69924391, 0.35132565],
    "exponential PTT": [3.0, 1.50387334, 0.282671],
    "FENE-P": [3.5625, 1.86274261, 0.36107138],
}

SWING = {  # G', G'' and the mean of N1/9 in a strain of 3 sin t
    "giesekus": [0.25642787, 0.41315569, 0.29026791],
    "linear PTT": [0.44893965, 0.5009617, 0.45583267],
    "exponential PTT": [0.3825807, 0.49336086, 0.3962157],
    "FENE-P": [0.47119416, 0.51636957, 0.47425861],
}

MOMENT = 1e-9
"""Duration of a step of strain: it changes stresses by about as much."""


def polymer(name, **changes):
    """Return a law of relaxation time 1 and polymer viscosity 1 in uniform shear, without solvent."""
    given = {**PARAMETERS[name], **changes}
    law = registry.load("rheology", given["type"]).Parameters(**given, relaxation_time=1.0, solvent_fraction=0.5)
    return UniformShear(lambda rate: 0.0 * rate, law.laws(2.0))


def constant(rate):
    return [(0.0, lambda t: rate + 0.0 * t)]


def step_of(strain):
    return [(0.0, lambda t: strain / MOMENT + 0.0 * t), (MOMENT, lambda t: 0.0 * t)]


@pytest.mark.parametrize("name", PARAMETERS)
def test_steady_viscosities_and_normal_stresses(name):
    for rate, viscosity, normal in zip([0.1, 1.0, 10.0, 100.0], *STEADY[name], strict=True):
        stress, difference = polymer(name).steady(rate)
        assert stress / rate == pytest.approx(viscosity, abs=6e-9, rel=1e-8)
        assert difference / rate**2 == pytest.approx(normal, abs=6e-9, rel=1e-8)


@pytest.mark.parametrize("name", PARAMETERS)
def test_largest_stresses_of_a_start(name):
    """A polynomial through the stress near the largest one has its value and its strain."""
    shear, normal, fast, after_one = LARGEST[name]
    for rate, row, (value, strain) in ((5.0, 0, shear), (5.0, 1, normal), (20.0, 0, fast)):
        times = strain / rate * np.linspace(0.95, 1.05, 11)
        stress = polymer(name).response(constant(rate), times)[row]
        curve = np.polynomial.Polynomial.fit(times, stress, 6)
        peak = min(curve.deriv().roots(), key=lambda root: abs(root - strain / rate)).real
        assert curve(peak) == pytest.approx(value, rel=3e-8)
        assert rate * peak == pytest.approx(strain, abs=2e-5)
    assert polymer(name).response(constant(5.0), [1.0])[0] == pytest.approx(after_one, rel=1e-8)


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_step_of_strain_and_the_identity_of_lodge_and_meissner(name):
    stress, normal = polymer(name).response(step_of(3.0), MOMENT + np.array([0.0, 0.5, 2.0]))
    assert stress == pytest.approx(STEP[name], rel=1e-7)
    assert normal == pytest.approx(3.0 * stress, rel=1e-7)


@pytest.mark.parametrize("name", PARAMETERS)
def test_moduli_and_mean_normal_stress_of_a_large_oscillation(name):
    t = 6.0 * np.pi + np.pi * np.arange(32) / 32  # over half a period, after which the shear stress changes its sign
    stress, normal = polymer(name).response([(0.0, lambda t: 3.0 * np.cos(t))], t)
    elastic, viscous = (2.0 * np.mean(stress * wave(t)) / 3.0 for wave in (np.sin, np.cos))
    assert [elastic, viscous, normal.mean() / 9.0] == pytest.approx(SWING[name], abs=2e-8)


def test_steady_curves_of_linear_ptt_and_fene_p_are_the_same():
    """The extensibility is the inverse of the maximum extension."""
    network, springs = polymer("linear PTT", extensibility=1.0 / 60.0), polymer("FENE-P")
    for rate in (0.1, 1.0, 10.0, 100.0):
        assert network.steady(rate) == pytest.approx(springs.steady(rate), rel=1e-9)
