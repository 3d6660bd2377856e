"""Bodies in cells: forces on them, momentum, bodies across the edges of the cell, and bodies that move."""

import numpy as np
import pytest
from case_from_text import to_end

pytestmark = pytest.mark.taichi


def test_momentum_closes(start_flow):
    # a body that oscillates across the edge of the cell: impulse and momentum between two times, by Simpson
    motion = "{amplitude: [20.0, 0.0], angular_frequency: 500.0, phase: sin}"
    body = f"bodies=[{{centre: [0.98, 0.5], radius: 0.25, motion: {motion}}}]"
    times = np.linspace(0.006, 0.01, 9)
    changes = "time.end=0.01", body, "drive.acceleration=0.0"
    scene, scheme = start_flow("array_of_cylinders", *changes, targets=times.tolist())
    found = []
    for time in times:
        while scheme.time < time:
            scheme.advance()
        found.append(scene.diagnostics(scheme.snapshot(), None))
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) * (times[1] - times[0]) / 3
    drag = np.array([each["drag"] for each in found])
    gained = scene.density * scene.region.area * (found[-1]["mean_velocity"] - found[0]["mean_velocity"])
    assert gained == pytest.approx(-weights @ drag, abs=2e-3 * np.abs(drag).max() * (times[-1] - times[0]))


def test_a_body_that_starts_to_move_pushes_the_fluid_away(start_flow):
    # potential flow but for the layer at the body; without the impulse the divergence is 0.7 of the gradient
    body = "bodies=[{centre: [0.8, 0.3], radius: 0.25, motion: {velocity: [20.0, 10.0]}}]"
    scene, scheme = start_flow("array_of_cylinders", body, "drive.acceleration=0.0")
    assert scheme.residual < 0.06
    snapshot = scheme.snapshot()
    assert scene.distance(np.stack([snapshot.x, snapshot.y], axis=1), 0.0).min() > 0.0
    along = (20.0 * snapshot.u + 10.0 * snapshot.v) / 500.0
    assert along.min() < -0.1  # it flows back where the body is broad


def test_a_cylinder_held_in_couette_flow(start_flow):
    # R/H = 0.1, L/H = 1: torque -0.063876 mu rate H^2 and effective viscosity 1.096644 by finite elements, to 1e-6.
    # With 6 spacings across the cylinder the torque is 3.4e-3 off (0.14 without polar coordinates in the rows around),
    # the flow 1.9e-3; with 10 of them 3e-4 and 1.2e-4
    scene, scheme = start_flow("cylinder_held_in_shear")
    found = scene.diagnostics(to_end(scheme), None)
    assert found["torque"] / 10.0 == pytest.approx(-0.063876, rel=1e-2)
    assert -found["drag_top"] / 10.0 == pytest.approx(1.096644, rel=4e-3)
    assert found["drag_bottom"] / 10.0 == pytest.approx(1.096644, rel=4e-3)
    assert abs(found["drag_bottom"] + found["drag_top"] + found["drag"]) < 7e-3 * 10.0  # at rest on the whole; 5e-3


def test_particles_stay_in_a_narrow_gap(start_flow):
    # with images of images as if the walls met in a corner one was pushed out at step 101; measured 0.38 spacings with
    # jitter 0.3 until t = 0.3
    scene, scheme = start_flow("cylinder_above_a_wall")
    end = to_end(scheme)
    places = np.stack([end.x, end.y], axis=1)
    nearest = min(body.nearest(places, end.t).distance.min() for body in scheme.problem.walls.bodies)
    assert nearest > 0.3 * scene.spacing


def test_steps_do_not_follow_what_a_gap_does_not_resolve(start_flow):
    # held to the tolerance alone they were 1500 at t = 0.4
    changes = "bodies.0.centre=[0.75, 0.3125]", "initial.jitter=0.3", "time.end=0.5"
    _, scheme = start_flow("cylinder_above_a_wall", "fluid.kinematic_viscosity=0.01", *changes)
    while not scheme.finished:
        scheme.advance()
        assert scheme.steps < 100  # three times what was measured
