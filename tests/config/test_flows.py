"""Flow and rheology in a config: wall motion, drive, fluid, cells, and the numbers that follow from these keys."""

import itertools
import pickle
from pathlib import Path

import numpy as np
import pytest
from vortices import GOOD

from tisph import registry, schemes
from tisph.config import load
from tisph.config.schema import estimated_bytes
from tisph.errors import ConfigError
from tisph.schemes.implicit.planar.problem import problem_of

CONFIGS = Path(__file__).parents[2] / "configs"
DRIVEN_CHANNEL = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {gap: 1.0, length: 2.0}
drive: {acceleration: 0.5}
time: {end: 1.0}
"""


def test_null_takes_a_wall_from_one_form_to_the_other(case):
    swing = ("walls.top.amplitude=1.0", "walls.top.angular_frequency=2.0")
    swinging = case("walls.top.velocity=null", *swing).walls
    assert (swinging.top.amplitude, swinging.top.phase, swinging.bottom.velocity) == (1.0, "cos", 0.0)
    assert case("walls.top.velocity=null", "walls.bottom.velocity=1.0").walls.top.velocity == 0.0


@pytest.mark.parametrize("bodies", ["", "bodies: [{centre: [1.0, 0.5], radius: 0.2}]\n"])
def test_walls_of_a_driven_channel_are_at_rest_unless_said(tmp_path, bodies):
    path = tmp_path / "driven.yaml"
    path.write_text(DRIVEN_CHANNEL + bodies)
    assert load(path) == load(path, ["walls.bottom.velocity=0", "walls.top.velocity=0"])
    with pytest.raises(ConfigError, match="nothing moves"):
        load(path, ["drive.acceleration=0"])


@pytest.mark.parametrize(
    ("overrides", "extent", "numbers"),
    [
        ((), (1.0, 1.0), (20, 20, 20, 0.05)),
        (("geometry.cells=[3, 2]", "geometry.length=0.5"), (1.5, 1.0), (20, 60, 40, 0.025)),
        (("geometry.cells=[3, 2]", "discretisation={spacing: 0.05}"), (3.0, 2.0), (20, 60, 40, 0.05)),
    ],
)
def test_numbers_of_periods(tmp_path, overrides, extent, numbers):
    (tmp_path / "case.yaml").write_text(GOOD)
    config = load(tmp_path / "case.yaml", overrides)
    assert config.extent == extent
    assert (config.particles_across, config.columns, config.rows, config.spacing) == numbers


@pytest.mark.parametrize(("accuracy", "courant"), [("fast", 2.0), ("high", 0.15), ("balanced", 1.0)])
def test_accuracy_sets_the_steps(tmp_path, accuracy, courant):
    (tmp_path / "case.yaml").write_text(GOOD)
    config, reason = schemes.resolve(load(tmp_path / "case.yaml", [f"scheme={{accuracy: {accuracy}}}"]))
    assert config.scheme.largest_courant == courant
    assert f"Courant number {courant:g}" in reason


def test_what_a_flow_between_walls_needs_was_measured():
    # resident memory of 50 across less that of 12 across, whose fields have the smallest size there is: 169 MB for a
    # Newtonian liquid, 197 MB with Oldroyd-B; to a quarter, what Python and libraries take besides
    for name, measured in (("circular_couette", 169e6), ("circular_couette_oldroyd_b", 197e6)):
        config = load(CONFIGS / f"{name}.yaml")
        grown = estimated_bytes(23562, config, True) - estimated_bytes(1357, config, True)
        assert 0.75 < grown / measured < 1.25


RHEOLOGIES = {
    "giesekus": "{type: giesekus, relaxation_time: 1.0, solvent_fraction: 0.5, mobility: 0.2}",
    "phan_thien_tanner": "{type: phan_thien_tanner, relaxation_time: 1.0, solvent_fraction: 0.5, extensibility: 0.1}",
    "multi_mode": "{type: multi_mode, solvent_fraction: 0.4, modes: [{relaxation_time: 1.0, fraction: 0.6}]}",
    "power_law": "{type: power_law, index: 0.5, reference_rate: 1.0, least_rate: 1.0e-3}",
    "carreau_yasuda": "{type: carreau_yasuda, time: 1.0, index: 0.5}",
    "herschel_bulkley": "{type: herschel_bulkley, yield_stress: 1.0, index: 1, reference_rate: 1, regularisation: 9}",
    "fene_p": "{type: fene_p, relaxation_time: 1.0, solvent_fraction: 0.5, maximum_extension: 100.0}",
}
"""Those that carry a stress, which scheme implicit serves."""


@pytest.mark.parametrize("name", RHEOLOGIES)
def test_a_fluid_can_be_sent_to_the_process_that_draws(case, name):
    rheology = case(f"fluid.rheology={RHEOLOGIES[name]}").fluid.rheology
    assert pickle.loads(pickle.dumps(rheology)) == rheology


VARYING = ["power_law", "carreau_yasuda", "herschel_bulkley"]
IN_TWO_DIMENSIONS = ["shear_layer", "circular_couette", "cylinder_lattice", "cylinder_in_channel", "turned_box"]


@pytest.mark.parametrize(("flow", "name"), [*itertools.product(IN_TWO_DIMENSIONS, VARYING)])
def test_fluids_of_varying_viscosity_are_served_in_two_dimensions(flow, name):
    """Their law reaches the problem that is solved, with the density by which a yield stress is divided."""
    config = load(CONFIGS / f"{flow}.yaml", [f"fluid.rheology={RHEOLOGIES[name]}", "fluid.density=2.0"])
    problem = problem_of(registry.load("scenes", config.scene).Scene.from_config(config))
    assert problem.rheology == config.fluid.rheology
    assert (problem.density, problem.solvent_viscosity) == (2.0, 0.0)


def parameters(name, **numbers):
    return registry.load("rheology", name).Parameters(**numbers)


def test_laws_of_modes_share_the_viscosity():
    modes = [
        {"type": "oldroyd_b", "relaxation_time": 1.0, "fraction": 0.3},
        {"type": "fene_p", "relaxation_time": 3.0, "maximum_extension": 9.0, "fraction": 0.2},
    ]
    rheology = parameters("multi_mode", solvent_fraction=0.5, modes=modes)
    first, second = rheology.laws(2.0)
    assert (first.polymer_viscosity, first.modulus, first.components) == (0.6, 0.6, 3)
    assert (second.polymer_viscosity, second.relaxation_time, second.components) == (0.4, 3.0, 4)
    assert rheology.relaxation_time == pytest.approx((0.3 * 1 + 0.2 * 3) / 0.5)
    (alone,) = parameters("oldroyd_b", relaxation_time=2.0, solvent_fraction=0.25).laws(2.0)
    assert alone.polymer_viscosity == 1.5


def viscosity(name, rates, **numbers):
    return registry.load("rheology", name).Law(parameters(name, **numbers), 0.8).viscosity(rates**2)


def test_viscosities_of_inelastic_fluids():
    rates = np.array([1e-9, 0.5, 2.0, 40.0])
    power = viscosity("power_law", rates, index=0.5, reference_rate=2.0, least_rate=1e-6)
    assert np.allclose(power[1:], 0.8 * (rates[1:] / 2.0) ** -0.5, rtol=1e-11)  # (least_rate/rate)^2 is 4e-12
    assert power[0] == pytest.approx(0.8 * (1e-6 / 2.0) ** -0.5)
    bent = viscosity("carreau_yasuda", rates, time=2.0, index=0.4, transition=1.5, fraction_at_infinity=0.1)
    assert bent[0] == pytest.approx(0.8)
    assert np.allclose(bent, 0.08 + 0.72 * (1 + (2 * rates) ** 1.5) ** (-0.6 / 1.5), rtol=1e-14)
    yielding = viscosity(
        "herschel_bulkley", rates, yield_stress=3.0, index=0.7, reference_rate=2.0, regularisation=50.0
    )
    stress = yielding * rates
    # from 0.5 on exp(-50 rate) is at most 1e-11, and the least rate, 2e-5, changes 1 part in 1e9
    assert np.allclose(stress[1:], 3.0 + 0.8 * 2**0.3 * rates[1:] ** 0.7, rtol=2e-9)
    assert yielding[0] == pytest.approx(3.0 * 50.0 + 0.8 * 2**0.3 * 2e-5**-0.3, rel=1e-3)
