"""Flow between eccentric cylinders: Stokes flow stays, and starts from rest end in it."""

import numpy as np
import pytest
from case_from_text import started

pytestmark = pytest.mark.taichi

CASE = """
scene: eccentric_annulus
fluid: {density: 2.0, kinematic_viscosity: 10.0}
geometry: {inner_radius: 1.0, outer_radius: 2.0, eccentricity: 0.5}
walls: {inner: {angular_velocity: 0.1}}
initial: {jitter: 0.2}
discretisation: {particles_across: 12}
time: {end: 0.15}
runtime: {threads: 1}
"""
"""Re = 0.01: what inertia changes is 1e-4 of the force. The end is 1.5 viscous times of the mean gap."""


@pytest.mark.parametrize(
    ("turning", "changes"),
    [
        ((0.1, 0.0), ()),
        ((0.05, -0.05), ("initial.state=developed", "time.end=0.03")),
    ],
)
def test_velocity_pressure_torques_and_force_are_those_of_stokes_flow(tmp_path, turning, changes):
    # measured: 7.4e-5, 2.8e-4, 7.5e-5, 2.4e-4; the errors fall with the fourth power of the spacing (tisph verify)
    walls = [f"walls.{name}.angular_velocity={speed}" for name, speed in zip(("inner", "outer"), turning, strict=True)]
    scene, scheme = started(tmp_path, CASE, [*walls, *changes])
    while not scheme.finished:
        scheme.advance()
    found, viscosity = scheme.snapshot(), {"dynamic_viscosity": scene.dynamic_viscosity}
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
