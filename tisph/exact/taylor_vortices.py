"""Linear stability of circular Couette flow to Taylor vortices: disturbances that are the same all around the axis.

The undisturbed fluid has the angular velocity W = A + B/r^2 between cylinders of given angular velocities. The
disturbances, x along the axis,

    u_r = a(r) cos(kx) e^(st),    u_x = b(r) sin(kx) e^(st),    u_t = c(r) cos(kx) e^(st)

obey, linearised and without pressure and u_x, with M = d2/dr2 + (1/r) d/dr - 1/r^2 - k^2 and no slip,

    s M a = nu M^2 a - 2 k^2 W c,    s c = nu M c - 2 A a,    b = -(da/dr + a/r)/k,    a = da/dr = c = 0 at the walls

They are solved by Galerkin's method with polynomials that satisfy the walls' conditions, (1 - z^2)^2 T_n(z) for a and
(1 - z^2) T_n(z) for c, -1 <= z <= 1 across the gap. Source: S. Chandrasekhar, Hydrodynamic and Hydromagnetic
Stability (1961), sections 70 to 72. Accuracy: 1e-10 at radius ratios from 0.1 on, and k up to 10 over the gap.

In an Oldroyd-B fluid the disturbances stretch the polymer, and the polymer, which the flow stretches around the axis,
pulls inwards: disturbances grow without inertia as well, and oscillate (``ElasticVortices``). With the conformation
tensor A + C e^(st), the rate g = r dW/dr, N = lam g = A_rt and A_tt = 1 + 2 N^2, and s' = s + 1/lam, C obeys

    s' C_rr = 2 a',     s' C_rt = g C_rr + N (a' + a/r) - a N' + c' - c/r,     s' C_xx = 2 k b,     s' C_rx = b' - k a,
    s' C_tt = 2 g C_rt + 2 N (c' - c/r) + 2 A_tt a/r - a A_tt',     s' C_tx = g C_rx + N b' - k c

at each point, C_rx and C_tx times sin(kx), the others times cos(kx). Velocity and stress obey the weak momentum
equation for the same polynomials. Sources: R. G. Larson, E. S. G. Shaqfeh, S. J. Muller, J. Fluid Mech. 218 (1990)
573-600. Accuracy: 1e-8 at radius ratios from 0.5 on, k up to 10 over the gap, and De up to 25.
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


@dataclass(frozen=True)
class ElasticVortices:
    """The disturbance of circular Couette flow of an Oldroyd-B fluid that grows fastest, or decays slowest.

    ``kinematic_viscosity`` of solvent and polymer together, infinite without inertia; other arguments as of
    ``TaylorVortices`` and of ``rheology/oldroyd_b.py``.
    """

    radii: tuple[float, float]
    angular_velocities: tuple[float, float]
    kinematic_viscosity: float
    wavenumber: float
    relaxation_time: float
    solvent_fraction: float

    @cached_property
    def growth_rate(self) -> complex:
        """s (1/time), growth rate + i angular frequency, of which the conjugate is a solution as well."""
        from scipy.linalg import block_diag, eig

        basis, lam, k = _Basis(*self.radii, self.wavenumber), self.relaxation_time, self.wavenumber
        slope, constant = coefficients(self.radii, self.angular_velocities)
        r, none = basis.r[:, None], 0.0 * basis.a
        a, da, dda = (np.hstack([each, none]) for each in basis.derivatives(basis.twice, 2))
        c, dc = (np.hstack([none, each]) for each in basis.derivatives(basis.once, 1))
        b, db = -(da + a / r) / k, -(dda + da / r - a / r**2) / k
        rate = -2.0 * constant / r**2
        shear, around = lam * rate, 1.0 + 2.0 * (lam * rate) ** 2  # N and A_tt, which fall as r^-2 and r^-4
        strain = np.stack([da, dc - c / r, a / r, k * b, db - k * a, -k * c])  # rr, rt, tt, xx, rx, tx
        twice = np.array([2.0, 1.0, 2.0, 2.0, 1.0, 1.0])[:, None, None] * strain
        stretched = twice.copy()
        stretched[1] += shear * (da + a / r) + 2.0 * a * shear / r
        stretched[2] += 2.0 * (around - 1.0) * a / r + 2.0 * shear * (dc - c / r) + 4.0 * a * (around - 1.0) / r
        stretched[5] += shear * db
        relaxed = -np.eye(6 * len(r)) / lam
        blocks = relaxed.reshape(6, len(r), 6, len(r))
        points = np.arange(len(r))
        for row, column, factor in ((1, 0, 1.0), (2, 1, 2.0), (5, 4, 1.0)):
            blocks[row, points, column, points] = factor * rate[:, 0]
        weights = basis.weights[:, None]
        tests = -np.concatenate(strain * weights).T
        turning = (2.0 * (slope + constant / r**2) * weights * a).T @ c - (2.0 * slope * weights * c).T @ a
        mass = sum(each.T @ (weights * each) for each in (a, b, c))
        beta, inertia = self.solvent_fraction, 1.0 / self.kinematic_viscosity
        upper = [inertia * turning + beta * tests @ np.concatenate(twice), (1.0 - beta) / lam * tests]
        left = np.vstack([np.hstack(upper), np.hstack([np.concatenate(stretched), relaxed])])
        values = eig(left, block_diag(inertia * mass, np.eye(6 * len(r))), right=False)
        return complex(max(values[np.isfinite(values) & (values.imag >= 0.0)], key=lambda s: s.real))


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

    Matrices (points, polynomials): ``a``, ``c``, M a (``of_a``), M c (``of_c``) and M^2 a (``fourth``). ``weights`` of
    points in integrals over r dr; ``tests`` for the equations of a and of c: matrices (polynomials, points) of
    integrals with each polynomial.
    """

    def __init__(self, inner: float, outer: float, wavenumber: float) -> None:
        domain, k = (inner, outer), wavenumber**2
        z, weights = np.polynomial.legendre.leggauss(2 * COUNT)
        self.r = inner + (outer - inner) * (z + 1) / 2
        wall = Chebyshev([0.5, 0.0, -0.5], domain=domain)  # 1 - z^2
        self.once = [wall * Chebyshev.basis(n, domain=domain) for n in range(COUNT)]
        self.twice = [wall * each for each in self.once]

        r, self.weights = self.r[:, None], weights * self.r
        self.c, first, second = self.derivatives(self.once, 2)
        self.of_c = second + first / r - (1 / r**2 + k) * self.c
        self.a, first, second, third, fourth = self.derivatives(self.twice, 4)
        curved = second + first / r - self.a / r**2
        self.of_a = curved - k * self.a
        fourth = fourth + 2 / r * third - 3 / r**2 * second + 3 / r**3 * first - 3 / r**4 * self.a
        self.fourth = fourth - 2 * k * curved + k**2 * self.a
        self.tests = [(values * self.weights[:, None]).T for values in (self.a, self.c)]

    def derivatives(self, polynomials: list[Chebyshev], orders: int) -> list[np.ndarray]:
        """Return the values (points, polynomials) of all derivatives of the ``polynomials`` up to these ``orders``."""
        return [np.stack([each.deriv(n)(self.r) for each in polynomials], axis=1) for n in range(orders + 1)]
