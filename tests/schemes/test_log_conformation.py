"""The logarithm of a conformation tensor, planar and with swirl: there and back, and how a flow changes it."""

import numpy as np
import pytest
from polymer_laws import KINDS, TIME, law
from scipy.linalg import expm, expm_frechet

from tisph.schemes._local_newton import SMALL, eliminate, matrix
from tisph.schemes.implicit.planar import log_conformation, log_conformation_with_swirl

SIZES = 0.0, 1e-4, 1e-3, 0.02, 0.04, 0.5, 2.0
"""Of P: both sides of where series give way to functions."""


class Planar:
    """Components xx, xy, yy and, of some laws, zz."""

    module, smallest, rounding, at_rest, largest = log_conformation, 3, 1e-14, 1e-14, 5.0

    @staticmethod
    def full(components):
        xx, xy, yy, zz = (*np.ravel(components), 0.0)[:4]
        return np.array([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, zz]])

    @staticmethod
    def law(kind):
        return law(kind)

    @staticmethod
    def gradient(numbers):
        xx, xy, yx, yy = np.ravel(numbers)
        return np.array([[xx, xy, 0.0], [yx, yy, 0.0], [0.0, 0.0, 0.0]])

    numbers = 4


class WithSwirl:
    """All six components."""

    module, smallest, rounding, at_rest, largest = log_conformation_with_swirl, 6, 1e-13, 1e-9, 2.0

    @staticmethod
    def full(components):
        return np.ravel(components)[log_conformation_with_swirl.PLACES]

    @staticmethod
    def law(kind):
        return law(kind).in_three_dimensions()

    @staticmethod
    def gradient(numbers):
        xx, xr, rx, rr, tt, tx, tr = np.ravel(numbers)
        return np.array([[xx, xr, 0.0], [rx, rr, 0.0], [tx, tr, tt]])

    numbers = 7


both = pytest.mark.parametrize("form", [Planar, WithSwirl])


def relaxed(kind, conformation):
    """dA/dt by relaxation, of matrices: the formulas in ``tisph/rheology``, with the numbers of ``polymer_laws``."""
    excess, trace = conformation - np.eye(3), np.trace(conformation) - 3.0
    rates = {
        "oldroyd_b": excess,
        "giesekus": excess + 0.3 * excess @ excess,
        "linear_ptt": (1.0 + 0.25 * trace) * excess,
        "exponential_ptt": np.exp(0.25 * trace) * excess,
        "fene_p": 17.0 / (17.0 - trace) * conformation - np.eye(3),
    }
    return -rates[kind] / TIME


@both
@pytest.mark.parametrize("kind", KINDS)
def test_the_logarithm_follows_the_law(form, kind):
    # A = exp P, so dA/dt is the derivative of exp at P along dP/dt; rounding of A and of 1/A, which the rate has
    mode, random = form.law(kind), np.random.default_rng(2)
    components = max(form.smallest, mode.components)
    for size in SIZES:
        state, numbers = size * random.normal(size=components), random.normal(size=form.numbers)
        changed = form.module.rate(mode, state[:, None], numbers[:, None])
        conformation, change = expm_frechet(form.full(state), form.full(changed))
        rounding = form.rounding * np.linalg.cond(conformation)
        found = form.full(form.module.conformation_excess(state[:, None])) + np.eye(3)
        assert np.abs(found - conformation).max() < rounding
        stretched = form.gradient(numbers) @ conformation
        expected = stretched + stretched.T + relaxed(kind, conformation)
        scale = max(1.0, np.abs(expected).max()) if form is WithSwirl else 1.0
        assert np.abs(change - expected).max() < 1e2 * rounding * scale, size


@both
def test_slopes_are_those_of_complex_steps(form):
    # the derivative of exp once more: functions of s^2 have no corner at s = 0, nor where series begin
    random = np.random.default_rng(3)
    for size in SIZES:
        state, way = size * random.normal(size=(2, form.smallest, 1))
        found = np.imag(form.module.conformation_excess(state + 1j * SMALL * way)) / SMALL
        expected = expm_frechet(form.full(state), form.full(way), compute_expm=False)
        assert np.abs(form.full(found) - expected).max() < 1e-13 * np.linalg.cond(expm(form.full(state)))
    # dP/dt = -P/lambda about rest, whatever else: the matrix of an implicit step is (1 + h/lambda) 1
    mode, rest = form.law("oldroyd_b"), np.zeros((form.smallest, 1))
    rows = matrix(lambda p: form.module.rate(mode, p, np.zeros((form.numbers, 1))), rest, 0.5 * TIME)
    found = np.array(rows, dtype=object).astype(float).reshape(2 * (form.smallest,))
    assert np.abs(found - 1.5 * np.eye(form.smallest)).max() < form.at_rest


@both
def test_logarithm_and_exponential_undo_each_other(form):
    states = np.random.default_rng(3).normal(size=(form.smallest, 30)) * np.geomspace(1e-9, form.largest, 30)
    states[:, 0], states[1, 1] = 0.0, 0.0
    conditions = [np.linalg.cond(expm(form.full(state))) for state in states.T]
    found = form.module.logarithm(np.array(form.module.conformation_excess(states)))
    assert np.all(np.abs(found - states) < 1e-14 * np.array(conditions))


def test_a_state_that_is_not_finite_does_not_harm_another_one():
    gone = np.full((6, 2), [np.nan, 0.0])
    found = log_conformation_with_swirl.conformation_excess(gone)
    assert np.array_equal(np.isnan(found).all(axis=0), [True, False])


def test_small_systems_are_solved_side_by_side():
    matrices, right = np.random.default_rng(3).uniform(size=(5, 3, 3)) + 2.0 * np.eye(3), np.ones((5, 3))
    found = eliminate(matrices.transpose(1, 2, 0), right.T)
    expected = np.linalg.solve(matrices, right[..., None])[..., 0].T
    assert found == pytest.approx(expected, rel=1e-12)
