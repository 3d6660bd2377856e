"""Free bodies that a stream carries from an inlet to an outlet, bodies that leave it, and bodies that enter later."""

import math

import numpy as np
import pytest
from finished_run import finished
from flows import flow_config

import tisph
from tisph.errors import DivergedError

pytestmark = pytest.mark.taichi

INLET, OUTLET = {"type": "inlet", "velocity": 1.0}, {"type": "outlet"}
STREAM = flow_config("stream")
CIRCLE = {"type": "circle", "radius": 0.15, "motion": "free"}
CARRIED = {"velocity": [1.33125, 0.0], "angular_velocity": -0.9}
"""Mean velocity u(0.35) - 6 R^2/4 and rotation -u'(0.35)/2 of the parabola u = 6 y (1 - y) in a circle there."""

LEAVING = {**CIRCLE, "centre": [1.65, 0.65], "velocity": [1.27, 0.0], "angular_velocity": 0.9}
BOTH = {**STREAM, "bodies": [LEAVING, {**CIRCLE, "centre": [0.6, 0.35], "enters": 0.1}]}
"""A circle that leaves at about t = 0.08, and one that enters at 0.1."""

MOTION = ("x", "y", "u", "v", "angular_velocity")

CARRY = {
    **STREAM,
    "geometry": {"gap": 1.0, "length": 3.0},
    "bodies": [{**CIRCLE, "centre": [0.9, 0.35]}],
    "time": {"end": 0.3},
}
"""A circle 0.3 of the gap wide, at first at rest in developed flow, Re = 5 by its diameter and the mean velocity."""


def run(config, at_step=lambda simulation: None):
    """Numbers at the end of a run, all numbers of the summary, the numbers of particles of all steps, and the state.

    After each step ``at_step`` is called.
    """
    with tisph.Simulation(config) as simulation:
        counts = []
        while not simulation.finished:
            simulation.step()
            counts.append(len(simulation.state.x))
            at_step(simulation)
        state, scheme = simulation.state, simulation.scheme
        numbers = simulation.scene.diagnostics(scheme.snapshot(), [])
        return numbers, scheme.numbers(), counts, (state.x, state.y, state.u, state.v)


@pytest.fixture(scope="module")
def passed(tmp_path_factory):
    """The run of ``BOTH``: numbers and particles at the end, numbers of particles, and a checkpoint after the entry."""
    path = tmp_path_factory.mktemp("passed") / "checkpoint.h5"

    def save(simulation):
        if simulation.time > 0.15 and not path.exists():
            simulation.save(path)

    return *run(BOTH, save), path


def test_a_body_that_has_left_is_gone(passed):
    found, numbers, counts, *_ = passed
    assert 0.05 < numbers["left_0"] < 0.1
    assert all(math.isnan(found[f"{name}_0"]) for name in MOTION)
    assert abs(found["mass_imbalance"]) < 1e-2  # above it a sample is not resolved
    change = round(math.pi * 3.0**2)  # particles in the place of a circle of three spacings
    assert sorted(set(counts)) == [counts[0], counts[0] + change]
    assert counts[-1] == counts[0]


def test_a_body_that_enters_moves_as_from_the_start(passed):
    """Both begin with the mean velocities of the fluid in developed flow, to which the other one has not come."""
    found, *_ = passed
    body = {**CIRCLE, **CARRIED, "centre": [0.6, 0.35]}
    first, _ = carried({**STREAM, "bodies": [body], "time": {"end": 0.14}})
    apart = np.abs([found[f"{name}_1"] for name in MOTION] - first)
    assert apart[:4].max() < 4e-3  # with three spacings to the radius; 2e-3 were measured
    assert apart[4] < 2e-2


def test_a_restart_after_bodies_have_left_and_entered_has_the_same_bits(passed):
    *_, fields, path = passed
    with tisph.Simulation.restore(path) as simulation:
        while not simulation.finished:
            simulation.step()
        state = simulation.state
        assert all(np.array_equal(*pair) for pair in zip(fields, (state.x, state.y, state.u, state.v), strict=True))


