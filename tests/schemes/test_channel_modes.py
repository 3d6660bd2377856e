"""The implicit scheme against what its own operators make of polynomials and sines, to rounding.

Rows of order 4 are exact for polynomials of degree 5, and on the lattice the sines that vanish on both walls are modes
of the discrete problem. So a step has an answer without truncation errors: its walls, its kick, its error estimate.
"""

import functools

import numpy as np
import pytest
from implicit_case import IMPLICIT, SLOW
from scipy.optimize import brentq

from tisph.runtime import view
from tisph.schemes._step_control import SAFETY
from tisph.schemes.implicit.channel.stages import B_HAT, GAMMA, A, B

pytestmark = pytest.mark.taichi

NU, ROWS = 0.01, 12
HEIGHTS = (np.arange(ROWS) + 0.5) / ROWS
NUMBERS = np.arange(1, ROWS + 1)
MODES = np.sin(np.pi * np.outer(NUMBERS, HEIGHTS))
STEP = 0.05
"""Short enough for one step to leave something of every mode: those at the rows' own scale decay at a rate near 10."""


@pytest.fixture(scope="module")
def make(make):
    """``make`` for scheme implicit with accurately solved systems."""
    return functools.partial(make, *IMPLICIT)


def test_virtual_ghosts_take_the_weighted_fit_at_their_mirror_points(make):
    """Weights (1 - r^2)^2 of the distance r over the reach, and a parabola: what is left is orthogonal to its terms."""
    scheme = make("scheme.type=implicit", "walls.treatment.type=virtual_image", jitter=0.3)
    scheme.particles.arrange(0.0)
    ghosts, points = scheme.ghosts, scheme.points
    values = np.random.default_rng(0).uniform(size=points.slots + 1)
    place, reach = view(points.position), float(view(ghosts.radius))
    for k in (0, 7, 20):
        row = slice(view(points.begin)[points.capacity + k], view(points.end)[points.capacity + k])
        near = view(points.neighbours)[row]
        apart = place[near] - view(points.mirror)[k]
        apart[:, 0] -= np.round(apart[:, 0] / scheme.channel.length) * scheme.channel.length
        x, y = apart.T / reach
        weight = np.maximum(0.0, 1.0 - x**2 - y**2) ** 2
        basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)
        moments = basis.T @ (weight[:, None] * basis)
        expected = np.linalg.solve(moments, basis.T @ (weight * values[near]))[0]
        assert view(ghosts.share)[row] @ values[near] == pytest.approx(expected, abs=1e-10)


def one_step(make, *overrides, velocity=None):
    """Velocity (rows,) at ``HEIGHTS`` after one step of ``STEP``, over ``SLOW``."""
    scheme = make(*overrides, f"time={{end: {STEP}, cfl: 1.0, tolerance: 1.0e-9}}", velocity=velocity)
    scheme.advance()
    assert scheme.finished
    profile = scheme.snapshot().u.reshape(ROWS, -1) / SLOW
    assert np.ptp(profile, axis=1).max() < 1e-9  # the flow is the same all along the channel
    return profile[:, 0]


def parts(profile):
    """Coefficients (rows,) of the modes in a profile."""
    return MODES @ profile / (MODES**2).sum(axis=1)


def stages(z):
    """Rates (4,) of the stages of one step of y' = z y from y = 1, times its length."""
    return z * np.linalg.solve(np.eye(4) - z * np.array(A), np.ones(4))


def growth(z):
    """Factor by which one step of y' = z y grows."""
    return 1.0 + np.array(B) @ stages(z)


@pytest.fixture(scope="module")
def modes(make):
    """Return eigenvalues (rows,) of the discrete Laplacian, and what one step leaves of each mode."""
    # every mode at once, on the developed flow of walls that must move for a velocity to refer to
    left = one_step(
        make,
        f"walls.top.velocity={SLOW}",
        "initial.state=developed",
        velocity=lambda x, y: SLOW * np.stack([np.sin(np.pi * np.outer(y, NUMBERS)).sum(axis=1) + y, 0 * y], 1),
    )
    left = parts(left - HEIGHTS)
    values = [brentq(lambda z, part=part: growth(z) - part, -1.0, 0.0, xtol=1e-14) for part in left]
    return np.array(values) / (NU * STEP), left


