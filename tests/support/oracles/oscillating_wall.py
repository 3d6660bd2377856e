"""Flow between a wall at rest and a wall that oscillates along itself: Stokes' second problem in a gap.

Equation: du/dt = nu d2u/dy2 for 0 < y < H, u(0, t) = 0, u(H, t) = Re[A e^{i w t}] with A = cosine - i sine, that is,
cosine cos(w t) + sine sin(w t). With eta = y/H, T = nu t/H^2, kappa = H sqrt(i w/nu), s = sqrt(i w t):

    periodic   u = Re[A e^{i w t} sinh(kappa eta)/sinh(kappa)]
    from rest  u = periodic - Re[A sum_{n>=1} b_n sin(n pi eta) exp(-n^2 pi^2 T)],
                   b_n = 2 (-1)^{n+1} n pi/(kappa^2 + n^2 pi^2)                                      (series)
               u = Re[A sum_{k>=0} h((2k+1-eta)/(2 sqrt T)) - h((2k+1+eta)/(2 sqrt T))],
                   h(x) = exp(-x^2) [erfcx(x - s) + erfcx(x + s)]/2                                  (images)

h is the flow in a half space whose wall starts to oscillate at t = 0, and erfcx(z) = exp(z^2) erfc(z); written so, no
term overflows, neither for Stokes layers much thinner than the gap nor far from the wall.

Sources: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3 (periodic); H. S. Carslaw and J. C. Jaeger,
Conduction of Heat in Solids, chapters 2 (half space with a periodic surface) and 3 (slab).

Accuracy: 1e-14 of the amplitude (for the gradient, of amplitude/layer thickness), plus the rounding of the phase, some
2e-16 w t.

Shapes and units: ``y`` and ``t`` broadcast against each other and the result has the broadcast shape; any
self-consistent units. ``wall`` is an ``Oscillation`` or any object with its three attributes.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from tisph.exact.couette import dimensionless, image_distances, select, series_terms


@dataclass(frozen=True)
class Oscillation:
    """Wall velocity cosine * cos(w t) + sine * sin(w t), w = ``angular_frequency`` > 0 (radians/time)."""

    cosine: float
    sine: float
    angular_frequency: float


def velocity(y, t, *, gap, kinematic_viscosity, wall):
    """Velocity u(y, t) along the walls of the flow that starts from rest at t = 0 (``wall`` at y = gap).

    At t = 0 the fluid is at rest and y = gap has the wall's velocity. Raises ValueError for a negative time and
    for an angular frequency that is not positive.
    """
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    frequency = _frequency(gap, kinematic_viscosity, wall)
    forms = (_start_velocity, _image_velocity, _series_velocity)
    return select([partial(form, wall, frequency) for form in forms], eta, diffusion_time)


def shear_rate(y, t, *, gap, kinematic_viscosity, wall):
    """Velocity gradient du/dy (1/time) of the flow from rest; arguments as ``velocity``.

    At t = 0 it is 0 in the fluid, and infinite at a wall whose velocity jumps there (cosine != 0).
    """
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    frequency = _frequency(gap, kinematic_viscosity, wall)
    forms = (_start_gradient, _image_gradient, _series_gradient)
    return select([partial(form, wall, frequency) for form in forms], eta, diffusion_time) / gap


def periodic_velocity(y, t, *, gap, kinematic_viscosity, wall):
    """Velocity of the periodic flow, which the flow from rest becomes; any ``t``, else as ``velocity``."""
    frequency = _frequency(gap, kinematic_viscosity, wall)
    return (_rotation(wall, t) * _profile(np.asarray(y, dtype=float) / gap, frequency)).real


def periodic_shear_rate(y, t, *, gap, kinematic_viscosity, wall):
    """Velocity gradient du/dy (1/time) of the periodic flow; arguments as ``periodic_velocity``."""
    frequency = _frequency(gap, kinematic_viscosity, wall)
    return (_rotation(wall, t) * _profile_slope(np.asarray(y, dtype=float) / gap, frequency)).real / gap


def _frequency(gap, kinematic_viscosity, wall):
    """w gap^2/nu: twice the square of the gap in Stokes layers sqrt(2 nu/w)."""
    if not wall.angular_frequency > 0:
        raise ValueError(f"an oscillating wall needs an angular frequency above 0, not {wall.angular_frequency}")
    return wall.angular_frequency * gap**2 / kinematic_viscosity


def _amplitude(wall):
    return wall.cosine - 1j * wall.sine


def _rotation(wall, t):
    return _amplitude(wall) * np.exp(1j * wall.angular_frequency * np.asarray(t, dtype=float))


def _profile(eta, frequency):
    """sinh(kappa eta)/sinh(kappa) by decaying exponentials."""
    kappa = np.sqrt(1j * frequency)
    return np.exp(-kappa * (1 - eta)) * np.expm1(-2 * kappa * eta) / np.expm1(-2 * kappa)


def _profile_slope(eta, frequency):
    """Derivative kappa cosh(kappa eta)/sinh(kappa) of ``_profile``."""
    kappa = np.sqrt(1j * frequency)
    return -kappa * np.exp(-kappa * (1 - eta)) * (1 + np.exp(-2 * kappa * eta)) / np.expm1(-2 * kappa)


def _series_velocity(wall, frequency, eta, diffusion_time):
    total = np.exp(1j * frequency * diffusion_time) * _profile(eta, frequency)
    for n in series_terms(diffusion_time):
        total -= _decaying(n, frequency, diffusion_time) * np.sin(n * np.pi * eta)
    return (_amplitude(wall) * total).real


def _series_gradient(wall, frequency, eta, diffusion_time):
    total = np.exp(1j * frequency * diffusion_time) * _profile_slope(eta, frequency)
    for n in series_terms(diffusion_time):
        total -= n * np.pi * _decaying(n, frequency, diffusion_time) * np.cos(n * np.pi * eta)
    return (_amplitude(wall) * total).real


def _decaying(n, frequency, diffusion_time):
    rate = (n * np.pi) ** 2
    return 2 * (-1) ** (n + 1) * n * np.pi / (1j * frequency + rate) * np.exp(-rate * diffusion_time)


def _image_velocity(wall, frequency, eta, diffusion_time):
    width, shift = 2 * np.sqrt(diffusion_time), np.sqrt(1j * frequency * diffusion_time)
    total = np.zeros(eta.shape, dtype=complex)
    for distance in image_distances(diffusion_time):
        total += _half_space((distance - eta) / width, shift) - _half_space((distance + eta) / width, shift)
    return (_amplitude(wall) * total).real


def _image_gradient(wall, frequency, eta, diffusion_time):
    width, shift = 2 * np.sqrt(diffusion_time), np.sqrt(1j * frequency * diffusion_time)
    total = np.zeros(eta.shape, dtype=complex)
    for distance in image_distances(diffusion_time):
        for x in ((distance - eta) / width, (distance + eta) / width):
            total -= _half_space_slope(x, shift)
    return (_amplitude(wall) * total).real / width


def _half_space(x, shift):
    from scipy.special import erfcx

    return np.exp(-(x**2)) * (erfcx(x - shift) + erfcx(x + shift)) / 2


def _half_space_slope(x, shift):
    """Derivative of ``_half_space`` with respect to x."""
    from scipy.special import erfcx

    return np.exp(-(x**2)) * (shift * (erfcx(x + shift) - erfcx(x - shift)) - 2 / np.sqrt(np.pi))


def _start_velocity(wall, frequency, eta, diffusion_time):
    return np.where(eta >= 1, wall.cosine, 0.0)


def _start_gradient(wall, frequency, eta, diffusion_time):
    jump = np.copysign(np.inf, wall.cosine) if wall.cosine != 0 else 0.0
    return np.where(eta >= 1, jump, 0.0)
