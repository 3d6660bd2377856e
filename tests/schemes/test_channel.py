"""The channel's implicit scheme: what it keeps exactly, symmetries, volume and limits."""

import functools

import numpy as np
import pytest
from case_from_text import to_end as run
from implicit_case import IMPLICIT

from tisph.errors import DivergedError
from tisph.numerics.point_cloud import active
from tisph.schemes.implicit.channel.walls import TREATMENTS

pytestmark = pytest.mark.taichi

LAST = list(TREATMENTS)[-1]


@pytest.fixture
def make(make):
    """``make`` for scheme implicit."""
    return functools.partial(make, *IMPLICIT)


# --- what is kept


# what rows and images do for a linear profile does not depend on one another
@pytest.mark.parametrize(("order", "treatment"), [(2 if each == LAST else 4, each) for each in TREATMENTS])
def test_developed_couette_flow_is_kept_on_a_jittered_arrangement(make, order, treatment):
    scheme = make(
        "initial={state: developed, jitter: 0.2}",
        "time.end=8.0",
        f"scheme.operators.order={order}",
        f"walls.treatment.type={treatment}",
    )
    last = run(scheme)
    assert scheme.steps >= 8  # a strain of 4 at 0.5 a step: rows slide along one another
    # a linear profile is exact for the rows and for the images, also where particles are shifted; rounding in the guess
    # of a stage stays where it is below the residual that the solver leaves, 1e-3 of the tolerance 1e-5
    assert np.abs(last.u - 0.5 * last.y).max() < 1e-8
    assert np.abs(last.v).max() < 1e-12


@pytest.mark.parametrize("treatment", ["comoving_image", "consistent_image"])
def test_a_uniform_translation_is_kept_exactly(make, treatment):
    translation = (f"walls.treatment.type={treatment}", "initial={state: developed, jitter: 0.2}", "time.end=7.0")
    exactly = lambda x, y: np.stack([np.full_like(x, 0.3), np.zeros_like(x)], 1)  # noqa: E731
    last = run(make(*translation, together=0.3, velocity=exactly))
    # all differences that rows are applied to are 0, and what walls give cancels what images take, to the last bit
    assert np.all(last.u == 0.3)
    assert np.all(last.v == 0.0)
    assert np.all(last.density == 1.0)


def test_a_lattice_that_is_carried_along_stays_one(make):
    scheme = make("initial.state=developed", "time.end=7.0", together=0.3)
    before, last = scheme.snapshot(), run(scheme)
    assert np.array_equal(last.y, before.y)
    behind = last.x - before.x - 0.3 * 7.0
    assert np.allclose(behind, np.round(behind), rtol=0, atol=1e-14)  # rounding of x in a few steps


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_what_the_walls_give_is_what_the_fluid_gains(make, jitter):
    scheme = make(f"initial.jitter={jitter}", "walls.bottom.velocity=-0.1", "drive.acceleration=0.02", "time.end=2.0")
    run(scheme)
    balance = scheme.momentum_balance()
    assert balance["top_wall"] > 0.0 > balance["bottom_wall"]
    # on the lattice what one particle gives another takes, but for the residuals of the systems: 1e-8 of their right
    # sides, three times in each of some 30 steps; the least-squares rows of a disordered arrangement are not
    # symmetric, which leaves their truncation error
    assert abs(balance["closure"]) < (1e-6 if jitter == 0.0 else 5e-2)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_walls_pull_developed_flow_with_the_stress_of_the_parabola(make, jitter):
    walls = "walls={bottom: {velocity: -0.1}, top: {velocity: 0.5}}"
    scheme = make(walls, "drive.acceleration=0.02", f"initial={{state: developed, jitter: {jitter}}}", "time.end=1.0")
    run(scheme)
    balance = scheme.momentum_balance()
    # nu u' of u = -0.1 + 1.6 y - y^2, over a channel 1 long for 1 s; rows are exact for it, systems solved to 1e-8
    assert balance["bottom_wall"] == pytest.approx(-0.01 * 1.6, rel=1e-6)
    assert balance["top_wall"] == pytest.approx(-0.01 * 0.4, rel=1e-6)


