"""Velocity and polymer shear stress of an Oldroyd-B fluid in a channel after a change at t = 0 (dimensionless).

With eta = y/H, T = nu t/H^2 (nu: total viscosity/density), solvent fraction b, elasticity E = lambda nu/H^2, and
with stresses over total viscosity/H, so that they and the slope u_eta have the unit of a velocity:

    u_T = G + b u_eta,eta + S_eta,    E S_T + S = (1 - b) u_eta,    u(0, T) = U0, u(1, T) = U1, G = g H^2/nu.

``early``: inverse Laplace transform. For the flow from rest and s on the contour, k^2 = s/(b + (1 - b)/(1 + E s)),

    s u^ = U1 sinh(k eta)/sinh(k) + U0 sinh(k (1 - eta))/sinh(k) + (G/s) [1 - cosh(k (eta - 1/2))/cosh(k/2)]

``late``: eigenmodes. With k = n pi, u - steady u = sum a_n sin(k eta), S - steady S = (1 - b)(U0 - U1) exp(-T/E)
+ sum s_n cos(k eta),

    a_n' = -b k^2 a_n - k s_n,    E s_n' = (1 - b) k a_n - s_n

whose 2x2 matrix exponential holds for real, complex and equal eigenvalues alike.

Which of the two: with x = b E eigenvalue and m = b^2 E k^2, x^2 + (b + m) x + m = 0, so that complex
eigenvalues lie on the circle |x + 1|^2 = 1 - b and, of each real pair, one tends to x = -1 for n -> infinity. Hence no
mode, however short, decays faster than exp(-T/(b E)): sums over modes end well only for T/(b E) >> 1. Up to
``SWITCH`` the contour encloses the whole circle instead; for it, early times are no harder than others.

Sources: N. D. Waters and M. J. King, Rheol. Acta 9 (1970) 345-355 (the flow and its eigenvalues); I. C. Christov,
arXiv:1305.5999 (2013) (both stress and velocity must start from rest); J. A. C. Weideman and L. N. Trefethen, Math.
Comput. 76 (2007) 1341-1356 (inverse transform by the trapezoidal rule on a parabola).
"""

from dataclasses import dataclass

import numpy as np

from oracles import _chebyshev, poiseuille
from tisph.exact import couette

SWITCH = 28.0
"""T/(b E) up to which ``early`` is taken: there the modes left out by ``late`` are below exp(-28) = 7e-13."""

CONTOUR_HEIGHT = 8.0
CONTOUR_POINTS = 32
"""Crossing of the real axis, in units of 1/T, and points in the upper half plane. Rounding is amplified by exp(8);
more points at the same height, or more height, change the result by less than 2e-12."""

DECAY = 38.5
"""exp(-DECAY) = 2e-17: what has decayed so far is left out."""

FEW_HEIGHTS = 200
COUNTS = (129, 513)
RESOLVED = 2e-13
"""Up to FEW_HEIGHTS heights are computed each; more are interpolated from the first of COUNTS Chebyshev points
whose last coefficients are below RESOLVED; where none is enough (very thin layers) all are computed each."""


@dataclass(frozen=True)
class Steady:
    """Developed flow: wall velocities and G = g H^2/nu, all in one unit of velocity."""

    bottom: float
    top: float
    drive: float

    def velocity(self, eta):
        """U0 + (U1 - U0) eta + G eta (1 - eta)/2."""
        return self.bottom + (self.top - self.bottom) * eta + self.drive * eta * (1 - eta) / 2

    def slope(self, eta):
        """Derivative of ``velocity`` with respect to eta; times (1 - b) the polymer shear stress."""
        return self.top - self.bottom + self.drive * (0.5 - eta)


@dataclass(frozen=True)
class Problem:
    """A flow that was developed as ``before`` and whose walls and drive change by ``change`` at T = 0."""

    solvent_fraction: float
    elasticity: float
    before: Steady
    change: Steady


def profiles(problem, eta, time):
    """Velocity, slope u_eta and polymer shear stress at heights ``eta`` (heights,), ``time`` >= 0: (3, heights).

    The slope is infinite at T = 0 on a wall whose velocity changes.
    """
    if eta.size > FEW_HEIGHTS and not _is_newtonian(problem, time):
        for count in COUNTS:
            series = _chebyshev.coefficients(profiles_at(problem, _chebyshev.points(count), time))
            if _chebyshev.resolved(series, RESOLVED):
                return _chebyshev.evaluate(series, eta)
    return profiles_at(problem, eta, time)


def profiles_at(problem, eta, time):
    """``profiles``, computed at each height."""
    fraction, slope = problem.solvent_fraction, problem.before.slope(eta)
    developed = np.stack([problem.before.velocity(eta), slope, (1 - fraction) * slope])
    if _is_newtonian(problem, time):
        return developed + newtonian(problem, eta, time)
    form = early if time <= SWITCH * fraction * problem.elasticity else late
    return developed + form(problem, eta, time)


def _is_newtonian(problem, time):
    """At T = 0 the change is the same for all fluids."""
    return time == 0 or problem.solvent_fraction == 1


def newtonian(problem, eta, time):
    """Start from rest by ``problem.change``, shape (3, heights), without polymer."""
    flow, unit = problem.change, {"gap": 1.0, "kinematic_viscosity": 1.0}
    walls, drive = {"bottom": flow.bottom, "top": flow.top, **unit}, {"acceleration": flow.drive, **unit}
    velocity = couette.velocity(eta, time, **walls) + poiseuille.velocity(eta, time, **drive)
    slope = couette.shear_rate(eta, time, **walls) + poiseuille.shear_rate(eta, time, **drive)
    return np.stack([velocity, slope, np.zeros_like(eta)])


