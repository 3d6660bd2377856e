"""What a config says of a liquid's rheology, and what is refused of it."""

import itertools
import pickle
from pathlib import Path

import numpy as np
import pytest

from tisph import registry, schemes
from tisph.config import load
from tisph.errors import ConfigError
from tisph.schemes import _two_dimensional

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


def refusal(case, *overrides):
    with pytest.raises(ConfigError) as caught:
        case(*overrides)
    return str(caught.value)


@pytest.mark.parametrize("name", RHEOLOGIES)
def test_no_scheme_runs_a_fluid_that_it_does_not_have(case, name):
    liquid = f"fluid.rheology={RHEOLOGIES[name]}"
    for scheme in ("auto", "implicit"):
        assert schemes.resolve(case(liquid, f"scheme={{type: {scheme}}}"))[0].scheme.type == "implicit"
    text = refusal(case, liquid, "scheme={type: wcsph}")
    assert "scheme.type" in text
    assert f"no {name} fluid" in text
    assert "take implicit" in text


@pytest.mark.parametrize("name", RHEOLOGIES)
def test_a_fluid_can_be_sent_to_the_process_that_draws(case, name):
    rheology = case(f"fluid.rheology={RHEOLOGIES[name]}").fluid.rheology
    assert pickle.loads(pickle.dumps(rheology)) == rheology


VARYING = ["power_law", "carreau_yasuda", "herschel_bulkley"]


def changed(flow, *changes):
    return load(Path(__file__).parents[2] / "configs" / f"{flow}.yaml", changes)


@pytest.mark.parametrize("name", RHEOLOGIES)
def test_vortices_whose_decay_is_not_known_are_refused(name):
    text = refusal(lambda *changes: changed("taylor_green", *changes), f"fluid.rheology={RHEOLOGIES[name]}")
    assert "fluid.rheology.type" in text
    assert "must be newtonian" in text
    assert name in text


IN_TWO_DIMENSIONS = ["shear_layer", "circular_couette", "cylinder_lattice", "cylinder_in_channel", "turned_box"]


@pytest.mark.parametrize(("flow", "name"), [*itertools.product(IN_TWO_DIMENSIONS, VARYING)])
def test_fluids_of_varying_viscosity_are_served_in_two_dimensions(flow, name):
    """Their law reaches the problem that is solved, with the density by which a yield stress is divided."""
    config = changed(flow, f"fluid.rheology={RHEOLOGIES[name]}", "fluid.density=2.0")
    problem = _two_dimensional._problem(registry.load("scenes", config.scene).Scene.from_config(config))
    assert problem.rheology == config.fluid.rheology
    assert (problem.density, problem.solvent_viscosity) == (2.0, 0.0)


@pytest.mark.parametrize("name", RHEOLOGIES)
def test_other_fluids_need_a_lid_that_leaves_corners_at_rest(name):
    change = f"fluid.rheology={RHEOLOGIES[name]}"
    text = refusal(lambda *changes: changed("cavity", *changes), change)
    assert f'walls.lid.profile = "sharp": must be regular with {name}' in text
    assert changed("cavity_regular", change).fluid.rheology.type == name


def between_cylinders(*changes):
    return changed("circular_couette", *changes)


@pytest.mark.parametrize("name", ["giesekus", "power_law"])
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("scheme={type: wcsph}", "wcsph has no {} fluid"),
        ("walls.outer={amplitude: 1.0, angular_frequency: 1.0}", "periodic flow of {} between cylinders"),
    ],
)
def test_between_cylinders_what_a_fluid_cannot_do_is_named(name, change, expected):
    options = f"fluid.rheology={RHEOLOGIES[name]}", "initial.state=developed", change
    assert expected.format(name) in refusal(between_cylinders, *options)


@pytest.mark.parametrize(
    ("name", "change", "expected"),
    [
        ("giesekus", "mobility=1.1", "must be at most 1"),
        ("giesekus", "mobility=-0.1", "must be at least 0"),
        ("giesekus", "solvent_fraction=0", "must be greater than 0 and at most 1"),
        ("phan_thien_tanner", "extensibility=2", "must be at most 1"),
        ("phan_thien_tanner", "form=cubic", "must be 'linear' or 'exponential'"),
        ("multi_mode", "modes=[]", "must not be empty"),
        ("multi_mode", "modes=[{type: newtonian}]", "must be one of fene_p, giesekus, oldroyd_b, phan_thien_tanner"),
        ("multi_mode", "modes=[{type: giesekus, mu: 1}]", "allowed: type, relaxation_time, mobility, fraction"),
        ("power_law", "index=0.2", "must be at least 0.3"),
        ("carreau_yasuda", "fraction_at_infinity=1.1", "must be at most 1"),
        ("herschel_bulkley", "regularisation=0", "must be greater than 0"),
        ("herschel_bulkley", "index=0.29", "must be at least 0.3"),
        ("herschel_bulkley", "index=1.51", "must be at most 1.5"),
        ("fene_p", "maximum_extension=3", "must be greater than 3"),
        ("fene_p", "relaxation_time=0", "must be greater than 0"),
    ],
)
def test_ranges(case, name, change, expected):
    text = refusal(case, f"fluid.rheology={RHEOLOGIES[name]}", f"fluid.rheology.{change}")
    assert f"fluid.rheology.{change.partition('=')[0]}" in text
    assert expected in text


@pytest.mark.parametrize("index", [0.3, 1.5])
@pytest.mark.parametrize("name", ["power_law", "herschel_bulkley"])
def test_ends_of_a_range_are_in_it(case, name, index):
    config = case(f"fluid.rheology={RHEOLOGIES[name]}", f"fluid.rheology.index={index}")
    assert config.fluid.rheology.index == index


def parameters(name, **numbers):
    return registry.load("rheology", name).Parameters(**numbers)


def test_shares_of_modes_add_up_to_the_whole_viscosity(case):
    modes = (
        "[{relaxation_time: 1.0, fraction: 0.3}, {type: giesekus, relaxation_time: 3, mobility: 0.1, fraction: 0.2}]"
    )
    text = refusal(case, f"fluid.rheology={{type: multi_mode, solvent_fraction: 0.4, modes: {modes}}}")
    assert "must add up to 1 with solvent_fraction, but make 0.9" in text


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
