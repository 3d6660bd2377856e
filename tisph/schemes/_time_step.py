"""Limits of an explicit time step, as formulas in plain numbers."""

import math
from typing import Literal

AUTO_CFL = 0.25
RELAXATION_NUMBER = 0.25
VISCOUS_NUMBER = 0.125
"""Step over h^2/nu; J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214-226."""


def effective_viscosity(kinematic_viscosity: float, artificial_viscosity: float, length: float, speed: float) -> float:
    """Kinematic viscosity with Monaghan's linear artificial one in it, alpha c h / 8 in two dimensions.

    ``length`` is the smoothing length h, ``speed`` the sound speed c (J. J. Monaghan, Rep. Prog. Phys. 68 (2005)
    1703-1759).
    """
    return kinematic_viscosity + artificial_viscosity * speed * length / 8.0


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
    """Largest stable steps [time] by the name of what limits them; a run takes the smallest.

    ``acoustic``: cfl h / (sqrt(c^2 + c_e^2) + U), with cfl 0.25 for ``auto`` and the ``elastic_speed`` c_e of
    shear waves in the polymer. ``viscous``: 0.125 h^2 / nu, nu that of the solvent. ``acceleration``: 0.25
    sqrt(h / a), no limit without acceleration. ``relaxation``: 0.25 ``relaxation_time``, so that an explicit step
    follows the decay of the polymer stress; no limit without elastic speed. All in the units of the config.
    """
    number = AUTO_CFL if cfl == "auto" else cfl
    return {
        "acoustic": number * smoothing_length / (math.hypot(sound_speed, elastic_speed) + reference_velocity),
        "viscous": VISCOUS_NUMBER * smoothing_length**2 / kinematic_viscosity,
        "acceleration": 0.25 * math.sqrt(smoothing_length / acceleration) if acceleration > 0 else math.inf,
        "relaxation": RELAXATION_NUMBER * relaxation_time if elastic_speed > 0 else math.inf,
    }
