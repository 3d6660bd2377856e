"""Whether a flow is steady: slowest times of flows, and judgements of numbers that were made by hand."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.measures.steadiness import CHANGE, Followed, constant_since, steadiness, steady_since

CONFIGS = Path(__file__).parents[2] / "configs"
TIMES = np.linspace(0.0, 10.0, 201)


def flow(slowest=1.0, **changes):
    """A flow with one slow time."""
    usual = {"driven_periodically": False, "start_time": 0.0, "jump_times": (), "slow_times": {"slow time": slowest}}
    return SimpleNamespace(**usual | changes)


def judged(values, t=10.0, times=TIMES, **changes):
    return steadiness(flow(**changes), t, Followed(times, np.asarray(values)[:, None], {"drag": 1.0}))


def test_a_number_that_decays_is_steady_once_little_is_left():
    """Over the last 1, means of exp(-t) over thirds differ by 1.13 e^-t, more than the rest e^-t."""
    for t in np.arange(3.0, 10.5, 0.5):
        found, rest = judged(1.0 + np.exp(-TIMES), t), np.exp(-t)
        assert found.change > rest
        assert found.steady == (found.change <= CHANGE)
        assert not (found.steady and rest > CHANGE)


def test_a_polymer_is_steady_after_its_slowest_mode():
    """An Oldroyd-B cavity at t = 1: the energy rises within .1 of a time and then falls by 5 % until t = 2."""
    energy = np.where(TIMES > 0.0, 0.0115 * (1.0 + 0.05 * np.exp(-2.0 * TIMES)), 0.0)
    early = steadiness(flow(), 1.0, Followed(TIMES, energy[:, None], {"kinetic_energy": 0.01}))
    assert (early.steady, "kinetic energy changes by" in early.reason) == (False, True)
    assert judged(np.ones(201), 1.0).steady
    late = judged(np.ones(201), 1.0, slowest=1.2)
    assert late.reason == "the flow has run for 1, less than the slow time, 1.2"


def test_scatter_of_a_mean_is_no_change_of_a_steady_flow():
    scattered = 1.0 + 2e-3 * np.random.default_rng(0).normal(size=201)  # as means over 25 x 25 particles
    for rise, steady in ((0.0, True), (2e-3, False)):  # 12 standard errors of thirds of 100 records: 5e-3
        found = [judged(scattered + rise * (TIMES - 10.0), t, slowest=5.0).steady for t in np.arange(5.0, 10.5, 0.5)]
        assert all(found) if steady else not any(found)


def test_a_bend_after_a_start_is_no_scatter():
    noise = 1e-4 * np.random.default_rng(0).normal(size=201)
    falling = 1.0 + 0.05 * np.exp(-0.4 * TIMES)
    assert not judged(falling * (1.0 + noise), slowest=10.0).steady


def test_a_number_that_swings_is_not_steady():
    swinging = 1.0 + 0.05 * np.sin(9.0 * TIMES)
    found = judged(swinging, slowest=7.0)
    assert (found.steady, "goes up and down" in found.reason) == (False, True)


def test_a_jump_of_the_drive_begins_the_time_anew():
    jumps = {"jump_times": (0.0, 9.5, 20.0)}
    assert judged(np.ones(201), **jumps).reason == "the flow has run for 0.5, less than the slow time, 1"
    assert judged(np.ones(201), 9.0, **jumps).steady


def test_a_number_beside_a_larger_one_of_its_kind_may_scatter():
    values = np.stack([np.ones(201), 5e-4 * TIMES], axis=1)
    together, alone = ({"drag": 1.0, "lift": size} for size in (1.0, 2.0))
    assert steadiness(flow(), 10.0, Followed(TIMES, values, together)).steady
    assert not steadiness(flow(), 10.0, Followed(TIMES, values, alone)).steady


def test_few_records_are_no_judgement():
    few = np.linspace(0.0, 10.0, 9)
    assert judged(np.ones(9), times=few).reason == "the history has too few times"
    assert steadiness(flow(), 10.0, None).reason == "the history has too few times"


def test_constant_is_what_does_not_change_for_a_tenth_of_the_run():
    times = np.linspace(0.0, 1.0, 101)
    values = np.stack([1.0 - np.exp(-20.0 * times), 5.0 + 0.0 * times], axis=1)
    # exp(-20 t) = 1e-3 at 0.345
    assert constant_since(times, values, [1.0, 1.0]) == pytest.approx(0.35)
    assert constant_since(times, np.stack([times, times], axis=1), [1.0, 1.0]) is None
    assert constant_since(times, 1e3 * values, [1e3, 1e3]) == pytest.approx(0.35)  # a thousandth of their size counts
    assert constant_since(times, np.where(times[:, None] > 0, values[:, :1], np.nan), [1.0]) == pytest.approx(0.35)


def test_steady_since_needs_the_slowest_time():
    numbers = Followed(TIMES, np.ones((201, 1)), {"drag": 1.0})
    assert steady_since(flow(), numbers) == 0.0
    assert steady_since(flow(11.0), numbers) is None


RELAXATION, VISCOUS, CONVECTIVE = "longest relaxation time", "time of viscous decay", "convective time of moving bodies"


@pytest.mark.parametrize(
    ("config", "times"),
    [
        ("confined_cylinder_refined", {RELAXATION: 0.47}),  # without inertia
        ("confined_cylinder_oldroyd_b", {RELAXATION: 0.3, VISCOUS: 2.0**2 / (np.pi**2 * 1.25)}),
        ("two_mode_couette", {RELAXATION: 1.0, VISCOUS: 1 / (np.pi**2)}),  # the other mode has 0.1
        ("free_cylinder", {VISCOUS: 2 / np.pi**2, CONVECTIVE: 0.5}),
        ("cavity_regular", {VISCOUS: 1.0 / (5.0 * np.pi**2 * 0.01)}),  # the second eigenvalue of a square
        ("eccentric_annulus", {VISCOUS: 3.2 / np.pi**2}),  # a circle turns in its place
        ("ellipse_refined", {CONVECTIVE: 0.4 / 1.5}),
    ],
)
def test_slow_times_of_a_flow(config, times):
    scene = scenes.of(load(CONFIGS / f"{config}.yaml"))
    assert scene.slow_times == pytest.approx(times, rel=1e-3)
    assert not scene.driven_periodically


@pytest.mark.parametrize("config", ["oscillating_wall_slow", "circular_oscillation", "womersley", "turned_box"])
def test_flows_that_oscillate_are_periodic_at_best(config):
    scene = scenes.of(load(CONFIGS / f"{config}.yaml"))
    assert "periodic" in steadiness(scene, 1e3, Followed(TIMES, np.ones((201, 1)), {"drag": 1.0})).reason