# --- symmetries

TIGHT = "time={end: 2.0, tolerance: 1.0e-7}"

# systems are solved to 1e-3 of the tolerance, 1e-10 of their right sides, whose norm is 6 at most (144 particles at
# 0.5): three systems in each of 40 steps, in two runs that take different roundings, may differ by twice that in all
SOLVED = 2e-7


def test_exchanged_walls_give_the_mirrored_flow(make):
    walls = "walls={{bottom: {{velocity: {0}}}, top: {{velocity: {1}}}}}"
    one = run(make(TIGHT, walls.format(-0.1, 0.5), jitter=0.2))
    two = run(make(TIGHT, walls.format(0.5, -0.1), jitter=0.2, moved=lambda x, y: np.stack([x, 1.0 - y], 1)))
    assert np.abs(one.u - two.u).max() < SOLVED
    assert np.abs(one.y + two.y - 1.0).max() < SOLVED


def test_the_flow_is_the_same_seen_from_the_other_wall(make):
    # walls at 0 and 0.5, and at -0.5 and 0: the reference velocity and with it the control of the steps are the same
    def seen_at(speed):
        return lambda x, y: np.stack([0.5 * y**3 + speed, 0 * y], 1)

    developed = "initial={state: developed, jitter: 0.2}"
    one = run(make(TIGHT, developed, velocity=seen_at(0.0)))
    moved = "walls={bottom: {velocity: -0.5}, top: {velocity: 0.0}}"
    two = run(make(TIGHT, developed, moved, velocity=seen_at(-0.5)))
    assert np.ptp(one.u - 0.5 * one.y) > 1e-2  # there is something to compare
    assert np.abs(one.u - two.u - 0.5).max() < SOLVED
    apart = one.x - two.x - 0.5 * one.t
    assert np.abs(apart - np.round(apart)).max() < SOLVED
    assert np.abs(one.y - two.y).max() < SOLVED


# --- linear systems


@pytest.mark.parametrize(("jitter", "identical"), [(0.0, True), (1e-6, False)])
def test_layers_solve_the_systems_on_a_sheared_lattice_particles_off_it(make, jitter, identical):
    scheme = make(f"initial.jitter={jitter}", "time.end=1.0")
    solve, counts = scheme.closed.solver.solve, []
    scheme.closed.solver.solve = lambda *numbers: (solve(*numbers), counts.append(scheme.closed.solver.iterations))[0]
    run(scheme)
    assert scheme.closed.solver.coarse.layers_identical == identical
    assert (max(counts) == 0) == identical  # to rounding of the operators, over a tolerance of 1e-7 of the right side


# --- volume


def test_no_volume_is_counted_before_derivatives_mean_something(make):
    """Re = 1000, 12 across: truncation errors of the layer while it is thinner than two spacings made 5.8e-3 of it."""
    scheme = make("fluid.kinematic_viscosity=5e-4", "initial.jitter=0.3", f"time.end={5 / 144 / 5e-4}")
    run(scheme)
    assert 2.0 < scheme.layer_thickness < 2.5
    assert 0.0 < np.abs(scheme.snapshot().density - 1.0).max() < 1e-3


@pytest.mark.parametrize("order", [2, 4])
def test_clustered_particles_stop_the_run(make, order):
    scheme = make(f"scheme={{type: implicit, operators: {{order: {order}}}}}")
    position = active(scheme.particles.position)
    angle = np.linspace(0, 2 * np.pi, 70, endpoint=False)
    # 70 particles within a fifth of a spacing: more than a row has room for at either order
    position[:70] = 0.5 + 0.1 * scheme.channel.spacing * np.stack([np.cos(angle), np.sin(angle)], 1)
    with pytest.raises(DivergedError, match=r"too many neighbours of a particle .* the particles have clustered"):
        scheme.advance()
