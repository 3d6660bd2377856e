"""Circular Couette flow: fluid between two cylinders, either of which turns, steadily, from a jump on, or to and fro.

Equation: du/dt = nu (u'' + u'/r - u/r^2) for R1 < r < R2, u the velocity around the axis, u(R1) = R1 w1(t) and
u(R2) = R2 w2(t); counterclockwise is positive. With kappa = sqrt(i W/nu) and the modes of ``_annulus_modes``:

    steady     u = a r + b/r,   a = (w2 R2^2 - w1 R1^2)/(R2^2 - R1^2),   b = (w1 - w2) R1^2 R2^2/(R2^2 - R1^2)
    periodic   u = Re[(combination of I1(kappa r) and K1(kappa r) with the values at the walls) e^{i W t}]
    from t = 0 u = steady or periodic flow of the walls - sum_n c_n u_n(r) exp(-nu k_n^2 t)
    early      u = sqrt(R/r) w at each wall, w_t = nu (w_rr - 3/(4 r^2) w), there with r = R: a half space

A wall that oscillates has the coefficient of the steady flow times nu k_n^2/(i W + nu k_n^2). Pressure:
dp/dr = rho u^2/r.

Sources: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.5 (steady); H. S. Carslaw and J. C. Jaeger,
Conduction of Heat in Solids, sections 13.3 and 13.5 (early), 14.3 (series).

Accuracy: 1e-12 of the largest wall speed (of the largest shear rate), but 3e-10 (6e-10) up to ``EARLY_TIME``.

Shapes and units: ``r`` and ``t`` broadcast against each other and results have the broadcast shape; any self-consistent
units.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from oracles import _chebyshev
from oracles._annulus_modes import modes, shear_rates, velocities
from tisph.exact.couette import EXPONENT

EARLY_TIME = 1e-6
"""nu t/min(R1, R2 - R1)^2 up to which the early form is taken. It leaves out parts of (nu t/R^2)^(3/2), here 1e-9: the
two forms differ by 3e-10 of the largest wall speed, and by 6e-10 of the largest shear rate."""


@dataclass(frozen=True)
class Rotation:
    """Angular velocity cosine * cos(W t) + sine * sin(W t) from t = 0 on, W = ``angular_frequency``.

    One that is constant has W = 0 and its value as ``cosine``; ``before`` it was that. All in radians/time.
    """

    cosine: float
    sine: float = 0.0
    angular_frequency: float = 0.0
    before: float = 0.0


@dataclass(frozen=True)
class CircularCouette:
    """The flow between radii R1 = ``inner_radius`` and R2 = ``outer_radius`` whose cylinders turn as they say.

    ``inner`` and ``outer``: ``Rotation``, or any object with its attributes. Up to t = 0 the flow is the steady one of
    what the cylinders did ``before``. ValueError for radii that do not grow outwards from above 0.
    """

    inner_radius: float
    outer_radius: float
    kinematic_viscosity: float
    inner: Rotation
    outer: Rotation

    def __post_init__(self):
        if not 0 < self.inner_radius < self.outer_radius < math.inf:
            raise ValueError(f"radii must grow outwards from above 0, not {self.inner_radius}, {self.outer_radius}")

    def velocity(self, r, t):
        """Velocity around the axis. At t = 0 it is the flow before, with the walls' new speeds at the walls."""
        return self._evaluate(r, t, shear=False)

    def shear_rate(self, r, t):
        """Shear rate r d(u/r)/dr (1/time). At t = 0 infinite at a wall whose velocity jumps."""
        return self._evaluate(r, t, shear=True)

    def settled_velocity(self, r, t=0.0):
        """Velocity that the flow tends to: steady, or periodic; any ``t``."""
        return np.real(self._settled(*np.broadcast_arrays(*_floats(r, t)), shear=False))[()]

    def settled_shear_rate(self, r, t=0.0):
        """Shear rate r d(u/r)/dr (1/time) that the flow tends to; any ``t``."""
        return np.real(self._settled(*np.broadcast_arrays(*_floats(r, t)), shear=True))[()]

    def torque(self, t, *, density):
        """Torques (inner, outer), counterclockwise, of the fluid on the cylinders, per length along the axis."""
        viscosity = density * self.kinematic_viscosity
        inner, outer = (self.shear_rate(r, t) for r in (self.inner_radius, self.outer_radius))
        radii = self.inner_radius, self.outer_radius
        return 2 * np.pi * radii[0] ** 2 * viscosity * inner, -2 * np.pi * radii[1] ** 2 * viscosity * outer

    def settled_torque(self, t=0.0, *, density):
        """As ``torque``, of the flow that it tends to."""
        factor = 2 * np.pi * density * self.kinematic_viscosity
        inner, outer = (r**2 * self.settled_shear_rate(r, t) for r in (self.inner_radius, self.outer_radius))
        return factor * inner, -factor * outer

    def pressure(self, r, t, *, density, settled=False):
        """Pressure at radii ``r`` and one time, of zero mean over the area; ``settled``: of the flow tended to."""
        change, total = self._integral(self._series(t, lambda r, u: density * u**2 / r, settled))
        # mean over the area: int p r dr = [p r^2/2] - int r^2/2 dp/dr
        moment = self._integral(self._series(t, lambda r, u: density * u**2 * r, settled))[1]
        inner, outer = self.inner_radius**2, self.outer_radius**2
        mean = (total * outer - moment) / (outer - inner)
        eta = (np.asarray(r, dtype=float) - self.inner_radius) / self._gap
        return _chebyshev.evaluate(change, eta) - mean

    # Parts of the walls' motion: (side 0 inner or 1 outer, complex amplitude, angular frequency).

    @property
    def _gap(self):
        return self.outer_radius - self.inner_radius

    @cached_property
    def _before(self):
        """The steady flow before t = 0."""
        still = (Rotation(wall.before or 0.0) for wall in (self.inner, self.outer))
        return replace(self, inner=next(still), outer=next(still))

    def _parts(self):
        for side, wall in enumerate((self.inner, self.outer)):
            yield side, wall.cosine - 1j * wall.sine, wall.angular_frequency

    def _changes(self):
        """Yield the parts of what changes at t = 0."""
        yield from self._parts()
        for side, wall in enumerate((self.inner, self.outer)):
            yield side, -(wall.before or 0.0), 0.0

    def _evaluate(self, r, t, shear):
        r, t = np.broadcast_arrays(*_floats(r, t))
        if (t < 0).any():
            raise ValueError("this flow starts at t = 0: it is defined for t >= 0 only")
        time = self.kinematic_viscosity * t / min(self.inner_radius, self._gap) ** 2
        result = np.empty(r.shape)
        for form, where in (
            (self._start, t == 0),
            (self._early, (t > 0) & (time <= EARLY_TIME)),
            (self._late, time > EARLY_TIME),
        ):
            if where.any():
                result[where] = form(r[where], t[where], shear)
        return result[()]

    def _start(self, r, t, shear):
        result = np.real(self._before._settled(r, t, shear))
        for side, wall in enumerate((self.inner, self.outer)):
            radius = (self.inner_radius, self.outer_radius)[side]
            jump = wall.cosine - (wall.before or 0.0)
            if jump and shear:
                result[r == radius] = math.copysign(math.inf, jump if side else -jump)
            elif not shear:
                result[r == radius] = radius * wall.cosine
        return result

    def _early(self, r, t, shear):
        total = np.real(self._before._settled(r, t, shear))
        for side, amplitude, frequency in self._changes():
            if amplitude:
                total += (amplitude * self._layer(side, frequency, r, t, shear)).real
        return total

    def _layer(self, side, frequency, r, t, shear):
        """Return the flow, or its shear rate, in a half space whose wall starts to turn as e^{i frequency t}."""
        from scipy.special import erfcx

        radius, outwards = ((self.inner_radius, 1.0), (self.outer_radius, -1.0))[side]
        fade = 0.75 * self.kinematic_viscosity / radius**2
        width, shift = 2 * np.sqrt(self.kinematic_viscosity * t), np.sqrt((1j * frequency + fade) * t)
        x = outwards * (r - radius) / width
        left, right = erfcx(x - shift), erfcx(x + shift)
        scale = np.exp(-(x**2) - fade * t) * radius * np.sqrt(radius / r)
        value = 0.5 * scale * (left + right)
        if not shear:
            return value
        slope = scale * (shift * (right - left) - 2 / np.sqrt(np.pi))
        return outwards * slope / width - 1.5 * value / r

    def _late(self, r, t, shear):
        total = np.real(self._settled(r, t, shear))
        radius, ratio = self.inner_radius, self.outer_radius / self.inner_radius
        time = self.kinematic_viscosity * t / radius**2
        k, quotient = modes(ratio, 1 + math.ceil(math.sqrt(EXPONENT / time.min()) * (ratio - 1) / math.pi))
        coefficient = np.zeros(len(k))
        for side, amplitude, frequency in self._changes():
            edge = -radius if side == 0 else quotient * self.outer_radius
            lag = k**2 / (1j * frequency * radius**2 / self.kinematic_viscosity + k**2)
            coefficient += (amplitude * lag).real * np.pi * edge / (quotient**2 - 1)
        mode = (lambda k, r: shear_rates(k, r) / radius) if shear else velocities
        for n in range(len(k)):
            total -= coefficient[n] * np.exp(-(k[n] ** 2) * time) * mode(k[n], r / radius)
        return total

    def _settled(self, r, t, shear):
        total = np.zeros(r.shape, dtype=complex)
        for side, amplitude, frequency in self._parts():
            if amplitude:
                form = self._swinging if frequency else self._steady
                total += amplitude * np.exp(1j * frequency * t) * form(side, frequency, r, shear)
        return total

    def _steady(self, side, _, r, shear):
        inner, outer = self.inner_radius**2, self.outer_radius**2
        a, b = ((-inner, inner * outer), (outer, -inner * outer))[side]
        return (-2 * b / r**2 if shear else a * r + b / r) / (outer - inner)

    def _swinging(self, side, frequency, r, shear):
        """Return R [f(r) g(E) e^.. - g(r) f(E) e^..]/[..], f = K1 and g = I1 for the inner wall, E the other wall.

        Bessel functions by their scaled forms K e^z and I e^-z, so that only decaying exponentials are left.
        """
        kappa = np.sqrt(1j * frequency / self.kinematic_viscosity)
        (decaying_1, growing_1), (decaying_2, growing_2) = (
            _bessel(1, kappa * edge) for edge in (self.inner_radius, self.outer_radius)
        )
        decaying, growing = _bessel(2 if shear else 1, kappa * r)
        if shear:
            decaying, growing = -kappa * decaying, kappa * growing
        across = np.exp(-2 * kappa * self._gap)
        whole = decaying_1 * growing_2 - growing_1 * decaying_2 * across
        from_inner, from_outer = np.exp(-kappa * (r - self.inner_radius)), np.exp(-kappa * (self.outer_radius - r))
        there = np.exp(-kappa * self._gap)
        if side == 0:
            part = decaying * growing_2 * from_inner - growing * decaying_2 * from_outer * there
            return self.inner_radius * part / whole
        part = growing * decaying_1 * from_outer - decaying * growing_1 * from_inner * there
        return self.outer_radius * part / whole

    def _series(self, t, form, settled=False):
        """Return the Chebyshev coefficients across the gap of ``form``(r, u) at time ``t``, of as many as it takes."""
        velocity = self.settled_velocity if settled else self.velocity if t else self._before.settled_velocity
        for count in (33, 65, 129, 257, 513, 1025):
            r = self.inner_radius + self._gap * _chebyshev.points(count)
            series = _chebyshev.coefficients(form(r, velocity(r, t)))
            if _chebyshev.resolved(series, 1e-13):
                break
        return series

    def _integral(self, series):
        """Return coefficients of the integral from the inner wall on, and its value at the outer wall."""
        integral = np.polynomial.chebyshev.chebint(0.5 * self._gap * series, lbnd=-1)
        return integral, float(_chebyshev.evaluate(integral, 1.0))


def _floats(*values):
    return (np.asarray(value, dtype=float) for value in values)


def _bessel(order, z):
    """Return K(z) e^z and I(z) e^-z."""
    from scipy.special import ive, kve

    return kve(order, z), ive(order, z) * np.exp(-1j * z.imag)
