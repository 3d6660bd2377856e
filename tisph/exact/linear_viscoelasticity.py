"""Small deformations of a fluid with relaxation modes: theory of rheometers, with the inertia of the fluid.

    complex viscosity  eta*(w) = solvent + sum eta_k/(1 + i w lambda_k),    G* = G' + i G'' = i w eta*

Between a wall at rest and one whose velocity is U e^(i w t), a gap H away, u = U sinh(q y)/sinh(q H) with q^2 = i w
density/eta*: the stress on the moving wall is Z U/H, Z = eta* qH coth(qH), which is eta* without inertia (J. D. Ferry,
Viscoelastic Properties of Polymers, 3rd ed. 1980, chapter 5).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

TERMS = 24
"""Terms of Talbot's contour for inverse transforms: at least ten digits for transforms without poles off the axis."""

MOST_ITERATIONS = 100


@dataclass(frozen=True)
class Spectrum:
    """Viscosity of the ``solvent`` and pairs (viscosity, relaxation time) of the ``modes``, all dynamic."""

    solvent: float
    modes: tuple[tuple[float, float], ...] = ()

    @property
    def viscosity(self) -> float:
        """Viscosity of a steady flow."""
        return self.solvent + sum(viscosity for viscosity, _ in self.modes)

    @property
    def longest_time(self) -> float:
        """The longest relaxation time, 0 without modes."""
        return max((time for _, time in self.modes), default=0.0)

    def complex_viscosity(self, s: Any) -> Any:
        """Return eta* at s = i w, or the Laplace transform of the relaxation modulus at ``s``."""
        return self.solvent + sum(viscosity / (1.0 + s * time) for viscosity, time in self.modes)

    def growth(self, t: Any) -> np.ndarray:
        """Return the viscosity eta+(t) at a time ``t`` after the start of shear, without inertia."""
        t = np.asarray(t, dtype=float)
        return self.solvent + sum(viscosity * -np.expm1(-t / time) for viscosity, time in self.modes) + 0.0 * t

    def modulus(self, t: Any) -> np.ndarray:
        """Return the relaxation modulus G(t > 0), stress over strain after a step strain, without inertia."""
        t = np.asarray(t, dtype=float)
        return sum(viscosity / time * np.exp(-t / time) for viscosity, time in self.modes) + 0.0 * t

    def normal_stress_growth(self, t: Any) -> np.ndarray:
        """Return N1 / (shear rate)^2 after the start of shear, for upper-convected modes, without inertia."""
        t = np.asarray(t, dtype=float)
        parts = [2.0 * eta * time * (1.0 - np.exp(-t / time) * (1.0 + t / time)) for eta, time in self.modes]
        return sum(parts) + 0.0 * t

    def compliance(self, t: Any) -> np.ndarray:
        """Return the creep compliance J(t > 0), strain over stress, without inertia."""
        return np.array([_inverted(lambda s: 1.0 / (s * s * self.complex_viscosity(s)), one) for one in np.ravel(t)])

    def apparent_viscosity(self, angular_frequency: float, density: float, gap: float) -> Any:
        """Return Z for a ``gap`` between a wall at rest and one that oscillates."""
        return apparent_viscosity(self.complex_viscosity(1j * angular_frequency), angular_frequency, density, gap)

    def free_oscillation(self, guess: complex, density: float, gap: float, mass_per_area: float) -> complex:
        """Return the root s near ``guess`` of mass s + sqrt(density s eta*) coth(qH) = 0: a plate moves as e^(s t)."""

        def balance(s: complex) -> complex:
            viscosity = self.complex_viscosity(s)
            root = gap * np.sqrt(density * s / viscosity)
            return mass_per_area * s + viscosity / gap * root / np.tanh(root)

        return _root(balance, complex(guess))


def apparent_viscosity(viscosity: Any, angular_frequency: float, density: float, gap: float) -> Any:
    """Return Z = eta* qH coth(qH) for a complex ``viscosity`` eta*."""
    root = gap * np.sqrt(1j * angular_frequency * density / viscosity)
    return viscosity * root / np.tanh(root)


def cylinder_apparent_viscosity(
    viscosity: complex, angular_frequency: float, density: float, moving_radius: float, resting_radius: float
) -> complex:
    """Return the stress over the nominal shear rate at an oscillating cylinder beside a coaxial cylinder at rest.

    Modified Bessel functions solve i w density u = eta* (u'' + u'/r - u/r^2). The nominal rate is 2 W b^2/(a^2 - b^2),
    with the radius a of the moving cylinder, of angular velocity W, and the radius b of the other one.
    """
    from scipy.special import iv, kv  # a fifth of a second, of no use to most runs

    root = np.sqrt(1j * angular_frequency * density / viscosity)
    own, other = root * moving_radius, root * resting_radius
    sheared = kv(1, other) * iv(2, own) + iv(1, other) * kv(2, own)
    moved = kv(1, other) * iv(1, own) - iv(1, other) * kv(1, own)
    return viscosity * own * sheared / moved * (moving_radius**2 - resting_radius**2) / (2.0 * resting_radius**2)


def corrected_viscosity(measured: complex, apparent_viscosity: Callable, guess: complex) -> complex:
    """Return the complex viscosity with ``apparent_viscosity(viscosity)`` = ``measured`` that is nearest to a guess.

    If the wavelength is shorter than the gap, there are several solutions.
    """
    return _root(lambda eta: apparent_viscosity(eta) - measured, complex(guess))


def _root(function: Callable, guess: complex) -> complex:
    """Return a root by Newton's method, with a derivative by a difference; NaN if it does not converge."""
    for _ in range(MOST_ITERATIONS):
        step = 1e-6 * abs(guess)
        slope = (function(guess + step) - function(guess - step)) / (2.0 * step)
        change = function(guess) / slope
        guess = guess - change
        if abs(change) <= 1e-12 * abs(guess):
            return guess
    return complex(np.nan, np.nan)


def _inverted(transform: Callable, t: Any) -> float:
    """Return the inverse Laplace transform at ``t``, by Talbot's method.

    J. Abate and W. Whitt, INFORMS J. Comput. 18 (2006) 408-421.
    """
    angle = np.arange(1, TERMS) * np.pi / TERMS
    cotangent = 1.0 / np.tan(angle)
    delta = 0.4 * TERMS * np.concatenate([[1.0], angle * (cotangent + 1j)])
    weight = np.exp(delta) * np.concatenate([[0.5], 1.0 + 1j * angle * (1.0 + cotangent**2) - 1j * cotangent])
    return 0.4 / t * np.sum((weight * transform(delta / t)).real)
