"""Parts of a step of free bodies against exact values: gaps that close, contacts, levels after a jump, buoyancy."""

import numpy as np
import pytest
from case_from_text import started
from flows import flow_text

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.runtime import view
from tisph.schemes.implicit.planar.free_bodies import Contact

pytestmark = pytest.mark.taichi

CHANNEL = flow_text("pulled_circle")


@pytest.fixture(scope="module")
def scheme(tmp_path_factory):
    """Scheme with a free circle in shear, with the operators after three steps."""
    _, scheme = started(tmp_path_factory.mktemp("case"), CHANNEL, [])
    for _ in range(3):
        scheme.advance()
    scheme.assemble(scheme.time)
    return scheme


def test_in_a_closing_gap_a_point_has_the_mean_pressure_around(scheme):
    """By halves where the other wall is 3/4 of a spacing away. The mean is of all within 2.5 spacings."""
    boundary, problem, points = scheme.boundary, scheme.problem, scheme.points
    (free,) = boundary.parts
    walls, distances = np.arange(problem.n_fluid, problem.particles), np.full((problem.particles, 2), 10.0)
    distances[: problem.n_fluid] = 0.95
    distances[0], distances[walls, 0] = [0.9, 1.11], 0.0
    entries, listed = points.rows_of(walls)
    table = view(points.neighbours)[entries]
    place = view(points.position)
    apart = place[table] - place[walls, None]
    apart -= [problem.length, 0.0] * np.round(apart / [problem.length, np.inf])
    square = (apart**2).sum(axis=2) / problem.spacing**2
    mean = np.where(listed, np.maximum(1.0 - square / 2.5**2, 0.0) ** 2, 0.0)
    rows, pressures = {}, {}
    for away, part in ((1.2, 0.0), (1.0, 0.0), (0.75, 0.5), (0.5, 1.0), (0.1, 1.0)):
        distances[walls, 1] = away
        free.approach(problem.spacing * distances)
        assert view(free.continued)[walls] == pytest.approx(part, abs=1e-12)
        boundary.set_neumann_rows()
        rows[part] = np.where(listed, view(scheme.operators.laplacian)[entries], 0.0)
        boundary.add_normal_momentum(scheme.equations, 0.01, 1.5, 1.0)
        pressures[part] = view(scheme.equations.pressure.b)[walls].copy()
        assert boundary.stokes_rows().open_walls == pytest.approx(1.0 - part, abs=1e-12)
    assert rows[1.0] * problem.spacing**2 == pytest.approx(mean, abs=1e-9)
    assert rows[0.5] == pytest.approx(0.5 * (rows[0.0] + rows[1.0]), rel=1e-9, abs=1e-9)
    assert view(scheme.operators.diagonal)[walls] == pytest.approx(-rows[1.0].sum(axis=1), rel=1e-9)
    assert np.abs(pressures[0.0]).max() > 1.0
    assert pressures[0.5] == pytest.approx(0.5 * pressures[0.0], rel=1e-12)
    assert (pressures[1.0] == 0.0).all()
    closed = boundary.stokes_rows().open_fluid == 0.0  # both walls within two spacings together
    assert closed.tolist() == [False] + [True] * (problem.n_fluid - 1)


def test_after_a_jump_bodies_have_the_newest_velocity_alone(scheme):
    boundary, motion = scheme.boundary, scheme.boundary.parts[0].bodies.motions[0]
    newest = motion.velocities[0].copy()
    for after in (boundary.forget, lambda: boundary.jump(scheme.time)):
        motion.times, motion.velocities = [3.0, 2.0, 1.0], [newest, newest + 1.0, newest - 1.0]
        after()
        assert [velocity.tolist() for velocity in motion.velocities] == [newest.tolist()]


@pytest.mark.parametrize(("curls", "most"), [(0, 4), (2, 12)])
def test_bodies_find_the_velocities_of_a_linear_problem(scheme, curls, most):
    """Whatever the guess of its derivatives: with as many differences as unknowns after one iteration more than these.

    Curls at walls that follow from the velocities are further unknowns, more than the differences that are kept.
    """
    free, draw = scheme.boundary.parts[0].bodies, np.random.default_rng(4).normal
    matrix, exact, given = np.eye(3) + 0.3 * draw(size=(3, 3)), draw(size=3), np.zeros(curls)
    coupled = 0.3 * draw(size=(3, curls))
    free.begin(np.zeros((1, 3)), np.full((1, 3), 2.0))
    for _ in range(most):
        found = 0.1 * coupled.T @ (free.velocities[0] - exact)
        residual = (matrix @ (free.velocities[0] - exact) + coupled @ given)[None]
        assert not free.correct(residual, 1e-9, given if curls else None, found if curls else None)
        if free.converged < 1e-7:
            break
    assert free.velocities[0] == pytest.approx(exact, abs=1e-8)
    assert free.correct((matrix @ (free.velocities[0] - exact) + coupled @ given)[None], 1e-8)


def test_contacts_are_counted_when_they_begin():
    contact = Contact([Body(Circle(0.2), (x, 0.5)) for x in (0.3, 0.8)], 0.1, 1.0, 0.05)
    steps = {}, {(0, 1): 2.0}, {(0, 1): 5.0, (0, 2): 1.0}, {}, {(0, 1): 3.0}
    for forces, dt in zip(steps, (0.1, 0.2, 0.3, 0.4, 0.5), strict=True):
        contact.accept(forces, dt)
    assert (contact.count, contact.duration, contact.largest) == (3, pytest.approx(1.0), 5.0)
    state = contact.state()
    contact.reset()
    assert (contact.count, contact.duration, contact.largest, contact.touching) == (0, 0.0, 0.0, set())
    contact.restore(state)
    assert contact.state() == state
