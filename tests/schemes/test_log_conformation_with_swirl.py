"""The logarithm of a conformation tensor with six components: there and back, its slopes, and how a flow changes it."""

import numpy as np
import pytest
from polymer_laws import KINDS, TIME, law
from scipy.linalg import expm, expm_frechet

from tisph.schemes._local_newton import SMALL, matrix
from tisph.schemes.implicit.planar import log_conformation_with_swirl

conformation_excess = log_conformation_with_swirl.conformation_excess
logarithm = log_conformation_with_swirl.logarithm
rate = log_conformation_with_swirl.rate
PLACES = log_conformation_with_swirl.PLACES
SIZES = 0.0, 1e-4, 0.02, 0.5, 2.0
"""Of P: both sides of where series give way to functions, differences of 1e-3."""


def full(components):
    return np.ravel(components)[PLACES]


def relaxed(kind, conformation):
    """dA/dt by relaxation, of matrices: the formulas in ``tisph/rheology``, with the numbers of ``polymer_laws``."""
    excess, trace = conformation - np.eye(3), np.trace(conformation) - 3.0
    return (
        -1.0
        / TIME
        * {
            "oldroyd_b": excess,
            "giesekus": excess + 0.3 * excess @ excess,
            "linear_ptt": (1.0 + 0.25 * trace) * excess,
            "exponential_ptt": np.exp(0.25 * trace) * excess,
            "fene_p": 17.0 / (17.0 - trace) * conformation - np.eye(3),
        }[kind]
    )


@pytest.mark.parametrize("kind", KINDS)
def test_six_components_follow_the_law(kind):
    # A = exp P, so dA/dt is the derivative of exp at P along dP/dt; rounding of A and of 1/A, which the rate has
    random = np.random.default_rng(2)
    for size in SIZES:
        state, (xx, xr, rx, rr, tt, tx, tr) = size * random.normal(size=6), random.normal(size=7)
        gradient = np.array([[xx, xr, 0.0], [rx, rr, 0.0], [tx, tr, tt]])
        numbers = np.array([[xx, xr, rx, rr, tt, tx, tr]]).T
        changed = rate(law(kind).in_three_dimensions(), state[:, None], numbers)
        conformation, change = expm_frechet(full(state), full(changed))
        rounding = 1e-13 * np.linalg.cond(conformation)
        assert np.abs(full(conformation_excess(state[:, None])) + np.eye(3) - conformation).max() < rounding
        stretched = gradient @ conformation
        expected = stretched + stretched.T + relaxed(kind, conformation)
        assert np.abs(change - expected).max() < 1e2 * rounding * max(1.0, np.abs(expected).max()), size


def test_complex_steps_give_slopes_of_six_components():
    # of the exponential exactly; of its rate by differences, to 1e-10 of it
    random = np.random.default_rng(3)
    for size in SIZES:
        state, way = size * random.normal(size=(2, 6, 1))
        found = np.imag(conformation_excess(state + 1j * SMALL * way)) / SMALL
        expected = expm_frechet(full(state), full(way), compute_expm=False)
        assert np.abs(full(found) - expected).max() < 1e-13 * np.linalg.cond(expm(full(state)))
    rows = matrix(
        lambda p: rate(law("oldroyd_b").in_three_dimensions(), p, np.zeros((7, 1))), np.zeros((6, 1)), 0.5 * TIME
    )
    assert np.abs(np.array(rows, dtype=object).astype(float).reshape(6, 6) - 1.5 * np.eye(6)).max() < 1e-9


def test_logarithm_of_six_components_undoes_the_exponential():
    states = np.random.default_rng(3).normal(size=(6, 30)) * np.geomspace(1e-9, 2.0, 30)
    conditions = [np.linalg.cond(expm(full(state))) for state in states.T]
    found = logarithm(conformation_excess(states))
    assert np.all(np.abs(found - states) < 1e-14 * np.array(conditions))
    gone = np.full((6, 2), [np.nan, 0.0])  # one that is not finite does not harm another one
    assert np.array_equal(np.isnan(conformation_excess(gone)).all(axis=0), [True, False])
