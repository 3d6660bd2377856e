"""What runs are held to: which numbers pass and which fail."""

import math

import h5py
import numpy as np
import pytest
from fake_runs import make_result

from tisph.studies.verification.criteria import (
    at_least,
    at_most,
    closes,
    near,
    order,
    same_bits,
    same_velocities,
    share,
)


def test_a_bound_passes_at_the_bound_and_fails_above():
    criterion = at_most("lattice", 0.018, "l2", 1.5e-3)
    assert criterion.judge(make_result(t18=1.5e-3)).passed
    assert not criterion.judge(make_result(t18=1.51e-3)).passed


def test_a_least_value_passes_at_the_bound_and_fails_below():
    criterion = at_least("vortex", 0.018, "l2", 0.55)
    assert criterion.judge(make_result(t18=0.55)).passed
    assert not criterion.judge(make_result(t18=0.549)).passed
    assert not criterion.judge(make_result(t18=None)).passed


@pytest.mark.parametrize("energy", [0.11, 0.09])
def test_a_number_is_off_its_exact_value_by_a_fraction_of_that(energy):
    result = make_result(t18=1e-3)
    result.summary["samples"][0] |= {"kinetic_energy": energy, "kinetic_energy_exact": 0.1}
    criterion = at_most("vortex", 0.018, "kinetic_energy off exact", 0.05)
    assert criterion.judge(result).value == pytest.approx(0.1, rel=1e-12)
    result.summary["samples"][0]["kinetic_energy"] = None
    assert not criterion.judge(result).passed


def test_transverse_velocity_is_measured_in_wall_speeds():
    check = at_most("long", 1.0, "transverse", 1e-6).judge(make_result(speed=0.5, t1000=0.0))
    assert check.value == pytest.approx(2e-7, rel=1e-14)
    assert check.passed


@pytest.mark.parametrize("ours", [{}, {"t27": 1e-9}, {"t18": None}])
def test_a_run_without_the_number_fails(ours):
    """It stopped before the sample, or its velocities are not finite."""
    stopped, good = make_result(**ours), make_result(t18=1e-3)
    for criterion, results in (
        (at_most("a", 0.018, "l2", 1.0), [stopped]),
        (near("a", "b", 0.018, 0.05), [stopped, good]),
        (near("a", "b", 0.018, 0.05), [good, stopped]),
        (order("a", {"a": 25, "b": 50}, 0.018, 1.0), [good, stopped]),
        (share("a", "b", 0.018, 0.5), [stopped, good]),
        (closes("a", 0.01), [stopped]),
    ):
        check = criterion.judge(*results)
        assert math.isnan(check.value)
        assert not check.passed


def test_nearness_is_two_sided():
    criterion = near("other", "lattice", 0.018, 0.05)
    for factor, passed in ((1.049, True), (0.951, True), (1.051, False), (0.949, False)):
        assert criterion.judge(make_result(t18=factor * 1e-3), make_result(t18=1e-3)).passed is passed


@pytest.mark.parametrize(("power", "passed"), [(1.9, True), (1.8, False)])
def test_order_is_the_power_with_which_the_error_falls(power, passed):
    resolutions = {"a": 25, "b": 50, "c": 100}
    results = [make_result(t27=3.0 * number**-power) for number in resolutions.values()]
    check = order("a/b/c", resolutions, 0.027, 1.85).judge(*results)
    assert check.value == pytest.approx(power, rel=1e-12)
    assert check.passed is passed


def test_the_order_is_that_of_the_quantity_asked_for():
    results = [make_result(t27=1e-3), make_result(t27=1e-3)]
    for result, error in zip(results, (8e-3, 1e-3), strict=True):
        result.summary["samples"][0]["shear_stress_l2"] = error
    assert order("a", {"a": 25, "b": 50}, 0.027, 1.7, "shear_stress_l2").judge(*results).value == pytest.approx(3.0)
    assert not order("a", {"a": 25, "b": 50}, 0.027, 1.7).judge(*results).passed


def test_a_share_is_of_the_other_runs_error():
    criterion = share("consistent", "comoving", 0.018, 0.5)
    assert criterion.judge(make_result(t18=0.5e-3), make_result(t18=1e-3)).passed
    assert not criterion.judge(make_result(t18=0.51e-3), make_result(t18=1e-3)).passed


@pytest.mark.parametrize(("closure", "passed"), [(0.01, True), (0.011, False), (None, False)])
def test_the_momentum_balance_closes_within_its_bound(closure, passed):
    result = make_result(t18=1e-3)
    result.summary["momentum"] = {"closure": closure}
    assert closes("a", 0.01).judge(result).passed is passed


def test_wall_shear_is_the_error_over_the_larger_stress():
    result = make_result(t18=1e-3)
    walls = {
        "wall_shear_bottom": 0.1,
        "wall_shear_bottom_exact": 0.1,
        "wall_shear_top": 1.97,
        "wall_shear_top_exact": 2.0,
    }
    result.summary["samples"][0] |= walls
    check = at_most("a", 0.018, "wall_shear", 0.01).judge(result)
    assert check.value == pytest.approx(0.015, rel=1e-12)
    assert not check.passed


def make_samples(folder, u, v=0.0):
    """A results folder with one sample of three particles."""
    folder.mkdir()
    with h5py.File(folder / "samples.h5", "w") as file:
        group = file.create_group("sample_000")
        group["x"] = np.array([0.1, 0.2, 0.3])
        group["u"] = np.array([0.0, 1.0, 2.0]) + u
        group["v"] = np.full(3, v)
    return folder


def test_velocities_are_compared_in_wall_speeds(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0), speed=0.5)
    shifted = make_result(make_samples(tmp_path / "b", 1e-7), speed=0.5)
    transverse = make_result(make_samples(tmp_path / "c", 0.0, v=-1e-6), speed=0.5)
    criterion = same_velocities("si", "reference", 1e-6)
    assert criterion.judge(shifted, reference).value == pytest.approx(2e-7, rel=1e-6)
    assert criterion.judge(shifted, reference).passed
    assert criterion.judge(transverse, reference).value == pytest.approx(2e-6, rel=1e-6)
    assert not criterion.judge(transverse, reference).passed


def test_one_bit_makes_a_difference(tmp_path):
    reference = make_result(make_samples(tmp_path / "a", 0.0))
    criterion = same_bits("repeat", "reference")
    assert criterion.judge(make_result(make_samples(tmp_path / "b", 0.0)), reference).passed
    one_bit = make_result(make_samples(tmp_path / "c", np.array([0.0, 2.3e-16, 0.0])))
    signed_zero = make_result(make_samples(tmp_path / "d", 0.0, v=-0.0))
    for different in (one_bit, signed_zero):
        assert criterion.judge(different, reference).value == 1
        assert not criterion.judge(different, reference).passed


def test_missing_arrays_are_not_equal_arrays(tmp_path):
    for criterion in (same_bits("a", "b"), same_velocities("a", "b", 1e-6)):
        nothing = make_result(tmp_path / "nothing")
        assert not criterion.judge(nothing, nothing).passed
