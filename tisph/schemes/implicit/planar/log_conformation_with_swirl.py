"""The logarithm P of a conformation tensor A with all six components: xx, xr, rr, tt, xt, rt, t being around an axis.

In the axes of P, where it has p_i and the velocity gradient L the symmetric part D and the other one W,

    dP_ij/dt = D_ij z coth(z/2) - W_ij z,    z = p_i - p_j,

z coth(z/2) being 2 where z is 0, and relaxation R adds R_ii/exp(p_i). A change V of P changes exp P, in the same axes,
by V_ij (exp p_i - exp p_j)/(p_i - p_j) (Yu. L. Daleckii and S. G. Krein, 1965). Functions of a
complex step use this formula, for a complex P has no such axes; ``rate`` uses differences, since Newton's method alone
needs its slopes.
Sources: as of ``log_conformation``.
"""

from typing import Any

import numpy as np

from tisph.schemes._local_newton import SMALL, Modes

PLACES = np.array([[0, 1, 4], [1, 2, 5], [4, 5, 3]])
"""Components by rows and columns x, r, t."""

DIFFERENCE = 1e-5
"""Of P, for slopes of its rate: both truncation and rounding leave some 1e-10 of them."""

NEAR = 1e-3
"""Difference of p_i below which series are used; their truncation error is below 1e-16."""


class ModesWithSwirl(Modes):
    """Modes whose stress has six components: in every law the shear stress is linear in the shear component of C."""

    def stress(self, state: Any, components: int = 6) -> np.ndarray:
        """Return S_xx, S_xr, S_rr, S_tt, S_xt, S_rt per unit density, the sums over the modes."""
        total: Any = 0.0
        for law, part in self:
            xx, xr, rr, tt, *around = conformation_excess(state[part])
            shear = [law.stress((xx, each, rr, tt))[1] for each in around]
            total = total + np.stack([*law.stress((xx, xr, rr, tt)), *shear])
        return total


def conformation_excess(state: Any) -> np.ndarray:
    """Return the components (6, n) of A - 1 for the components of P."""
    values, axes = _axes(state.real)
    excess = _components(axes * np.expm1(values)[:, None, :] @ _transposed(axes))
    if not np.iscomplexobj(state):
        return excess
    change = _transposed(axes) @ _matrix(state.imag) @ axes
    return excess + 1j * _components(axes @ (_slope(values) * change) @ _transposed(axes))


def _slope(values: np.ndarray) -> np.ndarray:
    """Return (exp p_i - exp p_j)/(p_i - p_j) (n, 3, 3) of the eigenvalues (n, 3) of P."""
    half = 0.5 * (values[:, :, None] - values[:, None, :])
    near = np.abs(half) < NEAR
    slope = np.where(near, 1.0 + half**2 / 6.0, np.sinh(half) / np.where(near, 1.0, half))
    return slope * np.exp(0.5 * (values[:, :, None] + values[:, None, :]))


def change_of_logarithm(state: Any, change: np.ndarray) -> np.ndarray:
    """Return the change of P that a ``change`` of A has, both in the components of ``state``, real, from xx on."""
    full, moved = np.zeros((2, 6, state.shape[1]))
    full[: len(state)], moved[: len(change)] = state, change
    values, axes = _axes(full)
    moved = _transposed(axes) @ _matrix(moved) @ axes
    return _components(axes @ (moved / _slope(values)) @ _transposed(axes))[: len(state)]


def logarithm(conformation_excess: Any) -> np.ndarray:
    """Return P (6, n) of the components of A - 1."""
    values, axes = _axes(np.asarray(conformation_excess))
    return _components(axes * np.log1p(values)[:, None, :] @ _transposed(axes))


def rate(law: Any, state: Any, gradient: np.ndarray) -> np.ndarray:
    """Return dP/dt (6, n) of a mode for the components xx, xr, rx, rr, tt, tx and tr of the velocity ``gradient``."""
    if np.iscomplexobj(state):
        way = DIFFERENCE / SMALL * state.imag
        after, before = (rate(law, state.real + sign * way, gradient) for sign in (1.0, -1.0))
        return 0.5j * SMALL / DIFFERENCE * (after - before)
    values, axes = _axes(state)
    zero = np.zeros_like(gradient[0])
    xx, xr, rx, rr, tt, tx, tr = gradient
    full = np.array([[xx, xr, zero], [rx, rr, zero], [tx, tr, tt]]).transpose(2, 0, 1)
    full = _transposed(axes) @ full @ axes
    apart = values[:, :, None] - values[:, None, :]
    near = np.abs(apart) < NEAR
    scaled = np.where(near, 2.0 + apart**2 / 6.0, apart / np.tanh(0.5 * np.where(near, 1.0, apart)))
    change = 0.5 * ((full + _transposed(full)) * scaled - (full - _transposed(full)) * apart)
    first, second, third = np.expm1(values).T
    relaxation = law.relaxation((first, 0.0 * first, second, third))
    for place, component in enumerate((0, 2, 3)):
        change[:, place, place] += relaxation[component] / np.exp(values[:, place])
    return _components(axes @ change @ _transposed(axes))


def _axes(state: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues (n, 3) and axes (n, 3, 3), in columns, of components (6, n); NaN where one is not finite."""
    full, finite = _matrix(state), np.isfinite(state).all(axis=0)
    values, axes = np.linalg.eigh(np.where(finite[:, None, None], full, 0.0))
    return np.where(finite[:, None], values, np.nan), axes


def _matrix(components: np.ndarray) -> np.ndarray:
    return components[PLACES].transpose(2, 0, 1)


def _transposed(matrices: np.ndarray) -> np.ndarray:
    return matrices.transpose(0, 2, 1)


def _components(matrices: np.ndarray) -> np.ndarray:
    return matrices[:, (0, 0, 1, 2, 0, 1), (0, 1, 1, 2, 2, 2)].T
