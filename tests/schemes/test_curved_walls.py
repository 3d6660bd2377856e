"""Curved walls: accuracy, forces, symmetries, starts from jumps, small steps, eccentric cylinders."""

import numpy as np
import pytest
from annulus_case import ACROSS, INNER, OUTER, VISCOSITY, error, make, run, steady
from case_from_text import started, to_end
from flows import flow_text

pytestmark = pytest.mark.taichi

SPACING = (OUTER - INNER) / ACROSS


def test_steady_flow_stays_as_it_is():
    # with plain rows in place of polar coordinates 9e-5 to 1.3e-4; measured 1.3e-6, torques
    # 1.6e-5, a force 1.9e-5 of them, the pressure 3.7e-5
    flow, places = make()
    scheme = run(flow, places, steady(places), 0.6)
    snapshot = scheme.snapshot()
    assert error(snapshot) < 5e-6
    torque = 4 * np.pi * VISCOSITY * INNER**2 * OUTER**2 / (OUTER**2 - INNER**2)
    assert snapshot.bodies.torque == pytest.approx([-torque, torque], rel=1e-4)
    assert np.abs(snapshot.bodies.force).max() < 1e-4 * torque
    # pressure: p' = u^2/r
    radius = np.hypot(snapshot.x, snapshot.y)
    exact = radius**2 / 18 - 8 / 9 * np.log(radius) - 8 / 9 / radius**2
    assert np.std(snapshot.pressure - exact) < 2e-4 * np.std(exact)


def test_particles_stay_between_the_walls_and_even():
    flow, places = make()
    scheme = run(flow, places, steady(places), 2.0)
    snapshot = scheme.snapshot()
    radius = np.hypot(snapshot.x, snapshot.y)
    assert radius.min() > INNER + 0.2 * SPACING  # the first layer is half a spacing off
    assert radius.max() < OUTER - 0.2 * SPACING
    apart = np.hypot(snapshot.x[:, None] - snapshot.x, snapshot.y[:, None] - snapshot.y)
    np.fill_diagonal(apart, 1.0)
    assert apart.min() > 0.55 * SPACING
    assert scheme.order_reduced < 10  # of 1400 rows a step: where too few layers were within reach of a wall many were


def test_rigid_rotation_has_no_stress():
    # velocities that are linear in space are e^w of the polar coordinates w, met to (reach/radius)^5/120 = 6e-5 at most
    # at the inner wall; measured 2.9e-7 in all, of which the error of the steps, (w dt)^3 and less, is below 1e-7
    turning = 1.0, 1.0
    flow, places = make(turning)
    snapshot = run(flow, places, steady(places, turning), 0.3).snapshot()
    assert error(snapshot, turning) < 1e-6
    assert np.abs(snapshot.bodies.torque).max() < 1e-3 * VISCOSITY  # 2 pi r^2 times that over a spacing


def test_a_cylinder_in_fluid_at_rest_floats_as_archimedes_says():
    # a pressure that is linear in space is met to (reach/radius)^5/120 = 6e-5 at most; measured 1.6e-5
    flow, places = make((0.0, 0.0), acceleration=(0.3, -2.0))
    bodies = run(flow, places, 0.0 * places, 0.01).snapshot().bodies
    area = np.pi * INNER**2
    assert bodies.force[0] == pytest.approx([-0.3 * area, 2.0 * area], rel=6e-5)
    assert np.abs(bodies.torque).max() < 1e-5


def test_place_and_angle_change_nothing():
    # but what the solvers leave: 1e-10 of velocities, and 1e-6 of pressures, which moves velocities by dt times that
    centre, angle = (-3.1, 17.4), 0.77
    still = run(*_with_velocity(make()), 0.2, steps=4).snapshot()
    moved = run(*_with_velocity(make(centre=centre, angle=angle), centre), 0.2, steps=4).snapshot()
    assert moved.t == pytest.approx(still.t, rel=1e-9)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    expected = np.stack([still.x, still.y], 1) @ turn + centre
    assert np.abs(np.stack([moved.x, moved.y], 1) - expected).max() < 1e-7
    expected = np.stack([still.u, still.v], 1) @ turn
    assert np.abs(np.stack([moved.u, moved.v], 1) - expected).max() < 1e-6


def _with_velocity(case, centre=(0.0, 0.0)):
    flow, places = case
    return flow, places, steady(places, centre=centre)


def test_an_impulsive_start_costs_few_steps():
    # a shift that does not know how short a step is stirred the layer at the wall up: 39 steps refused, down to 1e-11
    flow, places = make()
    scheme = run(flow, places, 0.0 * places, 0.03)
    assert scheme.control.rejected < 20
    assert scheme.steps < 130
    assert scheme.shortest > 1e-6
    assert scheme.residual < 2e-2


def test_small_steps_keep_pressure_and_divergence():
    # a splitting that asks for no divergence at once makes errors of the pressure grow as 1/step
    flow, places = make()
    scheme = run(flow, places, steady(places), 1.0, steps=40, tolerance=None, courant=0.02)
    snapshot = scheme.snapshot()
    radius = np.hypot(snapshot.x, snapshot.y)
    exact = radius**2 / 18 - 8 / 9 * np.log(radius) - 8 / 9 / radius**2
    assert np.std(snapshot.pressure - exact) < 5e-3 * np.std(exact)
    assert scheme.residual < 1e-3


CASE = flow_text("slow_bearing")


@pytest.mark.parametrize(
    ("turning", "changes"), [((0.1, 0.0), ()), ((0.05, -0.05), ("initial.state=developed", "time.end=0.03"))]
)
def test_velocity_pressure_torques_and_force_are_those_of_stokes_flow(tmp_path, turning, changes):
    # measured: 7.4e-5, 2.8e-4, 7.5e-5, 2.4e-4; the errors fall with the fourth power of the spacing (tisph verify)
    walls = [f"walls.{name}.angular_velocity={speed}" for name, speed in zip(("inner", "outer"), turning, strict=True)]
    scene, scheme = started(tmp_path, CASE, [*walls, *changes])
    found, viscosity = to_end(scheme), {"dynamic_viscosity": scene.dynamic_viscosity}
    flow = scene.stokes(*turning)
    velocity = np.array(flow.velocity(found.x, found.y))
    assert np.linalg.norm([found.u, found.v] - velocity) < 1.5e-4 * np.linalg.norm(velocity)
    pressure = flow.pressure(found.x, found.y, **viscosity)
    off = found.pressure - pressure
    assert np.linalg.norm(off - off.mean()) < 1e-3 * np.linalg.norm(pressure)
    assert found.bodies.torque == pytest.approx(flow.torque(**viscosity), rel=2e-4)
    force = flow.force(**viscosity)
    assert np.linalg.norm(found.bodies.force[0] - force) < 1e-3 * np.linalg.norm(force)
    assert np.linalg.norm(found.bodies.force.sum(axis=0)) < 1e-3 * np.linalg.norm(force)  # the fluid passes it on
