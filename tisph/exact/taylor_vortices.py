"""Linear stability of circular Couette flow to Taylor vortices: disturbances that are the same all around the axis.

The undisturbed fluid has the angular velocity W = A + B/r^2 between cylinders of given angular velocities. The
disturbances, x along the axis,

    u_r = a(r) cos(kx) e^(st),    u_x = b(r) sin(kx) e^(st),    u_t = c(r) cos(kx) e^(st)

obey, linearised and without pressure and u_x, with M = d2/dr2 + (1/r) d/dr - 1/r^2 - k^2 and no slip,

    s M a = nu M^2 a - 2 k^2 W c,    s c = nu M c - 2 A a,    b = -(da/dr + a/r)/k,    a = da/dr = c = 0 at the walls

They are solved by Galerkin's method with polynomials that satisfy the walls' conditions, (1 - z^2)^2 T_n(z) for a and
(1 - z^2) T_n(z) for c, -1 <= z <= 1 across the gap. Source: S. Chandrasekhar, Hydrodynamic and Hydromagnetic
Stability (1961), sections 70 to 72. Accuracy: 1e-10 at radius ratios from 0.1 on, and k up to 10 over the gap.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Chebyshev

COUNT = 32
"""Polynomials of each component."""


@dataclass(frozen=True)
class TaylorVortices:
    """The disturbance of ``wavenumber`` k (1/length) that grows fastest, or decays slowest.

    ``radii`` and ``angular_velocities`` (1/time) of the cylinders (inner, outer).
    """

    radii: tuple[float, float]
    angular_velocities: tuple[float, float]
    kinematic_viscosity: float
    wavenumber: float

    @property
    def growth_rate(self) -> float:
        """Real part of s (1/time), which is real where it is above 0."""
        return float(self._leading[0].real)

    def velocity(self, r: Any) -> np.ndarray:
        """Return the amplitudes (3, ...) of u_r, u_x and u_t at radii ``r``, scaled so that the largest a is 1."""
        radius = np.asarray(r, dtype=float)
        a, c = self._leading[1]
        slope = a.deriv()(radius)
        return np.stack([a(radius), -(slope + a(radius) / radius) / self.wavenumber, c(radius)])

    @cached_property
    def _leading(self) -> tuple[complex, list[Chebyshev]]:
        """s, and the series [a, c] in r."""
        from scipy.linalg import block_diag, eig

        basis = _Basis(*self.radii, self.wavenumber)
        slope, constant = coefficients(self.radii, self.angular_velocities)
        rotation = 2 * self.wavenumber**2 * (slope + constant / basis.r**2)[:, None] * basis.c
        nu = self.kinematic_viscosity
        rows = [[nu * basis.fourth, -rotation], [-2 * slope * basis.a, nu * basis.of_c]]
        left = np.concatenate([test @ np.hstack(row) for test, row in zip(basis.tests, rows, strict=True)])
        values, vectors = eig(left, block_diag(basis.tests[0] @ basis.of_a, basis.tests[1] @ basis.c))
        leading = np.argmax(values.real)
        a, c = np.split(vectors[:, leading], 2)
        a, c = (sum(x * f for x, f in zip(part, of, strict=True)) for part, of in ((a, basis.twice), (c, basis.once)))
        size = a(np.linspace(*self.radii, 1001))
        size = size[np.argmax(np.abs(size))]
        return values[leading], [Chebyshev((part / size).coef.real, domain=self.radii) for part in (a, c)]


def critical_reynolds(radius_ratio: float, wavenumber: float) -> float:
    """Return the W1 R1 d/nu at which s = 0, with the outer cylinder at rest; ``wavenumber``: k d, d = R2 - R1.

    With s = 0 the equations are M^2 a = 2 k^2 (W1/nu)^2 w c and M c = 2 A/W1 a, w = W/W1: eigenvalues (W1/nu)^2.
    """
    from scipy.linalg import eigvals

    radii = radius_ratio / (1 - radius_ratio), 1 / (1 - radius_ratio)
    basis = _Basis(*radii, wavenumber)
    slope, constant = coefficients(radii, (1.0, 0.0))
    c_of_a = basis.c @ np.linalg.solve(basis.tests[1] @ basis.of_c, basis.tests[1] @ (2 * slope * basis.a))
    rotation = 2 * wavenumber**2 * (slope + constant / basis.r**2)[:, None] * c_of_a
    shares = eigvals(basis.tests[0] @ rotation, basis.tests[0] @ basis.fourth)
    return float(radii[0] / np.sqrt(shares.real.max()))


def coefficients(radii: tuple[float, float], angular_velocities: tuple[float, float]) -> tuple[float, float]:
    """Return A and B of the angular velocity A + B/r^2."""
    (inner, outer), (slow, fast) = np.square(radii), angular_velocities
    slope = (fast * outer - slow * inner) / (outer - inner)
    return slope, (slow - slope) * inner


class _Basis:
    """Polynomials for c (``once``) and a (``twice``) between radii, and operators on them at points ``r``.

    Matrices (points, polynomials): ``a``, ``c``, M a (``of_a``), M c (``of_c``) and M^2 a (``fourth``). ``tests`` for
    the equations of a and of c: matrices (polynomials, points) of integrals over r dr with each polynomial.
    """

    def __init__(self, inner: float, outer: float, wavenumber: float) -> None:
        domain, k = (inner, outer), wavenumber**2
        z, weights = np.polynomial.legendre.leggauss(2 * COUNT)
        self.r = inner + (outer - inner) * (z + 1) / 2
        wall = Chebyshev([0.5, 0.0, -0.5], domain=domain)  # 1 - z^2
        self.once = [wall * Chebyshev.basis(n, domain=domain) for n in range(COUNT)]
        self.twice = [wall * each for each in self.once]

        def derivatives(polynomials: list[Chebyshev], orders: int) -> list[np.ndarray]:
            return [np.stack([each.deriv(n)(self.r) for each in polynomials], axis=1) for n in range(orders + 1)]

        r = self.r[:, None]
        self.c, first, second = derivatives(self.once, 2)
        self.of_c = second + first / r - (1 / r**2 + k) * self.c
        self.a, first, second, third, fourth = derivatives(self.twice, 4)
        curved = second + first / r - self.a / r**2
        self.of_a = curved - k * self.a
        fourth = fourth + 2 / r * third - 3 / r**2 * second + 3 / r**3 * first - 3 / r**4 * self.a
        self.fourth = fourth - 2 * k * curved + k**2 * self.a
        self.tests = [(values * (weights * self.r)[:, None]).T for values in (self.a, self.c)]
