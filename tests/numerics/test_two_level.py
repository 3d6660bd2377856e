"""Linear systems in a periodic box: solved, in a bounded number of iterations, whatever the number of particles."""

import numpy as np
import pytest
from vortex_case import make

from tisph.numerics.point_cloud import active
from tisph.runtime import view

pytestmark = pytest.mark.taichi


def laplacian(scheme, values):
    """Rows of the Laplacian times ``values`` (fluid)."""
    points, fluid = scheme.points, scheme.points.fluid
    entries, listed = points.rows_of(slice(fluid))
    table = view(points.neighbours)[entries]
    near = listed & (table < fluid)
    difference = values[np.where(near, table, 0)] - values[:, None]
    return np.where(near, view(scheme.operators.laplacian)[entries] * difference, 0.0).sum(1)


def solve_pressure(scheme, source, tolerance):
    """Solve -L x = source from 0; return the solution and the iterations."""
    solver, fluid = scheme.equations.pressure, scheme.points.fluid
    view(solver.b)[:fluid], view(solver.x)[:fluid] = source, 0.0
    assert scheme.equations.solve_pressure(tolerance)
    return view(solver.x)[:fluid].copy(), solver.iterations


def test_what_is_found_solves_the_system_but_for_a_constant():
    scheme = make(24)
    source = np.random.default_rng(0).normal(size=576)
    solution, _ = solve_pressure(scheme, source, 1e-9)
    left = source + laplacian(scheme, solution)
    assert np.linalg.norm(left - left.mean()) < 2e-9 * np.linalg.norm(source)
    assert abs(solution.mean()) < 1e-12 * np.abs(solution).max()


@pytest.mark.parametrize("rough", [False, True])
def test_viscous_system(rough):
    scheme = make(24)
    solver, known = scheme.equations.velocity, np.random.default_rng(1).normal(size=(576, 2))
    view(solver.b)[:576], view(solver.x)[:576] = known, 0.0
    assert solver.solve(0.01, 1e-10, 2.0, None if rough else scheme.equations.for_velocity)
    for component in range(2):
        found = view(solver.x)[:576, component].copy()
        left = known[:, component] - 2.0 * found + 0.01 * laplacian(scheme, found)
        assert np.linalg.norm(left) < 2e-10 * np.linalg.norm(known)


def test_iterations_do_not_grow_with_the_number_of_particles():
    # measured 4 to 5; with the diagonal alone 35 to 113 in the same range
    counts = []
    for number in (24, 95):
        scheme = make(number)
        x, y = active(scheme.levels.position).T
        source = np.random.default_rng(2).normal(size=number**2) + np.sin(2 * np.pi * x) + np.cos(6 * np.pi * y)
        counts.append(solve_pressure(scheme, source, 1e-6)[1])
    assert counts[1] <= 1.5 * counts[0]
    assert counts[1] < 10


def test_viscous_iterations_do_not_grow_with_the_viscous_number():
    scheme = make(24)
    solver, known = scheme.equations.velocity, np.random.default_rng(3).normal(size=(576, 2))
    counts = []
    for viscous_number in (1.0, 10.0, 100.0, 1e4):
        view(solver.b)[:576], view(solver.x)[:576] = known, 0.0
        assert solver.solve(viscous_number / 24**2, 1e-10, 1.0, scheme.equations.for_velocity)
        counts.append(solver.iterations)
    assert max(counts) < 12