@pytest.mark.slow
def test_a_body_that_leaves_does_not_disturb_others():
    """The other body is 1.8 lengths away, where disturbances have fallen to exp(-4.2 x 1.5) = 2e-3 of a slip of 0.1."""
    bodies = [{**CIRCLE, **CARRIED, "centre": [0.7, 0.35]}, {**LEAVING, "centre": [2.5, 0.35]}]
    config = {**STREAM, "geometry": {"gap": 1.0, "length": 3.0}, "bodies": bodies, "time": {"end": 0.6}}
    one, numbers, *_ = run(config)
    other, none, *_ = run({**config, "geometry": {"gap": 1.0, "length": 4.0}})
    assert "left_1" in numbers
    assert not any(name.startswith("left") for name in none)
    assert np.abs([one[f"{name}_0"] - other[f"{name}_0"] for name in MOTION]).max() < 3e-3


THINNING = {"type": "power_law", "index": 0.8, "reference_rate": 6.0, "least_rate": 0.1}
POLYMER = {"type": "oldroyd_b", "relaxation_time": 0.1, "solvent_fraction": 0.5}


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False}},
        {"fluid": {"density": 1.0, "kinematic_viscosity": 0.5, "rheology": POLYMER}, "initial": {"state": "rest"}},
        {"fluid": {"density": 1.0, "kinematic_viscosity": 15.0}},
        {"discretisation": {"particles_across": 20, "precision": "f32"}},
        {"fluid": {"density": 1.0, "kinematic_viscosity": 0.06, "rheology": THINNING}},
    ],
    ids=["without inertia", "polymer", "slow flow", "single precision", "power law"],
)
def test_other_features_go_with_it(changes):
    """The body that has entered has the velocity of the flow around it, to a tenth, and what enters leaves."""
    found, numbers, *_ = run({**BOTH, "time": {"end": 0.3}, **changes})
    assert "left_0" in numbers
    assert abs(found["mass_imbalance"]) < 1e-2
    assert found["u_1"] == pytest.approx(1.29, rel=0.1)
    assert found["y_1"] == pytest.approx(0.35, abs=0.01)


@pytest.mark.slow
def test_an_ellipse_and_a_polygon_leave_and_a_curve_enters():
    square = [[-0.15, -0.15], [0.15, -0.15], [0.15, 0.15], [-0.15, 0.15]]
    egg = [[-0.17, 0.0], [0.0, -0.15], [0.17, 0.0], [0.0, 0.15]]
    bodies = [
        {"type": "ellipse", "half_axes": [0.18, 0.16], "centre": [1.65, 0.3], "motion": "free"},
        {"type": "polygon", "corners": square, "corner_radius": 0.1, "centre": [1.5, 0.7], "motion": "free"},
        {"type": "curve", "points": egg, "centre": [0.5, 0.4], "motion": "free", "enters": 0.1},
    ]
    found, numbers, *_ = run({**STREAM, "bodies": bodies, "time": {"end": 0.5}})
    assert {"left_0", "left_1"} <= set(numbers)
    assert found["u_2"] == pytest.approx(1.3, rel=0.1)


@pytest.mark.slow
def test_a_body_leaves_through_an_end_of_given_pressure():
    ends = {"left": {"pressure": 12.0 * 0.06 * 2.0}, "right": {"pressure": 0.0}}
    found, numbers, *_ = run({**BOTH, "ends": ends, "time": {"end": 0.3}})
    assert "left_0" in numbers
    assert found["u_1"] == pytest.approx(1.29, rel=0.05)


@pytest.mark.slow
def test_settling_against_a_stream_without_inertia():
    """By superposition the weight adds the velocity in a closed channel, 0.0455299 F/mu: ../shared free_bodies.md.

    It is of a periodic channel of two gaps, whose images change it by exp(-4.2 x 1.75) = 6e-4 of it.
    """
    config = {
        **STREAM,
        "fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False},
        "geometry": {"gap": 1.0, "length": 3.0},
        "discretisation": {"particles_across": 32},
        "time": {"end": 0.01},
    }
    body = {"type": "circle", "radius": 0.125, "motion": "free", "centre": [1.5, 0.5]}
    weight = 40.0
    heavy, *_ = run({**config, "bodies": [{**body, "density": 2.0}], "drive": {"gravity": [-weight, 0.0]}})
    light, *_ = run({**config, "bodies": [body]})
    force = weight * math.pi * 0.125**2
    assert heavy["u"] - light["u"] == pytest.approx(-0.0455299 * force, rel=3e-3)
    assert heavy["v"] == pytest.approx(0.0, abs=1e-3)


