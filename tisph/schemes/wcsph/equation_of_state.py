"""Tait equation of state: pressure from density, p = B ((rho/rho0)^gamma - 1), B = rho0 c^2 / gamma."""

import math
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from tisph.config.base import LARGEST, Model, Positive
from tisph.config.fields import number_or

SCALE_RATIO = 10.0
"""Automatic sound speed over the fastest velocity scale: density then varies by about a percent at most."""


class Tait(Model):
    """Stiffness of the weakly compressible fluid.

    At most one of ``sound_speed`` and ``bulk_modulus`` (K = density * sound_speed^2, the bulk modulus at zero
    pressure) is given; without either the sound speed is ``auto``, see ``sound_speed``. ``pressure_cutoff``
    (negative) limits tension: the pressure never falls below it.
    """

    exclusive_keys = ("sound_speed", "bulk_modulus")

    type: Literal["tait"] = "tait"
    gamma: int = Field(default=7, ge=1, le=15)
    sound_speed: number_or(Positive, "auto") | None = None
    bulk_modulus: Positive | None = None
    pressure_cutoff: float | None = Field(default=None, lt=0, ge=-LARGEST)

    @model_validator(mode="before")
    @classmethod
    def _fill_in_sound_speed(cls, data: Any) -> Any:
        if isinstance(data, dict) and all(data.get(key) is None for key in cls.exclusive_keys):
            return {**data, "sound_speed": "auto"}
        return data


def sound_speed(
    parameters: Tait,
    *,
    reference_velocity: float,
    kinematic_viscosity: float,
    length: float,
    density: float,
    elastic_speed: float = 0.0,
) -> float:
    """Return the sound speed [length/time] for the parameters in a flow.

    ``auto`` is ten times the largest of the ``reference_velocity`` U, the fastest speed to expect (the
    ``peak_velocity`` of a scene); of the viscous scale sqrt(nu U / H), nu in total and H the reference ``length``; and
    of the ``elastic_speed`` sqrt(nu_p / relaxation time) of shear waves in a polymer. The first two keep inertial and
    viscous pressure differences small against density * c^2 (J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136
    (1997) 214-226); the third does so for polymer stresses: its square is the polymer's modulus per unit density.

    Morris' scale of a body force, sqrt(g H), is for a force that pressure balances, and is not used. Along the periodic
    x there is no pressure difference and friction balances the force; with the peak speed U = g H^2 / (8 nu) of that
    flow the viscous scale already is sqrt(g H / 8).
    """
    if parameters.bulk_modulus is not None:
        return math.sqrt(parameters.bulk_modulus / density)
    given: Any = parameters.sound_speed
    if given != "auto":
        return given
    viscous_velocity = math.sqrt(kinematic_viscosity * reference_velocity / length)
    return SCALE_RATIO * max(reference_velocity, viscous_velocity, elastic_speed)


def series(gamma: int) -> tuple[float, ...]:
    """Return the coefficients of ((1 + s)^gamma - 1) / gamma in s, highest power first, without the constant, 0.

    The polynomial loses no digits where s is small.
    """
    return tuple(math.comb(gamma, power) / gamma for power in range(gamma, 0, -1))


def compression(parameters: Tait, pressure: np.ndarray, *, density: float, sound_speed: float) -> np.ndarray:
    """Return the compression rho/rho0 - 1 for a ``pressure`` (any shape), without the cutoff."""
    stiffness = density * sound_speed**2
    return np.expm1(np.log1p(parameters.gamma * pressure / stiffness) / parameters.gamma)


def pressure(parameters: Tait, compression: np.ndarray, *, density: float, sound_speed: float) -> np.ndarray:
    """Return the pressure for ``compression`` = rho/rho0 - 1 (any shape), never below the cutoff."""
    values = density * sound_speed**2 * np.polyval([*series(parameters.gamma), 0.0], compression)
    return values if parameters.pressure_cutoff is None else np.maximum(values, parameters.pressure_cutoff)
