"""Viscous systems of a channel: solved, in a bounded number of iterations where there are many particles."""

import numpy as np
import pytest
from implicit_case import IMPLICIT, SLOW, run

from tisph.numerics import least_squares as operators
from tisph.numerics.auxiliary_grid import DirichletGrid
from tisph.numerics.point_cloud import active
from tisph.runtime import real, ti, view
from tisph.schemes.implicit.channel import operators as _operators
from tisph.simulation import checkpoint

pytestmark = pytest.mark.taichi

RESIDUAL = 1e-10
LONG = 30.0  # viscous number of a long step


@pytest.fixture
def two_levels(monkeypatch):
    """Let the solver of two levels serve the smallest channels, and the shortest steps."""
    monkeypatch.setattr(_operators, "FEW", 0)
    monkeypatch.setattr(_operators, "ROUGH", 0.0)


@pytest.fixture
def assembled(shared):
    """Return a function that gives a Scheme in disorder with its operators assembled."""

    def build(*overrides):
        scheme = shared(*IMPLICIT, *overrides)
        scheme.start(*disorder(scheme.channel))
        scheme.particles.arrange(0.0)
        return scheme

    return build


def disorder(channel):
    position = np.stack(channel.jittered(0, 0.2), 1)
    return position, np.zeros_like(position)


def solved(scheme, known, viscous_number, residual=RESIDUAL):
    """Solve for ``known`` from nothing; return solution and iterations."""
    solver, fluid = scheme.closed.solver, scheme.points.fluid
    view(solver.b)[:fluid], view(solver.x)[:fluid] = known, 0.0
    assert solver.solve(viscous_number * scheme.channel.spacing**2, residual)
    return view(solver.x)[:fluid].copy(), solver.iterations


# --- the lattice


@pytest.fixture
def lattice(assembled):
    scheme = assembled()
    lattice = DirichletGrid(scheme.points, scheme.channel, scheme.channel.gap)
    return lattice, lattice.nodes(real()), scheme.channel


def on_nodes(lattice, field):
    """The nodes' values (rows, columns), in place."""
    rows, columns = lattice.shape
    return view(field)[: rows * columns].reshape(rows, columns)


@pytest.mark.parametrize(("across", "along"), [(1, 0), (1, 1), (5, 2), (11, 5)])
def test_a_wave_that_vanishes_at_the_walls_is_divided_by_its_eigenvalue(lattice, across, along):
    lattice, nodes, _ = lattice
    rows, columns = lattice.shape
    row, column = np.arange(rows)[:, None], np.arange(columns)
    wave = np.sin(np.pi * across * row / rows) * np.cos(2 * np.pi * along * column / columns + 0.3)
    on_nodes(lattice, nodes)[...] = wave
    # the second differences of five points, the spacings being 1/12
    minus_laplacian = 4 * 12**2 * (np.sin(0.5 * np.pi * across / rows) ** 2 + np.sin(np.pi * along / columns) ** 2)
    lattice.invert(nodes, 1.0, 0.02)
    expected = wave / (1.0 + 0.02 * minus_laplacian)
    assert np.abs(on_nodes(lattice, nodes) - expected).max() < 1e-14  # rounding of some 100 sums


def test_the_inverse_is_symmetric_and_vanishes_at_the_walls(lattice):
    lattice, nodes, _ = lattice
    first, second = np.random.default_rng(0).normal(size=(2, *lattice.shape))
    first[0] = second[0] = 0.0
    images = []
    for values in (first, second):
        on_nodes(lattice, nodes)[...] = values
        lattice.invert(nodes, 1.0, 0.02)
        images.append(on_nodes(lattice, nodes).copy())
    assert np.vdot(first, images[1]) == pytest.approx(np.vdot(second, images[0]), rel=1e-12)
    assert not images[0][0].any()


@ti.data_oriented
class Transfers:
    """``grid`` from particles to nodes and back: what nodes get of ``given``, and particles of ``nodes``."""

    def __init__(self, lattice, nodes):
        self.lattice, self.nodes, self.points = lattice, nodes, lattice.points
        self.given, self.found = (ti.field(real(), shape=self.points.capacity) for _ in range(2))

    @ti.kernel
    def up(self):
        for node in range(self.lattice.rows[None] * self.lattice.columns[None]):
            self.nodes[node] = self.lattice.deposit(self.given, node)

    @ti.kernel
    def down(self):
        for i in range(self.points.fluid):
            self.found[i] = self.lattice.interpolate(self.nodes, i)