def test_eigenvalues_are_those_of_the_laplacian_to_fourth_order(modes):
    errors = modes[0][:2] / -((np.pi * NUMBERS[:2]) ** 2) - 1.0
    assert abs(errors[0]) < (np.pi / ROWS) ** 4 / 2  # the next term of the series, whose factor is below 1/2
    assert errors[1] / errors[0] == pytest.approx(16.0, rel=0.3)  # less the term after it, (2 pi/12)^2


# p'' and p are 0 on both walls but for p'' = 1 at y = 0; quintic'' = cubic (Lidstone)
CUBIC = -HEIGHTS * (1 - HEIGHTS) * (2 - HEIGHTS) / 6
QUINTIC = HEIGHTS * (1 - HEIGHTS) * (2 - HEIGHTS) * (4 + 6 * HEIGHTS - 3 * HEIGHTS**2) / 360


def test_a_wall_that_starts_gives_the_impulse_that_polynomials_ask_for(make, modes):
    # rows exact for polynomials: the ghosts of the wall give p'' - A p for p of degree 1, 3 and 5, and the kick is
    # (1 - y) - A^2 quintic; what one step leaves of it, and the steady flow
    values, left = modes
    found = one_step(make, f"walls={{bottom: {{velocity: {SLOW}}}, top: {{velocity: 0.0}}}}")
    expected = 1 - HEIGHTS - (left * values**2 * parts(QUINTIC)) @ MODES
    assert np.abs(found - expected).max() < 1e-7


def test_a_drive_that_starts_gives_the_impulse_that_polynomials_ask_for(make, modes):
    values, left = modes
    found = one_step(make, "walls={top: {velocity: 0.0}}", f"drive.acceleration={12 * NU * SLOW}")
    both = QUINTIC + QUINTIC[::-1]
    expected = -12 * (CUBIC + CUBIC[::-1]) + 12 * (left * values * parts(both)) @ MODES
    assert np.abs(found - expected).max() < 1e-7


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_a_quartic_between_walls_that_accelerate_stays_exact(make, jitter):
    # U'' = -w^2 U on both walls at t = 0, and a drive: u_yyyy = U''/nu^2 everywhere, u_yy = -g/nu on the walls;
    # u_t = nu u_yy + g and u_tt = U'' until (w t)^4/24 counts
    frequency, drive, end = 0.05, 0.02, 0.1
    middle = np.polynomial.Polynomial([-0.5, 1.0])
    fourth = -((frequency / NU) ** 2)
    start = fourth / 24 * middle**4 - (drive / NU + fourth / 8) / 2 * middle**2
    start = start - start(0.0) + 1.0
    wall = f"{{amplitude: {SLOW}, angular_frequency: {frequency}, phase: cos}}"
    scheme = make(
        f"walls={{bottom: {wall}, top: {wall}}}",
        f"drive.acceleration={drive * SLOW}",
        "initial.state=developed",
        f"time={{end: {end}, cfl: 1.0, tolerance: 1.0e-9}}",
        jitter=jitter,
        velocity=lambda x, y: SLOW * np.stack([start(y), 0 * y], 1),
    )
    scheme.advance()
    assert scheme.finished
    last = scheme.snapshot()
    change = end * (NU * start.deriv(2) + drive) - end**2 / 2 * frequency**2
    found = last.u / SLOW - start(last.y)
    assert np.abs(found - change(last.y)).max() < 1e-8


def test_the_error_estimate_of_a_step_is_that_of_the_embedded_method(make, modes):
    # of one mode: the difference of the two results, filtered, is E(z); the second step is as long as it allows
    values, _ = modes
    mode, tolerance = 3, 1e-4
    first = 0.25 / ROWS**2 / NU
    z = values[mode - 1] * NU * first
    error = abs((np.array(B) - np.array(B_HAT)) @ stages(z)) / (1 - GAMMA * z)
    rms = np.sqrt((MODES[mode - 1] ** 2).mean())
    scheme = make(
        f"walls.top.velocity={SLOW}",
        "initial.state=developed",
        f"time={{end: 1.0e3, tolerance: {tolerance}}}",
        velocity=lambda x, y: SLOW * np.stack([np.sin(mode * np.pi * y) + y, 0 * y], 1),
    )
    scheme.advance()
    assert scheme.time == pytest.approx(first, rel=1e-12)
    scheme.advance()
    factor = SAFETY * (error * rms / tolerance) ** (-1 / 3)
    assert 0.2 < factor < 2.0  # within what a step may change by
    assert (scheme.time - first) / first == pytest.approx(factor, rel=1e-3)
