"""Heat in a fluid or solid between two walls: conduction from a start, and heating by viscous dissipation.

Equation: rho c DT/Dt = div(k grad T) + 2 mu D:D with constant conductivity k. Any self-consistent units: T in
temperature, k in power/(length temperature), mu in stress x time; heat fluxes are powers per area.

* ``Conduction``: T_t = kappa (1/r^n) (r^n T')', n = 0 between planes, 1 between cylinders or in a circle; T is uniform
  at the start and the walls have given temperatures or heat fluxes from t = 0 on. The Laplace transform is a sum of
  two exponential or Bessel functions, so that each wall condition is one linear equation. It is inverted by the
  trapezoidal rule on Talbot's contour, to 1e-13 of the largest change of T at all times.
* ``rotating_mode``: a disturbance of T that a rotating circle carries without change of form.
* ``PlaneHeating``, ``PipeHeating``, ``CircularHeating``: steady viscous heating at constant viscosity.
* ``ExponentialCouette``: steady plane Couette flow with mu = mu0 exp(-a (T - T0)), given speed or given stress.

Other viscosities, start-up with heating and buoyancy: ``heated_shear``.

Sources: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids (2nd ed. 1959), chapters 12 and 13;
L. N. Trefethen, J. A. C. Weideman and T. Schmelzer, BIT 46 (2006) 653-670, for the contour; R. B. Bird, W. E. Stewart
and E. N. Lightfoot, Transport Phenomena, section 10.4, for viscous heating; R. Nahme, Ingenieur-Archiv 11 (1940)
191-209, and J. Gavis and R. L. Laurence, Ind. Eng. Chem. Fundam. 7 (1968) 232-239, for the exponential viscosity.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

CONTOUR_POINTS = 28
"""Points of Talbot's contour, half of which are evaluated: with fewer the error, 3.89^-points, grows, with more the
round-off, exp(0.17 points)."""


@dataclass(frozen=True)
class Wall:
    """A wall with a given ``temperature``, or, if it is None, a ``heat_flux`` into the material, 0 if insulated."""

    temperature: float | None = None
    heat_flux: float = 0.0


@dataclass(frozen=True)
class Conduction:
    """Heat conduction from the uniform temperature ``initial`` with the conditions of ``walls`` from t = 0 on.

    The walls (lower, upper) are at the coordinates ``ends``: planes or, if ``cylindrical``, cylinders of these radii.
    With the first radius 0 the material is a full circle, and the first wall has no effect. ``diffusivity`` kappa
    [length^2/time], ``conductivity`` k. Coordinates ``y`` and times ``t`` broadcast; results have their shape. At t = 0
    the walls have their new temperatures and the material has ``initial``. ValueError for other ends or times.
    """

    ends: tuple[float, float]
    walls: tuple[Wall, Wall]
    diffusivity: float
    conductivity: float = 1.0
    initial: float = 0.0
    cylindrical: bool = False

    def __post_init__(self) -> None:
        if not self.ends[0] < self.ends[1] or (self.cylindrical and self.ends[0] < 0):
            raise ValueError(f"the coordinates of the walls must grow, radii from 0 on, not {self.ends}")

    def temperature(self, y: Any, t: Any) -> np.ndarray:
        """Return the temperature T(y, t)."""
        y, t = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        start = np.full(y.shape, self.initial)
        for end, wall in zip(self.ends, self.walls, strict=True):
            if wall.temperature is not None:
                start[y == end] = wall.temperature
        return np.where(t == 0, start, self.initial + self._inverted(y, np.where(t == 0, 1.0, t), 0))[()]

    def heat_flux(self, y: Any, t: Any) -> np.ndarray:
        """Return the heat flux -k dT/dy towards larger y, for t > 0."""
        return -self.conductivity * self._inverted(y, t, 1)

    def _inverted(self, y: Any, t: Any, order: int) -> np.ndarray:
        """Return the derivative of an ``order`` 0 or 1 of T - initial by quadrature along the contour."""
        y, t = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        if np.any(t <= 0):
            raise ValueError("conduction from a start is defined for t >= 0, its heat flux for t > 0")
        angle = np.pi * np.arange(1, CONTOUR_POINTS, 2) / CONTOUR_POINTS
        slope = 0.5017 / np.tan(0.6407 * angle) - 0.5017 * 0.6407 * angle / np.sin(0.6407 * angle) ** 2 + 0.2645j
        point = CONTOUR_POINTS * (0.5017 * angle / np.tan(0.6407 * angle) - 0.6122 + 0.2645j * angle)
        weight = 2 * np.exp(point) * slope
        s = point.reshape(-1, *[1] * t.ndim) / t
        values = self._transform(y, s)[order] / t
        return np.einsum("n,n...->...", weight, values).imag[()]

    def _transform(self, y: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the Laplace transform of T - initial and its derivative along y, for ``s`` (contour, *shape of y)."""
        q = np.sqrt(s / self.diffusivity)
        low, high = self.ends
        near_low, near_high = (_cylindrical if self.cylindrical else _plane)(q, low, high)
        rows, right = [], []
        for end, wall, inwards in zip(self.ends, self.walls, (1.0, -1.0), strict=True):
            order = 0 if wall.temperature is not None else 1
            factor = 1.0 if order == 0 else -inwards * self.conductivity
            rows.append([factor * part(np.full(y.shape, end))[order] for part in (near_low, near_high)])
            right.append((wall.heat_flux if wall.temperature is None else wall.temperature - self.initial) / s)
        if self.cylindrical and low == 0.0:
            amplitudes = [0.0 * s, right[1] / rows[1][1]]
        else:
            (a, b), (c, d) = rows
            determinant = a * d - b * c
            amplitudes = [
                (right[0] * d - right[1] * b) / determinant,
                (right[1] * a - right[0] * c) / determinant,
            ]
        parts = near_low(y), near_high(y)
        value, slope = (
            sum(amplitude * part[order] for amplitude, part in zip(amplitudes, parts, strict=True)) for order in (0, 1)
        )
        return value, slope


