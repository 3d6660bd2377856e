"""The logarithm of a conformation tensor: there and back, and how a flow changes it."""

import numpy as np
import pytest
from scipy.linalg import expm, expm_frechet

from tisph import registry
from tisph.schemes._local_newton import SMALL, eliminate, matrix
from tisph.schemes.implicit.planar import log_conformation

conformation_excess = log_conformation.conformation_excess
logarithm = log_conformation.logarithm
rate = log_conformation.rate
LAWS = {
    "oldroyd_b": {},
    "giesekus": {"mobility": 0.3},
    "phan_thien_tanner": {"extensibility": 0.2},
    "fene_p": {"maximum_extension": 1e3},
}
SIZES = 0.0, 1e-3, 0.02, 0.04, 0.5, 2.0
"""Of P: both sides of where series give way to functions, s^2 = 1e-3."""


def law(name):
    numbers = {"relaxation_time": 0.6, "solvent_fraction": 0.3, **LAWS[name]}
    return registry.load("rheology", name).Parameters(**numbers).laws(1.0)[0]


def full(components):
    """The matrix of components xx, xy, yy and, where there is one, zz, which is 0 elsewhere."""
    xx, xy, yy, zz = (*np.ravel(components), 0.0)[:4]
    return np.array([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, zz]])


@pytest.mark.parametrize("name", LAWS)
def test_the_logarithm_follows_the_law(name):
    # A = exp P, so dA/dt is the derivative of exp at P along dP/dt; rounding of A and of 1/A, which the rate has
    mode, random = law(name), np.random.default_rng(2)
    for size in SIZES:
        logarithm, gradient = size * random.normal(size=mode.components), random.normal(size=4)
        conformation, changes = expm_frechet(full(logarithm), full(rate(mode, logarithm[:, None], gradient[:, None])))
        found = conformation_excess(logarithm[:, None])
        rounding = 1e-14 * np.linalg.cond(conformation)
        assert np.abs(full(found) + np.eye(3) - conformation).max() < rounding
        expected = mode.rate(np.ravel(found), gradient)
        assert np.abs(changes - full(expected)).max() < 1e2 * rounding, size


def test_slopes_are_those_of_complex_steps():
    # the derivative of exp once more: functions of s^2 have no corner at s = 0, nor where series begin
    random = np.random.default_rng(3)
    for size in SIZES:
        logarithm, way = size * random.normal(size=3), random.normal(size=3)
        found = np.imag(conformation_excess((logarithm + 1j * SMALL * way)[:, None])) / SMALL
        expected = expm_frechet(full(logarithm), full(way), compute_expm=False)
        assert np.abs(full(found) - expected).max() < 1e-13 * np.linalg.cond(expm(full(logarithm)))


def test_newton_sees_the_law_at_rest():
    # dP/dt = -P/lambda about rest, whatever else: the matrix of an implicit step is (1 + h/lambda) 1
    rows = matrix(lambda p: rate(law("oldroyd_b"), p, np.zeros((4, 1))), np.zeros((3, 1)), 0.3)
    assert np.abs(np.array(rows, dtype=object).astype(float).reshape(3, 3) - 1.5 * np.eye(3)).max() < 1e-14


def test_logarithm_and_deviation_undo_each_other():
    states = np.random.default_rng(3).normal(size=(4, 30)) * np.geomspace(1e-9, 5.0, 30)
    states[:3, 0], states[1, 1] = 0.0, 0.0
    found = logarithm(np.array(conformation_excess(states)))
    conditions = np.exp(2.0 * np.hypot(0.5 * (states[0] - states[2]), states[1]))  # of A, whose rounding log A has
    assert np.all(np.abs(found - states) < 1e-14 * conditions)


def test_small_systems_are_solved_side_by_side():
    matrices, right = np.random.default_rng(3).uniform(size=(5, 3, 3)) + 2.0 * np.eye(3), np.ones((5, 3))
    found = eliminate(matrices.transpose(1, 2, 0), right.T)
    expected = np.linalg.solve(matrices, right[..., None])[..., 0].T
    assert found == pytest.approx(expected, rel=1e-12)
