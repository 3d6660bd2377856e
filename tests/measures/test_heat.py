"""Numbers of temperature and dissolved substances in a sample, on fields that are known."""

from dataclasses import replace

import numpy as np
import pytest

from tisph import scenes
from tisph.config import loader
from tisph.config.schema import colours
from tisph.measures.heat import dimensionless_numbers
from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import resolution
from tisph.simulation.state import start_snapshot, start_values

CAVITY = {
    "scene": "cavity",
    "fluid": {"density": 2.0, "kinematic_viscosity": 1.0},
    "geometry": {"width": 2.0, "height": 1.0},
    "walls": {"lid": {"velocity": 0.0}},
    "discretisation": {"particles_across": 20},
    "time": {"end": 1.0},
}
HEATED = {"conductivity": 3.0, "heat_capacity": 5.0, "walls": {"left": 1.0, "right": 0.0}}
HEATED |= {"expansion": 1.0, "gravity": [0.0, -1.0]}
DYE = {"name": "dye", "diffusivity": 0.1}


def sample(config, fields, **state):
    """Return the numbers of a sample with ``fields``, functions of x and y by the names of substances or of u and v."""
    settings = loader.loaded(config, {})
    scene = scenes.of(settings)
    start = start_snapshot(scene, start_values(scene, settings.initial), "f64")
    values = {name: field(start.x, start.y) + np.zeros(len(start.x)) for name, field in fields.items()}
    carried = {name: values.pop(name) for name in start.substances if name in values}
    seen = replace(start, t=0.5, substances={**start.substances, **carried}, **values, **state)
    record = np.array([0.0]), np.zeros((1, len(scene.time_series(**settings.time_series).columns)))
    return sample_metrics(scene, seen, ((), record[1][0], record))


def test_both_nusselt_numbers_of_a_known_flow():
    """With u = y^2 and T = 1 - x/2 + y^2; the flows are given."""
    flows = np.array([[0.0, -12.0, 0.0, 9.0]])  # bottom, right, lid, left
    fields = {"temperature": lambda x, y: 1.0 - 0.5 * x + y**2, "u": lambda x, y: y**2}
    found = sample({**CAVITY, "temperature": HEATED}, fields, flows=flows)
    flux = 3.0 * 1.0 / 2.0  # conduction through a wall of height 1 with the width as length
    assert found["heat_flow_left"] == 9.0
    assert (found["nusselt_left"], found["nusselt_right"]) == pytest.approx((9.0 / flux, 12.0 / flux))
    # mean of u (T - mean T) = 1/5 - 1/9, kappa = 3/(2 5) = 0.3, over a distance of 2 and a difference of 1
    assert found["nusselt_sections"] == pytest.approx(1.0 + (1 / 5 - 1 / 9) * 2.0 / 0.3, rel=1e-9)


def test_the_largest_error_is_over_the_range_of_given_values():
    exact = {"temperature": np.linspace(1.0, 2.0, 200)}
    section = {**HEATED, "walls": {"left": 4.0, "right": 0.0}}
    found = sample({**CAVITY, "temperature": section}, {"temperature": lambda x, y: 0.0 * x}, reference=exact)
    assert found["temperature_error"] == 2.0 / 4.0
    assert "temperature_error" not in sample({**CAVITY, "temperature": section}, {})


def test_a_wall_with_a_flux_or_one_temperature_has_no_nusselt_number():
    for walls in ({"left": 1.0}, {"left": 1.0, "right": 1.0}, {"left": 1.0, "right": {"flux": 2.0}}):
        names = sample({**CAVITY, "temperature": {**HEATED, "walls": walls}}, {})
        assert not [name for name in names if name.startswith("nusselt")]


def test_the_gained_heat_is_the_integral_of_the_rise():
    config = {**CAVITY, "temperature": {**HEATED, "initial": "x*y"}}
    found = sample(config, {"temperature": lambda x, y: x * y + x**2}, received=np.array([7.0]))
    assert found["heat_gained"] == pytest.approx(2.0 * 5.0 * 8.0 / 3.0, rel=1e-6)  # fluid_mean is exact to degree 5
    assert found["heat_received"] == 7.0
    means = found["temperature_mean"], found["temperature_max"] > 4.0, found["temperature_min"] > 0.0
    assert means == (pytest.approx(0.5 + 4.0 / 3.0, rel=1e-6), True, True)


def test_around_an_axis_the_content_is_that_of_the_volume():
    pipe = {key: CAVITY[key] for key in ("fluid", "discretisation", "time")}
    pipe |= {"scene": "pipe", "geometry": {"radius": 1.0, "length": 2.0}, "drive": {"acceleration": 1.0}}
    found = sample(
        {**pipe, "temperature": {"conductivity": 3.0, "heat_capacity": 5.0}}, {"temperature": lambda x, y: y}
    )
    # T = r: the mean over the volume is 2/3, the content rho c 2 pi length/3
    assert (found["temperature_mean"], found["heat_gained"]) == pytest.approx((2 / 3, 10.0 * 4.0 * np.pi / 3), rel=1e-6)


def test_between_cylinders_the_mean_is_that_of_the_area():
    annulus = {key: CAVITY[key] for key in ("fluid", "discretisation", "time")}
    annulus |= {"scene": "annulus", "geometry": {"inner_radius": 1.0, "outer_radius": 2.0}}
    annulus |= {
        "walls": {"inner": {"angular_velocity": 1.0}},
        "temperature": {"conductivity": 1.0, "heat_capacity": 1.0},
    }
    found = sample(annulus, {"temperature": lambda x, y: x**2 + y**2})
    assert found["temperature_mean"] == pytest.approx(2.5, rel=1e-6)  # (R1^2 + R2^2)/2; the sum over particles: 3e-4


