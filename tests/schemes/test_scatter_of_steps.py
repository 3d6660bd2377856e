"""Scatter of velocities with the places of the particles must not set the steps: of bodies, and of thinning fluids."""

import math
from pathlib import Path

import numpy as np
import pytest
from flows import flow_config

import tisph
from tisph import scenes, schemes
from tisph.errors import ConfigError
from tisph.schemes._step_control import LARGEST_MULTISTEP_FACTOR, StepControl

pytestmark = pytest.mark.taichi

SHEAR = flow_config("channel_in_shear")
QUIET = "runtime.threads=1", "output.video=null"
FREE = {"centre": [0.75, 0.5], "motion": "free"}
SQUARE = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
BODIES = {
    "ellipse": {**FREE, "type": "ellipse", "half_axes": [0.22, 0.16], "angle": 1.2},
    "square": {**FREE, "type": "polygon", "corners": SQUARE, "corner_radius": 0.14, "angle": 0.3},
}


def run(config, inertia, courant=None):
    """Return steps, angles, and angular velocity of the first body at the end."""
    config = {**config, "fluid": {**config["fluid"], "inertia": inertia}}
    if courant:
        config = {**config, "time": {**config["time"], "cfl": courant}}
    with tisph.Simulation(config) as simulation:
        simulation.begin()
        simulation.run_until(config["time"]["end"])
        bodies = simulation.scheme.snapshot().bodies
        return simulation.scheme.steps, bodies.angle[0], bodies.angular_velocity[0]


def assert_steps_of_the_motion(scheme, count):
    """Advance by ``count`` of the longest steps.

    These are reached within ten steps: each is 1.5 times the one before, from a fiftieth on.
    """
    of_motion = 0.0
    while of_motion < count and not scheme.finished:
        before = scheme.time
        scheme.advance()
        of_motion += (scheme.time - before) / scheme.control.limit(scheme.speed)
        assert scheme.steps <= 2 * (10 + of_motion)


@pytest.mark.parametrize("shape", BODIES)
def test_bodies_that_are_no_circles_take_the_steps_of_the_motion(shape):
    """By a Courant number alone steps are those of the motion.

    Angles differ by the scatter of the angular velocity between steps, 1e-3 of it here.
    """
    config = {**SHEAR, "bodies": [BODIES[shape]]}
    of_motion, angle, _ = run(config, False, courant=1.0)
    steps, found, _ = run(config, False)
    assert steps <= 2 * of_motion
    assert found == pytest.approx(angle, abs=3e-3)


@pytest.mark.parametrize("shape", ["ellipse", pytest.param("square", marks=pytest.mark.slow)])
def test_little_inertia_changes_neither_steps_nor_angular_velocities(shape):
    """The start from rest, whose layers are thin at first, takes up to 40 steps more."""
    config = {**SHEAR, "bodies": [BODIES[shape]]}
    steps, angle, rate = run(config, True)
    of_motion, found, without = run(config, False, courant=1.0)
    assert steps <= 2 * of_motion + 40
    assert angle == pytest.approx(found, abs=5e-3)
    assert rate == pytest.approx(without, rel=1e-2)


def test_strong_thinning_without_inertia_takes_the_steps_of_the_motion():
    """With two outer iterations whatever they left, errors grew from step to step, and steps shrank to 1e-7."""
    law = {"type": "carreau_yasuda", "time": 5.0, "index": 0.5, "fraction_at_infinity": 1e-3}
    config = {
        **SHEAR,
        "fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False, "rheology": law},
        "walls": {},
        "bodies": [{"type": "circle", "centre": [0.75, 0.5], "radius": 0.25, "motion": "fixed"}],
        "drive": {"acceleration": 10.0},
        "initial": {},
        "discretisation": {"particles_across": 16},
    }
    with tisph.Simulation(config) as simulation:
        simulation.begin()
        assert_steps_of_the_motion(simulation.scheme, 5)


def test_errors_of_a_solution_leave_steps_the_error_of_their_motion():
    """Extrapolation over four steps makes errors of single ones (C(8, 4))^(1/2) = 8.4 times as large.

    So velocities of bodies that are off by more than an eighth of the tolerance refuse steps by that alone. An ellipse
    is off by 0.05 of it; by 0.9 while its residual left out the forces of the fluid.
    """
    config = {**SHEAR, "bodies": [BODIES["ellipse"]], "fluid": {**SHEAR["fluid"], "inertia": False}}
    with tisph.Simulation(config) as simulation:
        simulation.begin()
        scheme = simulation.scheme
        bodies, errors = scheme.couplings[0].bodies, []
        for _ in range(12):
            scheme.advance()
            residual, dt, found = scheme.equations.residual, scheme.control.dt_next, []
            for part in (1.0, 1e-3):
                scheme.equations.residual = part * residual
                scheme.attempt(dt)
                found.append(bodies.arm * bodies.velocities)
            scheme.equations.residual = residual
            errors.append(np.abs(found[0] - found[1]).max() / (scheme.tolerance * scheme.error_speed))
    assert np.sqrt(np.mean(np.square(errors))) < 1.0 / math.sqrt(math.comb(8, 4))


def controlled(error, steps=200, **chosen):
    """Return the lengths of ``steps`` steps whose error is ``error(dt)``, with its roughness; the longest are 1."""
    control = StepControl(1e-5, lambda speed: 1.0, multistep=True, **chosen)
    control.set_targets([1e9], 0.0)
    control.dt_next, time, lengths = 0.02, 0.0, []
    roughness = 0.0

    def attempt(dt):
        nonlocal roughness
        found, roughness = error(dt)
        return found, 3

    for _ in range(steps):
        dt, found = control.take(time, attempt, 0.0)
        control.notice_scatter(found, roughness)
        time += dt
        control.step_taken(time, 1.0)
        lengths.append(dt)
    return np.array(lengths)


