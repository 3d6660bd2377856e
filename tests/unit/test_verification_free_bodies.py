"""What the suite of bodies that the flow carries holds runs to: reference values, and how results are read."""

import math
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from ruamel.yaml import YAML
from scipy.integrate import quad

from tisph.config import load
from tisph.errors import ConfigError
from tisph.studies.processes import Result
from tisph.studies.verification import free_bodies, free_bodies_cases, free_bodies_long, suite


def run_with(last=None, samples=(), **fields):
    """A finished run whose bodies had these ``fields`` at its samples."""
    summary = {"status": "done", "samples": [*samples, *([last] if last else [])]}
    return SimpleNamespace(
        last=last or {"t": 1.0}, summary=summary, bodies=lambda field: np.array(fields[field], dtype=float)
    )


STOPPED = SimpleNamespace(last=None, summary={"status": "diverged", "samples": []}, bodies=None)


def row(name, words):
    """The one row of a run that has these words."""
    (found,) = [each for each in free_bodies.criteria(False) if each.case == name and words in each.quantity]
    return found


def test_added_mass_of_far_circles_is_that_of_one():
    """J. C. Maxwell's mixture, (1 - phi)/(1 + phi), is exact up to terms in phi^4."""
    for fraction in (1e-3, 1e-2):
        maxwell = (1 - fraction) / (1 + fraction)
        assert free_bodies.added_mass(fraction) == pytest.approx(maxwell, abs=2 * fraction**4 + 1e-12)


def test_circles_that_almost_touch_carry_all_fluid_along():
    """The gaps conduct nothing then, as far as six digits of the coefficients reach: s falls from 0.21 to 0.04."""
    fraction = 0.7853
    assert free_bodies.added_mass(fraction) == pytest.approx((1 - fraction) / fraction, abs=0.05 / fraction)


def test_an_ellipse_turns_once_in_the_time_of_its_series():
    """17.11633 over shear rate; the coefficients have six digits, the slowest rotation is 0.17."""
    time, _ = quad(lambda angle: -1 / free_bodies.ellipse_rotation(angle), 0.0, 2 * math.pi)
    assert time == pytest.approx(17.11633, rel=2e-5)
    assert free_bodies.ellipse_rotation(0.0) == pytest.approx(-0.166961, abs=1e-5)


def test_a_released_body_is_read_at_the_time_of_its_row():
    expected = -1.0 / (2.0 + free_bodies.added_mass(math.pi / 16))
    speeds = [[[0.0, expected * time * factor]] for time, factor in ((1e-5, 1.0), (0.01, 1.01))]
    run = run_with(velocity=speeds)
    first, early = row("released_2", "to 1e-05"), row("released_2", "to 0.01")
    assert first.judge(run).value == pytest.approx(0.0, abs=1e-12)
    assert early.judge(run).value == pytest.approx(0.01, rel=1e-9)
    assert (first.judge(run).passed, early.judge(run).passed) == (True, False)


def test_resistance_is_that_against_fluid_and_body_together():
    criterion = row("driven_0.2", "force")
    run = run_with({"t": 0.03, "superficial_velocity": -0.2}, velocity=[[[0.7, 0.0]]])
    assert criterion.judge(run).value == pytest.approx(1 / 0.9 - 1, rel=1e-12)


def test_stress_is_the_force_on_both_walls():
    config = free_bodies_cases.FULL["free_shear_long"]
    run = run_with({"t": 0.02, "drag_bottom": 20.0, "drag_top": -22.0})
    assert free_bodies.wall_stress(run, config) == pytest.approx(1.05, rel=1e-12)


def test_the_second_of_a_pair_mirrors_the_first():
    u, v = free_bodies_cases.PAIR_VELOCITY
    run = run_with(velocity=[[[u, v], [-u, -v], [0.5, 0.0], [-0.5, 0.0]]])
    criterion = row("pair", "velocities off, over")
    assert criterion.judge(run).value == pytest.approx(0.0, abs=1e-15)
    assert not criterion.judge(run_with(velocity=[[[u, v], [u, v]]])).passed


