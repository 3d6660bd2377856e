"""The channel's reference for liquids without closed forms."""

import numpy as np
import pytest

from tisph import registry
from tisph.geometry.motion import WallMotion
from tisph.scenes._layers import PolymerParameters
from tisph.scenes.channel import Channel

OIL = {
    "gap": 0.5,
    "length": 1.0,
    "density": 2.0,
    "kinematic_viscosity": 0.5,
    "bottom": WallMotion(0.0),
    "top": WallMotion(1.0),
    "initial_state": "rest",
    "start_time": 0.0,
    "spacing": 0.01,
    "columns": 100,
    "rows": 50,
    "units": None,
}
HEIGHTS = np.linspace(0.0, 0.5, 21)


def rheology(name, **numbers):
    return registry.load("rheology", name).Parameters(**numbers)


def test_giesekus_has_all_stresses_in_the_units_of_the_config():
    liquid = rheology("giesekus", relaxation_time=0.4, solvent_fraction=0.2, mobility=0.3)
    channel = Channel(**OIL, polymer=PolymerParameters(0.4, 0.2), rheology=liquid)
    assert not channel.initial_polymer_stress(HEIGHTS)[0].any()
    end = 30.0
    rate = 1.0 / 0.5
    xx, xy = channel.exact_polymer_stress(HEIGHTS, end)
    yy = channel.exact("stress_yy", 0.0, HEIGHTS, end)
    modulus = 2.0 * 0.8 * 0.5 / 0.4  # density * kinematic viscosity of the polymer/relaxation time
    c = np.array([xx, xy, yy])[:, 10] / modulus
    law = registry.load("rheology", "giesekus").Law(liquid, 0.4)
    assert np.abs(law.rate_in_shear(c, rate)).max() < 1e-7 * np.abs(c).max()
    assert channel.exact_wall_shear(end) == pytest.approx((xy[0] + 2.0 * 0.1 * rate,) * 2, rel=1e-7)
    assert yy[10] < 0


def test_a_flow_of_several_modes_and_one_that_stops():
    modes = [{"type": "oldroyd_b", "relaxation_time": 0.4, "fraction": part} for part in (0.5, 0.3)]
    both = rheology("multi_mode", solvent_fraction=0.2, modes=modes)
    moving = {
        **OIL,
        "top": WallMotion(0.0, before=1.0),
        "initial_state": "developed",
        "polymer": PolymerParameters(0.4, 0.2),
    }
    one = rheology("oldroyd_b", relaxation_time=0.4, solvent_fraction=0.2)
    solved, closed = Channel(**moving, rheology=both), Channel(**moving, rheology=one)
    scale = np.abs(closed.exact_polymer_stress(HEIGHTS, 0.0)).max()
    for t in (0.01, 0.3):
        # the accuracy of tisph.exact.start_up
        assert np.allclose(solved.exact_velocity(HEIGHTS, t), closed.exact_velocity(HEIGHTS, t), atol=1e-8)
        mine, its = solved.exact_polymer_stress(HEIGHTS, t), closed.exact_polymer_stress(HEIGHTS, t)
        assert np.allclose(mine, its, atol=2e-8 * scale)


def test_an_inelastic_fluid():
    liquid = rheology("power_law", index=0.8, reference_rate=2.0, least_rate=1e-3)
    channel = Channel(**OIL, rheology=liquid)
    # at the reference rate the viscosity is the fluid's; least rate over reference rate, squared: 3e-7
    assert channel.exact_wall_shear(30.0) == pytest.approx((2.0 * 0.5 * 2.0,) * 2, rel=1e-6)
    assert np.allclose(channel.exact_velocity(HEIGHTS, 30.0), 2.0 * HEIGHTS, atol=1e-8)
    assert not channel.exact_polymer_stress(HEIGHTS, 30.0)[0].any()
