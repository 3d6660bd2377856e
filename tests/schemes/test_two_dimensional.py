"""Flow that turns, with a pressure: accuracy, symmetries, small steps, output between steps, and the same bits."""

from dataclasses import replace

import numpy as np
import pytest
from same_bits import check_resuming
from vortex_case import VISCOSITY, arrangement, errors, exact, flow, make, run

from tisph import runtime
from tisph.errors import DivergedError
from tisph.numerics import least_squares as operators
from tisph.numerics.point_cloud import active
from tisph.numerics.shifting import SCATTER
from tisph.runtime import view
from tisph.schemes.implicit.planar import scheme as splitting_scheme
from tisph.schemes.implicit.planar import step_limits

pytestmark = pytest.mark.taichi


@pytest.mark.parametrize("jitter", [0.0, 0.35])
def test_any_start_stays_even_and_accurate(jitter):
    # the flow stretches a lattice at first; where the rows became singular errors were 0.1 and more
    scheme = make(24, jitter=jitter, targets=[0.6])
    snapshot = run(scheme, 0.6)
    assert errors(snapshot)[0] < 2e-3
    apart = np.stack([snapshot.x, snapshot.y], 1)[:, None] - np.stack([snapshot.x, snapshot.y], 1)
    distance = np.linalg.norm(apart - np.round(apart), axis=2) + np.eye(len(apart))
    assert distance.min() > 0.55 / 24


def test_a_wind_changes_nothing():
    # steps see differences of velocities only; the residuals of the linear systems, 1e-10 of the wind, are what differs
    still, windy = (bits(make(24, wind=wind, tolerance=2e-7), 3) for wind in ((0.0, 0.0), (3.0, -2.0)))
    assert np.abs(windy[2] - 3.0 - still[2]).max() < 1e-8
    assert np.abs(windy[3] + 2.0 - still[3]).max() < 1e-8
    assert np.abs(windy[4] - still[4]).max() < 1e-5


def test_a_flow_in_other_units_is_bitwise_the_same():
    found = []
    for length, time, density in ((1.0, 1.0, 1.0), (2.0**-8, 2.0**-4, 2.0**6)):  # as in test_units.py
        runtime.start("f64", 1)
        units = {"spacing": length / 12, "density": density, "reference_velocity": length / time}
        box = replace(flow(12, 1), kinematic_viscosity=VISCOSITY * length**2 / time, **units)
        scheme, position = splitting_scheme.PlanarScheme(box, [time], True), arrangement(12, 0.3)
        scheme.start(position * length, np.stack(exact(*position.T, 0.0, VISCOSITY)[:2], 1) * length / time)
        for _ in range(8):
            scheme.advance()
        last = scheme.snapshot()
        speeds = [part * time / length for part in (last.u, last.v)]
        pressure = last.pressure / density * (time / length) ** 2
        found.append(np.stack([last.x / length, last.y / length, *speeds, pressure]))
        found.append(last.t / time)
    assert found[1] == found[3]
    assert np.array_equal(found[0], found[2])


def test_a_lattice_is_scattered_by_the_first_step_and_not_again():
    """Evenly up to SCATTER along each axis, less what the sweeps of a step even out again."""
    scheme, moved = make(24, jitter=0.0), []
    for _ in range(2):
        scheme.advance()
        moved.append(24 * view(scheme.shift.moved)[:576].std() / (SCATTER / np.sqrt(3.0)))
    assert 0.5 < moved[0] < 1.0
    assert moved[1] < 0.5 * moved[0]  # measured: 0.91 and 0.14


def test_pressure_at_the_start():
    # that of the exact velocities, by rows of which the Laplacian has errors of (2 k dx)^4: measured 1.6e-3
    velocity, pressure, _ = errors(make(24).snapshot())
    assert velocity == 0.0
    assert pressure < 4e-3


def test_small_steps_keep_pressure_and_divergence():
    # a splitting that asks for no divergence at once makes errors of the pressure grow as 1/step: 20 times here
    scheme = make(24, targets=[1.0], courant=0.02, tolerance=None)
    while scheme.steps < 40:
        scheme.advance()
    assert errors(scheme.snapshot())[1] < 4e-3
    assert scheme.residual < 5e-4


def test_a_coarse_tolerance_makes_fewer_steps_and_larger_errors():
    found = []
    for tolerance in (1e-6, 3e-3):
        scheme = make(24, targets=[0.5], tolerance=tolerance, courant=5.0)
        found.append((errors(run(scheme, 0.5))[0], scheme.steps))
    (small, many), (large, few) = found
    assert few < 0.3 * many
    assert large > 2 * small


def test_a_flow_that_runs_away_stops_with_a_specific_message(monkeypatch):
    monkeypatch.setattr(step_limits, "RUNAWAY", 0.5)
    with pytest.raises(DivergedError, match=r"u, v: above 0\.5 times the reference velocity at step 1"):
        make(12).advance()


