"""The laws of polymers against closed forms of steady flows, their limits, and what a conformation tensor must be."""

import numpy as np
import pytest
from polymer_laws import KINDS, LAWS, TIME, VISCOSITY, conformation_excess, law, least_root, steady_shear
from scipy.integrate import solve_ivp
from scipy.special import lambertw

ROUNDING = 2e-13  # of numbers up to the square of the largest rate, 100, over the smallest law
WEISSENBERG = [0.01, 0.5, 3.0, 100.0]
NONLINEAR = [kind for kind in KINDS if kind != "oldroyd_b"]


@pytest.mark.parametrize("wi", WEISSENBERG)
@pytest.mark.parametrize("kind", KINDS)
def test_steady_shear_is_that_of_the_literature(kind, wi):
    c = steady_shear(kind, wi)
    rates = np.array(LAWS[kind].rate_in_shear(c, wi / TIME))
    assert np.abs(rates).max() < ROUNDING * (1 + np.abs(c).max()) * (1 + wi) ** 2


@pytest.mark.parametrize("wi", WEISSENBERG)
@pytest.mark.parametrize("kind", ["linear_ptt", "exponential_ptt", "fene_p"])
def test_viscosity_and_first_normal_stress_difference(kind, wi):
    """S_xy = eta_p rate/Y and N1 = 2 relaxation_time S_xy^2/eta_p, of FENE-P with f for Y."""
    stress = LAWS[kind].stress(steady_shear(kind, wi))
    numbers = KINDS[kind]
    if kind == "exponential_ptt":
        y = np.exp(lambertw(4 * numbers["extensibility"] * wi**2).real / 2)
    else:
        y = least_root(2 * wi**2 * numbers.get("extensibility", 1 / numbers.get("maximum_extension", 1)))
    assert stress[1] == pytest.approx(VISCOSITY * wi / TIME / y, rel=1e-11)
    assert stress[0] - stress[2] == pytest.approx(2 * TIME * stress[1] ** 2 / VISCOSITY, rel=1e-11)


def steady_elongation(kind, wi):
    """C_xx and C_yy, of FENE-P also C_zz, in planar elongation at ``wi`` = relaxation time * rate."""
    numbers = KINDS[kind]
    if kind == "oldroyd_b":
        return [2 * wi / (1 - 2 * wi), -2 * wi / (1 + 2 * wi)]
    if kind == "giesekus":
        a = numbers["mobility"]
        return [(2 * w - 1 + np.sqrt((1 - 2 * w) ** 2 + 8 * a * w)) / (2 * a) for w in (wi, -wi)]
    if kind == "linear_ptt":
        epsilon = numbers["extensibility"]
        y = max(np.roots([1.0, -1.0, -4 * wi**2, 4 * wi**2 - 8 * epsilon * wi**2]).real)
        return [2 * wi / (y - 2 * wi), -2 * wi / (y + 2 * wi)]
    large = numbers["maximum_extension"]
    # (f - 1) L2 = f tr A - 3 with tr A = 1/(f - 2 Wi) + 1/(f + 2 Wi) + 1/f
    f = max(np.roots([1.0, -1.0, -4 * wi**2, 4 * wi**2 * (1 - 2 / large)]).real)
    return [1 / (f - 2 * wi) - 1, 1 / (f + 2 * wi) - 1, 1 / f - 1]


@pytest.mark.parametrize(
    ("kind", "wi"),
    [
        *((kind, wi) for kind in ("giesekus", "linear_ptt", "fene_p") for wi in (0.01, 0.4, 0.5, 3.0)),
        ("oldroyd_b", 0.3),  # below its limit
    ],
)
def test_steady_elongation_is_that_of_the_literature(kind, wi):
    xx, yy, *zz = steady_elongation(kind, wi)
    rate = wi / TIME
    rates = np.array(LAWS[kind].rate((xx, 0.0, yy, *zz), (rate, 0.0, 0.0, -rate)))
    assert np.abs(rates).max() < ROUNDING * (1 + abs(xx)) ** 2 * (1 + wi)


