"""What operators of degree 4 miss: nothing of such polynomials, and terms of degree 5 at the distance of a spacing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tisph.geometry.wanted_spacing import WantedSpacing
from tisph.measures.indicator import missed
from tisph.snapshot import Snapshot

SPEED = 2.0


def box(rows, polymer=False):
    flow = {"origin": (0.0, 0.0), "bodies": (), "extent": (1.0, 1.0), "periodic": (False, False), "spacing": 1 / rows}
    scene = SimpleNamespace(**flow, wanted_spacing=WantedSpacing(1 / rows), reference_velocity=SPEED, polymer=polymer)
    scene.seen = lambda snapshot: scene
    return scene


def scattered(rows, u, v):
    """Particles off a lattice by up to a fifth of a spacing, with velocities that are functions of x and y."""
    y, x = (
        np.indices((rows, rows)).reshape(2, -1) + 0.5 + np.random.default_rng(0).uniform(-0.2, 0.2, (2, rows**2))
    ) / rows
    return Snapshot(t=0.0, step=0, x=x, y=y, u=u(x, y), v=v(x, y), density=np.ones_like(x), pressure=0 * x)


def test_polynomials_of_degree_four_are_not_missed():
    state = scattered(12, lambda x, y: x**4 - y**3 * x, lambda x, y: 3 * y**4)
    # rounding errors of velocities of order 1, fitted over a few spacings by matrices of condition numbers up to 1e6
    assert missed(box(12), state).max() < 1e-10


@pytest.mark.parametrize("rows", [12, 24])
def test_terms_of_degree_five_count_over_the_reference_velocity(rows):
    state = scattered(rows, lambda x, y: 3 * x**5, lambda x, y: 4 * x**2 * y**3)
    assert missed(box(rows), state) == pytest.approx(5.0 * rows**-5.0 / SPEED, rel=1e-3)


def test_small_particles_miss_less():
    state = scattered(12, lambda x, y: x**5, lambda x, y: 0 * x)
    small = replace(state, area=np.full_like(state.x, (0.5 / 12) ** 2))
    assert missed(box(12), small) == pytest.approx(missed(box(12), state) / 32)


def test_stress_counts_over_its_root_mean_square():
    state = scattered(12, lambda x, y: 0 * x, lambda x, y: 0 * x)
    stretched = replace(state, stress_xx=1 + 0 * state.x, stress_xy=7 * state.x**5, stress_yy=0 * state.x)
    size = np.sqrt(np.mean(1 + 49 * state.x**10))
    assert missed(box(12, polymer=True), stretched) == pytest.approx(7 * 12**-5.0 / size, rel=1e-3)
