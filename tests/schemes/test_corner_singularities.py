"""Flow under a sliding lid: leaks where it slides past corners, the regular lid's exact flow, and coarse corners."""

from types import SimpleNamespace

import numpy as np
import pytest
from case_from_text import to_end as run
from scipy.integrate import solve_ivp

from tisph import runtime
from tisph.exact.cavity import RegularCavity
from tisph.runtime import view
from tisph.scenes.cavity import Scene
from tisph.schemes.implicit import planar as _two_dimensional
from tisph.schemes.implicit.planar.corner_singularities import FAR, STEEPEST

pytestmark = pytest.mark.taichi


def cavity(across, reynolds, regular=False, velocity=1.0):
    return Scene(
        width=1.0,
        height=1.0,
        velocity=velocity,
        regular=regular,
        density=1.0,
        kinematic_viscosity=1.0 / reynolds,
        spacing=1.0 / across,
        units=None,
    )


def started(scene, end, courant, velocity=None):
    runtime.start("f64", 1)
    steps = {"time": SimpleNamespace(cfl=courant), "scheme": SimpleNamespace(error_ratio=None)}
    scheme = _two_dimensional.build(SimpleNamespace(**steps, singular=not scene.regular), scene, [end], True)
    places = np.stack(scene.jittered(0, 0.2), 1)
    scheme.start(places, np.zeros_like(places) if velocity is None else np.stack(velocity(*places.T), 1))
    return scheme


def test_next_to_nothing_leaks_past_singular_corners():
    """Of slow flow the corners' singular part is known: what flows through a centre line one way flows back.

    Without the inertia of that part 1e-3 of U W was lost at 25 across.
    """
    scene = cavity(16, reynolds=1.0)
    snapshot = run(started(scene, 0.3, 0.5))
    coordinate = np.linspace(0.0, 1.0, 201)
    u, v = scene.lines(snapshot, coordinate)
    for line in (u, v):
        assert abs(np.trapezoid(line, coordinate)) < 4e-4  # measured 2.4e-4, at 25 across 3e-5
    # slow flow has a mirror plane; Re = 1 spoils that by 2e-3
    assert v.max() == pytest.approx(-v.min(), rel=0.02)


def test_the_regular_lids_steady_flow_stays():
    flow = RegularCavity(1.0, 1.0, 1.0, 0.1, order=24)
    snapshot = run(started(cavity(16, 10.0, regular=True), 0.4, 0.5, flow.velocity))
    u, v = flow.velocity(snapshot.x, snapshot.y)
    assert np.sqrt(np.sum((snapshot.u - u) ** 2 + (snapshot.v - v) ** 2) / np.sum(u**2 + v**2)) < 0.01


@pytest.mark.parametrize("velocity", [1.0, -1.0])
def test_no_particle_is_lost_where_corners_are_not_resolved(velocity):
    """The cell Reynolds number is 42: what pushes in the corners must not make explicit steps unstable."""
    scene = cavity(12, 500.0, velocity=velocity)
    snapshot = run(started(scene, 4.0, 0.5))
    assert scene.contains(np.stack([snapshot.x, snapshot.y], 1)).all()
    assert np.hypot(snapshot.u, snapshot.v).max() < 1.05
    assert scene.lines(snapshot, np.linspace(0.0, 1.0, 101))[0].min() * velocity < -0.02 or velocity < 0


def test_output_between_steps_lies_on_the_paths():
    scheme = started(cavity(12, 100.0), 0.5, 0.3)
    before = None
    while not scheme.finished:
        before = scheme.snapshot()
        scheme.advance()
    after = scheme.snapshot(before.t)
    # shifting moves particles by some hundredths of a spacing; without the flow in the corners it were a step's way
    assert np.median(np.hypot(after.x - before.x, after.y - before.y)) * 12 < 0.02
    assert np.median(np.hypot(after.u - before.u, after.v - before.v)) < 2e-3


def test_paths_past_corners_follow_their_flow():
    """The flow in the corners moves particles as an integrator with the exact formulas does, on and back."""
    scheme = started(cavity(12, 100.0), 0.5, 0.3)
    corners, length = scheme.boundary.corners, 0.02
    places = view(scheme.levels.position)[: scheme.problem.n_fluid].astype(float)
    for sign in (1.0, -1.0):
        found = corners.paths.find(lambda part: np.zeros(4), sign * length)
        rate = lambda t, place: corners.velocity(place.reshape(-1, 2)).ravel()  # noqa: E731
        exact = solve_ivp(rate, (0.0, sign * length), places.ravel(), rtol=1e-11, atol=1e-13).y[:, -1].reshape(-1, 2)
        assert np.abs(exact - places).max() > 0.01
        # of fourth order: a half step of 0.01 U at 0.04 from a corner leaves 0.01 0.25^4/20, a whole one of 0.02 U at
        # FAR times that from one 0.2 0.1^5/120, and there are two
        assert np.abs(found - exact).max() < 2e-6
        away = np.min([np.linalg.norm(places - corner, axis=1) for corner in view(corners.paths.place)], axis=0)
        assert np.abs(found - exact)[away > FAR * length].max() < 1e-7


def test_force_of_the_known_flow_is_that_of_its_formulas():
    scheme = started(cavity(12, 100.0), 0.5, 0.3)
    walls, dt = scheme.boundary, 0.01
    points, weights = walls.positions + walls.corners.origin, np.array([2.0, -1.0])
    velocity, gradient, acceleration = (
        sum(getattr(corner, name)(points) for corner in walls.corners.corners)
        for name in ("velocity", "gradient", "acceleration")
    )
    levels = view(scheme.levels.fields)[: len(points), :4].reshape(-1, 2, 2)  # the newest two velocities
    velocity += np.einsum("a,nac->nc", weights, levels)
    fading = 1.0 + (dt * np.linalg.norm(gradient, axis=(1, 2)) / STEEPEST) ** 4
    expected = (np.einsum("ni,nij->nj", velocity, gradient) - acceleration) / fading[:, None]
    found = walls.corners.force(dt, weights)[: scheme.problem.particles]
    # rounding, of sums of terms that are up to 100 times as large
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()
