"""Flow and rheology in a config: wall motion, drive, fluid, start, and the conditions between these keys."""

import itertools
import pickle
import types
from pathlib import Path

import numpy as np
import pytest
from inside import problem_of

from tisph import registry, schemes
from tisph.config import load
from tisph.config.checks import REALS, estimated_bytes
from tisph.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 2.0, solvent_fraction: 0.1}"
SWINGING = "walls.top={amplitude: -0.5, angular_frequency: 3.0, phase: sin}"
STOPPED = "walls.top={velocity: 0.0, velocity_before: 0.5}"


@pytest.fixture
def message(case):
    """Message of the error that the case with overrides must raise."""

    def load_bad(*overrides):
        with pytest.raises(ConfigError) as caught:
            case(*overrides)
        return str(caught.value)

    return load_bad


def test_a_wall_has_a_constant_velocity_or_swings(case):
    config = case(SWINGING)
    top, bottom = config.walls.top, config.walls.bottom
    assert (top.velocity, top.amplitude, top.angular_frequency, top.phase) == (None, -0.5, 3.0, "sin")
    assert (bottom.velocity, bottom.velocity_before, bottom.amplitude, bottom.phase) == (0.0, None, None, None)
    assert case("walls.top={amplitude: 1, angular_frequency: 1}").walls.top.phase == "cos"


def test_null_takes_a_wall_from_one_form_to_the_other(case):
    swing = ("walls.top.amplitude=1.0", "walls.top.angular_frequency=2.0")
    assert case("walls.top.velocity=null", *swing).walls.top.amplitude == 1.0
    assert case("walls.top.velocity=null", "walls.bottom.velocity=1.0").walls.top.velocity == 0.0


@pytest.mark.parametrize("overrides", [(SWINGING,), (STOPPED, "initial.state=developed"), (POLYMER,)])
def test_resolved_config_has_the_keys_of_the_form_in_use_only(case, tmp_path, overrides):
    config = case(*overrides)
    text = config.resolved_yaml()
    assert ("amplitude" in text, "velocity_before" in text) == (overrides[0] == SWINGING, overrides[0] == STOPPED)
    resolved = tmp_path / "resolved.yaml"
    resolved.write_text(text)
    assert load(resolved, ["name=case"]) == config


@pytest.mark.parametrize("sign", [1, -1])
def test_a_drive_alone_moves_the_fluid(case, sign):
    config = case("walls.top.velocity=0", f"drive.acceleration={sign * 0.02}")
    assert config.drive.acceleration == sign * 0.02


@pytest.mark.parametrize("bodies", ["", "bodies: [{centre: [1.0, 0.5], radius: 0.2}]\n"])
def test_walls_of_a_driven_channel_are_at_rest_unless_said(tmp_path, bodies):
    path = tmp_path / "driven.yaml"
    path.write_text(DRIVEN_CHANNEL + bodies)
    assert load(path) == load(path, ["walls.bottom.velocity=0", "walls.top.velocity=0"])
    with pytest.raises(ConfigError, match="nothing moves"):
        load(path, ["drive.acceleration=0"])


def test_polymer(case):
    rheology = case(POLYMER, "output.video={color_by: shear_stress}").fluid.rheology
    assert (rheology.type, rheology.relaxation_time, rheology.solvent_fraction) == ("oldroyd_b", 2.0, 0.1)
    assert rheology.carries_stress
    assert case(POLYMER.replace("0.1", "1")).fluid.rheology.solvent_fraction == 1.0
    assert not case().fluid.rheology.carries_stress


def test_a_developed_or_exact_run_may_start_from_an_earlier_flow(case):
    for start in ("initial.state=developed", "initial={state: exact, time: 1.0}"):
        assert case(STOPPED, start).walls.top.velocity_before == 0.5


def test_polymer_stress_needs_memory(case):
    # three stresses of 8 bytes in four buffers, of a size that fields have
    assert estimated_bytes(1e5, case(POLYMER), False) - estimated_bytes(1e5, case(), False) == pytest.approx(
        1e5 * 3 * 4 * 8
    )


def test_what_a_flow_between_walls_needs_was_measured():
    # resident memory of 50 across less that of 12 across, whose fields have the smallest size there is: 169 MB for a
    # Newtonian liquid, 197 MB with Oldroyd-B; to a quarter, what Python and libraries take besides
    for name, measured in (("circular_couette", 169e6), ("circular_couette_oldroyd_b", 197e6)):
        config = load(CONFIGS / f"{name}.yaml")
        grown = estimated_bytes(23562, config, True) - estimated_bytes(1357, config, True)
        assert 0.75 < grown / measured < 1.25


def test_single_precision_needs_half_the_memory_for_numbers(case):
    both = (case(f"discretisation={{particles_across: 50, precision: {one}}}") for one in ("f64", "f32"))
    whole, half = (estimated_bytes(1e5, one, False) for one in both)
    assert whole - half == pytest.approx(1e5 * 4 * REALS[False])