@pytest.mark.parametrize(("factor", "passed"), [(1.0, True), (1.01, False)])
def test_momentum_that_a_body_loses_is_found(factor, passed):
    """Constant net forces on both, and velocities by them or 1 % more."""
    times, density, load = np.linspace(0.06, 6.0, 100), 3.0, 0.02
    mass = density * math.pi * 0.1**2
    net = 0.25 * load * np.array([1.0, -1.0])
    force = np.tile(np.stack([net - [load, -load], [0.0, 0.0]], axis=1), (100, 1, 1))
    velocity = np.zeros((100, 2, 2))
    velocity[..., 0] = factor * times[:, None] * net / mass
    samples = [{"t": time, "superficial_velocity": 0.0} for time in times]
    run = run_with(samples[-1], samples[:-1], velocity=velocity, force=force)
    check = row("drawn_apart_3", "off its impulse").judge(run)
    assert check.passed == passed
    assert check.value == pytest.approx(0.25 * (factor - 1), abs=1e-12)
    assert row("drawn_apart_3", "fluid and bodies").judge(run).value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("criteria", [free_bodies.criteria(False), free_bodies_long.criteria()], ids=["all", "long"])
def test_no_row_of_a_run_that_stopped_passes(criteria):
    for criterion in criteria:
        check = criterion.judge(*(STOPPED for _ in criterion.runs))
        assert math.isnan(check.value)
        assert not check.passed


@pytest.mark.parametrize("part", suite.LONG)
def test_long_runs_are_valid_and_needed(part, tmp_path):
    runs, criteria = suite.one(part, long=True)
    assert {name for criterion in criteria for name in criterion.runs} == set(runs)
    for name, config in runs.items():
        path = tmp_path / f"{name}.yaml"
        YAML(typ="safe", pure=True).dump({"name": name, **config}, path)
        assert load(path).time.samples == tuple(config["time"]["samples"])


def test_the_published_flows_have_their_reynolds_numbers():
    """40 of gap and walls; 25, and 1 of the ellipse; the disc settles in a box of 2 x 6."""
    migration, ellipse, disc = (
        free_bodies_long.CASES[name] for name in ("migration", "turning_ellipse", "settling_disc")
    )
    assert 1.0 / migration["fluid"]["kinematic_viscosity"] == pytest.approx(40.0)
    assert 1.0 / ellipse["fluid"]["kinematic_viscosity"] == pytest.approx(25.0)
    half_axis = max(ellipse["bodies"][0]["half_axes"])
    assert 4 * half_axis**2 / ellipse["fluid"]["kinematic_viscosity"] == pytest.approx(1.0)
    corners = np.array(disc["walls"]["around"]["corners"])
    assert np.ptp(corners, axis=0).tolist() == [2.0, 6.0]
    assert disc["bodies"][0]["density"] == 1.25


def test_one_part_has_its_own_runs():
    runs, criteria = suite.one("free_bodies", quick=True)
    assert set(runs) == set(free_bodies_cases.QUICK)
    assert [one.quantity for one in criteria] == [one.quantity for one in free_bodies.criteria(True)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "free_bodys"}, "no suite 'free_bodys'; nearest: free_bodies; there are couette, "),
        ({"name": "couette", "long": True}, "couette has no runs of minutes; those that have: cavity, free_bodies"),
    ],
)
def test_a_part_that_does_not_exist_is_refused(arguments, message):
    with pytest.raises(ConfigError, match=message):
        suite.one(**arguments)


def test_fields_of_bodies_are_read_in_the_order_of_samples(tmp_path):
    with h5py.File(tmp_path / "samples.h5", "w") as file:
        for number in range(12):
            file[f"sample_{number:03d}/bodies/torque"] = [float(number), 0.5]
            file[f"sample_{number:03d}/u"] = np.zeros(7)
    found = Result(tmp_path, {}).bodies("torque")
    assert found.shape == (12, 2)
    assert found[:, 0].tolist() == [*range(12)]
