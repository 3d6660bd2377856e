"""Points and their neighbours: complete, periodic, with ghosts, padded, and told where there is no room."""

import dataclasses
import functools

import numpy as np
import pytest

from tisph import runtime
from tisph.numerics.domain import PeriodicDomain
from tisph.numerics.point_cloud import CELLS_WITHIN, LANES, PointCloud, active
from tisph.runtime import view
from tisph.schemes.implicit.planar.problem import Problem

pytestmark = pytest.mark.taichi


@pytest.fixture
def make(shared):
    """``shared`` for scheme implicit, in a channel of twice the length."""
    overrides = ("scheme={type: implicit}", "walls.treatment.type=comoving_image", "geometry.length=2.0")
    return functools.partial(shared, *overrides)


def place(scheme, x, y):
    """Put the particles at (x, y) and list their neighbours."""
    active(scheme.particles.position)[...] = np.stack([x, y], 1)
    scheme.particles.predict(0.0)
    scheme.ghosts.find()
    scheme.points.find_neighbours()


def distances(channel, x, y, others_x, others_y):
    """Distances (particles, others) to the nearest periodic copies."""
    apart = others_x - x[:, None]
    apart -= channel.length * np.round(apart / channel.length)
    return np.hypot(apart, others_y - y[:, None])


def brute_force(scheme, x, y):
    """Distances of all particles to all particles and to all mirror images below and above: (particles, 3, particles).

    A particle is no neighbour of itself.
    """
    gap = scheme.channel.gap
    inside, below, above = (distances(scheme.channel, x, y, x, heights) for heights in (y, -y, 2 * gap - y))
    np.fill_diagonal(inside, np.inf)
    return np.stack([inside, below, above], 1)


def listed(scheme):
    """Whether each particle has each particle, or its image below or above, as a neighbour: (particles, 3, particles).

    Fails where a neighbour is listed twice, or is none of these.
    """
    points, ghosts = scheme.points, scheme.ghosts
    table, begin, end = view(points.neighbours), view(points.begin), view(points.end)
    source, side = view(ghosts.source), ghosts.side
    result = np.zeros((points.fluid, 3, points.fluid), dtype=bool)
    for i in range(points.fluid):
        row = table[begin[i] : end[i]]
        row = row[row != points.sentinel]
        assert len(set(row)) == len(row)
        assert row.min() >= 0
        assert row.max() < points.capacity + points.ghosts[None]
        result[i, 0, row[row < points.capacity]] = True
        beyond = row[row >= points.capacity] - points.capacity
        result[i, 1 + side[beyond], source[beyond]] = True
    return result


def compare_with_brute_force(scheme, x, y):
    """Check that what is nearer than the reach is listed, and nothing else."""
    assert scheme.points.overflow() == 0
    reach = np.sqrt(scheme.points.cutoff_squared[None])
    apart, has = brute_force(scheme, x, y), listed(scheme)
    # pairs at just the reach, as on a lattice, may be in or out: coordinates of size 1e2 at most carry 1e-14
    assert np.all(has[apart < reach - 1e-12])
    assert not np.any(has[apart > reach + 1e-12])


CASES = [
    # order, particles across, jitter, lengths that the upper wall has gone, columns
    *((order, across, jitter, 0.0, 24) for order in (2, 4) for across in (6, 12) for jitter in (0.0, 0.2, 0.45)),
    *((4, 12, 0.2, lengths, 24) for lengths in (-30.7, 0.3, 17.4)),  # rows slide to anywhere relative to one another
    # the fewest columns that make three cells, and periods that cells do not divide evenly
    *((4, 12, 0.4, 0.0, columns) for columns in (10, 11, 23)),
]


@pytest.mark.parametrize(("order", "across", "jitter", "lengths", "columns"), CASES)
def test_neighbours_are_those_of_brute_force(make, order, across, jitter, lengths, columns):
    sizes = f"discretisation.particles_across={across}", f"geometry.length={columns / 12!r}"
    scheme = make(f"scheme.operators.order={order}", *sizes)
    x, y = scheme.channel.jittered(0, jitter)
    x = x + lengths * scheme.channel.length * scheme.channel.lattice()[1]
    place(scheme, x, y)
    compare_with_brute_force(scheme, x, y)


def test_neighbours_on_the_seam_of_the_period(make):
    # at x = 0, just below 0 and just below the length, which rounding may confuse
    scheme = make()
    x, y = scheme.channel.jittered(3, 0.2)
    first, last = x.reshape(scheme.channel.rows, -1)[:, 0], x.reshape(scheme.channel.rows, -1)[:, -1]
    first[::2] = 0.0
    first[1::4] = -1e-17
    last[1::2] = np.nextafter(scheme.channel.length, 0.0)
    place(scheme, x, y)
    assert view(scheme.points.position)[: x.size, 0].min() >= 0.0
    assert view(scheme.points.position)[: x.size, 0].max() < scheme.channel.length
    compare_with_brute_force(scheme, x, y)


