"""Start-up of plane Couette flow with every scheme, wall treatment and order, to one tolerance.

Source: ``tisph/exact/couette.py`` (Fourier series and images). The planar scheme has the flow in a region between two
planes, the axisymmetric one between two cylinders of radii 1000 and 1001, where the curvature changes it by 5e-4.
"""

import numpy as np
import pytest

import tisph
from tisph import registry
from tisph.exact import couette
from tisph.schemes.implicit.channel.walls import TREATMENTS

pytestmark = [pytest.mark.taichi, pytest.mark.verification]

TOLERANCE = 0.01
"""Root mean square error of the velocity over that of the exact velocity, 16 particles across, at nu t/H^2 = 0.1."""

NU, SPEED, END = 1.0, 1.0, 0.1
COMMON = {
    "fluid": {"density": 1.0, "kinematic_viscosity": NU},
    "initial": {"jitter": 0.1},
    "discretisation": {"particles_across": 16},
    "time": {"end": END, "samples": [END]},
    "runtime": {"threads": 1},
}
CHANNEL = {"scene": "channel", "geometry": {"gap": 1.0, "length": 1.25}, "walls": {"top": {"velocity": SPEED}}}


def channel(scheme, treatment):
    walls = {"top": {"velocity": SPEED}, "treatment": {"type": treatment}}
    return {**CHANNEL, "walls": walls, "scheme": scheme}


CASES = {
    **{
        f"wcsph {operators} {treatment}": channel({"type": "wcsph", "operators": operators}, treatment)
        for operators in ("consistent", "standard")
        for treatment in registry.names("walls")
    },
    **{
        f"implicit order {order} {treatment}": channel({"type": "implicit", "operators": {"order": order}}, treatment)
        for order in (2, 4)
        for treatment in TREATMENTS
    },
    "planar": {"scene": "region", "geometry": {"height": 1.0, "length": 1.25}, "walls": {"top": {"velocity": SPEED}}},
    "axisymmetric": {
        "scene": "region",
        "coordinates": "axisymmetric",
        "geometry": {"inner_radius": 1000.0, "height": 1.0, "length": 1.25},
        "walls": {"top": {"velocity": SPEED}},
    },
}


@pytest.mark.parametrize("name", CASES)
def test_start_up_of_plane_couette_flow_has_one_tolerance_in_all_schemes(name):
    with tisph.Simulation({**COMMON, **CASES[name]}) as simulation:
        found = simulation.run_until(END)
    height = found.y - (1000.0 if name == "axisymmetric" else 0.0)
    exact = couette.velocity(height, END, gap=1.0, kinematic_viscosity=NU, bottom=0.0, top=SPEED)
    assert np.linalg.norm(found.u - exact) < TOLERANCE * np.linalg.norm(exact)