IN_THE_WAY = [{**CIRCLE, "centre": [0.6, 0.35]}, {**CIRCLE, "centre": [0.6, 0.4], "enters": 1e-3}]
SINKING = {"drive": {"gravity": [-400.0, 0.0]}, "bodies": [{**CIRCLE, "centre": [0.3, 0.4], "density": 2.0}]}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"bodies": IN_THE_WAY}, r"enters at \(0.6, 0.4\).*in its way.*let it enter later"),
        (SINKING, r"reaches the inlet at t = 0.*make the channel longer"),
    ],
)
def test_bodies_in_the_way_and_at_the_inlet_end_the_run(changes, words):
    with pytest.raises(DivergedError, match=words):
        run({**STREAM, "time": {"end": 0.1}, **changes})


def carried(config):
    """Numbers of the body at the end of the run, its centre and velocities, and all numbers of the sample."""
    *_, found = finished(config)
    return np.array([found[name] for name in MOTION]), found


def against_the_periodic_channel(config):
    """Differences of velocities and height from the periodic channel's, whose mean velocity the body lowers.

    It is driven as developed flow of the mean velocity 1 is.
    """
    drive = {"acceleration": 12.0 * config["fluid"]["kinematic_viscosity"]}
    periodic = {**{key: value for key, value in config.items() if key != "ends"}, "drive": drive}
    (_, height, *velocities), _ = carried(config)
    (_, other, *others), found = carried(periodic)
    return np.array([*(np.array(velocities) - np.array(others) / found["superficial_velocity"]), height - other])


def test_a_stream_carries_a_circle_as_a_periodic_channel_does():
    """Images one length apart disturb each other by exp(-4.2 (3.0 - 0.3)) = 1e-5.

    With three spacings to the radius velocities have errors of some 1e-3, and angular velocities of 1e-2.
    """
    along, across, turning, height = np.abs(against_the_periodic_channel(CARRY))
    assert max(along, across, height) < 5e-3
    assert turning < 2e-2


@pytest.mark.slow
@pytest.mark.parametrize("viscosity", [0.06, 15.0], ids=["Re 5", "Re 0.02"])
def test_a_circle_on_its_way_from_inlet_to_outlet(viscosity):
    """The bound of the issue that brought this feature."""
    config = {**CARRY, "geometry": {"gap": 1.0, "length": 4.0}, "discretisation": {"particles_across": 32}}
    config |= {"fluid": {"density": 1.0, "kinematic_viscosity": viscosity}, "time": {"end": 1.6}}
    assert np.abs(against_the_periodic_channel(config)).max() < 3e-3


def test_with_the_inlet_on_the_right_all_is_the_mirror_image():
    """Particles lie otherwise: velocities agree to the error of the spacing."""
    body, ends = [{**CIRCLE, "centre": [2.1, 0.35]}], {"left": OUTLET, "right": INLET}
    one, _ = carried({**CARRY, "time": {"end": 0.2}})
    other, _ = carried({**CARRY, "time": {"end": 0.2}, "bodies": body, "ends": ends})
    assert [3.0, 0.0, 0.0, 0.0, 0.0] + other * [-1, 1, -1, 1, -1] == pytest.approx(one, abs=5e-3)


HEAVY = {"drive": {"gravity": [0.0, -2.0]}, "bodies": [{**CIRCLE, "density": 1.5, "centre": [0.9, 0.7]}]}


@pytest.mark.parametrize(
    "changes", [{"fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False}}, HEAVY], ids=["slow", "heavy"]
)
def test_a_body_has_the_velocity_of_the_flow_around_it_or_settles(changes):
    (x, y, u, v, _), found = carried({**CARRY, "time": {"end": 0.2}, **changes})
    assert 0.9 < x < 1.2
    assert abs(found["mass_imbalance"]) < 1e-2  # above it a sample is not resolved
    if "drive" in changes:
        assert v < -0.02
        assert y < 0.7
    else:  # slower than 6 y (1 - y) by the Faxen term, (a/H)^2 / 2 x 6
        assert u == pytest.approx(6.0 * y * (1.0 - y) - 12.0 * 0.15**2 / 4.0, rel=0.05)
