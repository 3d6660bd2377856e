"""Open ends of a channel in a config: keys of inlet and outlet, and the flows that they cannot serve."""

from pathlib import Path

import pytest

from tisph.config import load
from tisph.errors import ConfigError

OPEN = """\
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.05}
geometry: {gap: 1.0, length: 2.0}
ends: {left: {type: inlet, velocity: 1.0}, right: {type: outlet}}
discretisation: {particles_across: 16}
time: {end: 1.0}
"""
CARREAU = "fluid.rheology={type: carreau_yasuda, time: 1.0, index: 0.5}"
OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"
PULSATING = "ends.left={type: inlet, velocity: 1.0, amplitude: 0.5, angular_frequency: 2.0}"
RAMP = "ends.left={type: inlet, times: [0.0, 1.0], velocities: [0.0, 1.0]}"
CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture
def loaded(tmp_path):
    """Config of an open channel with overrides."""

    def loaded_with(*overrides):
        path = tmp_path / "case.yaml"
        path.write_text(OPEN)
        return load(path, overrides)

    return loaded_with


def inlet(keys):
    return f"ends.left={{type: inlet, velocity: 1.0, {keys}}}"


def table(heights, velocities):
    return inlet(f"profile: {{heights: {heights}, velocities: {velocities}}}")


def test_the_keys_of_an_inlet_have_defaults(loaded):
    ends = loaded().ends
    assert (ends.inlet, ends.inlet.profile, ends.right.profile) == (ends.left, "developed", None)
    assert loaded(PULSATING).ends.inlet.phase == "cos"
    swapped = loaded("ends={left: {type: outlet}, right: {type: inlet, velocity: 1.0}}").ends
    assert swapped.inlet is swapped.right


@pytest.mark.parametrize("changes", [(), (PULSATING,), (RAMP,), (table([0, 0.5, 1], [0, 1, 0]),)])
def test_a_resolved_config_with_ends_loads_again(loaded, tmp_path, changes):
    config, path = loaded(*changes), tmp_path / "resolved.yaml"
    path.write_text(config.resolved_yaml())
    assert load(path) == config
    assert "right:\n    type: outlet\n" in path.read_text()


@pytest.mark.parametrize(
    ("keys", "singular"),
    [("profile: uniform", True), ("profile: parabolic", False), ("profile: developed", False)]
    + [(f"profile: {{heights: [0, 0.5, 1], velocities: [0, 1, {last}]}}", last > 0) for last in (0, 1)],
)
def test_a_velocity_at_walls_is_singular(loaded, keys, singular):
    assert loaded(inlet(keys)).singular is singular


def test_flows_that_ends_can_serve_are_accepted(loaded):
    for changes in (
        (CARREAU,),
        (CARREAU, "initial.state=developed"),
        (CARREAU, PULSATING, "ends.left.profile=parabolic"),
        (OLDROYD_B, PULSATING),
        ("bodies=[{centre: [1.0, 0.5], radius: 0.2}]",),
        ("discretisation.precision=f32",),
        ("fluid.inertia=false",),
        ("geometry.length=0.625",),
    ):
        assert loaded(*changes).ends.inlet