@pytest.mark.parametrize("scatter", [3e-6, 3e-5, 1e-3])
def test_steps_grow_to_the_longest_where_errors_only_scatter(scatter):
    """Differences of white noise grow by (C(8, 4)/C(6, 3))^(1/2) with the order."""
    random = np.random.default_rng(3)
    noise = lambda dt: (scatter * abs(random.normal()), 0.5 * math.log(70 / 20) + 0.5 * random.normal())  # noqa: E731
    lengths = controlled(noise)
    assert lengths[60:].min() == 1.0  # some ten steps until it is noticed; then steps grow by half


def test_errors_of_smooth_motion_still_set_the_steps():
    """An error of 1e-5 dt^4/0.1^4 is 0.66 of the tolerance at dt = 0.09; differences fall with the order."""
    lengths = controlled(lambda dt: (1e-5 * (dt / 0.1) ** 4, math.log(dt / 0.3)))
    assert lengths[-1] == pytest.approx(0.09, rel=0.02)


def test_an_event_is_no_scatter():
    """A kink in the velocities is rough for the five steps whose levels hold it: errors up to then do not count."""
    number = iter(range(10000))

    def error(dt):
        rough = 30 <= next(number) < 35
        return 1e-5 * (dt / 0.1) ** 4, 0.6 if rough else math.log(dt / 0.3)

    assert controlled(error).max() <= 0.09 * LARGEST_MULTISTEP_FACTOR


STOKES = {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False}
TALL_BOX = {"type": "polygon", "corners": [[0, 0], [4, 0], [4, 6], [0, 6]], "corner_radius": 0.2}
DISC = {"type": "circle", "motion": "free", "radius": 0.17}
FLOWS = {
    "falling_disc": (
        {
            "scene": "channel",
            "fluid": STOKES,
            "geometry": {"gap": 2.0, "length": 8.0},
            "bodies": [{**DISC, "centre": [4.0, 1.0], "radius": 0.25, "density": 1.5}],
            "drive": {"gravity": [100.0, 0.0]},
            "discretisation": {"spacing": 0.0625},
            "time": {"end": 0.5},
        },
        2 * (10 + 5),
    ),
    "ellipse": (
        {
            **SHEAR,
            "fluid": STOKES,
            "geometry": {"gap": 1.0, "length": 2.0},
            "bodies": [
                {"type": "ellipse", "centre": [1.0, 0.5], "half_axes": [0.2, 0.12], "angle": 1.2, "motion": "free"}
            ],
            "discretisation": {"particles_across": 50},
            "time": {"end": 6.0},
        },
        2 * (10 + 150),
    ),
    "three_discs": (
        {
            "scene": "region",
            "fluid": {"density": 1.0, "kinematic_viscosity": 0.05},
            "walls": {"around": TALL_BOX},
            "bodies": [
                {**DISC, "centre": centre, "density": density}
                for centre, density in (([1.3, 5.0], 1.01), ([2.0, 5.2], 1.02), ([2.7, 5.0], 1.05))
            ],
            "drive": {"gravity": [0.0, -981.0]},
            "discretisation": {"spacing": 1 / 15},
            "time": {"end": 1.0},
        },
        200,
    ),
}
"""Config, and steps: twice those of the longest length and ten at the start; of the discs twice those by a Courant
number of 0.5."""


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOWS)
def test_flows_whose_steps_scatter_had_set(name):
    config, steps = FLOWS[name]
    with tisph.Simulation({**config, "runtime": {"threads": 1}}) as simulation:
        simulation.begin()
        simulation.run_until(config["time"]["end"])
        bodies = simulation.scheme.snapshot().bodies
        assert simulation.scheme.steps <= steps
    if name == "falling_disc":  # by symmetry it moves along the middle
        assert bodies.velocity[0, 1] == pytest.approx(0.0, abs=1e-3 * bodies.velocity[0, 0])
        assert bodies.centre[0, 1] == pytest.approx(1.0, abs=1e-4)
    if name == "three_discs":  # with steps of a quarter of the length: scatter of 1 % of the way
        assert bodies.centre[:3, 1] == pytest.approx([4.65, 4.05, 2.38], abs=0.03)


SMALL = ["segre_silberberg"]
LARGE = [
    "carried_circle", "cavity_oldroyd_b", "confined_cylinder_oldroyd_b", "confined_cylinder_refined",
    "drafting_kissing_tumbling", "ellipse_refined", "falling_ball", "free_cylinder", "jeffery_orbit", "migration",
    "oldroyd_b_cylinder_in_stream", "settling_disc", "suspension",
]  # fmt: skip


def loaded(name):
    """Settings and scene of a shipped config without inertia; None where that is refused."""
    try:
        settings = tisph.config.load(f"configs/{name}.yaml", ["fluid.inertia=false", *QUIET])
    except ConfigError as error:
        return None if "inertia" in str(error) else pytest.fail(str(error))
    settings, _ = schemes.resolve(settings)
    return settings, scenes.of(settings)


def test_all_shipped_configs_with_bodies_or_other_fluids_are_here():
    found = {path.stem: loaded(path.stem) for path in Path("configs").glob("*.yaml")}
    found = {name for name, it in found.items() if it and (it[1].has_free_bodies or it[1].rheology is not None)}
    assert found == {*SMALL, *LARGE}


@pytest.mark.parametrize("name", [*SMALL, *(pytest.param(name, marks=pytest.mark.slow) for name in LARGE)])
def test_shipped_configs_without_inertia_take_the_steps_of_the_motion(name):
    settings, _ = loaded(name)
    with tisph.Simulation(settings) as simulation:
        simulation.begin()
        assert_steps_of_the_motion(simulation.scheme, 6)
