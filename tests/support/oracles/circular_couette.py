"""Circular Couette flow by numerical inverse Laplace transforms: the cylinders turn steadily, oscillate, or change.

    du/dt = nu (u'' + u'/r - u/r^2),   u(R1) = R1 w1(t),   u(R2) = R2 w2(t),   dp/dr = rho u^2/r

With k = sqrt(p/nu) the transform of the flow from rest is W1(p) f(r; R1, R2) + W2(p) f(r; R2, R1) for the transforms W
of the angular velocities, counterclockwise, and

    f(r; a, b) = a [K1(k r) I1(k b) - I1(k r) K1(k b)] / [K1(k a) I1(k b) - I1(k a) K1(k b)]

Sources: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.5 (steady); H. S. Carslaw and J. C. Jaeger,
Conduction of Heat in Solids, section 13.3 (transform); the inverse is that of ``plane``. Accuracy: 1e-12 of the largest
wall speed, or shear rate. ``r`` and ``t`` broadcast against each other; any self-consistent units.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev
from scipy.special import ive, kve

from oracles.plane import inverse

DEGREE = 600
"""Of the polynomial of the velocity across the gap, of which the pressure is an integral."""


@dataclass(frozen=True)
class Rotation:
    """Angular velocity cosine * cos(W t) + sine * sin(W t) from t = 0 on, and ``before``, in radians/time."""

    cosine: float
    sine: float = 0.0
    angular_frequency: float = 0.0
    before: float = 0.0


@dataclass(frozen=True)
class CircularCouette:
    """The flow between radii R1 and R2; ``inner`` and ``outer``: ``Rotation``, or any object with its attributes.

    Up to t = 0 the flow is the steady one of what the cylinders did ``before``.
    """

    inner_radius: float
    outer_radius: float
    kinematic_viscosity: float
    inner: Rotation
    outer: Rotation

    def velocity(self, r, t):
        """Velocity around the axis. At t = 0 it is the flow before, with the walls' new speeds at the walls."""
        return self._evaluate(r, t, False)

    def shear_rate(self, r, t):
        """Shear rate r d(u/r)/dr (1/time). At t = 0 infinite at a wall whose velocity jumps."""
        return self._evaluate(r, t, True)

    def settled_velocity(self, r, t=0.0):
        """Velocity that the flow tends to: steady, or periodic; any ``t``."""
        return self._settled(np.asarray(r, float), t, False)

    def settled_shear_rate(self, r, t=0.0):
        """Shear rate r d(u/r)/dr (1/time) that the flow tends to; any ``t``."""
        return self._settled(np.asarray(r, float), t, True)

    def torque(self, t, *, density):
        """Torques (inner, outer), counterclockwise, of the fluid on the cylinders, per length along the axis."""
        return self._torque(self.shear_rate, t, density)

    def settled_torque(self, t=0.0, *, density):
        """As ``torque``, of the flow that it tends to."""
        return self._torque(self.settled_shear_rate, t, density)

    def pressure(self, r, t, *, density, settled=False):
        """Pressure at radii ``r`` and one time, of zero mean over the area; ``settled``: of the flow tended to."""
        of, ends = self.settled_velocity if settled else self.velocity, (self.inner_radius, self.outer_radius)
        gradient = Chebyshev.interpolate(lambda r: density * of(r, t) ** 2 / r, DEGREE, domain=ends)
        change = gradient.integ(lbnd=ends[0])
        weighted = (change * Chebyshev.identity(domain=ends)).integ(lbnd=ends[0])
        return change(np.asarray(r, float)) - 2 * weighted(ends[1]) / (ends[1] ** 2 - ends[0] ** 2)

    def _torque(self, of, t, density):
        factor = 2 * np.pi * density * self.kinematic_viscosity
        return tuple(
            sign * factor * r**2 * of(r, t) for sign, r in ((1.0, self.inner_radius), (-1.0, self.outer_radius))
        )

    def _walls(self):
        radii = self.inner_radius, self.outer_radius
        return [
            (wall, own, other) for wall, own, other in zip((self.inner, self.outer), radii, radii[::-1], strict=True)
        ]

    def _evaluate(self, r, t, shear):
        r, t = np.broadcast_arrays(np.asarray(r, float), np.asarray(t, float))
        found = np.zeros(r.shape)
        for wall, own, other in self._walls():
            before = wall.before or 0.0
            found += before * self._steady(r, own, other, shear)
            for time in np.unique(t[t > 0]):
                at = t == time
                found[at] += self._change(wall, before, r[at], time, own, other, shear)
            at = (t == 0) & (r == own)
            if not shear:
                found[at] = own * wall.cosine
            elif wall.cosine != before:
                found[at] = math.copysign(math.inf, (wall.cosine - before) * (own - other))
        return found[()]

    def _change(self, wall, before, r, t, own, other, shear):
        """Return the change since t = 0 by one wall; the periodic part of an oscillation is known."""
        frequency = wall.angular_frequency

        def response(p):
            k = np.sqrt(p / self.kinematic_viscosity)[:, None]
            return own * quotient(r[None, :], k, own, other, shear=shear)

        def transform(p):
            constant = wall.cosine - before if not frequency else -before
            total = constant / p[:, None] * response(p)
            if frequency:
                both = (wall.cosine * p + wall.sine * frequency)[:, None] * response(p)
                periodic = amplitude.real * p[:, None] - amplitude.imag * frequency
                total = total + (both - periodic) / (p**2 + frequency**2)[:, None]
            return total

        if not frequency:
            return inverse(transform, t)
        amplitude = (wall.cosine - 1j * wall.sine) * response(np.array([1j * frequency]))[0]
        return (amplitude * np.exp(1j * frequency * t)).real + inverse(transform, t)

    def _settled(self, r, t, shear):
        total = 0.0
        for wall, own, other in self._walls():
            frequency = wall.angular_frequency
            if frequency:
                k = np.sqrt(1j * frequency / self.kinematic_viscosity)
                swings = (wall.cosine - 1j * wall.sine) * np.exp(1j * frequency * np.asarray(t))
                total = total + (swings * own * quotient(r, k, own, other, shear=shear)).real
            else:
                total = total + wall.cosine * self._steady(r, own, other, shear)
        return total

    def _steady(self, r, own, other, shear):
        a, b = own**2, -(own**2) * other**2
        return (-2 * b / r**2 if shear else a * r + b / r) / (own**2 - other**2)


def quotient(r, k, own, other, order=1, shear=False):
    """Return f(r; own, other)/own, or its shear rate, by K e^z and I e^-z: only decaying exponentials are left.

    With the ``order`` 0 it is that of flow along the axis.
    """
    i_other, k_other, i_own, k_own = (bessel(order, k * edge) for edge in (other, own) for bessel in (_i, _k))
    near, gap = np.exp(-k * np.abs(r - own)), np.exp(-k * abs(own - other))
    far = np.exp(-k * np.abs(other - r)) * gap
    i, k = (k * _i(2, k * r), -k * _k(2, k * r)) if shear else (_i(order, k * r), _k(order, k * r))
    if own < other:
        return (k * i_other * near - i * k_other * far) / (k_own * i_other - i_own * k_other * gap**2)
    return (i * k_other * near - k * i_other * far) / (i_own * k_other - k_own * i_other * gap**2)


def _i(order, z):
    return ive(order, z) * np.exp(-1j * z.imag)


def _k(order, z):
    return kve(order, z)
