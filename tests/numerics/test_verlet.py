"""Neighbour lists: complete, periodic, ordered, and outdated in time."""

import numpy as np
import pytest
from rates import slots_in_use

from tisph.config import schema
from tisph.runtime import view
from tisph.schemes.wcsph.kernels import SKIN
from tisph.schemes.wcsph.verlet import VerletLists

pytestmark = pytest.mark.taichi


def middle_positions(scheme):
    """Fluid and wall positions that the lists refer to, with images where there are any."""
    return scheme.particles.mid_position.to_numpy()[scheme.now][slots_in_use(scheme)]


def missing_pairs(scheme):
    """Pairs (fluid i, any j) closer than the cutoff that the lists lack; brute force."""
    slots, fluid = slots_in_use(scheme), scheme.particles.fluid
    places = middle_positions(scheme)
    apart = places[:fluid, None] - places
    apart[..., 0] -= scheme.scene.length * np.round(apart[..., 0] / scheme.scene.length)
    near = np.hypot(apart[..., 0], apart[..., 1]) < scheme.lists.cutoff
    table, count = view(scheme.lists.table)[:fluid], view(scheme.lists.count)[:fluid]
    listed = np.zeros((fluid, slots.max() + 1), bool)
    row, number = np.nonzero(np.arange(table.shape[1]) < count[:, None])
    listed[row, table[row, number]] = True
    return np.count_nonzero(near & ~listed[:, slots] & (slots != slots[:fluid, None]))


@pytest.mark.parametrize(("treatment", "across"), [("adami", 6), ("comoving_image", 12), ("adami", 25)])
def test_no_pair_is_missing_after_a_build(make, treatment, across):
    scheme = make(
        f"walls.treatment.type={treatment}",
        f"discretisation.particles_across={across}",
        "geometry.length=2.0",
        jitter=0.45,
    )
    assert missing_pairs(scheme) == 0


MOVING = {
    # overrides, jitter, and bounds of the number of times that the lists are made anew
    "comoving_image": (("walls.treatment.type=comoving_image", "time.end=0.6"), 0.3, (1, 75)),
    "adami": (("walls.treatment.type=adami", "time.end=0.6"), 0.3, (1, 75)),
    # the wall goes 0.14, more than a spacing, beside a liquid that it has hardly moved
    "swinging wall": (
        (
            "walls.treatment.type=adami",
            "walls.top={amplitude: 0.5, angular_frequency: 5.0, phase: sin}",
            "fluid.kinematic_viscosity=1e-4",
            "time.end=0.4",
        ),
        0.0,
        (0, 75),
    ),
}


@pytest.mark.parametrize(("overrides", "jitter", "bounds"), MOVING.values(), ids=MOVING)
def test_no_pair_is_missing_while_the_lists_are_reused(make, overrides, jitter, bounds):
    # checked in each step: many between two builds
    scheme = make(*overrides, jitter=jitter)
    while not scheme.finished:
        scheme.advance()
        drifts = scheme.stepper.drift_squared[None], *(drift**2 for drift in scheme.boundaries.drifts())
        if scheme.lists.outdated(max(drifts), scheme.middle - scheme.built):
            scheme.rebuild()
        assert missing_pairs(scheme) == 0
    assert bounds[0] < scheme.rebuilds < bounds[1]


def test_a_uniform_shear_hardly_wears_the_lists_out(make):
    sheared = make("initial.state=developed", "time.end=4.0")
    while not sheared.finished:
        sheared.advance()
    # by a shear of 2 in all, each build lasting a shear of about 2 SKIN / support = 0.067
    assert sheared.rebuilds < 2 / 0.067 * 1.5


def test_particles_stand_in_cell_order(make):
    scheme = make(jitter=0.4)
    rows, columns = scheme.cells.rows[None], scheme.cells.columns[None]
    start = view(scheme.cells.start)[scheme.cells.start.used].reshape(rows + 2, columns + 1)
    places = middle_positions(scheme)
    for row in range(1, rows + 1):
        for column in range(columns):
            inside = places[start[row, column] : start[row, column + 1]]
            assert np.all(inside[:, 0] * columns / scheme.scene.length // 1 == column)
            assert np.all(inside[:, 1] * rows / scheme.scene.gap // 1 == row - 1)
    assert start[rows, -1] == scheme.particles.fluid
    before = scheme.particles.identity.to_numpy()[scheme.now]
    scheme.rebuild()  # particles of one cell keep their order
    assert np.array_equal(scheme.particles.identity.to_numpy()[scheme.now], before)


@pytest.mark.parametrize(("capacity", "told"), [(8, 28), (27, 28), (28, 28), (29, 0)])
def test_a_row_that_may_not_fit_is_told(make, capacity, told):
    # 28 neighbours within reach on the square lattice; a full row may have lost its last one
    scheme = make()
    lists = VerletLists(scheme.cells, scheme.lists.cutoff, scheme.scene.spacing, serial=True)
    lists.capacity = capacity
    lists.build(scheme.now)
    assert lists.overflow() == told


def test_a_row_names_each_neighbour_once_and_ends_with_its_own_particle(make):
    scheme = make(jitter=0.2)
    table, count = scheme.lists.table.to_numpy(), scheme.lists.count.to_numpy()
    for i in range(scheme.particles.fluid):
        row = table[i, : count[i]]
        assert i not in row
        assert len(set(row)) == len(row)
        assert table[i, count[i]] == i


def test_the_config_leaves_room_for_the_skin():
    # the checks of a config, which know no Taichi, have a number of their own for the least length
    assert schema.SKIN >= SKIN
