"""Taylor vortices: critical Reynolds numbers and growth rates of the literature, and energy of the disturbance."""

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from scipy.optimize import minimize_scalar

from tisph.exact.taylor_vortices import ElasticVortices, TaylorVortices, coefficients, critical_reynolds


@pytest.mark.parametrize(
    ("ratio", "reynolds", "wavenumber"),
    [(0.5, 68.18627, 3.16248), (5 / 7, 81.07840, 3.13780), (0.883, 121.97910, 3.12928)],
)
def test_critical_reynolds_numbers_of_two_other_solvers(ratio, reynolds, wavenumber):
    """shared/reference/axisymmetric.md, to its last digit; with 0.5: 68.19, 3.16 (DiPrima and Swinney 1981)."""
    least = minimize_scalar(lambda k: critical_reynolds(ratio, k), bounds=(2.5, 4.0), options={"xatol": 1e-7})
    assert least.fun == pytest.approx(reynolds, abs=6e-6)
    assert least.x == pytest.approx(wavenumber, abs=6e-6)
    radii = ratio / (1 - ratio), 1 / (1 - ratio)
    below, at, above = (
        TaylorVortices(radii, (1.0, 0.0), radii[0] / (least.fun * part), wavenumber).growth_rate
        for part in (0.99, 1.0, 1.01)
    )
    assert below < -1e-4
    assert abs(at) < 1e-10
    assert above > 1e-4


def test_the_growth_rate_of_marcus():
    """J. Fluid Mech. 146 (1984) 65-113 prints 0.035636; two other solvers have 0.035639."""
    found = TaylorVortices((1.0, 2.0), (1.0, 0.0), 1 / 74.924, 3.161)
    assert found.growth_rate == pytest.approx(0.035639, abs=6e-7)
    twice = TaylorVortices((2.0, 4.0), (3.0, 0.0), 12 / 74.924, 3.161 / 2)  # the same in other units
    assert twice.growth_rate == pytest.approx(3 * found.growth_rate, rel=1e-9)


def test_vortices_decay_where_rayleigh_says_so():
    """Inviscid flow is stable where (W r^2)^2 grows outwards: W2/W1 > (R1/R2)^2."""
    for outer in (0.26, 1.0):
        assert TaylorVortices((1.0, 2.0), (1.0, outer), 1e-3, 3.0).growth_rate < 0


@pytest.mark.parametrize("outer", [0.0, -0.5])
def test_the_energy_of_vortices_grows_as_they_do(outer):
    """s int u^2 r dr = -int a c r dW/dr r dr - nu int vorticity^2 r dr, by squares over a wavelength; no slip."""
    nu, k, (inner, outside) = 1 / 300, 3.0, (1.0, 2.0)
    found = TaylorVortices((inner, outside), (1.0, outer), nu, k)
    r = 1.5 + 0.5 * np.cos(np.pi * np.arange(49) / 48)
    parts = [Chebyshev.fit(r, part, 48, domain=(inner, outside)) for part in found.velocity(r)]
    nodes, weights = np.polynomial.legendre.leggauss(64)
    r, weights = 1.5 + 0.5 * nodes, weights * (1.5 + 0.5 * nodes)
    (a, b, c), (_, db, dc) = ([part(r) for part in some] for some in (parts, [part.deriv() for part in parts]))
    assert np.allclose(b * k, -parts[0].deriv()(r) - a / r, atol=1e-9)
    _, constant = coefficients((inner, outside), (1.0, outer))
    production = weights @ (2 * constant / r**2 * a * c)
    dissipation = nu * weights @ ((dc + c / r) ** 2 + k**2 * c**2 + (k * a + db) ** 2)
    energy = weights @ (a**2 + b**2 + c**2)
    assert found.growth_rate > 0.1
    assert (production - dissipation) / energy == pytest.approx(found.growth_rate, rel=1e-9)
    assert np.allclose(found.velocity(np.array([inner, outside])), 0.0, atol=1e-10)
    assert np.max(a) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(
    ("ratio", "reynolds", "wavenumber", "deborah", "expected"),
    [
        (0.9, 1.0, 8.0, 22.0, 0.00361647 + 0.05723428j),
        (0.8, 1.0, 8.0, 20.0, 0.00828110 + 0.08299942j),
        (0.8, 1.0, 8.0, 12.0, -0.01600224 + 0.08869387j),
        (0.8, 0.0, 8.0, 20.0, 0.00799974 + 0.08299562j),
        (0.5, 1.0, 8.0, 25.0, 0.00370135 + 0.09417848j),
        (0.5, 75.0, 3.16, 0.1, 0.04151059),
        (0.9, 0.0, 8.15978, 20.222588, 0.0573309j),
        (0.8, 0.0, 11.58507, 15.361475, 0.0821030j),
    ],
)
def test_elastic_vortices_of_two_other_solvers(ratio, reynolds, wavenumber, deborah, expected):
    """shared/reference/viscoelastic.md, part E, to its last digit: De = lam W1 R1/d, in units of W1 R1/d; d = 1."""
    radii, viscosity = (ratio / (1 - ratio), 1 / (1 - ratio)), 1 / reynolds if reynolds else np.inf
    found = ElasticVortices(radii, (1 / radii[0], 0.0), viscosity, wavenumber, deborah, 0.5)
    assert abs(found.growth_rate - expected) < 6e-8


def test_elastic_vortices_without_polymer_are_taylor_vortices():
    found = ElasticVortices((1.0, 2.0), (1.0, 0.0), 1 / 74.924, 3.161, 0.1, 1.0)
    exact = TaylorVortices((1.0, 2.0), (1.0, 0.0), 1 / 74.924, 3.161)
    assert found.growth_rate == pytest.approx(exact.growth_rate, rel=1e-8)
