"""Scatter of the forces on bodies from step to step, of forces that are known."""

import numpy as np
import pytest

from tisph.schemes._two_dimensional.wall_boundary import scatter


def test_a_cubic_force_over_uneven_steps_has_no_scatter():
    times = np.array([2.0, 1.7, 1.5, 1.1, 0.4, 0.3])
    forces = np.stack([1.0 + times - 0.3 * times**3, 0.0 * times], axis=1)[:, None]
    assert scatter(times, forces)[0] < 1e-14  # rounding, a few times 1e-16


def test_random_forces_have_the_scatter_they_were_made_with():
    # of 8 differences in each of 400 windows: the mean square is known to 1 / sqrt(1600), its root to half of that
    noise = np.random.default_rng(0).normal(scale=0.01, size=(400, 12, 2, 2)) * [[0.1], [1.0]]
    forces = np.array([[2.0, 0.0], [1.0, 0.0]]) + noise
    found = [scatter(np.linspace(1.0, 0.0, 12), each) for each in forces]
    assert {number for _, number in found} == {1}
    measured = np.sqrt(np.mean([value**2 for value, _ in found]))
    # over the larger force, 2; both components count
    assert measured == pytest.approx(0.01 * np.sqrt(2.0) / 2.0, rel=0.05)


def test_few_steps_or_no_force_have_no_scatter():
    times = np.arange(4.0)[::-1]
    assert scatter(times, np.ones((4, 1, 2))) is None
    assert scatter(np.arange(6.0)[::-1], np.zeros((6, 1, 2))) is None