def test_rows_are_padded_with_a_far_sentinel_and_follow_one_another(make):
    scheme = make()
    x, y = scheme.channel.jittered(0, 0.3)
    place(scheme, x, y)
    points = scheme.points
    table, begin, end = view(points.neighbours), view(points.begin), view(points.end)
    reach = np.sqrt(points.cutoff_squared[None])
    assert begin[0] == 0
    assert np.array_equal(begin[1 : points.fluid], end[: points.fluid - 1])
    assert distances(scheme.channel, x, y, *view(points.position)[points.sentinel]).min() > 100 * reach
    assert points.mean_length() == pytest.approx((brute_force(scheme, x, y) < reach).sum() / x.size, rel=1e-12)
    for i in range(points.fluid):
        row = table[begin[i] : end[i]]
        assert len(row) % LANES == 0
        padding = np.count_nonzero(row == points.sentinel)
        assert padding < LANES
        assert np.all(row[len(row) - padding :] == points.sentinel)
    before = table.copy()
    points.find_neighbours()  # once more
    assert np.array_equal(view(points.neighbours), before)


def heap(scheme, size):
    """Positions on the lattice, but for ``size`` particles around the centre that stand together on a small circle."""
    channel = scheme.channel
    x, y = channel.lattice()
    centre = np.array([0.5 * channel.length, 0.5 * channel.gap])
    taken = np.argsort(np.hypot(x - centre[0], y - centre[1]), kind="stable")[:size]
    angle = 2 * np.pi * np.arange(size) / size
    x[taken] = centre[0] + 0.1 * channel.spacing * np.cos(angle)
    y[taken] = centre[1] + 0.1 * channel.spacing * np.sin(angle)
    return x, y


def test_a_heap_that_fits_is_not_told(make):
    scheme = make()
    place(scheme, *heap(scheme, scheme.points.row_capacity))
    assert scheme.points.overflow() == 0
    compare_with_brute_force(scheme, *heap(scheme, scheme.points.row_capacity))


@pytest.mark.parametrize("more", [1, 2, 100])
def test_a_row_that_may_not_fit_is_told(make, more):
    scheme = make()
    size = scheme.points.row_capacity + more
    x, y = heap(scheme, size)
    near = np.count_nonzero(brute_force(scheme, x, y) < np.sqrt(scheme.points.cutoff_squared[None]), axis=(1, 2))
    assert near.max() == size - 1  # the rest is out of reach
    place(scheme, x, y)
    assert scheme.points.overflow() == size - 1
    # rows keep what they have room for, and nothing is written beyond them
    table = view(scheme.points.neighbours)
    assert np.max(view(scheme.points.end) - view(scheme.points.begin)) == scheme.points.row_capacity
    assert table.min() >= 0
    assert table.max() <= scheme.points.sentinel


def test_a_period_of_too_few_cells_is_refused(make):
    # a cell on one side would be one on the other side, too, and its points be listed twice
    scheme = make()
    channel, reach = scheme.channel, np.sqrt(scheme.points.cutoff_squared[None])
    columns = int(6.9 / CELLS_WITHIN * reach / channel.spacing)
    short = dataclasses.replace(channel, columns=columns, length=columns * channel.spacing)
    with pytest.raises(ValueError, match="6 cells along x"):
        PointCloud(short, scheme.domain, reach, 0, serial=True)


REACH = 3.0


def box(columns, rows):
    runtime.start("f64", 1)
    numbers = {"density": 1.0, "kinematic_viscosity": 1.0, "reference_velocity": 1.0}
    flow = Problem(columns=columns, rows=rows, n_fluid=columns * rows, spacing=0.1, **numbers)
    return flow, PointCloud(flow, PeriodicDomain(flow.length, flow.height), REACH * flow.spacing, 0, True)


@pytest.mark.parametrize(("columns", "rows"), [(7, 10), (14, 7), (23, 17)])
def test_neighbours_in_a_box_are_those_of_brute_force(columns, rows):
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
    table = view(points.neighbours)
    for i, (begin, end) in enumerate(zip(view(points.begin)[: points.fluid], view(points.end), strict=False)):
        listed = table[begin:end][table[begin:end] != points.sentinel]
        assert np.array_equal(np.sort(listed), np.flatnonzero(near[i] < REACH * flow.spacing))


@pytest.mark.parametrize(("columns", "rows", "axis"), [(6, 20, "x"), (20, 6, "y")])
def test_a_box_of_too_few_cells_is_refused(columns, rows, axis):
    with pytest.raises(ValueError, match=f"6 cells along {axis}"):
        box(columns, rows)
