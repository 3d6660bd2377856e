"""Limits of an explicit time step, and the speed of shifts, which an explicit step limits too."""

import math
from typing import Any, Literal

import numpy as np

from tisph.config.schema import Config
from tisph.scenes._scene import Scene
from tisph.schemes.wcsph.equation_of_state import sound_speed

AUTO_CFL = 0.25
RELAXATION_NUMBER = 0.25
VISCOUS_NUMBER = 0.125
"""Step over h^2/nu; J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214-226."""

SHIFT = 1.5
"""Decay rate, by shifting, of the stiffest wave of displacements on the lattice, times h/c.

A step of CFL 0.25 then reduces that wave by 3/8. The predictor is stable up to a reduction by 1, and disorder, with
pairs closer than a spacing, is up to twice as stiff. At 0.2 (the 2 U h usual in the literature) particles cross walls
from cell Reynolds numbers of 20 on.
"""

WAVES = 32
"""Number of wave lengths among which the stiffest is searched."""


def sound_speed_of(config: Config, scene: Scene) -> float:
    """Return the speed of sound [length/time] of a run of scheme ``wcsph``."""
    return sound_speed(
        config.scheme.equation_of_state,
        reference_velocity=scene.peak_velocity,
        kinematic_viscosity=scene.kinematic_viscosity,
        length=scene.reference_length,
        density=scene.density,
        elastic_speed=scene.elastic_speed,
    )


def limits_of(
    config: Config, scene: Scene, sound: float, *, speed: float, acceleration: float, elastic_speed: float
) -> dict[str, float]:
    """Return the ``time_step_limits`` of a run of scheme ``wcsph`` with this ``sound`` speed.

    Monaghan's linear artificial viscosity alpha adds alpha c h / 8 to the kinematic viscosity in two dimensions (J. J.
    Monaghan, Rep. Prog. Phys. 68 (2005) 1703-1759).
    """
    length = config.discretisation.smoothing_ratio * scene.spacing
    return time_step_limits(
        config.time.cfl,
        smoothing_length=length,
        sound_speed=sound,
        reference_velocity=speed,
        kinematic_viscosity=scene.solvent_viscosity + config.scheme.artificial_viscosity * sound * length / 8.0,
        acceleration=acceleration,
        elastic_speed=elastic_speed,
        relaxation_time=scene.polymer.relaxation_time if scene.polymer else math.inf,
    )


def time_step_limits(
    cfl: float | Literal["auto"],
    *,
    smoothing_length: float,
    sound_speed: float,
    reference_velocity: float,
    kinematic_viscosity: float,
    acceleration: float = 0.0,
    elastic_speed: float = 0.0,
    relaxation_time: float = math.inf,
) -> dict[str, float]:
    """Return the largest stable steps [time] by the names of the limits; a run takes the smallest.

    ``acoustic``: cfl h / (sqrt(c^2 + c_e^2) + U), with cfl 0.25 for ``auto`` and the ``elastic_speed`` c_e of
    shear waves in the polymer. ``viscous``: 0.125 h^2 / nu, with the ``kinematic_viscosity`` nu of the solvent.
    ``acceleration``: 0.25 sqrt(h / a), no limit without acceleration. ``relaxation``: 0.25 ``relaxation_time``, so that
    an explicit step follows the decay of the polymer stress; no limit without elastic speed. All in the units of the
    config.
    """
    number = AUTO_CFL if cfl == "auto" else cfl
    return {
        "acoustic": number * smoothing_length / (math.hypot(sound_speed, elastic_speed) + reference_velocity),
        "viscous": VISCOUS_NUMBER * smoothing_length**2 / kinematic_viscosity,
        "acceleration": 0.25 * math.sqrt(smoothing_length / acceleration) if acceleration > 0 else math.inf,
        "relaxation": RELAXATION_NUMBER * relaxation_time if elastic_speed > 0 else math.inf,
    }


def shift_speed(
    kernel: Any,
    smoothing_ratio: float,
    sound_speed: float,
    cfl: float | Literal["auto"],
    diffusion_speed: float,
) -> float:
    """Return the speed [length/time] that multiplies -h sum V grad W in the shift velocity.

    It scales with the sound speed c, as the inverse of the longest step does, and above the automatic CFL number with
    1/cfl, so that the shift of a step is bounded. Where viscosity limits the step more strictly, it scales with the
    ``diffusion_speed`` nu/h instead, for the same shift in a step: else disorder would last beyond the start of a slow
    flow. ``kernel`` is a module of ``kernels/``, ``smoothing_ratio`` h over the spacing, ``cfl`` as in the config.
    """
    number = AUTO_CFL if cfl == "auto" else max(cfl, AUTO_CFL)
    pace = AUTO_CFL * max(sound_speed / number, diffusion_speed / VISCOUS_NUMBER)  # h over the longest step, times CFL
    return SHIFT * pace / stiffness(kernel, smoothing_ratio)


def stiffness(kernel: Any, smoothing_ratio: float) -> float:
    """Return the largest eigenvalue of -h^2 d(sum V grad W)_i/dx_i on the square lattice, a pure number.

    The stiffest waves of displacement are longitudinal, along a row.
    """
    furthest = int(kernel.SUPPORT * smoothing_ratio)
    row = np.arange(-furthest, furthest + 1.0)
    x, y = (axis.ravel() for axis in np.meshgrid(row, row))
    neighbours = (x != 0) | (y != 0)
    x, y = x[neighbours] / smoothing_ratio, y[neighbours] / smoothing_ratio
    small = 1e-4
    slope = (_pull(kernel, x + small, y) - _pull(kernel, x - small, y)) / (2 * small)
    numbers = np.arange(1, WAVES + 1) * np.pi / WAVES * smoothing_ratio
    return max(-float(np.sum(slope * (1 - np.cos(number * x)))) for number in numbers) / smoothing_ratio**2


def _pull(kernel: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    distance = np.hypot(x, y)
    weights = [kernel.slope_over_q(q) if q < kernel.SUPPORT else 0.0 for q in distance]
    return np.array(weights) * x
