"""The implicit scheme: orders of convergence of rows, steps and output within them; errors that walls leave."""

import functools
import math

import numpy as np
import pytest
from implicit_case import IMPLICIT, SLOW, exact_error, fix_steps

from tisph.numerics.point_cloud import active

pytestmark = pytest.mark.taichi


@pytest.fixture
def make(make):
    """``make`` for scheme implicit."""
    return functools.partial(make, *IMPLICIT)


# --- order of convergence


@pytest.mark.parametrize(("order", "least"), [(2, 1.8), (4, 3.5)])
def test_the_order_of_convergence_is_that_of_the_rows(make, order, least):
    # from the exact profile at t* = 0.02 to 0.04, whose layer of sqrt(0.02) = 0.14 is 1.7 spacings deep on 12 across:
    # the orders are those of the rows less what the next term takes there
    errors = [
        exact_error(
            make(
                f"discretisation.particles_across={across}",
                f"scheme.operators.order={order}",
                "initial={state: exact, time: 2.0, jitter: 0.1}",
                "time={end: 4.0, tolerance: 1.0e-8}",
            )
        )
        for across in (12, 24)
    ]
    assert np.log2(errors[0] / errors[1]) > least


def sine(x, y):
    """Odd about both walls, and so a mode of the discrete problem on the lattice; the walls are almost at rest."""
    return SLOW * np.stack([np.sin(np.pi * y) + y, 0 * y], 1)


def slow(make, velocity, *overrides):
    """A Scheme with accurately solved systems, a far target, and SLOW as reference velocity."""
    return make(*overrides, "initial.state=developed", "time={end: 1.0e3, tolerance: 1.0e-9}", velocity=velocity)


def along(velocity):
    """Velocities (fluid, 2) from those along the channel."""
    return np.stack([velocity, np.zeros_like(velocity)], 1)


def in_steps_of(scheme, length, number, position, velocity):
    """Start again and take ``number`` steps of a given length."""
    scheme.reset()
    fix_steps(scheme, length)
    scheme.start(position, velocity)
    for _ in range(number):
        scheme.advance()
    assert scheme.time == pytest.approx(number * length, rel=1e-12)  # rounding of a sum


FLOWS = {
    "decay": (sine, f"walls.top.velocity={SLOW}"),
    # a period of 63 and a layer of 5 spacings, both well resolved
    "swing": (None, f"walls.top={{amplitude: {SLOW}, angular_frequency: 0.1, phase: sin}}"),
}


@pytest.mark.parametrize("flow", FLOWS)
def test_steps_are_of_third_order(make, flow):
    scheme = slow(make, *FLOWS[flow])
    start = active(scheme.particles.position).copy(), along(active(scheme.particles.velocity))
    results = {}
    for length in (8.0, 4.0, 0.5):
        in_steps_of(scheme, length, int(24.0 / length), *start)
        results[length] = scheme.snapshot().u / SLOW
    errors = [np.linalg.norm(results[length] - results[0.5]) for length in (8.0, 4.0)]
    # 8, less what the next order takes with steps of 0.8 (nu pi^2 h, or w h)
    assert errors[0] / errors[1] > 5


# --- output within steps


def test_output_at_the_ends_of_a_step_is_the_state_there(make):
    scheme = make("initial.jitter=0.2", "time.end=3.0")
    for _ in range(4):
        scheme.advance()
    start = scheme.snapshot()
    scheme.advance()
    end = scheme.snapshot()
    inside = end.t - 1e-13 * end.t  # so near to the end that what changes is below the tolerance
    for expected, time in ((start, start.t), (end, inside)):
        found = scheme.snapshot(time)
        assert found.t == time
        for name in ("x", "y", "u", "v"):
            # rounding, with x wrapped at the seam
            apart = getattr(found, name) - getattr(expected, name)
            assert np.abs(apart - np.round(apart)).max() < 1e-12, name


def test_output_within_a_step_is_of_the_order_of_the_steps(make):
    # a mode that decays as exp(-s t); its s on the lattice follows from a short step
    scheme = slow(make, sine, f"walls.top.velocity={SLOW}")
    start = active(scheme.particles.position).copy(), along(active(scheme.particles.velocity))
    linear = SLOW * start[0][:, 1]
    profile = start[1][:, 0] - linear
    in_steps_of(scheme, 0.1, 1, *start)
    rate = -math.log(profile @ (scheme.snapshot().u - linear) / (profile @ profile)) / 0.1
    assert rate == pytest.approx(0.01 * np.pi**2, rel=1e-3)  # fourth-order rows with 24 spacings a wave: (pi/12)^4/5
    errors = []
    for length in (8.0, 4.0):
        in_steps_of(scheme, length, 1, *start)
        times = np.array([0.25, 0.5, 0.75]) * length
        found = np.array([scheme.snapshot(time).u - linear for time in times])
        errors.append(np.linalg.norm(found - np.exp(-rate * times)[:, None] * profile, axis=1).max())
    # the error of one step, and of a cubic through values and slopes, is of fourth order: 16, less the next order
    assert errors[0] / errors[1] > 10
    # and far below what a straight line between the ends is off, (s h)^2 / 8 of the mode at its middle
    assert errors[1] < 0.05 * (4.0 * rate) ** 2 / 8 * np.linalg.norm(profile)


# --- walls


DRIVEN = ("walls.top.velocity=0.0", "drive.acceleration=0.04", "time={end: 10.0, tolerance: 1.0e-6}")
STARTED = ("time={end: 2.0, tolerance: 1.0e-6}",)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize(
    ("flow", "part", "bound"),
    [
        # from rest to t* = 0.1; a comoving image leaves out d^2 g/nu, an error of first order in the curvature at the
        # wall. Fourth order: (1/12)^4 = 5e-5 of the profile, whose fourth derivatives are small away from the start
        pytest.param(DRIVEN, 0.02, 5e-5, id="driven"),
        # at t* = 0.02; co-moving images have the same series in Couette flow, but no kick
        pytest.param(STARTED, 0.2, np.inf, id="started"),
    ],
)
def test_images_that_obey_momentum_serve_driven_flow_and_starts(make, jitter, flow, part, bound):
    errors = {
        treatment: exact_error(make(*flow, f"walls.treatment.type={treatment}", f"initial.jitter={jitter}"))
        for treatment in ("comoving_image", "consistent_image")
    }
    assert errors["consistent_image"] < part * errors["comoving_image"]
    assert errors["consistent_image"] < bound


def test_a_wall_that_stops_gives_the_opposite_impulse(make):
    start = make("time.end=1.0")
    moved = start.snapshot().u
    stop = make("walls.top={velocity: 0.0, velocity_before: 0.5}", "initial.state=developed")
    state = stop.snapshot()
    assert np.abs(moved).max() > 1e-2
    assert np.allclose(state.u - 0.5 * state.y, -moved, rtol=0, atol=1e-14)  # rounding
