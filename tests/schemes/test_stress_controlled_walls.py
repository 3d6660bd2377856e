"""Stress-controlled walls, scheme implicit: against the reference, on layers and on disordered particles."""

from types import SimpleNamespace

import numpy as np
import pytest
from implicit_case import channel_of, layers, run

from tisph import registry, runtime
from tisph.schemes._channel.stress_controlled import MasslessWall
from tisph.simulation.state import start_values

pytestmark = pytest.mark.taichi

CASE = """
scene: channel
fluid:
  density: 2.0
  kinematic_viscosity: 0.5
  rheology: {type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.2}
geometry: {gap: 1.0, length: 1.0}
walls: {top: {shear_stress: 1.0}}
discretisation: {particles_across: 20}
scheme: {type: implicit}
time: {end: 1.0}
runtime: {threads: 1}
"""
HEAVY = "walls.top.mass_per_area=2.0"
RECOVERY = "walls.top={times: [0.0, 0.5], stresses: [1.0, 0.0]}"
NEWTONIAN = "fluid.rheology={type: newtonian}"


@pytest.fixture
def case(tmp_path):
    """Return a function that gives a config and its channel of overrides."""

    return lambda *overrides: channel_of(tmp_path, CASE, overrides)


def particles(settings, channel):
    """The last snapshot of a run."""
    runtime.start("f64", 1)
    kind = registry.load("schemes", settings.scheme.type).build
    scheme = kind(settings, channel, [settings.time.end], True)
    scheme.start(*start_values(channel, settings.initial))
    return run(scheme)


def apart(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


# measured: 2.5e-5, 7.7e-5, 1.1e-5, 1.7e-4 and 3.7e-5; the error of 20 layers
@pytest.mark.parametrize(
    ("overrides", "bound"),
    [
        pytest.param([], 2e-4, marks=pytest.mark.slow, id="creep"),  # how recovery begins
        pytest.param([HEAVY], 2e-4, id="heavy"),
        pytest.param([HEAVY, NEWTONIAN], 2e-4, id="newtonian"),
        pytest.param([RECOVERY], 1e-3, id="recovery"),
        pytest.param([HEAVY, "drive={acceleration: 3.0}"], 2e-4, id="heavy_driven"),
    ],
)
def test_layers_meet_the_reference(case, overrides, bound):
    settings, channel = case(*overrides)
    found = layers(settings, channel)
    wall, end = found.walls.stress_controlled, settings.time.end
    assert apart(found.velocity, channel.exact_velocity(found.heights, end)) < bound
    nodes, weights = np.polynomial.legendre.leggauss(24)
    halves = [0.25 * end * (nodes + 1.0), 0.25 * end * (nodes + 3.0)]  # the stress jumps in the middle, or not
    way = 0.25 * end * sum(float(weights @ channel.exact_velocity(channel.gap, half)) for half in halves)
    assert wall.displacement == pytest.approx(way, rel=bound)


@pytest.mark.parametrize("overrides", [[], [HEAVY]], ids=["massless", "heavy"])
def test_particles_do_what_layers_do_and_disorder_does_little(case, overrides):
    slow = ["walls.top.shear_stress=1e-5", "time.end=0.2", "discretisation.particles_across=12", *overrides]
    settings, channel = case(*slow)
    reference, last = layers(settings, channel), particles(settings, channel)
    order = np.argsort(last.y, kind="stable")
    lines = np.array([last.u[row].mean() for row in np.array_split(order, 12)])
    assert apart(lines, reference.velocity) < 1e-7  # what residuals of linear systems leave
    jittered = particles(*case(*slow, "initial.jitter=0.2"))
    exact = channel.exact_velocity(jittered.y, jittered.t)
    lattice = apart(last.u, channel.exact_velocity(last.y, last.t))
    assert apart(jittered.u, exact) < 3.0 * lattice


def test_either_wall_may_be_the_one(case):
    flipped = "walls={bottom: {shear_stress: 1.0, mass_per_area: 2.0}, top: {velocity: 0.0}}"
    one, other = layers(*case(HEAVY)), layers(*case(flipped))
    assert apart(one.velocity, other.velocity[::-1]) < 1e-12


def test_images_in_a_massless_wall_use_its_curvature_others_the_slope(case):
    other, massless = layers(*case("time.end=0.1")).walls
    assert massless.second[1] != 0.0
    assert massless.state_excess(1) == (massless.state[1], massless.second[1])
    assert other.state_excess(1) == (other.slope[1], 0.0)


def test_the_shear_rate_of_a_shear_thinning_fluid_follows_the_stress(case):
    thins = "fluid.rheology={type: power_law, index: 0.5, reference_rate: 1.0, least_rate: 1e-3}"
    wall = layers(*case(thins, "time.end=0.1")).walls.stress_controlled
    moment = SimpleNamespace(stress=lambda t: 1.0 + 2.0 * t)
    wall.control = SimpleNamespace(after=lambda t: moment, stress_rate=lambda t: 2.0)
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
