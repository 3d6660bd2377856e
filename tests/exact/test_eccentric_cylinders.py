"""Stokes flow between eccentric cylinders: its equations, no slip, forces and torques, which determine it."""

import numpy as np
import pytest

from tisph.exact.eccentric_cylinders import EccentricCylinders

VISCOSITY = {"dynamic_viscosity": 0.7}
FLOWS = [
    EccentricCylinders(1.0, 2.0, distance, inner, outer)
    for distance in (0.0, 1e-9, 0.5, 0.9)
    for inner, outer in ((1.0, 0.0), (0.0, 1.0), (1.0, -0.5))
]


def circle(centre, radius, count=400):
    """Points on a circle around (``centre``, 0), and unit vectors outwards."""
    angle = 2 * np.pi * np.arange(count) / count
    normal = np.stack([np.cos(angle), np.sin(angle)])
    return np.array([[centre], [0.0]]) + radius * normal, normal


def places(flow, shares=(0.1, 0.5, 0.8)):
    """Points between the cylinders, on circles from the inner to the outer one."""
    circles = [
        circle((1 - share) * flow.distance, flow.inner_radius + share * (flow.outer_radius - flow.inner_radius))
        for share in shares
    ]
    return np.concatenate([points for points, _ in circles], axis=1)


def slopes(function, points, step):
    """Derivatives of a function of x and y along both, by central differences of fourth order."""
    x, y = points
    along = [lambda h: function(x + h, y), lambda h: function(x, y + h)]
    return [(8 * (f(step) - f(-step)) - (f(2 * step) - f(-2 * step))) / (12 * step) for f in along]


def gradient(flow, points, step=1e-3):
    """Velocity gradient [component][direction]."""
    return [slopes(lambda x, y, k=k: flow.velocity(x, y)[k], points, step) for k in (0, 1)]


def tractions(flow, centre, radius):
    """Force and torque around (``centre``, 0) on what is within a circle, by the trapezoidal rule."""
    points, normal = circle(centre, radius, 2000)
    slope = np.array(gradient(flow, points[:, None], 2e-4))[:, :, 0]  # places of any shape
    stress = VISCOSITY["dynamic_viscosity"] * (slope + np.swapaxes(slope, 0, 1))
    traction = np.einsum("ijn,jn->in", stress, normal) - flow.pressure(*points, **VISCOSITY) * normal
    arm = points - np.array([[centre], [0.0]])
    return 2 * np.pi * radius * np.array([*traction.mean(axis=1), np.mean(arm[0] * traction[1] - arm[1] * traction[0])])


@pytest.mark.parametrize("flow", FLOWS)
def test_the_fluid_sticks_to_both_cylinders(flow):
    for centre, radius, turning in ((flow.distance, 1.0, flow.inner), (0.0, 2.0, flow.outer)):
        points, normal = circle(centre, radius)
        wall = turning * radius * np.array([-normal[1], normal[0]])
        assert np.abs(flow.velocity(*points) - wall).max() < 1e-12  # round-off, which the narrow gap magnifies


@pytest.mark.parametrize("flow", FLOWS)
def test_velocity_pressure_and_vorticity_obey_the_stokes_equations(flow):
    # differences of fourth order over 1e-3, whose own error is that of fifth derivatives, (1e-3/gap)^4
    points, viscosity = places(flow), VISCOSITY["dynamic_viscosity"]
    (ux, uy), (vx, vy) = gradient(flow, points)
    scale = np.abs([ux, uy, vx, vy]).max()
    assert np.abs(ux + vy).max() < 1e-8 * scale
    assert np.abs(vx - uy - flow.vorticity(*points)).max() < 1e-8 * scale
    px, py = slopes(lambda x, y: flow.pressure(x, y, **VISCOSITY), points, 1e-3)
    wx, wy = slopes(flow.vorticity, points, 1e-3)  # of a velocity without divergence lap u = (-w_y, w_x)
    size = viscosity * max(np.abs([wx, wy]).max(), scale)
    assert np.abs(px + viscosity * wy).max() < 1e-8 * size
    assert np.abs(py - viscosity * wx).max() < 1e-8 * size


@pytest.mark.parametrize("flow", FLOWS)
def test_force_and_torque_are_those_of_the_stress_on_any_circle(flow):
    inner, outer = flow.torque(**VISCOSITY)
    force = flow.force(**VISCOSITY)
    room = 2.0 - 1.0 - flow.distance
    size = 1e-7 * max(1.0, np.abs([*force, inner, outer]).max())  # of the differences
    for distance in (0.2, 0.8):
        assert tractions(flow, flow.distance, 1.0 + distance * room) == pytest.approx([*force, inner], abs=size)
        assert tractions(flow, 0.0, 2.0 - distance * room) == pytest.approx([*force, -outer], abs=size)


def test_a_small_eccentricity_changes_the_flow_in_proportion():
    """No digits are lost on the way to coaxal cylinders: the force per distance goes to a limit."""
    forces = [EccentricCylinders(1.0, 2.0, d, 1.0, 0.5).force(**VISCOSITY)[1] / d for d in (1e-2, 1e-4, 1e-6)]
    assert forces[1] == pytest.approx(forces[2], rel=1e-7)  # the next part is d^2; round-off 1e-15/d
    assert forces[0] == pytest.approx(forces[2], rel=1e-3)


def test_a_narrow_gap_bears_sommerfelds_load():
    """Force 12 pi mu U (R/c)^2 e/((2 + e^2) sqrt(1 - e^2)) of lubrication theory, up to the clearance c over R."""
    clearance, eccentricity = 1e-3, 0.6
    flow = EccentricCylinders(1.0, 1.0 + clearance, eccentricity * clearance, 1.0, 0.0)
    force, shape = flow.force(dynamic_viscosity=1.0)[1], (2 + eccentricity**2) * np.sqrt(1 - eccentricity**2)
    assert force == pytest.approx(12 * np.pi * eccentricity / (clearance**2 * shape), rel=3 * clearance)


@pytest.mark.parametrize("distance", [1.0, 1.5, -1.0])
def test_cylinders_that_touch_are_refused(distance):
    with pytest.raises(ValueError, match="is not within"):
        EccentricCylinders(1.0, 2.0, distance, 1.0, 0.0)
