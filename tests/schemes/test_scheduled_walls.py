"""Walls with velocities or stresses at times: against the reference, on layers and on particles."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
from case_from_text import to_end as run
from flows import flow_text
from implicit_case import channel_of, layers, start_of_layers
from oracles.plane import Plane

from tisph import registry, runtime
from tisph.measures.channel import wall_shear
from tisph.schemes.implicit.channel.stages import FlowState
from tisph.schemes.implicit.channel.stress_controlled import MasslessWall
from tisph.schemes.implicit.channel.walls import PrescribedWall
from tisph.simulation.state import start_values

pytestmark = pytest.mark.taichi

CASE = flow_text("stopped_wall")
OLDROYD_B = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.2}"
TRIANGLE = "walls.top={times: [0.0, 0.1, 0.2], velocities: [0.0, 1.0, 0.0]}"
UPSIDE_DOWN = "walls={bottom: {times: [0.0, 0.1, 0.2], velocities: [0.0, 1.0, 0.0]}, top: {velocity: 0.0}}"


DRIVEN = flow_text("wall_under_stress")
HEAVY = "walls.top.mass_per_area=2.0"
RECOVERY = "walls.top={times: [0.0, 0.5], stresses: [1.0, 0.0]}"
NEWTONIAN = "fluid.rheology={type: newtonian}"
THINNING = "fluid.rheology={type: power_law, index: 0.5, reference_rate: 1.0, least_rate: 1e-3}"
DRIVEN_UPSIDE_DOWN = "walls={bottom: {shear_stress: 1.0, mass_per_area: 2.0}, top: {velocity: 0.0}}"


@pytest.fixture
def case(tmp_path):
    """Return a function that gives a config and its channel of overrides."""
    return lambda *overrides, text=CASE: channel_of(tmp_path, text, overrides)


@pytest.fixture
def driven(case):
    """``case`` with a stress on a wall."""
    return functools.partial(case, text=DRIVEN)


def apart(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


def error(found, channel):
    """Root mean square, over the largest speed of the wall, 1."""
    wrong = found.velocity - channel.exact_velocity(found.heights, found.time)
    return float(np.sqrt(np.mean(wrong**2)))


@pytest.mark.parametrize("shape", [[], [TRIANGLE]], ids=["pulse", "triangle"])
def test_steps_end_where_the_velocity_has_a_kink(case, shape):
    settings, channel = case(*shape)
    found = layers(settings, channel)
    assert found.control.jump_times == list(channel.top.jump_times)
    assert error(found, channel) < 1e-4  # of 12 layers; measured: 2.6e-5 and 1.1e-5


# measured: 35 and 2.3
@pytest.mark.parametrize(("shape", "worse"), [([], 20.0), ([TRIANGLE], 2.0)], ids=["pulse", "triangle"])
def test_the_impulse_at_a_kink_makes_the_order(case, monkeypatch, shape, worse):
    fine = ["discretisation.particles_across=24", *shape]
    coarse, finer = (error(*layers_of(case, *overrides)) for overrides in (shape, fine))
    assert coarse > 2.0**3.5 * finer  # measured: 2^4.2, with steps that err by 1e-6
    monkeypatch.setattr(PrescribedWall, "later_jumps", lambda *_: (0.0, 0.0))
    assert error(*layers_of(case, *shape)) > worse * coarse


def layers_of(case, *overrides):
    settings, channel = case(*overrides)
    return layers(settings, channel), channel


def test_an_impulse_changes_the_stress_with_the_velocity(case):
    found, _ = layers_of(case, OLDROYD_B)
    # linear in velocity and shear stress: a wall that stops is the difference of two that start
    plane = Plane(1.0, 0.5, 0.2, 1.0)
    since_start, since_stop = (plane.fields(found.heights, t, top=1.0) for t in (0.3, 0.1))
    stress = found.walls.model.shear_stress(found.flow.state, None)
    for mine, part in ((found.velocity, 0), (stress, 2)):
        wrong = np.linalg.norm(mine - (since_start - since_stop)[part])
        assert wrong < 1e-2 * np.linalg.norm(since_start[part])  # of 12 layers; measured: 2.7e-3, 6.4e-3


def test_the_error_of_a_step_is_the_filtered_embedded_error(case):
    # Oldroyd-B: shear stress and velocity of a stage are linear in what it starts from
    found, channel = layers_of(case, OLDROYD_B)
    extra, flow, gamma_dt, random = found.step.extra_stress, found.flow, 0.02, np.random.default_rng(0)
    defects = random.normal(size=12), np.zeros_like(flow.state)
    defects[1][1] = random.normal(size=12)
    ends = []
    for share in (0.0, 1.0):
        known = FlowState(flow.velocity + share * defects[0], flow.state + share * defects[1])
        end = extra.respond(known.velocity, extra.shear_rate(known.velocity, 3), known, known.state, gamma_dt)
        stress, boundary = extra.linearise(end, 3)
        right = known.velocity + gamma_dt * extra.source(stress, 3)
        velocity = found.operators.solve(gamma_dt, end.tangent, right, end.velocity, 1e-12)
        velocity, shear_rate, _ = extra.solution(velocity, end, boundary, gamma_dt, 1e-12)
        ends.append(extra.respond(velocity, shear_rate, known, end.state, gamma_dt))
    one, other = ends
    stated = extra.filtered_error(one, gamma_dt, *defects)
    stress = (other.stress - one.stress) * channel.gap / channel.kinematic_viscosity
    differences = np.stack([other.velocity - one.velocity, stress])
    assert stated == pytest.approx(np.sqrt(np.mean(differences**2, axis=1).sum()), rel=1e-6)


def test_a_small_step_strain_shows_the_relaxation_modulus(case):
    # in a gap so narrow that momentum crosses it in 1e-3 of the relaxation time, 1
    step = "walls.top={times: [0.0, 0.05, 0.05], velocities: [0.02, 0.02, 0.0]}"
    narrow = ["geometry={gap: 0.01, length: 0.01}", "time={end: 0.5, tolerance: 1e-5}"]
    found, channel = layers_of(case, OLDROYD_B, step, *narrow)
    stress = channel.density * found.walls.model.shear_stress(found.flow.state, None)
    stress += channel.density * channel.solvent_viscosity * found.flow.shear_rate
    middle, half = 0.025, 0.025  # of the ramp, over which exp(-t) has the mean exp(-middle) sinh(half)/half
    modulus = 0.8 * np.exp(middle - 0.5) * np.sinh(half) / half
    assert stress / 0.1 == pytest.approx(modulus, rel=5e-5)  # measured: 1.3e-5, of the steps; 7e-6 with 3e-7


def test_a_slow_ramp_shows_the_viscosity_and_a_third_of_the_inertia(case):
    ramp = "walls.top={times: [0.0, 10.0], velocities: [0.0, 1.0]}"
    found, channel = layers_of(case, "geometry={gap: 0.5, length: 0.5}", ramp, "time={end: 5.0}")
    _, stress = wall_shear(channel, SimpleNamespace(t=5.0, y=found.heights, u=found.velocity))
    # u = a t y/gap + a/(6 nu gap) (y^3 - gap^2 y) after the start: a cubic, for which the operators are exact
    assert stress == pytest.approx(1.0 + 2.0 * 0.1 * 0.5 / 3.0, rel=1e-9)


def test_a_stress_may_drive_the_other_wall(case):
    plate = "walls.bottom={times: [0.0, 0.15], stresses: [0.5, 0.0]}"
    settings, channel = case(plate, "walls.top={times: [0.0, 0.2], velocities: [0.0, 1.0]}")
    found = start_of_layers(settings, channel)
    found.run_to(settings.time.end)
    assert found.control.jump_times == [0.15, 0.2]
    assert error(found, channel) < 3e-5  # measured: 6.4e-6


@pytest.mark.parametrize(
    ("text", "walls", "upside_down", "bound"),
    [(CASE, TRIANGLE, UPSIDE_DOWN, 1e-14), (DRIVEN, HEAVY, DRIVEN_UPSIDE_DOWN, 1e-12)],
    ids=["velocity", "stress"],
)
def test_either_wall_may_be_the_one(case, text, walls, upside_down, bound):
    one, other = (layers(*case(each, text=text)) for each in (walls, upside_down))
    assert apart(one.velocity, other.velocity[::-1]) < bound


def particles(settings, channel):
    """The last snapshot of a run, and its number of steps."""
    runtime.start("f64", 1)
    scheme = registry.load("schemes", settings.scheme.type).build(settings, channel, [settings.time.end], True)
    scheme.start(*start_values(channel, settings.initial))
    return run(scheme), scheme.steps


# measured: 7.7e-5, 1.1e-5, 1.7e-4 and 3.7e-5; the error of 20 layers
@pytest.mark.parametrize(
    ("overrides", "bound"),
    [
        pytest.param([THINNING], 1e-3, id="thinning"),  # measured: 5.4e-5, and 3.2e-4 of the way
        pytest.param([HEAVY], 2e-4, id="heavy"),
        pytest.param([HEAVY, NEWTONIAN], 2e-4, id="newtonian"),
        pytest.param([RECOVERY], 1e-3, id="recovery"),
        pytest.param([HEAVY, "drive={acceleration: 3.0}"], 2e-4, id="heavy_driven"),
    ],
)
def test_layers_meet_the_reference(driven, overrides, bound):
    settings, channel = driven(*overrides)
    found = layers(settings, channel)
    wall, end = found.walls.stress_controlled[0], settings.time.end
    assert apart(found.velocity, channel.exact_velocity(found.heights, end)) < bound
    nodes, weights = np.polynomial.legendre.leggauss(24)
    halves = [0.25 * end * (nodes + 1.0), 0.25 * end * (nodes + 3.0)]  # the stress jumps in the middle, or not
    way = 0.25 * end * sum(float(weights @ channel.exact_velocity(channel.gap, half)) for half in halves)
    assert wall.displacement == pytest.approx(way, rel=bound)


SLOW = ["walls.top.shear_stress=1e-5", "time.end=0.2", "discretisation.particles_across=12"]


@pytest.mark.parametrize(
    ("text", "overrides", "bound"),
    [(CASE, ["walls.top.velocities=[1e-6, 1e-6, 0.0]"], 1e-6), (DRIVEN, SLOW, 1e-7), (DRIVEN, [*SLOW, HEAVY], 1e-7)],
    ids=["velocity", "massless", "heavy"],
)
def test_particles_that_hardly_move_do_what_layers_do_and_disorder_does_little(case, text, overrides, bound):
    settings, channel = case(*overrides, text=text)
    reference, (last, steps) = layers(settings, channel), particles(settings, channel)
    order = np.argsort(last.y, kind="stable")
    lines = np.array([last.u[row].mean() for row in np.array_split(order, 12)])
    assert apart(lines, reference.velocity) < bound  # what residuals of linear systems leave
    assert steps == reference.steps
    jittered, _ = particles(*case(*overrides, "initial.jitter=0.2", text=text))
    lattice = apart(last.u, channel.exact_velocity(last.y, last.t))
    assert apart(jittered.u, channel.exact_velocity(jittered.y, jittered.t)) < 3.0 * lattice


def test_the_shear_rate_of_a_shear_thinning_fluid_follows_the_stress(driven):
    wall = layers(*driven(THINNING, "time.end=0.1")).walls.stress_controlled[0]
    moment = SimpleNamespace(stress=lambda t: 1.0 + 2.0 * t)
    wall.control = SimpleNamespace(after=lambda t: moment, slope=lambda t: 2.0)
    wall.jump(0.5)
    rate, step = wall.rate, 1e-5
    # stresses are over the density: half the root of the rate is 2 there, and grows by 2 in a unit of time
    assert (rate, wall.change) == pytest.approx((16.0, 32.0), rel=1e-5)
    wall.stress = moment.stress(0.5 + step)
    wall.balance(rate)
    assert (wall.shear_rate - rate) / step == pytest.approx(32.0, rel=1e-4)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_massless_wall_moves_with_the_fluid_near_it(sign):
    # u = U + s (u_y d + u_yyy d^3 / 6) at the distance d, s the normal's sign: exact for any weights
    distance = np.array([0.1, 0.25, 0.4, 0.7])
    velocity = 2.0 + sign * (0.3 * distance - 1.7 * distance**3 / 6.0)
    near, weights = np.array([3, 1, 0, 2]), np.array([0.4, 0.3, 0.2, 0.1])
    wall = SimpleNamespace(normal_sign=sign, near=near, distance=distance[near], weights=weights)
    found = MasslessWall.fitted_velocity(wall, velocity, 0.3, -1.7)
    assert found == pytest.approx(2.0, rel=1e-14)
