"""The implicit scheme of parallel flow: restart, linear systems, and volume."""

import functools

import numpy as np
import pytest
from implicit_case import IMPLICIT, run

from tisph.simulation import checkpoint

pytestmark = pytest.mark.taichi


@pytest.fixture
def make(make):
    """``make`` for scheme implicit."""
    return functools.partial(make, *IMPLICIT)


def test_particles_around_a_place_are_those_of_a_snapshot_there(make):
    scheme = make(jitter=0.2)
    for _ in range(3):
        scheme.advance()
    times = scheme.time - np.array([0.75, 0.25, 0.0]) * scheme.dense.dt
    x, length = np.array([0.3, 0.6, 0.0]), scheme.channel.length
    when, place, y, u = scheme.around(times, x, 0.1)
    for index, t in enumerate(times):
        snapshot = scheme.snapshot(t)
        away = (snapshot.x - x[index] + length / 2) % length - length / 2
        near, own = np.abs(away) < 0.1, when == index
        expected, found = np.argsort(snapshot.y[near]), np.argsort(y[own])
        # the same sums of the same numbers, in another order
        assert place[own][found] - x[index] == pytest.approx(away[near][expected], abs=1e-12)
        assert y[own][found] == pytest.approx(snapshot.y[near][expected], abs=1e-12)
        assert u[own][found] == pytest.approx(snapshot.u[near][expected], abs=1e-12)


# --- restart


@pytest.mark.parametrize(
    "overrides",
    [
        ("initial.jitter=0.2", "time.end=4.0"),
        (
            "initial={state: developed, jitter: 0.2}",
            "walls.top={amplitude: 0.5, angular_frequency: 2.0, phase: cos}",
            "time.end=2.0",
        ),
        ("walls.treatment.type=comoving_image", "scheme.operators.order=2", "time={end: 2.0, samples: [1.0, 1.5]}"),
    ],
    ids=["start", "swing", "comoving"],
)
def test_a_restart_gives_the_bits_of_going_on(make, tmp_path, overrides):
    scheme = make(*overrides)
    times = [scheme.time]
    for _ in range(6):
        scheme.advance()
        times.append(scheme.time)
    assert [scheme.shortest, scheme.longest] == pytest.approx([f(np.diff(times)) for f in (np.min, np.max)], rel=1e-12)
    checkpoint.save(tmp_path / "state.h5", scheme, "fingerprint")
    steps = scheme.steps
    whole = run(scheme)
    assert scheme.steps > steps + 3
    numbers = scheme.numbers(), scheme.momentum_balance(), scheme.shortest, scheme.longest

    resumed = make(*overrides, started=False)
    checkpoint.restore(tmp_path / "state.h5", resumed, "fingerprint")
    assert resumed.steps == steps
    last = run(resumed)
    for name in ("t", "step", "x", "y", "u", "v", "density", "pressure"):
        assert np.array_equal(getattr(last, name), getattr(whole, name)), name
    assert (resumed.numbers(), resumed.momentum_balance(), resumed.shortest, resumed.longest) == numbers


# --- linear systems


@pytest.mark.parametrize(("jitter", "identical"), [(0.0, True), (1e-6, False)])
def test_layers_solve_the_systems_on_a_sheared_lattice_particles_off_it(make, jitter, identical):
    scheme = make(f"initial.jitter={jitter}", "time.end=1.0")
    solve, counts = scheme.solver.solve, []
    scheme.solver.solve = lambda *numbers: (solve(*numbers), counts.append(scheme.solver.iterations))[0]
    run(scheme)
    assert scheme.solver.coarse.layers_identical == identical
    assert (max(counts) == 0) == identical  # to rounding of the operators, over a tolerance of 1e-7 of the right side


# --- volume


def test_no_volume_is_counted_before_derivatives_mean_something(make):
    """Re = 1000, 12 across: truncation errors of the layer while it is thinner than two spacings made 5.8e-3 of it."""
    scheme = make("fluid.kinematic_viscosity=5e-4", "initial.jitter=0.3", f"time.end={5 / 144 / 5e-4}")
    run(scheme)
    assert 2.0 < scheme.layer_thickness < 2.5
    assert 0.0 < np.abs(scheme.snapshot().density - 1.0).max() < 1e-3
