"""Steady flow in a lid-driven cavity: the stream function as a polynomial, by Galerkin's and Newton's methods.

In the cell 0 <= x <= 1, 0 <= y <= a with u = psi_y, v = -psi_x and the lid y = a moving as u = g(x), and for every
function phi that is 0 at the walls with its normal derivative,

    int lap psi lap phi/Re + lap psi (psi_y phi_x - psi_x phi_y) = 0
    psi = g(x) a (Y^3 - Y^2) + sum c_kl f_k(X) f_l(Z)

with Y = y/a, X and Z in [-1, 1] across the cell. The first part of psi has the velocities of the walls; the functions
f_k are sums of the Legendre polynomials k, k + 2 and k + 4 that are 0 at both ends with their derivatives. In this weak
form the corners, where psi is only as smooth as r^3.7 (H. K. Moffatt, J. Fluid Mech. 18 (1964) 1-18), cost least; by
collocation at 48 points each way the highest polynomials spoil the velocity by 1e-6.

Source: J. Shen, SIAM J. Sci. Comput. 15 (1994) 1489-1505, equation (3.2) and section 3.
"""

from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial, legendre

NEWTON_STEPS = 20
TOLERANCE = 1e-9
"""Of the last step of Newton's method, in units of the lid's speed and the width; the error is about its square."""

FIRST_REYNOLDS, GROWTH = 100.0, 2.0
"""Newton's method starts from Stokes flow, and goes to Reynolds numbers above the first by this factor at a time."""

LID = Polynomial([0.0, 0.0, 16.0, -32.0, 16.0])
"""Velocity 16 x^2 (1 - x)^2 of the regular lid, over its largest, in the middle."""


@lru_cache(maxsize=8)
def stream_function(reynolds, aspect, order):
    """Legendre coefficients (order + 1, order + 1) of psi over X and Z; ``aspect`` a = height/width.

    ValueError where Newton's method does not converge: Re is too large for the order.
    """
    equations = _Equations(aspect, order)
    stages = [reynolds]
    while stages[-1] > FIRST_REYNOLDS:
        stages.append(stages[-1] / GROWTH)
    c = np.zeros((order - 3) ** 2)
    for stage in reversed(stages):
        c = _newton(equations, c, stage)
    return equations.coefficients(c)


def _newton(equations, c, reynolds):
    for _ in range(NEWTON_STEPS):
        step = np.linalg.solve(*equations.linearised(c, reynolds))
        c = c - step
        if np.abs(step).max() <= TOLERANCE:
            return c
    raise ValueError(f"no steady flow was found at Re = {reynolds:g}: take a higher order, or a smaller Re")


class _Equations:
    """The weak form for all phi = f_k f_l as one vector, and its derivatives; integrals by Gauss's quadrature."""

    def __init__(self, aspect, order):
        self.aspect = aspect
        self.basis = _clamped(order)
        node, weight = legendre.leggauss(order + 5)  # exact for lap psi lap phi with the lift
        self.place = 0.5 * (1 + node)
        values = [legendre.legvander(node, order - k) @ legendre.legder(self.basis, k) for k in range(3)]
        along, across = ([value * (2 / size) ** k for k, value in enumerate(values)] for size in (1.0, aspect))
        self.x, self.y, xx, yy = (np.kron(along[i], across[j]) for i, j in ((1, 0), (0, 1), (2, 0), (0, 2)))
        self.lap = xx + yy
        self.lift_x, self.lift_y = self._lift(1, 0), self._lift(0, 1)
        self.lift_lap = self._lift(2, 0) + self._lift(0, 2)
        self.weight = np.outer(weight, weight).ravel()
        self.viscous = self.lap.T @ (self.weight[:, None] * self.lap)

    def linearised(self, c, reynolds):
        """Return the derivatives (n, n) of the equations over the coefficients ``c`` (n,), and the equations (n,)."""
        x, y, lap = self.x @ c + self.lift_x, self.y @ c + self.lift_y, self.lap @ c + self.lift_lap
        x, y, weighted = self.weight * x, self.weight * y, self.weight * lap
        equations = self.lap.T @ (weighted / reynolds) + self.x.T @ (lap * y) - self.y.T @ (lap * x)
        slopes = self.x.T @ (y[:, None] * self.lap + weighted[:, None] * self.y)
        slopes -= self.y.T @ (x[:, None] * self.lap + weighted[:, None] * self.x)
        return slopes + self.viscous / reynolds, equations

    def coefficients(self, c):
        """Return the Legendre coefficients of psi."""
        count = self.basis.shape[1]
        total = self.basis @ c.reshape(count, count) @ self.basis.T
        half = Polynomial([0.5, 0.5])
        profile, height = (legendre.poly2leg(part(half).coef) for part in (LID, Polynomial([0.0, 0.0, -1.0, 1.0])))
        total[: len(profile), : len(height)] += self.aspect * np.outer(profile, height)
        return total

    def _lift(self, i, j):
        """Return d^(i + j)/dx^i dy^j of the first part of psi at the points of the quadrature."""
        height = Polynomial([0.0, 0.0, -1.0, 1.0]).deriv(j)(self.place)
        return np.outer(LID.deriv(i)(self.place), height).ravel() * self.aspect ** (1 - j)


def _clamped(order):
    """Legendre coefficients (order + 1, order - 3) of the functions f_k, scaled so that int f_k''^2 = 1."""
    k = np.arange(order - 3)
    scale = 1 / np.sqrt(2 * (2 * k + 3) ** 2 * (2 * k + 5))
    basis = np.zeros((order + 1, order - 3))
    basis[k, k] = scale
    basis[k + 2, k] = -scale * 2 * (2 * k + 5) / (2 * k + 7)
    basis[k + 4, k] = scale * (2 * k + 3) / (2 * k + 7)
    return basis
