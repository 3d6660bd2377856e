"""Circular Couette flow: its equation, its walls, two forms, limits, torques and angular momentum, pressure."""

import math
from dataclasses import replace

import numpy as np
import pytest
from exact_collocation import chebyshev_derivatives
from oracles import circular_couette, oscillating_wall
from oracles.circular_couette import CircularCouette, Rotation
from scipy.linalg import expm

from tisph.exact import couette

GAPS = {"wide": (1.0, 5.0), "half": (1.0, 2.0), "narrow": (9.0, 10.0)}
WALLS = {
    "inner starts": (Rotation(1.0), Rotation(0.0)),
    "outer starts": (Rotation(0.0), Rotation(-0.7)),
    "inner stops": (Rotation(0.0, before=1.0), Rotation(0.3, before=0.3)),
    "inner swings": (Rotation(0.4, 0.8, 6.0), Rotation(0.0)),
    "both swing": (Rotation(0.0, 1.0, 2.0, before=0.5), Rotation(0.7, 0.0, 40.0)),
}
gaps = pytest.mark.parametrize("radii", GAPS.values(), ids=GAPS)
walls = pytest.mark.parametrize("motion", WALLS.values(), ids=WALLS)


def flow_of(radii, motion):
    """The flow with viscosity and times such that the gap counts as 1: frequencies are W gap^2/nu."""
    return CircularCouette(*radii, (radii[1] - radii[0]) ** 2, *motion)


def largest_speed(flow):
    sizes = (max(math.hypot(wall.cosine, wall.sine), abs(wall.before)) for wall in (flow.inner, flow.outer))
    return max(size * radius for size, radius in zip(sizes, (flow.inner_radius, flow.outer_radius), strict=True))


def operator(flow, count):
    """Radii from the outer to the inner wall, d/dr and nu (d2/dr2 + 1/r d/dr - 1/r^2) by collocation on them."""
    nodes, first, second = chebyshev_derivatives(count)
    gap = flow.outer_radius - flow.inner_radius
    r = flow.inner_radius + gap * nodes
    first, second = first / gap, second / gap**2
    return r, first, flow.kinematic_viscosity * (second + first / r[:, None] - np.diag(1 / r**2))


@gaps
@walls
@pytest.mark.parametrize("time", [0.02, 0.11, 0.5])
def test_against_an_independent_solution_of_the_equation(radii, motion, time):
    """Collocation in r; the walls' rotating pairs (w, w'/W) are part of the state of a matrix exponential."""
    flow = flow_of(radii, motion)
    r, first, rates = operator(flow, 32)
    matrix, start = np.zeros((35, 35)), np.zeros(35)
    matrix[:31, :31] = rates[1:-1, 1:-1]
    matrix[:31, 31], matrix[:31, 33] = rates[1:-1, 0] * r[0], rates[1:-1, -1] * r[-1]
    for place, wall in ((31, flow.outer), (33, flow.inner)):
        matrix[place, place + 1], matrix[place + 1, place] = wall.angular_frequency, -wall.angular_frequency
        start[place : place + 2] = wall.cosine, wall.sine
    start[:31] = flow.velocity(r[1:-1], 0.0)
    state = expm(time * matrix) @ start
    reference = np.concatenate([[r[0] * state[31]], state[:31], [r[-1] * state[33]]])
    # 2e-12 and 4e-11 as in test_exact_oscillating_wall; the matrix exponential has the walls themselves wrong by more
    # where they stand still for long, and the shear rate of that is some ten times as much
    allowed = 4e-12 * largest_speed(flow) + 2 * np.abs((flow.velocity(r, time) - reference)[[0, -1]]).max()
    assert np.abs(flow.velocity(r, time) - reference).max() <= allowed
    gap = radii[1] - radii[0]
    assert np.abs(flow.shear_rate(r, time) - (first @ reference - reference / r)).max() <= 20 * allowed / gap
    assert allowed <= 1e-10 * largest_speed(flow)


