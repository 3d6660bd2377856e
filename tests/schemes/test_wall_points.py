"""How rows near walls know the curvature of these."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.polygon import Polygon
from tisph.schemes._two_dimensional.wall_points import WallPoints


def test_operators_use_polar_coordinates_near_curved_walls_only():
    """Of particles 0.2 from walls of radius 1, from outside and inside, from a flat one, and too far from one."""
    normal = np.array([[0.6, 0.8], [0.0, 1.0], [1.0, 0.0], [0.6, 0.8]])
    planes = np.column_stack([normal, np.zeros(4)])[:, None]
    distances, curvatures = np.array([0.2, 0.2, 0.2, 1.0])[:, None], np.array([1.0, -1.0, 0.0, 1.0])[:, None]
    found = WallPoints.polar_map(SimpleNamespace(spacing=0.1), None, planes, distances, curvatures)
    assert found == pytest.approx(np.array([[0.6 / 1.2, -0.8 / 1.2], [0.0, 1.0 / 0.8], [0.0, 0.0], [0.0, 0.0]]))


def curvatures_along(shape, spacing):
    """Those that operators use along a line half a spacing off the wall of a body across the edge of a cell."""
    body = Body(shape, (0.05, 2.0), angle=0.3, periods=(4.0, np.inf))
    boundary = body.boundary_points(0.05 * spacing)
    points = boundary.point + 0.5 * spacing * boundary.normal
    return WallPoints([body], spacing, (0.0, 0.0)).nearest_walls(points % [4.0, 9.0], 0.0)[2][:, 0]


def test_curvature_varies_continuously_where_corners_begin():
    """By a part of its window at most every twentieth of a spacing; its jump would be one of the operators."""
    square = Polygon(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)), 0.4)
    found = curvatures_along(square, 0.1)
    assert np.abs(np.diff(found)).max() < 0.06 * 2.5
    assert found.max() == pytest.approx(2.5, rel=0.05)
    assert found.min() == 0.0


def test_curvature_of_a_circle_is_that_of_its_radius():
    assert curvatures_along(Circle(0.4), 0.1) == pytest.approx(2.5, rel=1e-12)
