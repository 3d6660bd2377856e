"""Flow of a Newtonian or Oldroyd-B fluid between two walls y = 0 and y = H, by numerical inverse Laplace transforms.

    du/dt = g + b nu d2u/dy2 + dS/dy/density,    lambda dS/dt + S = (1 - b) density nu du/dy,    u = wall velocities

b is the solvent fraction and nu the total kinematic viscosity. With k^2 = H^2 p/(nu (b + (1 - b)/(1 + lambda p))) the
transform of the flow from rest is, at eta = y/H, for the transforms U0 and U1 of the wall velocities,

    u = U1 sinh(k eta)/sinh(k) + U0 sinh(k (1 - eta))/sinh(k) + (g/p^2) [1 - cosh(k (eta - 1/2))/cosh(k/2)]

Sources: J. A. C. Weideman and L. N. Trefethen, Math. Comput. 76 (2007) 1341-1356 (trapezoidal rule on a parabola);
N. D. Waters and M. J. King, Rheol. Acta 9 (1970) 345-355 (the complex singularities p of Oldroyd-B lie on the circle
|b lambda p + 1|^2 = 1 - b, which the parabola encloses). Accuracy: 1e-11 of the largest value. Times are scalars > 0.
"""

import itertools
from dataclasses import dataclass

import numpy as np

CROSSING, DECAY, POINTS = 8.0, 38.5, 36
"""Crossing of the real axis in units of 1/t; exp(-DECAY) = 2e-17; points on the narrowest parabola."""


@dataclass(frozen=True)
class Wall:
    """Wall velocity cosine cos(w t) + sine sin(w t) from t = 0 on, w = ``angular_frequency``; a constant has w = 0."""

    cosine: float = 0.0
    sine: float = 0.0
    angular_frequency: float = 0.0


@dataclass(frozen=True)
class Plane:
    """A channel of width ``gap`` and its fluid; total kinematic viscosity, solvent fraction, relaxation time."""

    gap: float
    viscosity: float
    fraction: float = 1.0
    relaxation: float = 0.0

    def fields(self, y, t, bottom=0.0, top=0.0, acceleration=0.0):
        """Return velocity, shear rate and polymer shear stress over density, each (heights,), from rest at t > 0.

        ``bottom`` and ``top``: ``Wall``, any object with its attributes, or a constant velocity.
        """
        eta, found = np.asarray(y) / self.gap, np.zeros((3, np.size(y)))
        for wall, place, sign in ((bottom, 1 - eta, -1.0), (top, eta, 1.0)):
            wall = wall if hasattr(wall, "cosine") else Wall(wall)
            if wall.cosine or wall.sine:
                found += np.array([[1.0], [sign], [sign]]) * self._by(
                    lambda p, place=place: self._wall(place, p), wall, t
                )
        if acceleration:
            found += acceleration * self._inverse(lambda p: self._drive(eta, p), t)
        return found

    def ramp(self, y, t):
        """Return velocity and shear rate at t > 0 of a top wall whose velocity is t."""
        return self._inverse(lambda p: self._wall(np.asarray(y) / self.gap, p) / p[:, None, None] ** 2, t)[:2]

    def scheduled(self, y, t, breakpoints):
        """Return velocity and shear rate of a top wall with jumps and kinks (time, jump, change of acceleration)."""
        past = [(t - time, jump, bend) for time, jump, bend in breakpoints if t > time]
        starts = sum(self.fields(y, since, top=jump)[:2] for since, jump, _ in past if jump)
        return starts + sum(bend * self.ramp(y, since) for since, _, bend in past if bend)

    def periodic(self, y, t, wall):
        """Return velocity and shear rate of the periodic flow of an oscillating top wall."""
        return (self._amplitude(np.asarray(y) / self.gap, wall) * np.exp(1j * wall.angular_frequency * t)).real[:2]

    def normal_stress(self, y, t, fields, slope_before=0.0):
        """Return S_xx/density = 2 int exp(-(t - s)/lambda) u_y S ds with the earlier stress; ``fields`` of a time s.

        In the root of s, of which starts are smooth, on panels that halve towards s = 0.
        """
        nodes, weights = np.polynomial.legendre.leggauss(12)
        panels = [np.linspace(2.0**-j, 2.0 ** (1 - j), 4)[:-1] for j in range(14, 0, -1)]
        edges = np.sqrt(t) * np.concatenate([[0.0], *panels, [1.0]])
        steady = 2 * self.relaxation * (1 - self.fraction) * self.viscosity * slope_before**2
        total = steady * np.exp(-t / self.relaxation)
        for low, high in itertools.pairwise(edges):
            for node, weight in zip((low + high + (high - low) * nodes) / 2, (high - low) / 2 * weights, strict=True):
                _, rate, stress = fields(node**2)
                total = total + 4 * weight * node * np.exp((node**2 - t) / self.relaxation) * rate * stress
        return total

    def _polymer(self, p):
        return (1 - self.fraction) * self.viscosity / (1 + self.relaxation * p)

    def _three(self, value, slope, p):
        slope = slope / self.gap
        return np.stack([value, slope, self._polymer(p)[:, None] * slope], axis=1)

    def _k(self, p):
        return (self.gap * np.sqrt(p / (self.fraction * self.viscosity + self._polymer(p))))[:, None]

    def _wall(self, eta, p):
        k = self._k(p)
        near, far, whole = np.exp(-k * (1 - eta)), np.exp(-k * (1 + eta)), -np.expm1(-2 * k)
        return self._three((near - far) / whole, k * (near + far) / whole, p)

    def _drive(self, eta, p):
        k = self._k(p)
        one, other, whole = np.exp(-k * (1 - eta)), np.exp(-k * eta), 1 + np.exp(-k)
        return self._three(1 - (one + other) / whole, k * (other - one) / whole, p) / p[:, None, None] ** 2

    def _amplitude(self, eta, wall):
        frequency = np.array([1j * wall.angular_frequency])
        return (wall.cosine - 1j * wall.sine) * self._wall(eta, frequency)[0]

    def _by(self, response, wall, t):
        """Transform of the oscillation times ``response``, less the periodic part, which is known: no other pole."""
        c, s, w = wall.cosine, wall.sine, wall.angular_frequency
        if not w:
            return c * self._inverse(lambda p: response(p) / p[:, None, None], t)
        amplitude = (c - 1j * s) * response(np.array([1j * w]))[0]

        def transient(p):
            p = p[:, None, None]
            return (response(p[:, 0, 0]) * (c * p + s * w) - amplitude.real * p + amplitude.imag * w) / (p**2 + w**2)

        return (amplitude * np.exp(1j * w * t)).real + self._inverse(transient, t)

    def _inverse(self, transform, t):
        elastic = t / (self.fraction * self.relaxation) if self.fraction < 1 else 0.0
        return inverse(transform, t, max(6.0, 1.1 * np.sqrt(2 * elastic)))


def inverse(transform, t, width=6.0):
    """Return the function at ``t`` of a ``transform`` of p (points,), by the trapezoidal rule on a parabola."""
    count = int(np.ceil(POINTS * width / 6.0))
    step = np.sqrt(CROSSING + DECAY) / count
    v = step * (np.arange(count) + 0.5)
    weight = step / np.pi * (width + 2j * v) * np.exp(CROSSING - v**2 + 1j * width * v) / t
    return np.einsum("n,n...", weight, transform((CROSSING - v**2 + 1j * width * v) / t)).real
