"""Open ends of pipes and axisymmetric regions: exact flows carried through, a sphere in the stream, a constriction."""

import numpy as np
import pytest

import tisph

pytestmark = pytest.mark.taichi

INLET, OUTLET = {"type": "inlet", "velocity": 1.0}, {"type": "outlet"}
SPIN = 2.0
PIPE = {
    "scene": "pipe",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.05},
    "geometry": {"radius": 1.0, "length": 2.0},
    "walls": {"outer": {"angular_velocity": SPIN}},
    "ends": {"left": INLET, "right": OUTLET},
    "initial": {"state": "developed"},
    "discretisation": {"particles_across": 12},
    "time": {"end": 1.2},
    "runtime": {"threads": 1},
}
OF_STEPS = 2e-5
"""A parabola and solid rotation are exact with operators of order 4. What remains are the residuals of the linear
systems and the errors of steps, 2e-6 of the velocity each, ten times over."""


def finished(config, **changes):
    with tisph.Simulation({**config, **changes}) as simulation:
        while not simulation.finished:
            simulation.step()
        snapshot = simulation.scheme.snapshot()
        return simulation.scene, snapshot, simulation.scene.diagnostics(snapshot, [])


@pytest.mark.parametrize("viscosity", [0.05, 20.0], ids=["splitting", "together"])
def test_a_pipe_that_turns_carries_its_rotation_through(viscosity):
    """Solid rotation W, a parabola and the pressure W^2 r^2/2 - 8 nu U x/R^2 solve the equations exactly."""
    _, snapshot, found = finished(PIPE, fluid={"density": 1.0, "kinematic_viscosity": viscosity})
    assert np.abs(snapshot.u - 2.0 * (1.0 - snapshot.y**2)).max() < 10 * OF_STEPS
    assert np.abs(snapshot.v).max() < 10 * OF_STEPS
    assert np.abs(snapshot.w / snapshot.y - SPIN).max() < 10 * OF_STEPS * SPIN
    drop = 8.0 * viscosity * 2.0
    assert found["pressure_drop"] == pytest.approx(drop, rel=1e-3)
    assert found["force_outer"] == pytest.approx(np.pi * drop, rel=1e-4)  # the balance of momentum
    pressure = 0.5 * SPIN**2 * (snapshot.y**2 - 1.0) + 0.5 * drop * (2.0 - snapshot.x)  # 0 on the rim of the outlet
    assert np.abs(snapshot.pressure - pressure).max() < 1e-3 * max(drop, SPIN**2)
    assert abs(found["mass_imbalance"]) < OF_STEPS
    assert snapshot.passages.sum() > len(snapshot.x) / 2


def test_flow_between_pipes_leaves_an_outlet_on_the_left_without_inertia():
    """Circular Couette flow and the logarithmic profile have errors of polynomials, at the ends above all."""
    scene, snapshot, found = finished(
        PIPE,
        fluid={"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False},
        geometry={"radius": 1.0, "length": 2.0, "inner_radius": 0.4},
        walls={"outer": {"angular_velocity": -0.5}, "inner": {"angular_velocity": 1.0}},
        ends={"left": OUTLET, "right": INLET},
        initial={"state": "rest"},
        time={"end": 0.6},
    )
    radius, part = snapshot.y, 0.84 / np.log(0.4)
    profile = 2.0 * (1.0 - radius**2 - part * np.log(radius)) / (1.16 + part)
    assert np.abs(snapshot.u + profile).max() < 4e-3
    vortex = 1.5 * 0.16 / 0.84
    assert np.abs(snapshot.w / radius - (-0.5 + vortex * (1.0 / radius**2 - 1.0))).max() < 1e-2
    inside = np.abs(snapshot.x - 1.0) < 0.5
    assert np.abs(snapshot.u + profile)[inside].max() < 4e-4
    drop = 16.0 / (1.16 + part)
    assert found["pressure_drop"] == pytest.approx(drop, rel=2e-3)
    assert found["outflow"] == pytest.approx(0.84 * np.pi, rel=1e-3)
    assert scene.inlet.area == pytest.approx(0.84 * np.pi)


SPHERE = {
    "scene": "region",
    "coordinates": "axisymmetric",
    "fluid": {"density": 1.0, "kinematic_viscosity": 1.0, "inertia": False},
    "geometry": {"length": 4.0, "height": 1.0},
    "ends": {"left": INLET, "right": OUTLET},
    "runtime": {"threads": 1},
}