def early(problem, eta, time):
    """Start from rest by ``problem.change``, shape (3, heights), by the inverse Laplace transform."""
    flow, fraction = problem.change, problem.solvent_fraction
    s, weight = _contour(time, time / (fraction * problem.elasticity))
    polymer = (1 - fraction) / (1 + problem.elasticity * s)
    k = np.sqrt(s / (fraction + polymer))
    # sinh(k eta)/sinh(k) = (Q - e P)/(1 - e^2) with P = exp(-k eta), Q = exp(-k (1 - eta)), e = exp(-k), and
    # 1 - cosh(k (eta - 1/2))/cosh(k/2) = (1 - P)(1 - Q)/(1 + e). With p = P - 1, q = Q - 1 and e - 1 nothing
    # overflows where k is large, and nothing is lost to cancellation where it is small; elsewhere exp takes less time.
    less_one = np.expm1 if np.abs(k).min() < 1.0 else lambda exponent: np.exp(exponent) - 1.0
    p, q, less = less_one(-np.outer(k, eta)), less_one(-np.outer(k, 1 - eta)), np.expm1(-k)
    e = 1 + less
    top, bottom = (weight * speed / s / (-less * (2 + less)) for speed in (flow.top, flow.bottom))
    drive = weight * flow.drive / s**2 / (2 + less)
    slope_p, slope_q = k * (e * top - bottom + drive), k * (top - e * bottom - drive)
    uniform = np.stack([-(top + bottom) * less, slope_p + slope_q, polymer * (slope_p + slope_q)])
    total = uniform.sum(axis=1)[:, None] + _sums([bottom - e * top, slope_p, polymer * slope_p], p)
    total += _sums([top - e * bottom, slope_q, polymer * slope_q], q)
    total[0] += _sums([drive], p * q)[0]
    return total.real


def _sums(rows, terms):
    """Weighted sums (rows, heights) of ``terms`` (terms, heights), one for each of the ``rows`` of weights.

    Not by a matrix product: BLAS splits these small ones over threads, which on a busy machine takes 10 times longer.
    """
    return np.einsum("ij,jk", np.stack(rows), terms)


def _contour(time, ratio):
    """Points s and weights of f(time) = Re sum(weight * F(s)), the contour a parabola around all singularities.

    s time = height - v^2 + i width v. The circle of complex eigenvalues, of radius ``ratio`` = T/(b E) in s time and
    touching 0, is inside a parabola that opens as its osculating one, width^2 = 2 ratio, with 10 % to spare.
    """
    width = max(6.0, 1.1 * np.sqrt(2 * ratio))
    step = np.sqrt(CONTOUR_HEIGHT + DECAY) / CONTOUR_POINTS
    v = step * (np.arange(CONTOUR_POINTS) + 0.5)
    exponent = CONTOUR_HEIGHT - v**2 + 1j * width * v
    return exponent / time, step / np.pi * (width + 2j * v) * np.exp(exponent) / time


def late(problem, eta, time):
    """Start from rest by ``problem.change``, shape (3, heights), by eigenmodes."""
    flow, fraction = problem.change, problem.solvent_fraction
    # a pair of complex eigenvalues decays as exp(-b k^2 T/2), a real one faster or as exp(-T/(b E))
    count = 1 + int(np.sqrt(2 * DECAY / (fraction * time)) / np.pi)
    k = np.pi * np.arange(1, count + 1)
    velocity, stress = _modes(problem, k, time)
    angle = np.outer(k, eta)
    cosines = _sums([k * velocity, stress], np.cos(angle))
    steady, uniform = flow.slope(eta), (flow.top - flow.bottom) * np.exp(-time / problem.elasticity)
    return np.stack(
        [
            flow.velocity(eta) + _sums([velocity], np.sin(angle))[0],
            steady + cosines[0],
            (1 - fraction) * (steady - uniform) + cosines[1],
        ]
    )


def _modes(problem, k, time):
    """Amplitudes (a_n, s_n) at ``time`` of the deviation from the steady flow."""
    flow, fraction, rate = problem.change, problem.solvent_fraction, 1 / problem.elasticity
    sign = np.cos(k)  # (-1)^n
    velocity = -2 * (flow.bottom - sign * flow.top) / k - 2 * (1 - sign) * flow.drive / k**3
    stress = -(1 - fraction) * 2 * (1 - sign) * flow.drive / k**2
    # exp(M T) = even I + odd (M - mean I) with mean the half trace, both regular where the eigenvalues coincide
    mean, determinant = -(fraction * k**2 + rate) / 2, rate * k**2
    root = np.sqrt((mean**2 - determinant).astype(complex))
    larger = np.where(root.real > 0, determinant / (mean - root), mean + root)
    ratio = np.where(root == 0, time, -np.expm1(-2 * root * time) / np.where(root == 0, 1, 2 * root))
    even = (np.exp(larger * time) * (1 + np.exp(-2 * root * time)) / 2).real
    odd = (np.exp(larger * time) * ratio).real
    half = (rate - fraction * k**2) / 2
    return (
        even * velocity + odd * (half * velocity - k * stress),
        even * stress + odd * ((1 - fraction) * rate * k * velocity - half * stress),
    )
