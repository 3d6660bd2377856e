"""How fast particles are shifted towards an even arrangement, bounded by what an explicit step can follow."""

import numpy as np

from tisph.schemes._time_step import AUTO_CFL, VISCOUS_NUMBER

SHIFT = 1.5
"""Rate at which the shift evens out the stiffest wave of displacements on the lattice, times h/c.

A step of CFL 0.25 then takes away 3/8 of that wave, where the predictor is stable up to 1 and disorder, with pairs
closer than a spacing, is up to twice as stiff. At 0.2 (the 2 U h usual in the literature) particles cross walls from
cell Reynolds numbers of 20 on.
"""

WAVES = 32
"""Wave lengths among which the stiffest is looked for."""


def shift_speed(kernel, smoothing_ratio, sound_speed, cfl, diffusion_speed):
    """Return the speed [length/time] that multiplies -h sum V grad W in the shift velocity.

    It scales with the sound speed c, as the longest step does, and above the automatic CFL number with 1/cfl, so that
    the shift of a step is bounded. Where viscosity binds the step more tightly it scales with the ``diffusion_speed``
    nu/h instead, for the same shift in a step: else disorder would outlive the start of a slow flow. ``kernel`` is a
    module of ``kernels/``, ``smoothing_ratio`` h over the spacing, ``cfl`` the number of the config or ``auto``.
    """
    number = AUTO_CFL if cfl == "auto" else max(cfl, AUTO_CFL)
    pace = AUTO_CFL * max(sound_speed / number, diffusion_speed / VISCOUS_NUMBER)  # h over the longest step, times CFL
    return SHIFT * pace / stiffness(kernel, smoothing_ratio)


def stiffness(kernel, smoothing_ratio):
    """Return the largest eigenvalue of -h^2 d(sum V grad W)_i/dx_i on the square lattice, a pure number.

    The stiffest waves of displacement are longitudinal, along a row.
    """
    reach = int(kernel.SUPPORT * smoothing_ratio)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-reach, reach + 1.0), np.arange(-reach, reach + 1.0)))
    neighbours = (x != 0) | (y != 0)
    x, y = x[neighbours] / smoothing_ratio, y[neighbours] / smoothing_ratio
    small = 1e-4
    slope = (_pull(kernel, x + small, y) - _pull(kernel, x - small, y)) / (2 * small)
    numbers = np.arange(1, WAVES + 1) * np.pi / WAVES * smoothing_ratio
    return max(-float(np.sum(slope * (1 - np.cos(number * x)))) for number in numbers) / smoothing_ratio**2


def _pull(kernel, x, y):
    distance = np.hypot(x, y)
    weights = [kernel.slope_over_q(q) if q < kernel.SUPPORT else 0.0 for q in distance]
    return np.array(weights) * x
