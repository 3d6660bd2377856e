"""Flow in a sliding corner: the equations that it obeys, by differences, and what inertia it leaves near the corner."""

import numpy as np
import pytest

from tisph.exact.sliding_corner import CornerSingularity
from tisph.schemes.implicit.planar.corner_singularities import CornerSingularities

NU, SPEED = 0.01, 1.3
WAYS = np.eye(2)


def corner(reach=0.4, share=1.0, speed=SPEED):
    return CornerSingularity((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), 0.5 * np.pi, speed, NU, reach, share)


@pytest.fixture
def points():
    away = np.random.default_rng(0).uniform(0.05, 0.6, (20, 2))
    return np.array([0.0, 1.0]) + away * [1.0, -1.0]


def slopes(function, points, step=1e-6):
    pairs = [(function(points + step * way), function(points - step * way)) for way in WAYS]
    return np.stack([(ahead - back) / (2 * step) for ahead, back in pairs], axis=1)


def laplacian(function, points, step=1e-3):
    weights = {-2: -1, -1: 16, 0: -30, 1: 16, 2: -1}
    return sum(w * function(points + k * step * way) for way in WAYS for k, w in weights.items()) / (12 * step**2)


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_gradient_and_forces_are_those_of_velocity_and_pressure(points, share):
    flow = corner(share=share)
    gradient = flow.gradient(points)
    # central differences: step^2/6 of the third derivatives, some 2 U/r^3, is 3e-9 in 0.05 from the corner
    assert np.abs(gradient - slopes(flow.velocity, points)).max() < 1e-8
    assert np.abs(gradient[:, 0, 0] + gradient[:, 1, 1]).max() < 1e-13
    forces = NU * laplacian(flow.velocity, points) - slopes(flow.pressure, points)
    # the same of fourth order: (step/r)^4 = 2e-7 there, times factorials
    assert np.abs(forces - flow.acceleration(points)).max() < 5e-6 * np.abs(forces).max()


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_walls_slide_and_rest(speed):
    flow, away = corner(speed=speed), np.linspace(0.1, 1.0, 5)
    lid, wall = (np.stack(pair, 1) for pair in ((away, 1.0 + 0 * away), (0 * away, 1.0 - away)))
    assert np.allclose(flow.velocity(lid), [speed, 0.0], rtol=0, atol=1e-13)
    assert np.allclose(flow.velocity(wall), 0.0, rtol=0, atol=1e-13)


def test_the_second_part_carries_the_inertia_of_the_first():
    """With it u . grad u - nu lap u + grad p stays finite in the corner; of slow flow alone it goes like 1/r."""
    theta = np.linspace(0.1, 1.5, 9)
    ways = np.stack([np.cos(theta), -np.sin(theta)], 1)

    def defect(flow, radius):
        points = np.array([0.0, 1.0]) + radius * ways
        force = np.einsum("ni,nij->nj", flow.velocity(points), flow.gradient(points)) - flow.acceleration(points)
        return np.abs(force).max()

    whole, slow = corner(reach=1e3), corner(reach=1e3, share=0.0)
    assert defect(slow, 1e-4) == pytest.approx(10 * defect(slow, 1e-3), rel=1e-9)
    assert defect(whole, 1e-4) == pytest.approx(defect(whole, 1e-3), rel=0.01)  # r U/nu = 0.13 is the next term
    assert defect(whole, 1e-4) < 1e-3 * defect(slow, 1e-4)


def test_a_wall_feels_the_pressure_of_all_corners_along_its_normal():
    corners = object.__new__(CornerSingularities)  # without the paths of particles
    corners.corners, corners.origin = [corner(), corner(speed=-0.4)], np.array([0.0, 0.5])
    place, normal = np.array([[0.3, 0.5], [0.0, 0.1]]), np.array([[0.0, -1.0], [1.0, 0.0]])
    viscous, pressed = corners.traction(place, normal, NU)
    pressure, gradient = (
        sum(getattr(flow, name)(place + corners.origin) for flow in corners.corners)
        for name in ("pressure", "gradient")
    )
    assert pressed == pytest.approx(-pressure[:, None] * normal)
    strain = gradient + gradient.transpose(0, 2, 1)
    assert viscous == pytest.approx(NU * np.stack([-strain[0, 1], strain[1, 0]]))
