"""Parts of a step between open ends against exact values: kept divergence, places of entering particles, flow rates."""

import numpy as np
import pytest
from case_from_text import started
from flows import flow_text

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.ends import LEAST_DISTANCE
from tisph.runtime import view

pytestmark = pytest.mark.taichi

CHANNEL = flow_text("long_open_channel")
MIRRORED = "ends={left: {type: outlet}, right: {type: inlet, velocity: 2.0}}"


@pytest.fixture(scope="module", params=[(), (MIRRORED,)], ids=["from the left", "from the right"])
def scheme(request, tmp_path_factory):
    """Scheme of Poiseuille flow after two steps, with the operators at the places of the end of the next one."""
    _, scheme = started(tmp_path_factory.mktemp("case"), CHANNEL, request.param)
    for _ in range(2):
        scheme.advance()
    scheme.attempt(scheme.control.dt_next)
    return scheme


def test_the_kept_divergence_is_that_at_the_places_before(scheme):
    """Of velocities A x that carried all points by w A x: the trace of A (1 - w A)^-1."""
    levels, boundary, points = scheme.levels, scheme.boundary, scheme.problem.particles
    slopes, step = np.array([[0.3, -1.1], [0.7, 0.4]]), 0.2
    view(levels.fields)[:points, :2] = boundary.positions @ slopes.T
    view(levels.step_weights)[...] = [step, 0.0, 0.0, 0.0]
    boundary.parts[0].measure_kept_divergence()
    exact = np.trace(slopes @ np.linalg.inv(np.eye(2) - step * slopes))
    assert view(boundary.parts[0].divergence)[: scheme.problem.n_fluid] == pytest.approx(
        exact, rel=1e-9
    )  # rounding in operators


def test_a_particle_enters_where_most_room_is(scheme):
    """Up to 1.2 spacings from its end and 0.4 along it, away from what is already there and from one another."""
    boundary, spacing = scheme.boundary, scheme.problem.spacing
    way = float(boundary.walls.bodies[-2].shape.normal[0])
    end = np.array([[0.0 if way > 0.0 else 3.0, 0.5]]) - scheme.problem.origin
    normals = np.array([[way, 0.0]])
    nearest, deepest = LEAST_DISTANCE, LEAST_DISTANCE + 0.9
    corner = (deepest * way, 0.4)
    for others, expected in (((nearest * way, -0.4), corner), ((deepest * way, -0.4), (nearest * way, 0.4))):
        found = boundary.parts[0].roomiest(end, normals, end + spacing * np.array([others]), scheme.time)
        assert (found - end) / spacing == pytest.approx(np.array([expected]), abs=1e-9)
    first, second = boundary.parts[0].roomiest(end.repeat(2, axis=0), normals.repeat(2, axis=0), end, scheme.time) - end
    assert np.abs(first / spacing) == pytest.approx(np.abs(corner), abs=1e-9)
    # as far from the first as from the one at the end: 0.8^2 + 0.4^2 = (1.2 - 0.8)^2 + (0.4 + 0.4)^2
    assert second / spacing == pytest.approx(np.array([0.8 * way, -first[1] / spacing]), abs=1e-9)


@pytest.fixture
def control(scheme):
    """The control of the flow rate at the beginning of a step of 0.01 of steady Poiseuille flow."""
    levels, points, control = scheme.levels, scheme.problem.particles, scheme.couplings[0]
    y = scheme.boundary.positions[:, 1] + scheme.problem.origin[1]
    steady = control.along * 12.0 * y * (1.0 - y)
    fields = view(levels.fields)[:points]
    fields[...] = 0.0
    fields[:, :8:2] = steady[:, None]
    view(scheme.equations.velocity.x)[:points] = np.stack([steady, 0.0 * steady], axis=1)
    control.prepare(scheme.equations, 0.01, float(view(scheme.equations.alpha).sum()), scheme.time, 1e-6)
    return control


def test_sections_integrate_quadratics_and_leave_out_bodies(scheme, control):
    boundary, origin = scheme.boundary, scheme.problem.origin
    x, y = (boundary.positions + origin).T
    places = control.sections + origin[0]
    assert np.sort(places) == pytest.approx(np.linspace(0.5, 2.5, 3))  # 6 spacings from the ends, 8 apart
    assert control.weights @ (x + 3.0 * y**2) == pytest.approx(places + 1.0, rel=1e-9)
    control.ends.solid.append(Body(Circle(0.2), (1.4, 0.5)))
    try:
        control.place_sections(boundary.positions, scheme.time)
    finally:
        control.ends.solid.pop()
    assert np.sort(control.sections + origin[0]) == pytest.approx([0.5, 2.5])


def test_an_excess_flow_rate_is_removed_before_the_first_section(scheme, control):
    """Of steady flow faster by 0.1: an acceleration of 0.1 gamma_0/dt, and 0.1/T at which the excess has to go."""
    equations, points = scheme.equations, scheme.problem.particles
    assert control.correct(equations)
    view(equations.velocity.x)[:points, 0] += 0.1 * control.along
    assert not control.correct(equations)
    renewal = 3.0 / 3 / 2.0  # the length over the number of sections and the velocity
    x = scheme.boundary.positions[: scheme.problem.n_fluid, 0] + scheme.problem.origin[0]
    before = (x if control.along > 0.0 else 3.0 - x) < 0.5
    area = before.sum() * scheme.problem.spacing**2
    expected = np.where(before, -0.1 * (control.gamma0 / 0.01 + 1.0 / renewal) / area, 0.0)
    assert equations.sources == pytest.approx(expected, rel=1e-9, abs=1e-6)
