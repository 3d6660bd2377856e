"""What a config says of the flow: wall motion, drive, rheology, start; and the conditions between these keys."""

import types
from pathlib import Path

import pytest

from tisph import registry
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
SOLVENT = "must be greater than 0 and at most 1: at 0 (upper-convected Maxwell) what starts at a wall is a front"

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
        ["output.video={color_by: shear_stress}"],
        'output.video.color_by = "shear_stress"',
        "must be 'speed', 'u', 'error' or 'dye'",
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
