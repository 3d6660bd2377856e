"""Bodies that the flow carries: at rest, released, in shear, and in contact."""

import math
from dataclasses import replace

import numpy as np
import pytest
from flows import flow_config

import tisph
from tisph.measures.fits import cell_mean
from tisph.measures.resolution import resolution
from tisph.schemes.implicit.planar.free_bodies import RESIDUAL

pytestmark = pytest.mark.taichi

SHEAR = flow_config("free_circle_in_shear")
CELL = flow_config("free_circle_in_a_cell")


LONGER = {**CELL, "time": {"end": 0.1, "samples": [0.1]}}


def changed(config, **of_body):
    """The ``config`` with other keys of its first body."""
    first, *others = config["bodies"]
    return {**config, "bodies": [{**first, **of_body}, *others]}


def ended(config, until=None):
    """The bodies of a run at its end or at the time ``until``, and its scheme."""
    with tisph.Simulation(config) as simulation:
        simulation.run_until(until or config["time"]["end"])
        return simulation.scheme.snapshot().bodies, simulation.scheme


def added_mass(fraction):
    """Added mass coefficient of a square array of circles, by Rayleigh's conductivity of one that insulates.

    W. T. Perrins, D. R. McKenzie, R. C. McPhedran, Proc. R. Soc. A 369 (1979) 207-225, eq. 15.
    """
    more = 0.305827 * fraction**4 / (1.0 - 1.402958 * fraction**8) + 0.013362 * fraction**8
    conductivity = 1.0 - 2.0 * fraction / (1.0 + fraction - more)
    return (1.0 - fraction - conductivity) / fraction


@pytest.mark.parametrize(("drive", "velocity"), [(CELL["drive"], [0.0, 0.0]), ({"acceleration": 1.0}, [0.1, 0.0])])
def test_body_as_heavy_as_the_fluid_rests_or_falls_with_it(drive, velocity):
    bodies, _ = ended({**LONGER, "drive": drive})
    assert np.abs(bodies.velocity - velocity).max() < 1e-12  # of sqrt(g R) = 0.4: rounding errors alone
    assert np.abs(bodies.angular_velocity).max() < 1e-12


def test_a_drift_without_walls_is_measured_and_not_resolved():
    """All moved faster by a twentieth of the body's velocity against the fluid is a drift of so much more."""
    drawn = changed({**CELL, "drive": {"acceleration": -1.0}}, force=[1.0, 0.0])
    drawn["fluid"] = {"density": 1.0, "kinematic_viscosity": 0.1}
    with tisph.Simulation({**drawn, "time": {"end": 0.1, "samples": [0.1]}}) as simulation:
        simulation.run_until(0.1)
        scene, snapshot = simulation.scene, simulation.scheme.snapshot()
    before, apart = scene.drift(snapshot), snapshot.bodies.velocity[0, 0] - cell_mean(scene, snapshot)[0]
    assert before < 2e-3  # of the impulse of 0.1 a step keeps some 1e-4, of a velocity of 0.26
    faster = 0.05 * apart
    bodies = replace(snapshot.bodies, velocity=snapshot.bodies.velocity + np.array([faster, 0.0]))
    moved = replace(snapshot, u=snapshot.u + faster, bodies=bodies)
    assert scene.drift(moved) == pytest.approx(0.05, abs=before + 1e-4)
    resolved, reason = resolution(scene, 0.1, moved)
    assert not resolved
    assert "drift together by 0.05" in reason


@pytest.mark.parametrize("density", [0.0, 2.0, 1000.0])
def test_first_acceleration_of_a_released_body_is_that_of_potential_flow(density):
    _, scheme = ended(changed(CELL, density=density), 1e-6)
    motion = scheme.boundary.parts[0].bodies.motions[0]
    exact = (1.0 - density) / (density + added_mass(math.pi * 0.15**2))
    assert motion.change[1] == pytest.approx(exact, rel=5e-3)
    assert abs(motion.change[0]) < 1e-3 * abs(exact)


def test_cylinder_in_slow_shear_rotates_as_by_finite_elements():
    bodies, _ = ended(SHEAR)
    assert bodies.angular_velocity[0] == pytest.approx(-0.482223, rel=6e-3)  # 4e-3; 6e-4 with 40 across, third order
    assert np.abs(bodies.velocity[0]).max() < 2e-3
    assert abs(bodies.torque[0]) < 1e-3  # of 0.1, what holds one that does not turn


def test_massless_circle_at_once_rotates_as_the_fluid_around_it():
    """Half the shear rate, clockwise, which is the circulation of a uniform shear along any circle; until it decays."""
    config = changed({**SHEAR, "initial": {"state": "developed"}}, density=0.0)
    start, _ = ended(config, 1e-9)
    assert start.angular_velocity[0] == pytest.approx(-0.5, rel=1e-2)  # a layer far thinner than the spacing
    later, _ = ended(config, 1e-3)
    assert -0.5 < later.angular_velocity[0] < -0.48


def test_held_freedoms_stay():
    bodies, _ = ended(changed(SHEAR, hold=["y", "angle"], velocity=[0.0, 0.0], force=[0.0, 1.0], torque=1.0), 0.01)
    assert bodies.angular_velocity[0] == 0.0
    assert bodies.velocity[0, 1] == 0.0
    assert abs(bodies.torque[0]) > 0.1


def test_ellipse_turned_by_half_a_turn_rotates_alike():
    ellipse = {"type": "ellipse", "centre": [0.5, 0.5], "half_axes": [0.2, 0.15], "motion": "free"}
    one, other = (ended({**SHEAR, "bodies": [{**ellipse, "angle": angle}]}, 0.02)[0] for angle in (0.3, 0.3 + math.pi))
    assert one.angular_velocity[0] == pytest.approx(other.angular_velocity[0], rel=1e-3)  # other wall points


def test_force_that_is_reported_is_the_one_that_moves_a_body():
    config = {**changed(CELL, density=2.0, force=[0.3, 0.0]), "fluid": {"density": 1.0, "kinematic_viscosity": 0.1}}
    bodies, scheme = ended({**config, "time": {"end": 0.05, "samples": [0.05]}})
    mass = 2.0 * math.pi * 0.15**2
    motion = scheme.boundary.parts[0].bodies.motions[0]
    load = [0.3, -0.5 * mass]  # from outside, and weight less buoyancy
    # to which velocities are found, times what multiplies the newest in the acceleration
    rounding = RESIDUAL * scheme.tolerance * scheme.error_speed * 2.0 * mass / scheme.dts[0]
    assert mass * motion.acceleration(scheme.time) - load == pytest.approx(bodies.force[0], abs=rounding)


def test_bodies_pushed_together_touch_and_are_counted():
    pair = [
        {"type": "circle", "centre": [x, 0.5], "radius": 0.15, "motion": "free", "force": [pull, 0.0]}
        for x, pull in ((0.32, 1.0), (0.72, -1.0))
    ]
    fluid = {"density": 1.0, "kinematic_viscosity": 0.1}
    longer = {"end": 0.4, "samples": [0.4]}
    _, scheme = ended({**CELL, "fluid": fluid, "bodies": pair, "drive": {}, "time": longer})
    free = scheme.boundary.parts[0].bodies
    assert free.contact.count == 1
    assert free.contact.largest > 0.0
    assert min(free.gaps.values()) > 0.0