TYPES = "must be 'inlet' or 'outlet'"
MORE_KEYS = "allowed: type, velocity, amplitude, angular_frequency, phase, times, velocities, profile"
NO_VELOCITY = "must be greater than 0, unless there is an amplitude, or velocities at times"
ERRORS = [
    ("ends=1", "ends = 1: must be a map of keys"),
    ("ends.right=null", "ends.right = null: must be a map of keys"),
    ("ends={left: {type: outlet}}", "ends.right: is missing"),
    ("ends.top=1", "ends.top = 1: unknown key"),
    ("ends.left.type=inlett", f'ends.left.type = "inlett": {TYPES}'),
    ("ends.left={velocity: 1.0}", "ends.left.type: is missing"),
    ("ends.right={type: inlet, velocity: 1.0}", 'ends.right.type = "inlet": must be outlet, with an inlet on the left'),
    ("ends.left={type: outlet}", 'ends.right.type = "outlet": must be inlet, with an outlet on the left'),
    ("ends.right.velocity=1.0", "ends.right.velocity = 1.0: is only for an inlet"),
    ("ends.right.profile=uniform", 'ends.right.profile = "uniform": is only for an inlet'),
    ("ends.left.velocty=1.0", f"ends.left.velocty = 1.0: unknown key; nearest: velocity; {MORE_KEYS}"),
    ("ends.left.velocity=0", f"ends.left.velocity = 0.0: {NO_VELOCITY}"),
    ("ends.left.velocity=null", f"ends.left.velocity: {NO_VELOCITY}"),
    ("ends.left.velocity=-1", "ends.left.velocity = -1: must be at least 0"),
    ("ends.left.velocity=.nan", "ends.left.velocity = NaN: must be a finite number"),
    ("ends.left.velocity=fast", 'ends.left.velocity = "fast": must be a number'),
    ("ends.left.amplitude=1", "ends.left.angular_frequency: is missing: an inlet with an amplitude oscillates"),
    ("ends.left.phase=sin", 'ends.left.phase = "sin": is only for an inlet with an amplitude'),
    ("ends.left.times=[0, 1]", "ends.left.times = [0.0, 1.0]: is only for an inlet with velocities at times"),
    (inlet("times: [0], velocities: [1]"), "ends.left.velocity = 1.0: is not for an inlet with velocities at times"),
    ("ends.left={type: inlet, times: [0, 1], velocities: [1]}", "ends.left.times = [0.0, 1.0]: must be as many times"),
    ("ends.left={type: inlet, times: [0, 0], velocities: [0, 1]}", "must ascend: an inflow that jumps needs an inf"),
    ("ends.left={type: inlet, times: [0, 1], velocities: [0, 0]}", "ends.left.velocities = [0.0, 0.0]: must not all"),
    (inlet("profile: plug"), "must be 'developed', 'parabolic' or 'uniform', or a map of heights and velocities"),
    (inlet("profile: {height: [0, 1]}"), "ends.left.profile.height = [0, 1]: unknown key; nearest: heights; allowed"),
    (table([0, 1], [1]), "ends.left.profile.velocities = [1.0]: must be as many as there are heights, 2"),
    (table([0.1, 1], [1, 1]), "ends.left.profile.heights = [0.1, 1.0]: must be two or more, ascending from 0"),
    (table([0], [1]), "ends.left.profile.heights = [0.0]: must be two or more, ascending from 0"),
    (table([0, 0.5], [1, 1]), "ends.left.profile.heights = [0.0, 0.5]: must end at the width of the inlet, 1"),
    (table([0, 0.5, 1], [0, -1, 0]), "ends.left.profile.velocities.1 = -1: must be at least 0"),
    (table([0, 1], [0, 0]), "ends.left.profile.velocities = [0.0, 0.0]: must not all be 0"),
    (table([0, 0.1, 0.9, 1], [0, 0, 1, 0]), "must be more points: the cubic spline through these is negative"),
    (f"{CARREAU}|{PULSATING}", 'ends.left.profile = "developed": must be parabolic, uniform or a table where'),
    (f"{CARREAU}|{RAMP}", "a developed carreau_yasuda flow has another profile at each velocity"),
    ("scheme={type: wcsph}", 'scheme.type = "wcsph": wcsph has no open ends; take auto or implicit'),
    ("walls.top={velocity: 1.0}", "walls.top: must be at rest: with open ends no wall moves yet"),
    ("walls.top={shear_stress: 1.0}", "walls.top: must be at rest: with open ends no wall moves yet"),
    ("walls.top={times: [0, 1], velocities: [0, 1]}", "walls.top: must be at rest: with open ends no wall moves yet"),
    ("bodies=[{centre: [1, 0.5], radius: 0.2, motion: free}]", 'bodies.0.motion = "free": must not be free'),
    ("bodies={type: random_circles, radius: 0.2, fraction: 0.1, motion: free}", 'bodies.motion = "free": must not be'),
    ("bodies=[{centre: [0.1, 0.5], radius: 0.2}]", "bodies.0.centre = [0.1, 0.5]: overlaps ends.left, by 0.1"),
    ("drive={acceleration: 1.0}", "drive.acceleration = 1.0: must be 0: the inlet drives the flow"),
    ("initial={state: exact, time: 0.5}", 'initial.state = "exact": must be rest or developed: with open ends no'),
    (f"{OLDROYD_B}|initial.state=developed", "must be rest with open ends, unless a fluid without polymer makes it"),
    (f"{inlet('profile: uniform')}|time.tolerance=1e-5", "is not allowed where velocities jump in a corner"),
    ("probes={count: 5}", "probes: must be left out: with open ends forces are recorded"),
    ("geometry.length=0.5", "geometry.length = 0.5: must be at least 0.625, 10 particle spacings"),
]


@pytest.mark.parametrize(("changes", "wanted"), ERRORS, ids=[changes[:60] for changes, _ in ERRORS])
def test_an_error_names_its_key(loaded, changes, wanted):
    with pytest.raises(ConfigError) as caught:
        loaded(*changes.split("|"))
    assert wanted in str(caught.value)


@pytest.mark.parametrize("name", ["pipe", "cavity", "turned_box"])
def test_other_scenes_name_the_scene_with_open_ends(name):
    with pytest.raises(ConfigError, match="ends = 1: unknown key; open ends are only for scene channel"):
        load(CONFIGS / f"{name}.yaml", ["ends=1"])


@pytest.mark.parametrize("profile", [inlet("profile: uniform"), table([0, 0.5, 1], [0.2, 1, 0])])
def test_a_velocity_that_jumps_at_walls_has_inertia_and_no_polymer(loaded, profile):
    loaded(profile)
    with pytest.raises(ConfigError, match="must be 0 at walls with oldroyd_b: the stress would be infinite"):
        loaded(profile, OLDROYD_B)
    with pytest.raises(ConfigError, match="jumps at a corner, from one wall to another or from an inlet to a wall"):
        loaded(profile, "fluid.inertia=false")


REVERSING = [
    ("velocity: 1.0, amplitude: 2.0, angular_frequency: 1.0, phase: sin", 6.0),
    ("velocity: 1.0, amplitude: -1.1, angular_frequency: 1.0", 0.1),
    ("amplitude: 1.0, angular_frequency: 1.0, phase: sin", 4.0),
    ("times: [0.0, 1.0, 2.0], velocities: [0.0, 1.0, -0.1]", 2.0),
    ("times: [0.0, 1.0], velocities: [-1.0, 1.0]", 0.5),
]


@pytest.mark.parametrize(("keys", "end"), REVERSING)
def test_an_inflow_that_reverses_is_refused(loaded, keys, end):
    with pytest.raises(ConfigError, match="lets fluid out through the inlet: its mean velocity is -"):
        loaded(f"ends.left={{type: inlet, {keys}}}", f"time.end={end}")


@pytest.mark.parametrize("number", [0, 2, 3])
def test_an_inflow_that_would_reverse_after_the_run_is_accepted(loaded, number):
    """Up to t = 3.1 a sine is above 0, and 1 + 2 sin t above -1e-9; the table is below 0 from t = 1.9 on."""
    loaded(f"ends.left={{type: inlet, {REVERSING[number][0]}}}", f"time.end={1.9 if number == 3 else 3.1}")
