"""Open ends of a channel in a config: keys of inlet and outlet, and the flows that they cannot serve."""

import pytest

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


@pytest.fixture
def loaded(loader):
    return loader(OPEN)


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


REVERSING = [
    ("velocity: 1.0, amplitude: 2.0, angular_frequency: 1.0, phase: sin", 3.1),
    ("amplitude: 1.0, angular_frequency: 1.0, phase: sin", 3.1),
    ("times: [0.0, 1.0, 2.0], velocities: [0.0, 1.0, -0.1]", 1.9),
]


@pytest.mark.parametrize(("keys", "end"), REVERSING)
def test_an_inflow_that_would_reverse_after_the_run_is_accepted(loaded, keys, end):
    """Up to t = 3.1 a sine is above 0, and 1 + 2 sin t above -1e-9; the table is below 0 from t = 1.9 on."""
    loaded(f"ends.left={{type: inlet, {keys}}}", f"time.end={end}")
