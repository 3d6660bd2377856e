"""Fluid that slips along the walls of a channel: against the exact flow, on layers and on particles."""

import numpy as np
import pytest
from case_from_text import to_end as run
from flows import flow_text
from implicit_case import channel_of, layers

from tisph import registry, runtime
from tisph.measures.channel import wall_shear
from tisph.simulation.state import start_values

pytestmark = pytest.mark.taichi

CASE = flow_text("channel_with_slip")
COUETTE = ["walls={bottom: {slip_length: 0.1}, top: {velocity: 1.0, slip_length: 0.05}}"]
POISEUILLE = ["walls={bottom: {slip_length: 0.1}, top: {slip_length: 0.05}}", "drive.acceleration=1.0"]
FILM = ["walls.top={slip_length: infinite}", "drive.acceleration=1.0"]
SWINGING = [
    "walls={bottom: {slip_length: 0.05}, top: {amplitude: 1.0, angular_frequency: 20.0, slip_length: 0.1}}",
    "initial.state=developed",
]
SCHEDULE = ["walls.top={times: [0.0, 0.05, 0.05], velocities: [1.0, 1.0, 0.0], slip_length: 0.1}"]
POLYMER = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.2, solvent_fraction: 0.3}"


@pytest.fixture
def case(tmp_path):
    """Return a function that gives a config and its channel of overrides."""
    return lambda *overrides: channel_of(tmp_path, CASE, overrides)


def error(found, channel):
    """Root mean square error of the velocities over the reference velocity."""
    wrong = found.velocity - channel.exact_velocity(found.heights, found.time)
    return float(np.sqrt(np.mean(wrong**2))) / channel.reference_velocity


# measured: 3.9e-6, 9.5e-7, 5.9e-7, 1.9e-6, 1.6e-6
@pytest.mark.parametrize(
    "flow",
    [[*COUETTE, "time.end=0.02"], POISEUILLE, FILM, SWINGING, SCHEDULE],
    ids=["couette", "poiseuille", "film", "swinging", "schedule"],
)
def test_layers_meet_the_exact_flow(case, flow):
    settings, channel = case(*flow)
    assert error(layers(settings, channel), channel) < 2e-5


@pytest.mark.parametrize("slip_length", [1e-5, 1e-2, 1e2])  # of 0.05 spacings and less, and of many gaps
def test_slip_of_any_length(case, slip_length):
    walls = f"walls={{bottom: {{slip_length: {slip_length}}}, top: {{velocity: 1.0, slip_length: {slip_length}}}}}"
    settings, channel = case(walls, "discretisation.particles_across=20")
    assert error(layers(settings, channel), channel) < 3e-6  # as without slip; measured: 2e-7 to 1e-6


def test_with_a_polymer_the_slip_follows_the_whole_stress(case):
    coarse, fine = (
        error(layers(*made), made[1])
        for made in (case(POLYMER, *COUETTE, f"discretisation.particles_across={across}") for across in (15, 30))
    )
    assert fine < 5e-5  # measured: 1.6e-5; slip by the shear rate alone would not converge
    assert fine < coarse / 2.0**3  # measured: 2^3.7


def test_particles_out_of_order_slip_as_layers_do(case):
    settings, channel = case(*COUETTE, "discretisation.particles_across=20", "initial.jitter=0.1")
    runtime.start("f64", 1)
    scheme = registry.load("schemes", "implicit").build(settings, channel, [settings.time.end], True)
    scheme.start(*start_values(channel, settings.initial))
    start = scheme.snapshot()
    # the stress of the wall is viscosity * speed / slip length before any fluid moves
    assert wall_shear(channel, start) == pytest.approx([0.0, 2.0 / 0.05], abs=1e-6)
    last = run(scheme)
    wrong = last.u - channel.exact_velocity(last.y, last.t)
    assert np.sqrt(np.mean(wrong**2)) < 1e-5  # measured: 2.8e-6
    assert wall_shear(channel, last) == pytest.approx(channel.exact_wall_shear(last.t), abs=1e-3)  # measured: 1.3e-4
    assert scheme.momentum_balance()["closure"] < 2e-3  # measured: 7e-4, with stages of third order in the first steps