def test_snapshots_within_a_step_lie_on_the_exact_solution_too():
    scheme = make(24, targets=[0.2])
    run(scheme, 0.2)
    now = errors(scheme.snapshot())
    for part in (0.1, 0.5, 0.9):
        snapshot = scheme.snapshot(scheme.time - part * scheme.dts[0])
        assert snapshot.t < scheme.time
        for index in range(2):
            assert errors(snapshot)[index] < 1.2 * now[index]


def test_places_within_a_step_are_those_of_the_path():
    # the derivative of the places is the velocity, but for the step of the difference squared
    scheme = make(24, targets=[0.2])
    run(scheme, 0.2)
    time, small = scheme.time - 0.5 * scheme.dts[0], 1e-3 * scheme.dts[0]
    before, middle, after = (scheme.snapshot(time + shift) for shift in (-small, 0.0, small))
    for place, velocity in (("x", "u"), ("y", "v")):
        gone = getattr(after, place) - getattr(before, place)
        rate = (gone - np.round(gone)) / (2 * small)
        assert np.abs(rate - getattr(middle, velocity)).max() < 1e-6


@pytest.mark.other_program
def test_one_and_two_threads_are_bitwise_reproducible(monkeypatch):
    monkeypatch.setattr(operators, "FEW", 0)  # or small loops would stay on one thread
    monkeypatch.setattr(operators, "FEW_NUMBERS", 0)
    one, two = (bits(make(24, threads=threads), 4) for threads in (1, 2))
    assert all(np.array_equal(left, right) for left, right in zip(one, two, strict=True))


def bits(scheme, steps):
    """Places, velocities and pressures after so many more steps."""
    for _ in range(steps):
        scheme.advance()
    snapshot = scheme.snapshot()
    return [getattr(snapshot, name).copy() for name in ("x", "y", "u", "v", "pressure")]


def test_places_in_memory_change_nothing_that_is_seen(monkeypatch):
    # but the order of sums, and so their rounding, and what the solvers leave: 1e-10 of velocities, 1e-6 of pressures
    kept = bits(make(24), 20)
    monkeypatch.setattr(splitting_scheme, "REORDER_INTERVAL", 2)
    scheme = make(24)
    tidied = bits(scheme, 20)
    assert np.any(np.diff(active(scheme.levels.number)) != 1)
    for left, right in zip(kept, tidied, strict=True):
        assert np.abs(left - right).max() < 1e-5


def test_a_resumed_run_is_bitwise_reproducible(monkeypatch, tmp_path):
    monkeypatch.setattr(splitting_scheme, "REORDER_INTERVAL", 4)
    check_resuming(
        lambda started=True: make(24, jitter=0.2 if started else 0.1, fresh=not started), tmp_path, stops=(6,), steps=12
    )


@pytest.mark.other_program
def test_single_precision():
    # rounding of 6e-8 in the positions, over a spacing and times the largest entries of the rows
    scheme = make(24, targets=[0.1], precision="f32")
    assert errors(run(scheme, 0.1))[0] < 1e-2


def test_a_shift_takes_all_that_is_carried_along():
    # a sine by its Taylor series to second order, whose slopes have errors of (k dx)^4; without the second order 5e-4
    scheme = make(24)
    sine = lambda place: np.sin(2 * np.pi * place[:, 0]) * np.cos(2 * np.pi * place[:, 1])  # noqa: E731
    place, moved = active(scheme.levels.position).copy(), np.random.default_rng(1).uniform(-0.2, 0.2, (576, 2)) / 24
    scheme.assemble(scheme.time)
    active(scheme.levels.fields)[:, 3] = sine(place)
    scheme.levels.measure()
    view(scheme.points.position)[:576] = place + moved
    view(scheme.shift.moved)[:576] = moved
    scheme.levels.remap()
    assert np.abs(active(scheme.levels.fields)[:, 3] - sine(place + moved)).max() < 1e-4
    assert np.abs(active(scheme.levels.position) - (place + moved) % 1.0).max() < 1e-15


def test_vortex_of_fifty_across():
    # the bounds that the scheme was built for; measured 1.5e-5, 8e-5, 3e-5, 2e-5
    scheme = make(50, targets=[0.5])
    velocity, pressure, energy = errors(run(scheme, 0.5))
    assert velocity < 6e-5
    assert pressure < 1e-4
    assert abs(energy) < 2e-4
    steepest = float(view(scheme.levels.largest_gradient))
    assert np.abs(active(scheme.levels.divergence)).max() < 1e-4 * steepest
    assert scheme.steps < 100


def test_order_in_the_spacing_at_a_fixed_courant_number():
    # degree-4 rows and steps of third order; measured 4.5 and 3.9
    coarse, fine = (errors(run(make(n, targets=[0.25], tolerance=None), 0.25)) for n in (24, 48))
    for index in range(2):
        assert np.log2(coarse[index] / fine[index]) > 3.0


def test_two_vortices_side_by_side():
    # a box that is no square: no other errors than in one vortex
    scheme = make(24, cells=2, targets=[0.1])
    assert scheme.points.fluid == 2 * 24**2
    assert errors(run(scheme, 0.1))[0] < 1e-3
