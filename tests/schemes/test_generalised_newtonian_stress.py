"""Generalised Newtonian fluids in two-dimensional flow: steady flow between cylinders, torques, the Newtonian limit."""

from dataclasses import replace

import annulus_case as case
import numpy as np
import pytest
import vortex_case

from tisph import runtime
from tisph.rheology import carreau_yasuda, power_law
from tisph.runtime import view
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.scheme import PlanarScheme

pytestmark = pytest.mark.taichi

TURNING = (1.0, 0.0)


def power_law_flow(places, index):
    """Velocity (n, 2) of the steady flow, u/r a constant and r^(-2/n), and its torque per density."""
    steepness, radius = 2.0 / index, np.linalg.norm(places, axis=1)
    scale = 1.0 / (1.0 - case.OUTER**-steepness)
    rate = scale * (radius**-steepness - case.OUTER**-steepness)
    return rate[:, None] * np.stack([-places[:, 1], places[:, 0]], axis=1), 2 * np.pi * (steepness * scale) ** index


@pytest.mark.parametrize("index", [0.5, 1.5])
def test_steady_flow_of_a_power_law_stays_and_balances_torques(index):
    # measured 12 across: velocities 3e-5 and 7e-6, torques 8e-5 and 3e-5; the bounds at 25 across, 1e-4 and 1e-3, for a
    # spacing twice as large, with the third power
    flow, places = case.make(TURNING, viscosity=1.0)
    law = power_law.Parameters(index=index, reference_rate=1.0, least_rate=1e-3)
    velocity, torque = power_law_flow(places, index)
    found = case.run(replace(flow, rheology=law), places, velocity, 0.2).snapshot()
    exact, _ = power_law_flow(np.stack([found.x, found.y], axis=1), index)
    error = np.stack([found.u, found.v], axis=1) - exact
    assert np.linalg.norm(error) < 8e-4 * np.linalg.norm(exact)
    assert found.bodies.torque == pytest.approx([-torque, torque], rel=8e-3)
    assert found.bodies.normal_stress is None


def test_a_start_from_rest_ends_in_the_steady_flow():
    """The front of a thinning fluid's layer, beyond which it is stiff, leaves no other torque behind."""
    flow, places = case.make(TURNING, viscosity=1.0)
    law = power_law.Parameters(index=0.5, reference_rate=1.0, least_rate=1e-3)
    found = case.run(replace(flow, rheology=law), places, np.zeros_like(places), 1.5, courant=1.0).snapshot()
    exact, torque = power_law_flow(np.stack([found.x, found.y], axis=1), 0.5)
    # measured: 8e-5, 4e-5 and 1.4e-4, which still fall; where viscosities and not stresses are differentiated torques
    # differ sevenfold
    assert np.linalg.norm(np.stack([found.u, found.v], axis=1) - exact) < 8e-4 * np.linalg.norm(exact)
    assert found.bodies.torque == pytest.approx([-torque, torque], rel=1e-3)


def test_a_law_of_constant_viscosity_is_a_newtonian_fluid():
    """Vortices: its stress is differentiated twice, that of a Newtonian fluid not at all."""
    flow = Problem(
        columns=20, rows=20, n_fluid=400, spacing=1 / 20, reference_velocity=1.0, density=1.0, kinematic_viscosity=0.1
    )
    law = carreau_yasuda.Parameters(time=1.0, index=1.0)
    places, found = vortex_case.arrangement(20, 0.2), []
    for rheology in (None, law):
        runtime.start("f64", 1)
        scheme = PlanarScheme(replace(flow, rheology=rheology), [0.1], True)
        scheme.start(places, np.stack(vortex_case.exact(*places.T, 0.0, 0.1)[:2], axis=1))
        while not scheme.finished:
            scheme.advance()
        snapshot = scheme.snapshot()
        u, v, _ = vortex_case.exact(snapshot.x, snapshot.y, 0.1, 0.1)
        found.append(np.linalg.norm([snapshot.u - u, snapshot.v - v]) / np.linalg.norm([u, v]))
    assert found[1] < 2.0 * found[0]


def test_powers_are_sums_over_areas_where_the_spacing_varies():
    """With the velocity as added force: the integral of u^2 over the integral of nu q, of u = A r + B/r.

    Sums over particles, which are four times finer at the inner cylinder, are off by a sixth. Measured: 1e-3.
    """
    flow, places = case.make(TURNING, viscosity=1.0, ratio=4.0)
    law = carreau_yasuda.Parameters(time=1.0, index=1.0)
    scheme = case.run(replace(flow, rheology=law), places, case.steady(places), 1.0, steps=0)
    stress, velocity = scheme.extra_stress, scheme.equations.velocity.x
    capacity = scheme.points.capacity
    stress.find_added_force = lambda found: np.copyto(view(stress.added_force), view(found)[:capacity])
    a, b = -1.0 / 3.0, 4.0 / 3.0
    squared = a**2 * (2.0**4 - 1.0) / 4.0 + a * b * (2.0**2 - 1.0) + b**2 * np.log(2.0)
    assert stress.store(velocity, 0) == pytest.approx(squared / (4.0 * b**2 * 3.0 / 8.0), rel=0.01)