def _plane(q: np.ndarray, low: float, high: float) -> tuple[Callable, Callable]:
    """Return the functions exp(-q (y - low)) and exp(-q (high - y)) of y, each as (value, derivative)."""

    def near_low(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value = np.exp(-q * (y - low))
        return value, -q * value

    def near_high(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value = np.exp(-q * (high - y))
        return value, q * value

    return near_low, near_high


def _cylindrical(q: np.ndarray, low: float, high: float) -> tuple[Callable, Callable]:
    """Return K0(q r) and I0(q r), scaled to avoid overflow, as functions (value, derivative) of the radius r."""
    from scipy.special import ive, kve  # a fifth of a second to import

    def near_low(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if low == 0.0:
            return 0.0 * q, 0.0 * q  # K0 is infinite on the axis
        scale = np.exp(-q * (r - low))
        return scale * kve(0, q * r), -scale * q * kve(1, q * r)

    def near_high(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        scale = np.exp(q.real * (r - high))
        return scale * ive(0, q * r), scale * q * ive(1, q * r)

    return near_low, near_high


def rotating_mode(
    r: Any, theta: Any, t: Any, *, radius: float, diffusivity: float, angular_velocity: float, insulated: bool = False
) -> np.ndarray:
    """Return T = J1(k r) cos(theta - Omega t) exp(-kappa k^2 t) in a circle that rotates at Omega.

    k radius is the first zero of J1, for T = 0 at the wall, or of its derivative, if the wall is ``insulated``.
    """
    from scipy.special import j1, jn_zeros, jnp_zeros

    k = (jnp_zeros if insulated else jn_zeros)(1, 1)[0] / radius
    t = np.asarray(t, dtype=float)
    return j1(k * np.asarray(r)) * np.cos(theta - angular_velocity * t) * np.exp(-diffusivity * k**2 * t)


@dataclass(frozen=True)
class PlaneHeating:
    """Steady flow between planes y = 0 and ``gap`` that move at ``speeds`` and have ``temperatures`` (lower, upper).

    ``pressure_gradient`` G = -dp/dx drives the flow, too:

        mu u'' = -G,    k T'' = -mu u'^2

    u is a polynomial of degree 2 and T of degree 4.
    """

    gap: float
    viscosity: float
    conductivity: float
    speeds: tuple[float, float] = (0.0, 0.0)
    pressure_gradient: float = 0.0
    temperatures: tuple[float, float] = (0.0, 0.0)

    def velocity(self, y: Any) -> np.ndarray:
        """Return the velocity u."""
        return self._polynomials[0](np.asarray(y, dtype=float))

    def temperature(self, y: Any) -> np.ndarray:
        """Return the temperature T."""
        return self._polynomials[1](np.asarray(y, dtype=float))

    def heat_flux(self, y: Any) -> np.ndarray:
        """Return the heat flux -k dT/dy towards larger y."""
        return -self.conductivity * self._polynomials[1].deriv()(np.asarray(y, dtype=float))

    @cached_property
    def _polynomials(self) -> tuple[Polynomial, Polynomial]:
        """The polynomials u and T."""
        bend = Polynomial([-self.pressure_gradient / self.viscosity])
        u = _between(bend.integ(2), self.gap, self.speeds)
        heating = -self.viscosity / self.conductivity * u.deriv() ** 2
        return u, _between(heating.integ(2), self.gap, self.temperatures)


def _between(polynomial: Polynomial, gap: float, ends: tuple[float, float]) -> Polynomial:
    """Return the ``polynomial`` plus a linear function, with the values ``ends`` at 0 and at the ``gap``."""
    low, high = ends[0] - polynomial(0.0), ends[1] - polynomial(gap)
    return polynomial + Polynomial([low, (high - low) / gap])


@dataclass(frozen=True)
class PipeHeating:
    """Steady flow in a pipe of ``radius`` R that ``pressure_gradient`` G = -dp/dx drives, wall at ``temperature``.

    u = G (R^2 - r^2)/(4 mu),  T = T_wall + G^2 (R^4 - r^4)/(64 mu k).
    """

    radius: float
    viscosity: float
    conductivity: float
    pressure_gradient: float
    temperature_of_wall: float = 0.0

    def velocity(self, r: Any) -> np.ndarray:
        """Return the velocity u along the axis."""
        return self.pressure_gradient * (self.radius**2 - np.square(r)) / (4 * self.viscosity)

    def temperature(self, r: Any) -> np.ndarray:
        """Return the temperature T."""
        heating = self.pressure_gradient**2 / (64 * self.viscosity * self.conductivity)
        return self.temperature_of_wall + heating * (self.radius**4 - np.power(r, 4.0))

    def heat_flux(self, r: Any) -> np.ndarray:
        """Return the heat flux -k dT/dr outwards."""
        return self.pressure_gradient**2 * np.power(r, 3.0) / (16 * self.viscosity)


@dataclass(frozen=True)
class CircularHeating:
    """Steady flow between cylinders of ``radii`` with ``angular_velocities`` and ``temperatures`` (inner, outer).

    v = A r + B/r,  T = C + E ln r - mu B^2/(k r^2).
    """

    radii: tuple[float, float]
    angular_velocities: tuple[float, float]
    viscosity: float
    conductivity: float
    temperatures: tuple[float, float] = (0.0, 0.0)

    def velocity(self, r: Any) -> np.ndarray:
        """Return the velocity v around the axis."""
        a, b, *_ = self._coefficients
        return a * np.asarray(r) + b / np.asarray(r)

    def temperature(self, r: Any) -> np.ndarray:
        """Return the temperature T."""
        *_, constant, slope, heating = self._coefficients
        return constant + slope * np.log(r) - heating / np.square(r)

    def heat_flux(self, r: Any) -> np.ndarray:
        """Return the heat flux -k dT/dr outwards."""
        *_, slope, heating = self._coefficients
        return -self.conductivity * (slope / np.asarray(r) + 2 * heating / np.power(r, 3.0))

    @cached_property
    def _coefficients(self) -> tuple[float, float, float, float, float]:
        """A, B, C, E and mu B^2/k."""
        (inner, outer), (slow, fast) = self.radii, self.angular_velocities
        a = (fast * outer**2 - slow * inner**2) / (outer**2 - inner**2)
        b = (slow - a) * inner**2
        heating = self.viscosity * b**2 / self.conductivity
        low, high = (T + heating / r**2 for T, r in zip(self.temperatures, self.radii, strict=True))
        slope = (high - low) / np.log(outer / inner)
        return a, b, low - slope * np.log(inner), slope, heating


@dataclass(frozen=True)
class ExponentialCouette:
    """Steady plane Couette flow of a fluid with the viscosity mu0 exp(-a (T - T0)) between walls at T0.

    The wall y = 0 rests and the wall y = ``gap`` moves at ``speed`` U. ``viscosity`` mu0, ``coefficient`` a > 0
    [1/temperature], ``temperature_of_walls`` T0. With the Nahme number Na = a mu0 U^2/k, m = (Na/8)^(1/2),
    sigma = arsinh m and z = sigma (2 y/gap - 1):

        a (T - T0) = ln(1 + m^2) - 2 ln cosh z,   u/U = (1 + tanh z/tanh sigma)/2,
        stress gap/(mu0 U) = sigma/(m (1 + m^2)^(1/2))
    """

    gap: float
    viscosity: float
    conductivity: float
    coefficient: float
    speed: float
    temperature_of_walls: float = 0.0

    @classmethod
    def of_stress(
        cls,
        stress: float,
        *,
        gap: float,
        viscosity: float,
        conductivity: float,
        coefficient: float,
        temperature_of_walls: float = 0.0,
        hot: bool = False,
    ) -> "ExponentialCouette":
        """Return the flow of a given ``stress`` > 0, the colder or the ``hot`` one of its two flows.

        The flow from rest goes to the colder one. ValueError above the largest stress of a steady flow: with
        a stress^2 gap^2/(mu0 k) = G, G = 8 (sigma/cosh sigma)^2 <= 3.513830719.
        """
        from scipy.optimize import brentq

        unit = np.sqrt(viscosity * conductivity / coefficient) / gap
        turning = brentq(lambda sigma: sigma * np.tanh(sigma) - 1.0, 1.0, 2.0, xtol=1e-15)
        largest = np.sqrt(8) * turning / np.cosh(turning) * unit
        if not 0 < stress <= largest:
            raise ValueError(
                f"a steady flow needs a stress above 0 and up to {largest:.10g}, not {stress:.10g}: "
                "above it the fluid heats without end"
            )
        target = stress / unit / np.sqrt(8)

        def excess(sigma: float) -> float:
            return np.log(sigma) - np.logaddexp(sigma, -sigma) + np.log(2 / target)

        ends = (turning, 700.0) if hot else (1e-3 * target, turning)
        sigma = turning if stress == largest else brentq(excess, *ends, xtol=1e-15, rtol=1e-15)
        speed = np.sqrt(8) * np.sinh(sigma) * np.sqrt(conductivity / (coefficient * viscosity))
        return cls(gap, viscosity, conductivity, coefficient, float(speed), temperature_of_walls)

    @property
    def nahme(self) -> float:
        """Nahme number a mu0 U^2/k."""
        return self.coefficient * self.viscosity * self.speed**2 / self.conductivity

    def velocity(self, y: Any) -> np.ndarray:
        """Return the velocity u."""
        return self.speed * (1 + np.tanh(self._z(y)) / np.tanh(self._sigma)) / 2

    def temperature(self, y: Any) -> np.ndarray:
        """Return the temperature T."""
        excess = 2 * np.log(np.cosh(self._sigma)) - 2 * np.log(np.cosh(self._z(y)))
        return self.temperature_of_walls + excess / self.coefficient

    def heat_flux(self, y: Any) -> np.ndarray:
        """Return the heat flux -k dT/dy towards larger y."""
        return 4 * self.conductivity * self._sigma / (self.coefficient * self.gap) * np.tanh(self._z(y))

    @property
    def stress(self) -> float:
        """Shear stress, the same everywhere."""
        return float(self.viscosity * self.speed / self.gap * 2 * self._sigma / np.sinh(2 * self._sigma))

    @property
    def _sigma(self) -> float:
        return float(np.arcsinh(np.sqrt(self.nahme / 8)))

    def _z(self, y: Any) -> np.ndarray:
        return self._sigma * (2 * np.asarray(y, dtype=float) / self.gap - 1)