DRIVEN_CHANNEL = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.1}
geometry: {gap: 1.0, length: 2.0}
drive: {acceleration: 0.5}
time: {end: 1.0}
"""
DRIVEN = "walls.top={shear_stress: 1}"
SCHEDULED = "walls.top={times: [0, 1], velocities: [0, 1]}"
ONLY_STEADY = "is only for a wall of constant velocity; this one oscillates"
ONLY_SWINGING = "is only for a wall that oscillates, which has an amplitude"
EXACTLY_ONE = "give exactly one of velocity, amplitude, shear_stress, stress_amplitude, stresses, velocities: "
SOLVENT = "must be greater than 0 and at most 1: at 0 (upper-convected Maxwell) a started wall sends out a front"

# overrides that are wrong together, the key that is blamed with its value, part of the reason
BAD = [
    (["walls.top={velocity: 1, amplitude: 2}"], "walls.top.amplitude = 2.0", EXACTLY_ONE + "velocity and amplitude"),
    (["walls.top={angular_frequency: 2}"], "walls.top", EXACTLY_ONE + "none"),
    (["walls.top={phase: sin}"], "walls.top", EXACTLY_ONE + "none"),
    (["walls.top={amplitude: 2}"], "walls.top.angular_frequency", "is missing: a wall with an amplitude oscillates"),
    (["walls.top={velocity: 1, phase: sin}"], 'walls.top.phase = "sin"', ONLY_SWINGING),
    (["walls.top={velocity: 1, angular_frequency: 2}"], "walls.top.angular_frequency = 2.0", ONLY_SWINGING),
    ([SWINGING, "walls.top.velocity_before=1"], "walls.top.velocity_before = 1.0", ONLY_STEADY),
    ([SWINGING, "walls.top.phase=tan"], 'walls.top.phase = "tan"', "must be 'cos' or 'sin'"),
    ([SWINGING, "walls.top.amplitude=0"], "walls.top.amplitude = 0", "must not be 0: for a wall at rest"),
    ([SWINGING, "walls.top.angular_frequency=0"], "walls.top.angular_frequency = 0", "must be greater than 0"),
    ([SWINGING, "walls.top.angular_frequency=-1"], "walls.top.angular_frequency = -1", "must be greater than 0"),
    (["walls.top={amplitud: 2}"], "walls.top.amplitud = 2", "unknown key; nearest: amplitude; allowed: velocity,"),
    (["walls.top={angular_freqency: 2}"], "walls.top.angular_freqency = 2", "nearest: angular_frequency"),
    (["walls.top={amplitude: fast}"], 'walls.top.amplitude = "fast"', "must be a number"),
    (["walls.top.velocity=0"], "walls", "nothing moves"),
    (["walls.top={velocity: 0, velocity_before: 0}", "initial.state=developed"], "walls", "or drive.acceleration"),
    ([STOPPED], "walls.top.velocity_before = 0.5", "is not allowed with initial.state rest"),
    (["walls.bottom={velocity_before: 0}"], "walls.bottom.velocity_before = 0.0", "state developed, or exact"),
    (["drive.acceleration=.nan"], "drive.acceleration = NaN", "must be a finite number"),
    (["drive.acceleration=fast"], 'drive.acceleration = "fast"', "must be a number"),
    (
        ["output.video={color_by: swirl}"],
        'output.video.color_by = "swirl"',
        "must be 'speed', 'u', 'shear_rate', 'shear_stress', 'viscosity', 'error' or 'dye'",
    ),
    (["output.video={color_by: pressure}"], 'output.video.color_by = "pressure"', "must be 'speed', 'u',"),
    (["fluid.rheology={type: oldroyd_b, solvent_fraction: 0.1}"], "fluid.rheology.relaxation_time", "is missing"),
    (["fluid.rheology={type: oldroyd_b, relaxation_time: 1}"], "fluid.rheology.solvent_fraction", "is missing"),
    ([POLYMER, "fluid.rheology.relaxation_time=0"], "fluid.rheology.relaxation_time = 0", "must be greater than 0"),
    ([POLYMER, "fluid.rheology.solvent_fraction=0"], "fluid.rheology.solvent_fraction = 0", SOLVENT),
    ([POLYMER, "fluid.rheology.solvent_fraction=1.1"], "fluid.rheology.solvent_fraction = 1.1", SOLVENT),
    ([POLYMER, "fluid.rheology.solvent_fraction=.nan"], "fluid.rheology.solvent_fraction = NaN", "finite number"),
    ([POLYMER, "fluid.rheology.lambda=1"], "fluid.rheology.lambda = 1", "unknown key"),
    (["fluid.rheology={type: newtonian, relaxation_time: 1}"], "fluid.rheology.relaxation_time = 1", "unknown key"),
    (["fluid.rheology={type: oldroydb}"], 'fluid.rheology.type = "oldroydb"', "nearest: oldroyd_b"),
    ([POLYMER, "scheme.operators=standard"], 'scheme.operators = "standard"', "oldroyd_b needs the velocity gradient"),
    ([POLYMER, SWINGING, "initial.state=developed"], 'initial.state = "developed"', "no periodic flow is built in"),
    (["walls.top={shear_stress: 1, velocity: 1}"], "walls.top.shear_stress = 1.0", EXACTLY_ONE + "velocity and shear"),
    (["walls.top={mass_per_area: 1}"], "walls.top.mass_per_area = 1.0", "is only for a stress-controlled wall"),
    (
        ["walls.top={velocity: 1, mass_per_area: 1}"],
        "walls.top.mass_per_area = 1.0",
        "is only for a stress-controlled wall",
    ),
    (["walls.top={shear_stress: 1, phase: sin}"], 'walls.top.phase = "sin"', ONLY_SWINGING),
    (["walls.top={shear_stress: 1, times: [0]}"], "walls.top.times = [0.0]", "is only for a wall with stresses"),
    (["walls.top={stress_amplitude: 1}"], "walls.top.angular_frequency", "is missing: a stress with an amplitude"),
    (
        ["walls.top={stresses: [1, 0]}"],
        "walls.top.times = null",
        "must be as many times, ascending from 0 on, as there are",
    ),
    (["walls.top={stresses: [1, 0], times: [1, 0]}"], "walls.top.times = [1.0, 0.0]", "must ascend from 0 on"),
    (
        [DRIVEN, "walls.bottom={shear_stress: 1}"],
        "walls.top",
        "must have a velocity if the bottom wall is stress-controlled",
    ),
    (
        [DRIVEN, "initial={state: developed}"],
        'initial.state = "developed"',
        "must be rest where a wall is stress-controlled",
    ),
    (
        ["walls.top={velocities: [1, 0]}"],
        "walls.top.times = null",
        "must be as many times, ascending from 0 on, as there",
    ),
    (["walls.top={velocities: [1, 0], times: [0, 0]}"], "walls.top.times = [0.0, 0.0]", "come after the first"),
    (["walls.top={velocities: [1, 0], times: [1, 0]}"], "walls.top.times = [1.0, 0.0]", "must ascend from 0 on"),
    (
        ["walls.top={velocities: [1, 0, 1, 2], times: [0, 1, 1, 1]}"],
        "walls.top.times = [0.0, 1.0, 1.0, 1.0]",
        "two equal ones",
    ),
    (["walls.top={velocities: [0, 0], times: [0, 1]}"], "walls.top.velocities = [0.0, 0.0]", "must not all be 0"),
    ([SCHEDULED[:-1] + ", velocity_before: 1}"], "walls.top.velocity_before = 1.0", "it starts from rest"),
    ([SCHEDULED[:-1] + ", phase: sin}"], 'walls.top.phase = "sin"', "not for one with velocities at times"),
    ([SCHEDULED, "initial.state=developed"], 'initial.state = "developed"', "must be rest where a wall has velocities"),
    ([SCHEDULED, "scheme.type=wcsph"], 'scheme.type = "wcsph"', "wcsph has no wall with velocities at times"),
    (
        [SCHEDULED, "bodies=[{centre: [0.5, 0.5], radius: 0.2}]"],
        "walls.top.velocities = [0.0, 1.0]",
        "is not for a channel with bodies",
    ),
    ([DRIVEN, "scheme.type=wcsph"], 'scheme.type = "wcsph"', "wcsph has no stress-controlled wall (walls.top)"),
    (
        [DRIVEN, "time.cfl=0.5"],
        'scheme.type = "auto"',
        "wcsph has no stress-controlled wall (walls.top); take implicit",
    ),
]


@pytest.mark.parametrize(("overrides", "blamed", "reason"), BAD, ids=[" ".join(case[0])[:70] for case in BAD])
def test_what_cannot_be_is_refused(message, overrides, blamed, reason):
    text = message(*overrides)
    assert f": {blamed}: " in text
    assert reason in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("family", "member", "key"),
    [("walls", "consistent_image", "walls.treatment.type"), ("rheology", "newtonian", "fluid.rheology.type")],
)
def test_a_chosen_member_may_refuse_a_config(message, monkeypatch, family, member, key):
    """A module with a function ``problems`` is asked when it is chosen, and the message is its own."""

    def problems(config):
        yield key, f"serves no viscosity {config.kinematic_viscosity:g}"

    real = registry.load
    picked = types.SimpleNamespace(Parameters=real(family, member).Parameters, problems=problems)
    monkeypatch.setattr(registry, "load", lambda f, name: picked if (f, name) == (family, member) else real(f, name))
    assert message().endswith(f': {key} = "{member}": serves no viscosity 0.01')


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
    problem = problem_of(registry.load("scenes", config.scene).Scene.from_config(config))
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
