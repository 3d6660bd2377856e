"""What walls prescribe to images: twice the even part of the Taylor series of the velocity at a wall."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.geometry.motion import WallMotion
from tisph.schemes._channel.walls import CoupledWall, PrescribedWall

NU, FREQUENCY, TIME = 0.02, 3.0, 0.7
SWINGING, STILL = WallMotion(1.0, 0.5, FREQUENCY), WallMotion(0.0)


def channel():
    numbers = {"kinematic_viscosity": NU, "acceleration": 0.0, "start_time": 0.0, "starts_developed": False}
    return SimpleNamespace(bottom=SWINGING, top=STILL, wall_jumps=(1.0, 0.0), **numbers)


def even_part(depth):
    """Twice that of the layer at a swinging wall (Stokes), whose waves cosh have no odd one."""
    wave = (1.0 - 0.5j) * np.exp(1j * FREQUENCY * TIME)
    return 2.0 * np.real(wave * np.cosh(np.sqrt(1j * FREQUENCY / NU) * depth))


def test_the_series_is_that_of_the_layer_at_a_swinging_wall():
    errors = []
    for depth in (0.02, 0.01):
        found = np.polyval(PrescribedWall(channel(), 0, True).series_at(TIME)[::-1], depth**2)
        errors.append(abs(found - even_part(depth)))
    # what the series leaves is of the sixth power of the depth: 64, less the eighth's part of some per cent
    assert errors[0] / errors[1] == pytest.approx(64.0, rel=0.05)


def test_viscoelastic_wall_derivatives_are_those_of_a_taylor_series():
    wall = SimpleNamespace(obeys_momentum=True, series=[], stress_series=[])
    second, fourth, depth = 3.0, -40.0, 0.1
    CoupledWall.prescribe(wall, SWINGING.velocity(TIME), 0.0, 0.0, second, fourth, 0.0, 0.0)
    (found,) = wall.series
    exact = 2.0 * (SWINGING.velocity(TIME) + second * depth**2 / 2.0 + fourth * depth**4 / 24.0)
    assert np.polyval(found[::-1], depth**2) == pytest.approx(exact, rel=1e-14)