def test_mixing_numbers_of_a_wave():
    box = {key: CAVITY[key] for key in ("fluid", "time")}
    box |= {"scene": "taylor_green", "geometry": {"length": 1.0}, "initial": {"velocity": 1.0, "jitter": 0.1}}
    box |= {"discretisation": {"particles_across": 40}, "scalars": [DYE]}
    found = sample(box, {"dye": lambda x, y: np.cos(2.0 * np.pi * x)})
    # the error of the gradients of degree 4, 1e-4 of the largest at 50 particles a wavelength
    assert found["dye_variance"] == pytest.approx(0.5, rel=1e-4)
    assert found["dye_dissipation"] == pytest.approx(2.0 * 0.1 * (2.0 * np.pi) ** 2 / 2.0, rel=1e-3)
    assert "dye_received" in found
    assert "heat_gained" not in found


def test_an_open_end_leaves_no_balance():
    stream = {key: CAVITY[key] for key in ("fluid", "time", "discretisation")}
    stream |= {"scene": "channel", "geometry": {"gap": 1.0, "length": 2.0}, "scalars": [DYE]}
    stream |= {"ends": {"left": {"type": "inlet", "velocity": 1.0}, "right": {"type": "outlet"}}}
    names = sample(stream, {})
    assert {name for name in names if name.startswith("dye_flow")} == {"dye_flow_bottom", "dye_flow_top"}
    assert not {"dye_gained", "dye_received"} & set(names)


def test_a_temperature_that_acts_on_the_flow_leaves_no_reference():
    law = {"type": "exponential", "coefficient": 1.0}
    plain = {"conductivity": 1.0, "heat_capacity": 1.0}
    annulus = {key: CAVITY[key] for key in ("fluid", "discretisation", "time")}
    annulus |= {"scene": "annulus", "geometry": {"inner_radius": 1.0, "outer_radius": 2.0}}
    annulus |= {"walls": {"inner": {"angular_velocity": 1.0}}}
    for section, known in ((plain, True), ({**plain, "viscosity": law}, False)):
        settings = loader.loaded({**annulus, "temperature": section}, {})
        scene = scenes.of(settings)
        assert bool(scene.fields) == known
        assert [profile.exact is not None for profile in scene.profiles()] == [known, known]
        assert (scene.time_series().exact(np.array([0.5])) is not None) == known
        assert ("error" in colours(settings)) == known


def test_a_layer_of_heat_is_resolved_from_two_spacings_on():
    """Its depth is sqrt(kappa t), kappa = 0.3; the spacing is 0.1."""
    scene = scenes.of(loader.loaded({**CAVITY, "temperature": HEATED}, {}))
    early, late = (depth**2 / 0.3 for depth in (0.19, 0.21))
    assert resolution(scene, early) == (
        False,
        "the layer of temperature is 1.9 spacings thin; resolved from 2 spacings on",
    )
    assert resolution(scene, late) == (True, None)
    walls = {"left": 1.0, "right": {"flux": 1.0}}
    at_rest = {**CAVITY, "temperature": {**HEATED, "initial": 1.0, "walls": walls}}
    assert resolution(scenes.of(loader.loaded(at_rest, {})), early) == (True, None)  # nothing jumps


def test_a_sample_with_a_steep_substance_is_not_resolved():
    box = {**CAVITY, "scalars": [DYE]}

    def front(width):
        return lambda x, y: np.tanh((x - 1.0) / width)

    steep, even = (sample(box, {"dye": front(width)}) for width in (0.02, 0.2))
    assert (steep["resolved"], even["resolved"]) == (False, True)
    assert "dye changes by its whole range within" in steep["reason"]
    corner = sample(box, {"dye": lambda x, y: np.arctan2(y, x)})  # a wall at 0 that meets a wall at pi/2
    assert corner["resolved"]


def test_the_numbers_of_a_flow_with_heat_are_in_its_forecast():
    law = {"type": "arrhenius", "activation_temperature": 900.0}
    walls = {"left": 310.0, "right": 300.0}
    section = {
        **HEATED,
        "reference": 300.0,
        "initial": 300.0,
        "viscous_heating": True,
        "viscosity": law,
        "walls": walls,
    }
    config = {**CAVITY, "walls": {"lid": {"velocity": 4.0}}, "temperature": section, "scalars": [DYE]}
    found = {
        label: float(text.split()[0]) for label, text in dimensionless_numbers(scenes.of(loader.loaded(config, {})))
    }
    # L = 2, U = 4, nu = 1, k = 3, rho c = 10, kappa = 0.3, mu U^2/k = 32/3, ln mu changes by 900/300^2 = 0.01 a degree
    assert found["Prandtl number"] == pytest.approx(1 / 0.3, rel=1e-3)
    assert found["Peclet number"] == pytest.approx(8 / 0.3, rel=1e-3)
    assert found["Nahme number"] == pytest.approx(0.32 / 3, rel=1e-3)
    assert found["Brinkman number"] == pytest.approx(3.2 / 3, rel=1e-3)
    assert (found["Schmidt number of dye"], found["Peclet number of dye"]) == (10.0, 80.0)
    scale = scenes.of(loader.loaded(config, {})).temperature.scale
    assert found["Rayleigh number"] == pytest.approx(scale * 8 / 0.3, rel=1e-3)
