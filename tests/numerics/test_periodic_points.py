"""Neighbours in a box without walls: complete, across both seams, each once."""

import numpy as np
import pytest

from tisph import runtime
from tisph.neighbours.point_cloud import PointCloud
from tisph.periodic import PeriodicDomain
from tisph.runtime import view
from tisph.schemes._two_dimensional import PeriodicProblem

pytestmark = pytest.mark.taichi

REACH = 3.0


def box(columns, rows):
    runtime.start("f64", 1)
    numbers = {"density": 1.0, "kinematic_viscosity": 1.0, "reference_velocity": 1.0}
    flow = PeriodicProblem(columns=columns, rows=rows, spacing=0.1, **numbers)
    return flow, PointCloud(flow, PeriodicDomain(flow.length, flow.height), REACH * flow.spacing, 0, True)


@pytest.mark.parametrize(("columns", "rows"), [(7, 10), (14, 7), (23, 17)])
def test_neighbours_are_those_of_brute_force(columns, rows):
    flow, points = box(columns, rows)
    size = np.array([flow.length, flow.height])
    place = np.random.default_rng(0).uniform(0, 1, (columns * rows, 2)) * size
    place[:3], place[3:6, 1] = 0.0, np.nextafter(flow.height, 0.0)
    place[1:3, 0] = 0.03, 0.05
    view(points.position)[: points.fluid] = place
    points.find_neighbours()
    assert points.overflow() == 0
    apart = place - place[:, None]
    near = np.linalg.norm(apart - size * np.round(apart / size), axis=2)
    np.fill_diagonal(near, np.inf)
    for i, (row, count) in enumerate(zip(view(points.neighbours), view(points.count), strict=False)):
        if i == points.fluid:
            break
        listed = row[:count][row[:count] != points.sentinel]
        assert np.array_equal(np.sort(listed), np.flatnonzero(near[i] < REACH * flow.spacing))


@pytest.mark.parametrize(("columns", "rows", "axis"), [(6, 20, "x"), (20, 6, "y")])
def test_a_period_of_too_few_cells_is_refused(columns, rows, axis):
    with pytest.raises(ValueError, match=f"6 cells along {axis}"):
        box(columns, rows)