@pytest.mark.parametrize("radii", [GAPS["half"], GAPS["narrow"]])
@walls
def test_the_early_form_and_the_series_agree(radii, motion, monkeypatch):
    """Where they meet, over the layers at both walls, to what the module says."""
    flow = flow_of(radii, motion)
    unit = min(radii[0], radii[1] - radii[0])
    time = 0.999 * circular_couette.EARLY_TIME * unit**2 / flow.kinematic_viscosity
    depth = np.linspace(0.0, 8 * math.sqrt(flow.kinematic_viscosity * time), 25)
    r = np.concatenate([radii[0] + depth, radii[1] - depth])
    early = flow.velocity(r, time), flow.shear_rate(r, time)
    monkeypatch.setattr(circular_couette, "EARLY_TIME", 0.0)
    late = flow.velocity(r, time), flow.shear_rate(r, time)
    assert np.abs(early[0] - late[0]).max() <= 4e-10 * largest_speed(flow)
    assert np.abs(early[1] - late[1]).max() <= 1e-9 * np.abs(late[1]).max()


@gaps
@walls
def test_walls_have_their_velocities(radii, motion):
    flow = flow_of(radii, motion)
    times = np.array([0.0, 1e-9, 1e-4, 0.3, 4.0])
    for wall, radius in ((flow.inner, radii[0]), (flow.outer, radii[1])):
        angle = wall.angular_frequency * times
        speed = radius * (wall.cosine * np.cos(angle) + wall.sine * np.sin(angle))
        assert np.abs(flow.velocity(radius, times) - speed).max() <= 2e-12 * largest_speed(flow)


def test_at_the_start_the_fluid_moves_as_before():
    flow = CircularCouette(1.0, 2.0, 0.1, Rotation(0.0, before=1.0), Rotation(0.2, before=0.2))
    r = np.linspace(1.0, 2.0, 7)
    before = replace(flow, inner=Rotation(1.0)).settled_velocity(r)
    assert np.array_equal(flow.velocity(r, 0.0)[1:-1], before[1:-1])
    assert flow.shear_rate(1.0, 0.0) == math.inf
    assert math.isfinite(flow.shear_rate(2.0, 0.0))
    assert np.abs(flow.velocity(r[1:-1], 1e-5) - before[1:-1]).max() < 1e-12  # layers of 0.002 are not there yet


@gaps
def test_the_developed_flow_is_steady_and_rotates_rigidly_with_both_walls(radii):
    flow = CircularCouette(*radii, 0.3, Rotation(0.7), Rotation(0.7))
    r = np.linspace(*radii, 11)
    assert np.abs(flow.settled_velocity(r) - 0.7 * r).max() <= 1e-14 * radii[1]
    assert np.abs(flow.settled_shear_rate(r)).max() <= 1e-13
    inner = CircularCouette(*radii, 0.3, Rotation(1.0), Rotation(0.0))
    late = 20 * (radii[1] - radii[0]) ** 2 / 0.3
    assert np.abs(inner.velocity(r, late) - inner.settled_velocity(r)).max() <= 1e-13 * radii[0]


@walls
def test_a_narrow_gap_is_a_plane_channel(motion):
    """To first order in gap/radius: errors of two gaps differ by ten."""
    eta, time, errors = np.linspace(0.0, 1.0, 21), 0.06, []
    for curvature in (1e-3, 1e-4):
        radius = 1 / curvature
        inner, outer = (
            replace(wall, cosine=wall.cosine / radius, sine=wall.sine / radius, before=wall.before / radius)
            for wall in motion
        )
        flow = CircularCouette(radius, radius + 1.0, 1.0, inner, outer)
        plane = sum(plane_velocity(eta if wall is motion[1] else 1 - eta, time, wall) for wall in motion)
        errors.append(np.abs(flow.velocity(radius + eta, time) - plane).max())
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)


def plane_velocity(eta, time, wall):
    """Flow in a plane channel of width 1 and viscosity 1 whose wall at eta = 1 moves as ``wall`` turns."""
    channel = {"gap": 1.0, "kinematic_viscosity": 1.0}
    stopped = wall.before * (eta - couette.velocity(eta, time, **channel, bottom=0.0, top=1.0))
    if wall.angular_frequency:
        return stopped + oscillating_wall.velocity(eta, time, **channel, wall=wall)
    return stopped + wall.cosine * couette.velocity(eta, time, **channel, bottom=0.0, top=1.0)


