"""Viscous systems of a channel: solved, in a bounded number of iterations where there are many particles."""

import numpy as np
import pytest
from case_from_text import to_end as run
from implicit_case import IMPLICIT

from tisph.numerics import least_squares as operators
from tisph.numerics.auxiliary_grid import DirichletGrid
from tisph.numerics.point_cloud import active
from tisph.runtime import real, view
from tisph.schemes.implicit.channel import operators as _operators
from tisph.simulation import checkpoint

pytestmark = pytest.mark.taichi

RESIDUAL = 1e-10
LONG = 30.0  # viscous number of a long step


@pytest.fixture
def two_levels(monkeypatch):
    """Let the solver of two levels serve the smallest channels, and the shortest steps."""
    monkeypatch.setattr(_operators, "FEW", 0)
    monkeypatch.setattr(_operators, "ROUGH", 0.0)


@pytest.fixture
def assembled(shared):
    """Return a function that gives a Scheme in disorder with its operators assembled."""

    def build(*overrides):
        scheme = shared(*IMPLICIT, *overrides)
        position = np.stack(scheme.channel.jittered(0, 0.2), 1)
        scheme.start(position, np.zeros_like(position))
        scheme.particles.arrange(0.0)
        return scheme

    return build


def solved(scheme, known, viscous_number, residual=RESIDUAL):
    """Solve for ``known`` from nothing; return solution and iterations."""
    solver, fluid = scheme.closed.solver, scheme.points.fluid
    view(solver.b)[:fluid], view(solver.x)[:fluid] = known, 0.0
    assert solver.solve(viscous_number * scheme.channel.spacing**2, residual)
    return view(solver.x)[:fluid].copy(), solver.iterations


@pytest.mark.parametrize(("across", "along"), [(1, 0), (1, 1), (5, 2), (11, 5)])
def test_a_wave_that_vanishes_at_the_walls_is_divided_by_its_eigenvalue(assembled, across, along):
    scheme = assembled()
    lattice = DirichletGrid(scheme.points, scheme.channel, scheme.channel.gap)
    nodes, (rows, columns) = lattice.nodes(real()), lattice.shape
    on_nodes = view(nodes)[: rows * columns].reshape(rows, columns)
    row, column = np.arange(rows)[:, None], np.arange(columns)
    wave = np.sin(np.pi * across * row / rows) * np.cos(2 * np.pi * along * column / columns + 0.3)
    on_nodes[...] = wave
    # the second differences of five points, the spacings being 1/12
    minus_laplacian = 4 * 12**2 * (np.sin(0.5 * np.pi * across / rows) ** 2 + np.sin(np.pi * along / columns) ** 2)
    lattice.invert(nodes, 1.0, 0.02)
    expected = wave / (1.0 + 0.02 * minus_laplacian)
    assert np.abs(on_nodes - expected).max() < 1e-14  # rounding of some 100 sums


def laplacian_of(scheme):
    """The rows of the Laplacian as a square matrix, ghosts having minus what they mirror: from products with units."""
    operators = scheme.closed
    return np.stack([operators.laplacian(unit) for unit in np.eye(scheme.points.fluid)], 1)


@pytest.mark.parametrize("overrides", [(), ("walls.treatment.type=virtual_image",)], ids=["mirrored", "virtual"])
def test_two_levels_solve_what_the_rows_say(two_levels, assembled, overrides):
    scheme = assembled(*overrides)
    matrix = np.eye(scheme.points.fluid) - LONG * scheme.channel.spacing**2 * laplacian_of(scheme)
    known = np.random.default_rng(0).uniform(-1.0, 1.0, scheme.points.fluid)
    scheme.closed.solver.roughest = 0.0  # it may have been built for another test
    found, _ = solved(scheme, known, LONG)
    assert scheme.closed.solver.two_level is not None
    # what a residual of this size can mean, and rounding of the residual that the recursion carries
    farthest = np.linalg.norm(np.linalg.inv(matrix), 2) * RESIDUAL * np.linalg.norm(known)
    assert np.linalg.norm(found - np.linalg.solve(matrix, known)) <= 1.01 * farthest


# --- runs: with Schemes of their own, whose fields take the place of those above


def test_iterations_depend_neither_on_particles_nor_on_the_time_step(two_levels, make):
    # measured 4.5 and 4.5; with the diagonal alone 33 and 117
    counts = []
    for across in (12, 48):
        scheme = make(*IMPLICIT, f"discretisation.particles_across={across}", jitter=0.2)
        scheme.particles.arrange(0.0)
        x, y = active(scheme.particles.position).T
        known = np.random.default_rng(0).normal(size=across**2) + np.sin(np.pi * y) + np.cos(2 * np.pi * x)
        counts.append(max(solved(scheme, known, number)[1] for number in (1.0, LONG, across**2)))
    assert counts[1] <= 1.5 * counts[0]
    assert counts[1] < 8


def flow(make, *overrides, **words):
    return make(*IMPLICIT, "initial.jitter=0.2", "time.end=4.0", *overrides, **words)


@pytest.mark.other_program
def test_one_and_two_threads_and_a_restart_are_bitwise_reproducible(two_levels, make, monkeypatch, tmp_path):
    for name in ("FEW", "FEW_NUMBERS"):
        monkeypatch.setattr(operators, name, 0)  # or small loops would stay on one thread
    one = flow(make)
    for _ in range(6):
        one.advance()
    checkpoint.save(tmp_path / "state.h5", one, "fingerprint")
    whole = run(one)
    resumed = flow(make, started=False)
    checkpoint.restore(tmp_path / "state.h5", resumed, "fingerprint")
    again, other = run(resumed), run(flow(make, "runtime.threads=2"))
    for name in ("t", "x", "y", "u", "v"):
        assert np.array_equal(getattr(again, name), getattr(whole, name)), name
        assert np.array_equal(getattr(other, name), getattr(whole, name)), name
