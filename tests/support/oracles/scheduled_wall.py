"""Flow between a wall at rest and a wall whose velocity is piecewise linear in time, of a Newtonian fluid from rest.

Equation: du/dt = nu d2u/dy2 for 0 < y < H, u(0, t) = 0. It is linear: with f the flow of a wall y = H that starts with
unit velocity (``couette``) and F its integral over the time, a wall whose velocity jumps by J_k and whose acceleration
jumps by a_k at the times t_k makes

    u = sum over t_k < t of J_k f(y, t - t_k) + a_k F(y, t - t_k)

With eta = y/H, T = nu t/H^2 and i2erfc(x) = [(1 + 2 x^2) erfc(x) - 2 x exp(-x^2)/sqrt(pi)]/4,

    F nu/H^2 = eta T - (eta - eta^3)/6 - (2/pi^3) sum_{n>=1} (-1)^n/n^3 sin(n pi eta) exp(-n^2 pi^2 T)     (series)
    F nu/H^2 = 4 T sum_{k>=0} i2erfc((2k+1-eta)/(2 sqrt T)) - i2erfc((2k+1+eta)/(2 sqrt T))                (images)

Source: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, sections 2.5 and 3.4, appendix II. Accuracy: 1e-14
of the velocity that a ramp has reached.

Shapes and units: ``y`` and ``t`` broadcast against each other and the result has the broadcast shape; any
self-consistent units. ``breakpoints``: triples (t_k, J_k, a_k).
"""

import numpy as np

from tisph.exact import couette
from tisph.exact.couette import dimensionless, erfc, image_distances, select, series_terms


def velocity(y, t, *, gap, kinematic_viscosity, breakpoints):
    """Velocity u(y, t) along the walls (wall at y = gap); where it jumps that before, but at t = 0 that after.

    Raises ValueError for a negative time.
    """
    fluid = {"gap": gap, "kinematic_viscosity": kinematic_viscosity}
    scale = gap**2 / kinematic_viscosity
    return _sum(y, t, breakpoints, fluid, couette.velocity, (_nothing, _image_velocity, _series_velocity), scale)


def shear_rate(y, t, *, gap, kinematic_viscosity, breakpoints):
    """Velocity gradient du/dy (1/time); at t = 0 infinite at a wall whose velocity jumps then; as ``velocity``."""
    fluid = {"gap": gap, "kinematic_viscosity": kinematic_viscosity}
    scale = gap / kinematic_viscosity
    return _sum(y, t, breakpoints, fluid, couette.shear_rate, (_nothing, _image_gradient, _series_gradient), scale)


def _sum(y, t, breakpoints, fluid, step, ramp, scale):
    eta, diffusion_time = dimensionless(y, t, **fluid)
    total, times = np.zeros(eta.shape), np.broadcast_to(np.asarray(t, dtype=float), eta.shape)
    for time, jump, slope in breakpoints:
        passed = (times > time) | (time == 0.0)
        since = np.where(passed, times - time, 0.0)
        if jump:
            total = total + np.where(passed, step(y, since, **fluid, bottom=0.0, top=jump), 0.0)
        if slope:
            later = diffusion_time / np.where(times > 0.0, times, 1.0) * since
            total = total + slope * scale * select(ramp, eta, later)
    return total[()]


def _nothing(eta, diffusion_time):
    return np.zeros_like(eta)


def _series_velocity(eta, diffusion_time):
    total = eta * diffusion_time - (eta - eta**3) / 6
    for n in series_terms(diffusion_time):
        decay = np.exp(-((n * np.pi) ** 2) * diffusion_time)
        total -= (-1) ** n * 2 / (n * np.pi) ** 3 * np.sin(n * np.pi * eta) * decay
    return total


def _series_gradient(eta, diffusion_time):
    total = diffusion_time - (1 - 3 * eta**2) / 6
    for n in series_terms(diffusion_time):
        decay = np.exp(-((n * np.pi) ** 2) * diffusion_time)
        total -= (-1) ** n * 2 / (n * np.pi) ** 2 * np.cos(n * np.pi * eta) * decay
    return total


def _image_velocity(eta, diffusion_time):
    width = 2 * np.sqrt(diffusion_time)
    total = np.zeros_like(eta)
    for distance in image_distances(diffusion_time):
        total += _twice((distance - eta) / width) - _twice((distance + eta) / width)
    return 4 * diffusion_time * total


def _image_gradient(eta, diffusion_time):
    width = 2 * np.sqrt(diffusion_time)
    total = np.zeros_like(eta)
    for distance in image_distances(diffusion_time):
        total += _once((distance - eta) / width) + _once((distance + eta) / width)
    return width * total


def _once(x):
    """Integral of erfc from x on."""
    return np.exp(-(x**2)) / np.sqrt(np.pi) - x * erfc(x)


def _twice(x):
    """Integral of ``_once`` from x on."""
    return ((1 + 2 * x**2) * erfc(x) - 2 * x * np.exp(-(x**2)) / np.sqrt(np.pi)) / 4