@gaps
@walls
def test_torques_change_the_angular_momentum(radii, motion):
    """dL/dt = -(torque on the inner + torque on the outer cylinder), by central differences of fourth order."""
    flow, density = flow_of(radii, motion), 2.5
    scale = density * flow.kinematic_viscosity * largest_speed(flow) * radii[1] ** 2 / (radii[1] - radii[0])
    for time in (0.05, 0.7):
        step = 1e-4
        before, after = (
            [flow.angular_momentum(time + sign * k * step, density=density) for k in (1, 2)] for sign in (-1, 1)
        )
        rate = (8 * (after[0] - before[0]) - (after[1] - before[1])) / (12 * step)
        # rounding, 1e-13 of the angular momentum over the step
        assert abs(rate + sum(flow.torque(time, density=density))) <= 1e-8 * scale


def test_steady_torques_in_closed_form():
    """4 pi mu R1^2 R2^2/(R2^2 - R1^2) (w2 - w1) on the inner cylinder, the opposite on the outer."""
    flow = CircularCouette(1.0, 2.0, 0.5, Rotation(0.3), Rotation(-0.4))
    torque = 4 * math.pi * (2.0 * 0.5) * 4 / 3 * (-0.4 - 0.3)
    assert flow.settled_torque(density=2.0) == pytest.approx((torque, -torque), rel=1e-14)
    assert flow.torque(100.0, density=2.0) == pytest.approx((torque, -torque), rel=1e-12)


@pytest.mark.parametrize("time", [0.0, 1e-4, 0.01, 0.4])
def test_pressure_balances_the_centripetal_acceleration(time):
    """Differences by Gauss's quadrature of rho u^2/r, and no mean over the area."""
    flow, density = CircularCouette(1.0, 2.0, 1.0, Rotation(0.4, 0.8, 6.0, before=0.3), Rotation(0.7)), 3.0
    before = replace(flow, inner=Rotation(0.3), outer=Rotation(0.0)).settled_velocity
    fine = np.geomspace(1e-3, 0.5, 12)
    edges = np.unique(np.concatenate([1 + fine, 2 - fine, [1.0, 2.0]]))
    node, weight = np.polynomial.legendre.leggauss(24)
    half = 0.5 * np.diff(edges)[:, None]
    r = edges[:-1, None] + half * (1 + node)
    speed = flow.velocity(r, time) if time else before(r)
    expected = np.sum(half * weight * density * speed**2 / r, axis=1)
    assert np.abs(np.diff(flow.pressure(edges, time, density=density)) - expected).max() < 1e-10
    assert abs(np.sum(half * weight * r * flow.pressure(r, time, density=density))) < 1e-10
    momentum = 2 * np.pi * np.sum(half * weight * speed * r**2)
    assert flow.angular_momentum(time, density=1.0) == pytest.approx(momentum, abs=1e-10)


def test_steady_pressure_in_closed_form():
    """p = rho (a^2 r^2/2 + 2 a b ln r - b^2/(2 r^2)) + constant."""
    flow = CircularCouette(1.0, 2.0, 0.5, Rotation(0.3), Rotation(-0.4))
    a, b = (-0.4 * 4 - 0.3) / 3, 0.7 * 4 / 3
    r = np.linspace(1.0, 2.0, 9)
    closed = 2.0 * (a**2 * r**2 / 2 + 2 * a * b * np.log(r) - b**2 / (2 * r**2))
    difference = flow.pressure(r, 0.0, density=2.0, settled=True) - closed
    assert np.ptp(difference) < 1e-14


def test_a_periodic_flow_is_the_same_a_period_later():
    flow = CircularCouette(1.0, 2.0, 0.02, Rotation(0.4, 0.8, 3.0), Rotation(0.0))
    r, period = np.linspace(1.0, 2.0, 9), 2 * np.pi / 3.0
    assert np.abs(flow.settled_velocity(r, 0.3) - flow.settled_velocity(r, 0.3 + period)).max() < 1e-14
    # thin layers, sqrt(2 nu/W) = 0.12: at 1.5 from the outside exp(-4.3) is left
    assert 0.005 < np.abs(flow.settled_velocity(1.5, np.linspace(0, period, 20))).max() < 0.02
    thin = replace(flow, kinematic_viscosity=1e-9)
    assert np.isfinite(thin.settled_velocity(r, 0.3)).all()


def test_what_is_no_annulus_or_before_the_start_is_refused():
    with pytest.raises(ValueError, match="grow outwards"):
        CircularCouette(2.0, 1.0, 1.0, Rotation(1.0), Rotation(0.0))
    with pytest.raises(ValueError, match="starts at t = 0"):
        CircularCouette(1.0, 2.0, 1.0, Rotation(1.0), Rotation(0.0)).velocity(1.5, -1.0)
