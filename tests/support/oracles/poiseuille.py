"""Start-up plane Poiseuille flow: fluid at rest between two walls at rest, driven along them from t = 0 on.

Equation: du/dt = g + nu d2u/dy2 for 0 < y < H, u(y, 0) = u(0, t) = u(H, t) = 0; g = -(dp/dx)/density.
With eta = y/H, T = nu t/H^2 and 4 i2erfc(x) = (1 + 2 x^2) erfc(x) - (2/sqrt pi) x exp(-x^2), u = (g H^2/nu) F,

    F = eta (1 - eta)/2 - (4/pi^3) sum_{n odd} sin(n pi eta) exp(-n^2 pi^2 T)/n^3                (series)
    F = T [1 - sum_{k>=0} (-1)^k 4 (i2erfc((k+eta)/(2 sqrt T)) + i2erfc((k+1-eta)/(2 sqrt T)))]  (images)

Sources: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3; J. P. Morris, P. J. Fox and Y. Zhu,
J. Comput. Phys. 136 (1997) 214-226 (the series); H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids,
appendix II (the repeated integrals of erfc).

Shapes and units: ``y`` and ``t`` broadcast against each other and the result has the broadcast shape; any
self-consistent units, ``kinematic_viscosity`` in length^2/time, ``acceleration`` in length/time^2.
"""

import numpy as np

from tisph.exact.couette import EXPONENT, dimensionless, erfc, select, series_terms


def velocity(y, t, *, gap, kinematic_viscosity, acceleration):
    """Velocity u(y, t) along the walls, to 2e-15 of the largest velocity at that time.

    ``t >= 0``; at t = 0 the fluid is at rest. Raises ValueError for a negative time.
    """
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    forms = (_at_rest, _image_velocity, _series_velocity)
    return acceleration * gap**2 / kinematic_viscosity * select(forms, eta, diffusion_time)


def shear_rate(y, t, *, gap, kinematic_viscosity, acceleration):
    """Velocity gradient du/dy (1/time), to 2e-15 of the largest gradient at that time; as ``velocity``."""
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    forms = (_at_rest, _image_gradient, _series_gradient)
    return acceleration * gap / kinematic_viscosity * select(forms, eta, diffusion_time)


def developed_velocity(y, *, gap, kinematic_viscosity, acceleration):
    """Velocity of the steady flow, the parabola g y (H - y)/(2 nu); shape of ``y``."""
    y = np.asarray(y, dtype=float)
    return acceleration * y * (gap - y) / (2 * kinematic_viscosity)


def _at_rest(eta, diffusion_time):
    return np.zeros_like(eta)


def _series_velocity(eta, diffusion_time):
    total = eta * (1 - eta) / 2
    for n in series_terms(diffusion_time)[::2]:
        total -= 4 / (n * np.pi) ** 3 * np.sin(n * np.pi * eta) * np.exp(-((n * np.pi) ** 2) * diffusion_time)
    return total


def _series_gradient(eta, diffusion_time):
    total = 0.5 - eta
    for n in series_terms(diffusion_time)[::2]:
        total -= 4 / (n * np.pi) ** 2 * np.cos(n * np.pi * eta) * np.exp(-((n * np.pi) ** 2) * diffusion_time)
    return total


def _image_velocity(eta, diffusion_time):
    width = 2 * np.sqrt(diffusion_time)
    total = np.ones_like(eta)
    for k in range(1 + _image_reach(diffusion_time)):
        total -= (-1) ** k * (_slowed((k + eta) / width) + _slowed((k + 1 - eta) / width))
    return diffusion_time * total


def _image_gradient(eta, diffusion_time):
    width = 2 * np.sqrt(diffusion_time)
    total = np.zeros_like(eta)
    for k in range(1 + _image_reach(diffusion_time)):
        total += (-1) ** k * (_slowed_slope((k + eta) / width) - _slowed_slope((k + 1 - eta) / width))
    return width * total


def _image_reach(diffusion_time):
    """Distance, in gaps, at which an image adds less than rounding error at any of the times."""
    return int(np.ceil(2 * np.sqrt(EXPONENT * diffusion_time.max())))


def _slowed(x):
    """4 i2erfc(x): the part of g t that a wall at scaled distance x has taken away."""
    return (1 + 2 * x**2) * erfc(x) - 2 / np.sqrt(np.pi) * x * np.exp(-(x**2))


def _slowed_slope(x):
    """ierfc(x), a quarter of the slope of ``_slowed`` with the opposite sign."""
    return np.exp(-(x**2)) / np.sqrt(np.pi) - x * erfc(x)
