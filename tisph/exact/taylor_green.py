"""Taylor-Green vortices: a periodic array of vortices that keep their places and decay by viscosity.

Navier-Stokes equations of a fluid of constant density, with k = 2 pi/L, L the period, and e = exp(-2 nu k^2 t):

    u = -U cos kx sin ky e,   v = U sin kx cos ky e,   p = -rho U^2/4 (cos 2kx + cos 2ky) e^2

The viscous term balances du/dt; the pressure, of zero mean, balances the convective acceleration. Per mass and averaged
over a period, the kinetic energy is U^2/4 e^2, and its dissipation rate is nu k^2 U^2 e^2.

Source: G. I. Taylor and A. E. Green, Proc. R. Soc. Lond. A 158 (1937) 499-521, section 1; for two dimensions G. I.
Taylor, Phil. Mag. 46 (1923) 671-674.

Shapes and units: ``x``, ``y`` and ``t`` broadcast against each other and results have the broadcast shape; any
self-consistent units: ``length``: period, ``speed``: largest speed at t = 0, ``kinematic_viscosity`` in length^2/time.
"""

import math
from typing import Any

import numpy as np


def velocity(
    x: Any, y: Any, t: Any, *, length: float, speed: float, kinematic_viscosity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity components (u, v) along x and y."""
    k, decay = _wave_number(length), _decay(t, length, kinematic_viscosity)
    phase_x, phase_y = k * np.asarray(x, dtype=float), k * np.asarray(y, dtype=float)
    u = -speed * decay * np.cos(phase_x) * np.sin(phase_y)
    return u, speed * decay * np.sin(phase_x) * np.cos(phase_y)


def vorticity(x: Any, y: Any, t: Any, *, length: float, speed: float, kinematic_viscosity: float) -> np.ndarray:
    """Return the vorticity dv/dx - du/dy (1/time)."""
    k = _wave_number(length)
    cosines = np.cos(k * np.asarray(x, dtype=float)) * np.cos(k * np.asarray(y, dtype=float))
    return 2 * k * speed * _decay(t, length, kinematic_viscosity) * cosines


def pressure(
    x: Any, y: Any, t: Any, *, length: float, speed: float, kinematic_viscosity: float, density: float
) -> np.ndarray:
    """Return the pressure [mass/(length time^2)], of zero mean over a period."""
    double = 2 * _wave_number(length)
    cosines = np.cos(double * np.asarray(x, dtype=float)) + np.cos(double * np.asarray(y, dtype=float))
    return -0.25 * density * (speed * _decay(t, length, kinematic_viscosity)) ** 2 * cosines


def kinetic_energy(t: Any, *, length: float, speed: float, kinematic_viscosity: float) -> np.ndarray:
    """Return the kinetic energy per mass [length^2/time^2], the mean over a period."""
    return 0.25 * (speed * _decay(t, length, kinematic_viscosity)) ** 2


def dissipation(t: Any, *, length: float, speed: float, kinematic_viscosity: float) -> np.ndarray:
    """Return the dissipation rate of kinetic energy per mass [length^2/time^3], the mean over a period."""
    rate = kinematic_viscosity * _wave_number(length) ** 2
    return rate * (speed * _decay(t, length, kinematic_viscosity)) ** 2


def _wave_number(length: float) -> float:
    return 2 * math.pi / length


def _decay(t: Any, length: float, kinematic_viscosity: float) -> np.ndarray:
    """Return the factor by which velocities have decayed."""
    return np.exp(-2 * kinematic_viscosity * _wave_number(length) ** 2 * np.asarray(t, dtype=float))
