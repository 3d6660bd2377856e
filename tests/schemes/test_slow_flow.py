"""Slow flow: velocity and pressure solved together, with little inertia and without any."""

import numpy as np
import pytest
from flows import flow_config

import tisph

pytestmark = pytest.mark.taichi

BEARING = flow_config("bearing_without_inertia")
SHEAR = flow_config("circle_without_inertia")
SHEAR_RATE = -0.482223
"""Angular velocity of the circle in Stokes flow, by finite elements (``test_free_bodies.py``)."""

BALL = flow_config("ball_without_inertia")


def changed(config, **fluid):
    return {**config, "fluid": {**config["fluid"], **fluid}}


def off_stokes(scene, snapshot, time):
    """Error of the velocities of a bearing, relative to them, at a time at which the inner cylinder has its speed."""
    exact = np.stack(scene.stokes(scene.inner.velocity(time), 0.0).velocity(snapshot.x, snapshot.y))
    found = np.stack([snapshot.u, snapshot.v])
    return np.sqrt(np.square(found - exact).sum() / np.square(exact).sum())


def test_without_inertia_a_bearing_is_in_stokes_flow_from_the_start_on():
    """Errors of 8e-5 with 12 particles across and 9e-6 with 20: order 4."""
    errors = []
    for across in (12, 20):
        with tisph.Simulation({**BEARING, "discretisation": {"particles_across": across}}) as simulation:
            simulation.begin()
            errors.append(off_stokes(simulation.scene, simulation.scheme.snapshot(), 0.0))
    assert errors[0] < 2e-4
    assert errors[1] < 3e-5
    assert np.log(errors[0] / errors[1]) / np.log(20 / 12) > 3.0


def test_without_inertia_the_flow_follows_a_wall_that_jumps():
    jumps = {"times": [0.0, 0.05, 0.05], "angular_velocities": [0.1, 0.1, -0.2]}
    config = {**BEARING, "walls": {"inner": jumps}, "time": {"end": 0.06}}
    with tisph.Simulation(config) as simulation:
        simulation.run_until(0.06)
        assert off_stokes(simulation.scene, simulation.scheme.snapshot(), 0.06) < 2e-4  # 8e-5 at the start


def test_little_inertia_leads_to_the_same_flow():
    """At Re = 0.01 inertia changes velocities by less than 1.4e-4."""
    config = {**changed(BEARING, inertia=True), "time": {"end": 5.0}}
    with tisph.Simulation(config) as simulation:
        simulation.run_until(5.0)
        scheme = simulation.scheme
        assert off_stokes(simulation.scene, scheme.snapshot(), 5.0) < 2e-4
        limit = 5.0 * scheme.problem.spacing**2 / 10.0  # viscous number of the splitting, nu dt / spacing^2 = 5
        assert scheme.steps < 0.2 * 5.0 / limit  # mostly at the start, where the flow changes


@pytest.mark.parametrize("density", [0.0, 1.0])
def test_without_inertia_a_free_circle_turns_as_in_stokes_flow(density):
    bodies = [{**SHEAR["bodies"][0], "density": density}]
    with tisph.Simulation({**SHEAR, "bodies": bodies}) as simulation:
        simulation.begin()
        found = simulation.scheme.snapshot().bodies
    assert found.angular_velocity[0] == pytest.approx(SHEAR_RATE, rel=3e-3)  # 1.5e-3 with particles that have moved
    assert np.abs(found.velocity[0]).max() < 1e-3
    assert abs(found.torque[0]) < 1e-6  # found with the flow: to the residual
    assert np.abs(found.force[0]).max() < 1e-6


def test_without_inertia_the_drag_of_a_sphere_is_there_at_once():
    """5.970 times Stokes' drag at half the radius of the tube (W. L. Haberman, R. M. Sayre, DTMB report 1143, 1958)."""
    with tisph.Simulation({**BALL, "closure": "no_flux"}) as simulation:
        simulation.begin()
        drag = simulation.scene.diagnostics(simulation.scheme.snapshot(), [])["drag_ratio"]
    assert drag == pytest.approx(5.94738, rel=1e-2)  # its suite has 1.7e-3 with 28 across, and the length of this tube


def test_without_inertia_the_force_on_a_falling_ball_is_its_weight():
    """In a closed tube, with the force of the pressure gradient that the falling ball causes, a seventh of it here.

    Equation (12) has that gradient times the displaced volume, and the report of the scene adds it to the force.
    """
    falling = {"free": True, "density": 2.0, "force": -0.5}
    changes = {"geometry": {**BALL["geometry"], "length": 2.0}, "discretisation": {"particles_across": 12}}
    with tisph.Simulation({**BALL, **changes, "sphere": falling}) as simulation:
        simulation.begin()
        scene, snapshot = simulation.scene, simulation.scheme.snapshot()
        found = scene.diagnostics(snapshot, [])
    assert found["force_sphere"] == pytest.approx(0.5, abs=1e-6)  # found with the flow: to the residual
    assert found["acceleration"] * 4.0 / 3.0 * np.pi * 0.5**3 > 0.05


def test_a_polymer_without_inertia_flows_through_a_contraction_without_scatter():
    """At De = 0.5 scatter is 6e-4; with two outer iterations whatever they left, it was 1.4e-2 and grew."""
    wall = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.375], [2.0, 0.375]]
    outlines = {"bottom": wall, "top": [[x, 1.0 - y] for x, y in wall]}
    law = {"type": "oldroyd_b", "relaxation_time": 0.0625, "solvent_fraction": 1 / 9}
    config = {
        "scene": "channel",
        "fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False, "rheology": law},
        "geometry": {"gap": 1.0, "length": 2.0},
        "walls": {name: {"outline": outline, "corner_radius": 0.127} for name, outline in outlines.items()},
        "ends": {"left": {"type": "inlet", "velocity": 0.25}, "right": {"type": "outlet"}},
        "discretisation": {"particles_across": 24},
        "time": {"end": 0.17},
    }
    with tisph.Simulation(config) as simulation:
        assert simulation.run_until(0.17).snapshot.velocity_scatter < 3e-3