@pytest.mark.parametrize("kind", KINDS)
def test_deformation_is_that_of_a_tensor(kind):
    """L C + C L^T + L + L^T in matrices, and simple shear as its special case."""
    now, gradient = LAWS[kind], np.array([[0.3, -0.7], [0.4, -0.2]])
    c = conformation_excess(now.components, 1)[:, 0]
    tensor = np.array([[c[0], c[1]], [c[1], c[2]]])
    stretched = gradient @ tensor + tensor @ gradient.T + gradient + gradient.T
    found = np.array(now.rate(c, gradient.ravel())) - now.relaxation(c)
    assert np.allclose(found, [*stretched[[0, 0, 1], [0, 1, 1]], 0.0][: now.components], atol=1e-15)
    assert np.allclose(now.rate_in_shear(c, 0.8), now.rate(c, (0.0, 0.8, 0.0, 0.0)), atol=1e-15)


def started(now, gradient, end):
    """Deviations from rest on, as solve_ivp steps, shape (components, steps)."""
    rest = np.zeros(now.components)
    done = solve_ivp(lambda t, c: now.rate(c, gradient), (0, end), rest, method="Radau", rtol=1e-8, atol=1e-10)
    assert done.success
    return done.y


@pytest.mark.parametrize("kind", KINDS)
def test_a_small_strain_meets_the_theory_of_maxwell(kind):
    rate, end = 1e-5, 2.0
    found = LAWS[kind].stress(started(LAWS[kind], (0.0, rate, 0.0, 0.0), end)[:, -1])
    # what bends is of the order of the squared strain; the integration errs by its tolerance on C = 1e-5
    assert found[1] == pytest.approx(VISCOSITY * rate * -np.expm1(-end / TIME), rel=1e-4)


@pytest.mark.parametrize("gradient", [(0.0, 20.0, 0.0, 0.0), (4.0, 0.0, 0.0, -4.0)], ids=["shear", "elongation"])
@pytest.mark.parametrize("kind", NONLINEAR)
def test_conformation_stays_positive_and_ends_in_the_steady_flow(kind, gradient):
    now = LAWS[kind]
    c = started(now, gradient, 60 * TIME)
    trace, determinant = 2 + c[0] + c[2], (1 + c[0]) * (1 + c[2]) - c[1] ** 2
    assert trace.min() > 0
    assert determinant.min() > 0
    if kind == "fene_p":
        assert (1 + c[3]).min() > 0
        assert (trace + 1 + c[3]).max() < KINDS[kind]["maximum_extension"]
    if gradient[1]:
        assert np.allclose(c[:, -1], steady_shear(kind, gradient[1] * TIME), rtol=1e-5)
    elif kind != "exponential_ptt":
        assert np.allclose(
            c[[0, 2, 3][: now.components - 1], -1], steady_elongation(kind, gradient[0] * TIME), rtol=1e-5
        )


@pytest.mark.parametrize(
    ("kind", "numbers", "apart"),
    [
        ("giesekus", {"mobility": 0.0}, 0.0),
        ("linear_ptt", {"extensibility": 0.0}, 0.0),
        ("exponential_ptt", {"extensibility": 0.0}, 0.0),
        ("fene_p", {"maximum_extension": 1e14}, 1e-13),  # 1/L2, times a trace of 2 and its square
    ],
)
def test_each_law_has_oldroyd_b_as_its_limit(kind, numbers, apart):
    limit, c = law(kind, **numbers), conformation_excess(4, 20)
    for name in ("relaxation", "stress"):
        found, expected = getattr(limit, name)(c), getattr(LAWS["oldroyd_b"], name)(c)
        for one, other in zip(found, expected, strict=False):
            assert np.allclose(one, other, rtol=1e-14, atol=apart)


@pytest.mark.parametrize("kind", KINDS)
def test_complex_steps_are_derivatives(kind):
    """They are exact; central differences with steps of 1e-5 err by 1e-10 and by rounding, 1e-16/1e-5."""
    now = LAWS[kind]
    c = conformation_excess(now.components, 7)
    for function in (now.relaxation, now.stress):
        for k in range(now.components):
            step = np.zeros((now.components, 1))
            step[k] = 1.0
            exact = np.imag(function(c + 1e-30j * step)) / 1e-30
            differences = (np.array(function(c + 1e-5 * step)) - function(c - 1e-5 * step)) / 2e-5
            assert np.allclose(exact, differences, rtol=1e-7, atol=1e-8)
