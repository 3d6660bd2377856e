"""Parts of a step past a sphere in a tube: the impulse of the start, curls at walls, and iterations of slow flow."""

import numpy as np
import pytest
from case_from_text import started
from flows import flow_text

from tisph.runtime import real, ti, view

pytestmark = pytest.mark.taichi

SPHERE = flow_text("flow_past_a_sphere")
CENTRE = 1.0

ROTATING = flow_text("rotating_pipe")


@pytest.fixture(scope="module")
def scheme(tmp_path_factory):
    """Scheme of flow past a sphere at its impulsive start."""
    return started(tmp_path_factory.mktemp("case"), SPHERE, [])[1]


def places(scheme, points):
    """Place along the axis from the centre of the sphere, and distance from the axis."""
    return (view(scheme.points.position)[:points] + scheme.problem.origin).T.astype(float) - [[CENTRE], [0.0]]


def test_at_once_fluid_with_a_given_mean_flows_around_a_sphere(scheme):
    """In the gap its mean is 4/3, since a quarter of the section is solid; 1.348 by the mean over particles."""
    fluid = scheme.problem.n_fluid
    x, r = places(scheme, fluid)
    u = view(scheme.levels.fields)[:fluid, 0]
    for part, mean in ((np.abs(x) < 0.15, 4.0 / 3.0), (np.abs(x) > 0.85, 1.0)):
        assert np.average(u[part], weights=r[part]) == pytest.approx(mean, rel=0.03)
    assert scheme.couplings[0].weights @ view(scheme.levels.fields)[: scheme.problem.particles, 0] == pytest.approx(1.0)
    assert 0.0 < scheme.couplings[0].response < 1.0  # a part of the impulse presses on the sphere


def test_curls_at_walls_are_those_of_a_smooth_flow(scheme):
    """Along n: n_x (2 W + r^2 dW/ds) - n_r r dW/dx of W = dV/dx - du/ds, the vorticity over r."""
    points, boundary = scheme.problem.particles, scheme.boundary
    scheme.assemble(scheme.time)
    x, r = places(scheme, points)
    s, k = 0.5 * r**2, np.pi
    sine, cosine = np.sin(k * x), np.cos(k * x)
    velocity = ti.field(ti.types.vector(3, real()), scheme.points.slots + 1)
    view(velocity)[:points] = np.stack([sine * s + s**2, cosine * (1.0 - s), 0.0 * s], axis=1)
    vorticity = -k * sine * (1.0 - s) - sine - 2.0 * s
    by_x, by_s = -k * k * cosine * (1.0 - s) - k * cosine, k * sine - 2.0
    view(scheme.levels.fields)[:points, :3] = view(velocity)[:points]
    scheme.levels.measure()
    boundary.measure_normal_curls()
    of_levels = boundary.present_curls.copy()
    boundary.update_normal_curls(velocity)
    assert of_levels == pytest.approx(boundary.present_curls, rel=1e-9, abs=1e-9)
    walls, (n_x, n_r) = boundary.slots, boundary.normals.T
    exact = n_x * (2.0 * vorticity + r**2 * by_s)[walls] - n_r * (r * by_x)[walls]
    for part, bound in zip(boundary.walls.parts, (0.05, 0.005), strict=True):  # measured: 0.022 and 0.0015
        assert np.linalg.norm((boundary.present_curls - exact)[part]) < bound * np.linalg.norm(exact[part])


@pytest.mark.parametrize(
    ("change", "first", "later"), [("fluid.inertia=false", 22, 25), ("fluid.kinematic_viscosity=100", 15, 13)]
)
def test_velocity_and_pressure_of_slow_flow_take_few_iterations(tmp_path, change, first, later):
    """No more than a tenth above what was measured; the acceleration that keeps the mean is one of the unknowns."""
    _, scheme = started(tmp_path, SPHERE, [change])
    counts = []
    for _ in range(3):
        scheme.advance()
        counts.append(scheme.equations.stokes.iterations)
    assert counts[0] <= 1.1 * first
    assert max(counts[1:]) <= 1.1 * later


def test_slow_rigid_rotation_has_its_pressure(tmp_path):
    """An annulus has its own lowest radius; errors are those to which the linear systems are solved."""
    _, scheme = started(tmp_path, ROTATING, [])
    for _ in range(2):
        scheme.advance()
    assert scheme.equations.stokes.iterations > 0
    found = scheme.snapshot()
    pressure = 2.0 * found.y**2
    assert np.abs(found.w - 2.0 * found.y).max() < 2e-5  # measured: 6e-6, and 3e-5 of a pressure that rises by 1.5
    assert np.abs(found.pressure - pressure + pressure.mean()).max() < 1e-4
    assert max(np.abs(found.u).max(), np.abs(found.v).max()) < 1e-8
