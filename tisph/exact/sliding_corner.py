"""Flow in the corner between a wall that slides in its own direction and one at rest.

In polar coordinates from the corner, theta from the sliding wall, the stream function is, for small r U/nu,

    psi = r f(theta) + r^2 h(theta)/nu + ...,    u_r = psi_theta/r,    u_theta = -psi_r.

The first part is slow flow (G. I. Taylor, "On scraping viscous fluid from a plane surface", 1962): f = a cos theta +
b sin theta + c theta cos theta + d theta sin theta. Its velocities do not depend on r; its pressure varies as 1/r, and
so does its acceleration (u . grad) u = -f (f + f'')/r e_r, which has a finite flux out of the corner. The second part
balances this acceleration: h'''' + 4 h'' = -f' (f + f'') - f (f' + f'''), with a pressure e log r. Every flow has this
form near the corner, and no field of finite spacing resolves the corner unless both parts are subtracted (O. Botella,
R. Peyret, Comput. Fluids 27 (1998) 421-433, for a cavity).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

DEGREE = 16
"""Degree of the polynomial h: for angles up to a right angle its last coefficients are below 1e-9 of the largest."""


@dataclass(frozen=True)
class CornerSingularity:
    """Corner at ``place`` (2,) where a wall that slides with ``speed`` away from it, along ``along``, meets another.

    ``along`` (2,) and ``inward`` (2,), the normal of the sliding wall into the fluid, are of length 1. ``angle``
    between the walls, in radians. The second part of the flow is multiplied by ``share`` exp(-(r/``decay_length``)^2),
    since it holds only near the corner.
    """

    place: tuple[float, float]
    along: tuple[float, float]
    inward: tuple[float, float]
    angle: float
    speed: float
    kinematic_viscosity: float
    decay_length: float
    share: float = 1.0

    @cached_property
    def stokes_coefficients(self) -> np.ndarray:
        """a, b, c, d (4,) of f: no flow through the walls, ``speed`` at theta = 0, and rest at the other wall."""
        sine, cosine, angle = np.sin(self.angle), np.cos(self.angle), self.angle
        conditions = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 1.0, 0.0],
            [cosine, sine, angle * cosine, angle * sine],
            [-sine, cosine, cosine - angle * sine, sine + angle * cosine],
        ]
        return np.linalg.solve(conditions, [0.0, self.speed, 0.0, 0.0])

    def _slow(self, theta: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return f and its first three derivatives at ``theta`` (n,)."""
        a, b, c, d = self.stokes_coefficients
        sine, cosine = np.sin(theta), np.cos(theta)
        waves = c * cosine + d * sine, d * cosine - c * sine
        f = a * cosine + b * sine + theta * waves[0]
        slope = b * cosine - a * sine + waves[0] + theta * waves[1]
        return f, slope, 2 * waves[1] - f, -2 * waves[0] - slope

    @cached_property
    def _inertial(self) -> tuple[list[np.ndarray], float]:
        """Chebyshev coefficients of h and its first three derivatives in 2 theta/angle - 1, and e, by collocation."""
        size = 2.0 / self.angle
        node = chebyshev.chebpts1(DEGREE - 3)
        basis = [chebyshev.chebder(np.eye(DEGREE + 1), k) * size**k for k in range(5)]

        def at(place: np.ndarray, k: int) -> np.ndarray:
            return chebyshev.chebvander(place, DEGREE - k) @ basis[k]

        f, first, second, third = self._slow((node + 1.0) / size)
        push = -first * (f + second) - f * (first + third)
        ends = np.array([-1.0, 1.0])
        rows = np.concatenate([at(node, 4) + 4.0 * at(node, 2), at(ends, 0), at(ends, 1)])
        h = self.share * np.linalg.solve(rows, np.concatenate([push, np.zeros(4)]))
        log = (4.0 * at(ends[:1], 1) + at(ends[:1], 3)) @ h  # + f (f + f''), but f is 0 at theta = 0
        return [part @ h for part in basis[:4]], float(log[0])

    @cached_property
    def inertial_coefficients(self) -> np.ndarray:
        """Coefficients (``DEGREE`` + 1, 4) of h and its derivatives in 2 theta/angle - 1, highest power first."""
        powers = [chebyshev.cheb2poly(part) for part in self._inertial[0]]
        return np.stack([np.pad(part, (0, DEGREE + 1 - len(part))) for part in powers], axis=1)[::-1]

    @property
    def pressure_coefficient(self) -> float:
        """e, the coefficient of the logarithm in the pressure."""
        return self._inertial[1]

    def _polar(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return distance r and angle theta (n,) of ``points`` (n, 2), and the unit vectors (n, 2) along both."""
        away = np.asarray(points, dtype=float) - self.place
        along, inward = away @ np.array(self.along), away @ np.array(self.inward)
        radius, theta = np.hypot(along, inward), np.arctan2(inward, along)
        frame, sine, cosine = np.array([self.along, self.inward]), np.sin(theta), np.cos(theta)
        ways = np.stack([cosine, sine], axis=1) @ frame, np.stack([-sine, cosine], axis=1) @ frame
        return radius, theta, *ways

    def _fading(self, radius: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return chi = S/r^2, S'/r, S'' and S''' for S = r^2 exp(-(r/decay_length)^2)."""
        k, square = self.decay_length**-2, (radius / self.decay_length) ** 2
        chi = np.exp(-square)
        second, third = 2.0 - 10.0 * square + 4.0 * square**2, -24.0 + 36.0 * square - 8.0 * square**2
        return chi, (2.0 - 2.0 * square) * chi, second * chi, k * radius * third * chi

    def _parts(self, points: np.ndarray) -> tuple[Any, Any, np.ndarray, Any]:
        """Return ``_polar``, ``_slow``, h and its derivatives (4, n), and ``_fading`` at ``points`` (n, 2)."""
        polar = self._polar(points)
        part = 2.0 * polar[1] / self.angle - 1.0
        inertial = np.vander(part, DEGREE + 1) @ self.inertial_coefficients
        return polar, self._slow(polar[1]), inertial.T, self._fading(polar[0])

    def velocity(self, points: np.ndarray) -> np.ndarray:
        """Return the velocity (n, 2) at ``points`` (n, 2)."""
        (radius, _, out, turn), (f, slope, *_), (h, h1, *_), (chi, first, *_) = self._parts(points)
        scale = radius / self.kinematic_viscosity
        radial, turning = slope + scale * chi * h1, -f - scale * first * h
        return radial[:, None] * out + turning[:, None] * turn

    def gradient(self, points: np.ndarray) -> np.ndarray:
        """Return the velocity gradient (n, 2, 2) at ``points`` (n, 2): du_j/dx_i at [i, j]."""
        (radius, _, *ways), (f, _, bend, _), inertial, (chi, first, second, _) = self._parts(points)
        h, h1, h2, _ = inertial / self.kinematic_viscosity
        stretch = (chi - 2.0 * (radius / self.decay_length) ** 2 * chi) * h1
        parts = {
            (0, 0): stretch,
            (0, 1): -second * h,
            (1, 0): (bend + f) / radius + chi * h2 + first * h,
            (1, 1): -first * h1 + chi * h1,
        }
        terms = (part[:, None, None] * ways[i][:, :, None] * ways[j][:, None, :] for (i, j), part in parts.items())
        return sum(terms, np.zeros((1, 1, 1)))

    def acceleration(self, points: np.ndarray) -> np.ndarray:
        """Return the acceleration (n, 2) at ``points`` (n, 2) by pressure and viscous forces of this flow."""
        (radius, _, out, turn), _, (h, h1, h2, h3), (chi, first, second, third) = self._parts(points)
        log = self.pressure_coefficient
        square, k = (radius / self.decay_length) ** 2, radius * self.decay_length**-2
        slope = (chi / radius - 2.0 * k * chi * np.log(radius / self.decay_length)) * log
        radial = (second + first) * h1 / radius + chi * h3 / radius - slope
        turning = -(third + k * (4.0 * square - 8.0) * chi) * h + 2.0 * k * chi * h2
        return radial[:, None] * out + turning[:, None] * turn

    def pressure(self, points: np.ndarray) -> np.ndarray:
        """Return the pressure per unit density (n,) at ``points`` (n, 2); infinite in the corner."""
        _, _, c, d = self.stokes_coefficients
        radius, theta, *_ = self._polar(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            slow = 2.0 * self.kinematic_viscosity * (c * np.cos(theta) + d * np.sin(theta)) / radius
            return slow + self.pressure_coefficient * self._fading(radius)[0] * np.log(radius / self.decay_length)
