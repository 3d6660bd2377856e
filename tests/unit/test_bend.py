"""How rows near walls know the curvature of these."""

from types import SimpleNamespace

import numpy as np
import pytest

from tisph.schemes._splitting._wall_points import WallPoints


def test_operators_use_polar_coordinates_near_curved_walls_only():
    """Of particles 0.2 from walls of radius 1, from outside and inside, from a flat one, and too far from one."""
    normal = np.array([[0.6, 0.8], [0.0, 1.0], [1.0, 0.0], [0.6, 0.8]])
    planes = np.column_stack([normal, np.zeros(4)])[:, None]
    distances, curvatures = np.array([0.2, 0.2, 0.2, 1.0])[:, None], np.array([1.0, -1.0, 0.0, 1.0])[:, None]
    found = WallPoints.polar_map(SimpleNamespace(spacing=0.1), planes, distances, curvatures)
    assert found == pytest.approx(np.array([[0.6 / 1.2, -0.8 / 1.2], [0.0, 1.0 / 0.8], [0.0, 0.0], [0.0, 0.0]]))
