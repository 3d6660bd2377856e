"""Weights of steps of any length, and how long steps are."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph.cli.check import estimates
from tisph.config import load
from tisph.schemes._step_control import LARGEST_MULTISTEP_FACTOR
from tisph.schemes._two_dimensional import BETWEEN_WALLS, COST, OVERHEAD, STARTED, _guessed_steps
from tisph.schemes._two_dimensional.step_limits import FIRST
from tisph.schemes._two_dimensional.time_levels import TimeWeights

STEPS = [0.3, 0.25, 0.2, 0.28]
NOW = 1.7


@pytest.fixture
def times():
    return TimeWeights(STEPS, STEPS[0])


def values(function, first=0):
    """Values at the ends of the steps before now, newest first."""
    return function(NOW - np.cumsum(STEPS))


def test_differences_of_third_order_are_exact_for_cubics(times):
    leading, back = times.bdf()
    rate = (leading * NOW**3 - back @ values(lambda t: t**3)) / STEPS[0]
    assert rate == pytest.approx(3 * NOW**2, rel=1e-12)
    assert back[3] == 0.0


def test_differences_of_equal_steps_are_those_of_the_books():
    leading, back = TimeWeights([0.1] * 4, 0.1).bdf()
    assert leading == pytest.approx(11 / 6, rel=1e-12)
    assert back == pytest.approx([3, -3 / 2, 1 / 3, 0], abs=1e-12)


def test_the_path_is_exact_for_cubic_velocities(times):
    way = times.step_integral() @ values(lambda t: t**3)
    assert way == pytest.approx((NOW**4 - (NOW - STEPS[0]) ** 4) / 4, rel=1e-12)


def test_values_between_are_exact_for_cubics(times):
    assert times.interpolation(0.1, 4) @ values(lambda t: t**3) == pytest.approx((NOW - 0.1) ** 3, rel=1e-12)
    assert times.extrapolation(2) @ values(lambda t: 2 * t)[:2] == pytest.approx(2 * NOW, rel=1e-12)


def test_values_that_are_not_known_yet_weigh_nothing():
    weights = TimeWeights([0.1, 0.1], 0.1).step_integral()
    assert weights == pytest.approx([0.15, -0.05, 0, 0], abs=1e-12)


def test_the_error_is_that_of_the_differences(times):
    # of t^4, whose error the differences of third order make in a step: (rate of the differences - rate) h / g
    leading, back = times.bdf()
    before = values(lambda t: t**4)
    found = (back @ before + STEPS[0] * 4 * NOW**3) / leading
    error, order = times.step_error(NOW**4 - times.extrapolation(4) @ before, leading, 1.0)
    assert order == 3
    assert error == pytest.approx(abs(found - NOW**4), rel=1e-9)


FLOWS = {
    "scene: taylor_green\ngeometry: {length: 1.0}\ninitial: {velocity: 1.0}": (400, 1.0),
    "scene: cavity\ngeometry: {width: 1.0, height: 1.0}\nwalls: {lid: {velocity: 1.0}}": (400, BETWEEN_WALLS),
    "scene: annulus\ngeometry: {inner_radius: 1.0, outer_radius: 2.0}\nwalls: {inner: {angular_velocity: 1.0}}": (
        round(3 * math.pi * 400),
        BETWEEN_WALLS,
    ),
}


def test_every_start_of_an_unknown_flow_costs_its_growing_steps():
    scene = SimpleNamespace(
        reference_velocity=1.0, bodies=(), rheology=None, spacing=0.1, start_time=0.0, axisymmetric=False
    )
    found = []
    for changes in ((), (2.0,), (0.5,)):
        scene.jump_times = changes
        found += _guessed_steps(scene, [1.0], 2e-6, 0.2)
    grow = math.log(1.0 / FIRST) / math.log(LARGEST_MULTISTEP_FACTOR) - 1.0 / (1.0 - 1.0 / LARGEST_MULTISTEP_FACTOR)
    assert found == [round(STARTED + 50 + grow), round(STARTED + 50 + grow), round(STARTED + 50 + 2 * grow)]


def test_flow_around_the_axis_takes_no_step_shorter():
    """Of configs/taylor_vortices.yaml: 223 measured up to t = 40; by the speed of the wall it would be 1040."""
    sample = estimates(load(Path(__file__).parents[2] / "configs" / "taylor_vortices.yaml"))["samples"][1]
    assert sample.steps < 223 < sample.steps_range(sample.steps)[1] < 1040


def test_a_tight_tolerance_costs_more_steps_at_the_start():
    """By its fourth root, the errors of a step being of fourth order: 3e-4 in place of 2e-6 is a factor of 3.5."""
    config = Path(__file__).parents[2] / "configs" / "cylinder_in_channel.yaml"
    tight, loose = (
        estimates(load(config, [f"time.tolerance={tolerance}", "time.end=1e-3", "time.samples=[1e-3]"]))["steps"]
        for tolerance in (2e-6, 3e-4)
    )
    assert tight - loose == pytest.approx(STARTED * (1.0 - (2e-6 / 3e-4) ** 0.25), abs=1.0)


@pytest.mark.parametrize("flow", FLOWS, ids=lambda flow: flow.split()[1])
def test_a_particle_between_walls_is_stated_to_cost_more(flow, tmp_path):
    """Measured: 1.3 to 2.3 times as much in the annulus as in the vortex, 5900 particles each."""
    liquid = "fluid: {density: 1.0, kinematic_viscosity: 0.01}"
    (tmp_path / "case.yaml").write_text(
        f"{flow}\n{liquid}\ndiscretisation: {{particles_across: 20}}\ntime: {{end: 1.0}}"
    )
    found, (particles, factor) = estimates(load(tmp_path / "case.yaml")), FLOWS[flow]
    assert found["run_time"] == pytest.approx(found["steps"] * (OVERHEAD + particles * factor * COST), rel=1e-14)