def test_particles_get_from_the_nodes_by_the_weights_by_which_they_gave(lattice):
    lattice, nodes, _ = lattice
    lattice.sort()
    carried, fluid = Transfers(lattice, nodes), lattice.points.fluid
    random = np.random.default_rng(0)
    given, values = random.normal(size=fluid), random.normal(size=lattice.shape)
    view(carried.given)[:fluid] = given
    carried.up()
    gained = on_nodes(lattice, nodes).copy()
    on_nodes(lattice, nodes)[...] = values
    carried.down()
    # as many nodes as particles here, so that no share is taken
    assert np.vdot(values, gained) == pytest.approx(np.vdot(view(carried.found)[:fluid], given), rel=1e-12)
    # bilinear: waves as long as the box, at the places of the particles
    on_nodes(lattice, nodes)[...] = np.cos(2 * np.pi * np.arange(lattice.shape[1]) / lattice.shape[1])
    carried.down()
    expected = np.cos(2 * np.pi * view(lattice.points.position)[:fluid, 0])
    assert np.abs(view(carried.found)[:fluid] - expected).max() < 0.125 * (2 * np.pi / 12) ** 2  # f'' dx^2 / 8


# --- the systems


def laplacian_of(scheme):
    """The rows of the Laplacian as a square matrix, ghosts having minus what they mirror: from products with units."""
    operators = scheme.closed
    return np.stack([operators.laplacian(unit) for unit in np.eye(scheme.points.fluid)], 1)


@pytest.mark.parametrize("overrides", [(), ("walls.treatment.type=virtual_image",)], ids=["mirrored", "virtual"])
def test_two_levels_solve_what_the_rows_say(two_levels, assembled, overrides):
    scheme = assembled(*overrides)
    matrix = np.eye(scheme.points.fluid) - LONG * scheme.channel.spacing**2 * laplacian_of(scheme)
    known = np.random.default_rng(0).uniform(-1.0, 1.0, scheme.points.fluid)
    scheme.closed.solver.roughest = 0.0  # it may have been built for another test
    found, _ = solved(scheme, known, LONG)
    assert scheme.closed.solver.two_level is not None
    # what a residual of this size can mean, and rounding of the residual that the recursion carries
    farthest = np.linalg.norm(np.linalg.inv(matrix), 2) * RESIDUAL * np.linalg.norm(known)
    assert np.linalg.norm(found - np.linalg.solve(matrix, known)) <= 1.01 * farthest


@pytest.mark.parametrize(("few", "viscous_number"), [(10**4, LONG), (0, 0.9 * _operators.ROUGH)])
def test_few_particles_and_short_steps_do_without(assembled, monkeypatch, few, viscous_number):
    monkeypatch.setattr(_operators, "FEW", few)
    scheme = assembled()
    scheme.closed.solver.two_level, scheme.closed.solver.roughest = None, _operators.ROUGH * scheme.channel.spacing**2
    solved(scheme, np.ones(scheme.points.fluid), viscous_number)
    assert scheme.closed.solver.two_level is None


# --- runs: with Schemes of their own, whose fields take the place of those above


def test_iterations_depend_neither_on_particles_nor_on_the_time_step(two_levels, make):
    # measured 4.5 and 4.5; with the diagonal alone 33 and 117
    counts = []
    for across in (12, 48):
        scheme = make(*IMPLICIT, f"discretisation.particles_across={across}", jitter=0.2)
        scheme.particles.arrange(0.0)
        x, y = active(scheme.particles.position).T
        known = np.random.default_rng(0).normal(size=across**2) + np.sin(np.pi * y) + np.cos(2 * np.pi * x)
        counts.append(max(solved(scheme, known, number)[1] for number in (1.0, LONG, across**2)))
    assert counts[1] <= 1.5 * counts[0]
    assert counts[1] < 8


def flow(make, *overrides, **words):
    return make(*IMPLICIT, "initial.jitter=0.2", "time.end=4.0", *overrides, **words)


def test_a_run_has_the_velocities_of_one_with_the_diagonal_alone(make, monkeypatch):
    slow = f"walls.top.velocity={SLOW}"  # or errors in the places that grow would be compared
    before = run(flow(make, slow))
    monkeypatch.setattr(_operators, "FEW", 0)
    monkeypatch.setattr(_operators, "ROUGH", 0.0)
    scheme = flow(make, slow)
    after = run(scheme)
    assert scheme.closed.solver.two_level is not None
    assert after.step == before.step
    # a residual of 1e-3 of a step's tolerance of 1e-5 in each of some 20 steps of three stages
    assert np.linalg.norm(after.u - before.u) < 60 * 1e-8 * np.linalg.norm(before.u)


@pytest.mark.other_program
def test_one_and_two_threads_and_a_restart_are_bitwise_reproducible(two_levels, make, monkeypatch, tmp_path):
    for name in ("FEW", "FEW_NUMBERS"):
        monkeypatch.setattr(operators, name, 0)  # or small loops would stay on one thread
    one = flow(make)
    for _ in range(6):
        one.advance()
    checkpoint.save(tmp_path / "state.h5", one, "fingerprint")
    whole = run(one)
    resumed = flow(make, started=False)
    checkpoint.restore(tmp_path / "state.h5", resumed, "fingerprint")
    again, other = run(resumed), run(flow(make, "runtime.threads=2"))
    for name in ("t", "x", "y", "u", "v"):
        assert np.array_equal(getattr(again, name), getattr(whole, name)), name
        assert np.array_equal(getattr(other, name), getattr(whole, name)), name
