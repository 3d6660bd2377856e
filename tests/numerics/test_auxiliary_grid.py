"""The grid that the pressure between walls is preconditioned with: what it solves, and when it is made anew."""

import numpy as np
import pytest
from annulus_case import INNER, OUTER, make

from tisph import runtime
from tisph.runtime import view
from tisph.schemes.implicit.planar.scheme import PlanarScheme

pytestmark = pytest.mark.taichi


def started():
    flow, places = make()
    runtime.start("f64", 1)
    scheme = PlanarScheme(flow, [1.0], True)
    scheme.start(places, np.zeros_like(places))
    return scheme


def test_grid_between_cylinders_solves_a_neumann_problem():
    """-lap p = 1/r d/dr(r d(cos)/dr) with a normal derivative of 0 at both cylinders, for p = cos(pi (r - inner))."""
    scheme = started()
    grid, fluid, particles = scheme.grid, scheme.problem.n_fluid, scheme.points.fluid
    wave, radius = np.pi / (OUTER - INNER), np.hypot(*(view(scheme.points.position)[:fluid] + scheme.problem.origin).T)
    phase = wave * (radius - INNER)
    preconditioner, source = scheme.equations.for_pressure, view(scheme.equations.pressure.input)
    source[:particles] = 0.0
    source[:fluid] = wave**2 * np.cos(phase) + wave * np.sin(phase) / radius
    preconditioner.restrict()
    grid.invert(preconditioner.nodes, 0.0, 1.0)
    rows, columns = grid.shape
    place = np.stack(np.divmod(np.arange(rows * columns), columns)[::-1], axis=1)
    place = place * [scheme.problem.length / columns, scheme.problem.height / rows] + scheme.problem.origin
    radius = np.hypot(*place.T)
    inside = (radius > INNER) & (radius < OUTER)
    found, exact = view(preconditioner.nodes)[: rows * columns][inside], np.cos(wave * (radius[inside] - INNER))
    # elements of a sixth of the gap: (wave h)^2/12 = 2 %, and as much by the parts of elements at walls
    assert np.std(found - exact) < 0.05 * np.std(exact)


def test_iterations_between_walls_are_few():
    """From zero, with a rough source."""
    scheme = started()
    solver, particles = scheme.equations.pressure, scheme.points.fluid
    view(solver.b)[:particles] = np.random.default_rng(0).normal(size=particles)
    view(solver.x)[:particles] = 0.0
    assert scheme.equations.solve_pressure(1e-6)
    assert solver.iterations <= 8  # measured 6.5


@pytest.mark.parametrize(("way", "anew"), [(0.5, False), (1.5, True)])
def test_grid_is_made_anew_where_walls_have_moved_a_spacing(way, anew, monkeypatch):
    scheme = started()
    walls, made = scheme.boundary, []
    monkeypatch.setattr(walls, "set_grid", made.append)
    spacing = scheme.problem.spacing
    monkeypatch.setattr(walls.walls, "velocities", lambda time: walls.normals * 2.0)
    walls.move(walls.grid_time + 0.5 * way * spacing)
    assert bool(made) == anew
