"""Least-squares rows on disordered particles, what becomes of them where neighbours do not suffice, and the solver."""

import numpy as np
import pytest

from tisph.numerics import SUPPORT
from tisph.numerics.bicgstab import BiCGStab
from tisph.runtime import view

pytestmark = pytest.mark.taichi

IMPLICIT = ("scheme={type: implicit}", "walls.treatment.type=comoving_image")


@pytest.fixture
def assembled(shared):
    """Return a function that gives a Scheme at rest with its operators assembled."""

    def build(*overrides, jitter=0.0):
        scheme = shared(*IMPLICIT, *overrides)
        position = np.stack(scheme.channel.jittered(0, jitter), 1)
        scheme.start(position, np.zeros_like(position))
        scheme.particles.arrange(0.0)
        return scheme

    return build


def rows_of(scheme):
    """Rows (laplacian, d_dx, d_dy) and the vectors (x, y) that they go with, in spacings: (particles, row_capacity).

    Both are 0 beyond the last neighbour.
    """
    points, spacing = scheme.points, scheme.channel.spacing
    entries, listed = points.rows_of(slice(points.fluid))
    table, place = view(points.neighbours)[entries], view(points.position)
    listed &= table != points.sentinel
    apart = place[np.where(listed, table, 0)] - place[: points.fluid, None]
    apart[..., 0] -= scheme.channel.length * np.round(apart[..., 0] / scheme.channel.length)
    scales = {"laplacian": spacing**2, "d_dx": spacing, "d_dy": spacing}
    rows = [
        np.where(listed, view(getattr(scheme.operators, name))[entries], 0.0) * scale for name, scale in scales.items()
    ]
    return rows, np.where(listed[..., None], apart, 0.0) / spacing


def errors(scheme, order):
    """Largest error of each particle's rows over all monomials x^a y^b, 1 <= a + b <= order, in spacings."""
    (laplacian, d_dx, d_dy), apart = rows_of(scheme)
    x, y = apart[..., 0], apart[..., 1]
    worst = np.zeros(len(x))
    for a in range(order + 1):
        for b in range(order + 1 - a):
            if a + b == 0:
                continue
            values = x**a * y**b
            exact = (2.0 * ((a, b) in ((2, 0), (0, 2))), float((a, b) == (1, 0)), float((a, b) == (0, 1)))
            for row, value in zip((laplacian, d_dx, d_dy), exact, strict=True):
                worst = np.maximum(worst, np.abs((row * values).sum(axis=1) - value))
    return worst


# rounding of 1e-16, in sums of 30 terms of up to 3^4 = 81, times the condition of the systems, 1e2 to 1e4 with jitter
ROUNDING = 1e-10


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("jitter", [0.0, 0.1, 0.3])
def test_rows_are_exact_for_polynomials_up_to_their_order(assembled, order, jitter):
    scheme = assembled(f"scheme.operators.order={order}", jitter=jitter)
    assert errors(scheme, order).max() < ROUNDING
    assert scheme.operators.order_reduced[None] == scheme.operators.singular[None] == 0
    rows, apart = rows_of(scheme)
    beyond = np.hypot(apart[..., 0], apart[..., 1]) >= SUPPORT[order]
    assert np.count_nonzero(beyond) > 0
    assert all(np.all(row[beyond] == 0.0) for row in rows)
    if jitter == 0.3:  # a cell holds terms of the next degree with weights of about 1
        assert np.median(errors(scheme, order + 1)) > 1e-2


def give_neighbours(scheme, i, neighbours):
    """Let particle ``i`` have these neighbours alone, and compute all rows anew."""
    points = scheme.points
    table, free = view(points.neighbours), int(view(points.end).max())  # behind all rows
    padded = -(-len(neighbours) // 4) * 4
    table[free : free + padded] = points.sentinel
    table[free : free + len(neighbours)] = neighbours
    view(points.begin)[i], view(points.end)[i] = free, free + padded
    scheme.operators.assemble()


CENTRE = 6 * 12 + 6


def nearest(number):
    """Return a function that gives the ``number`` nearest particles of the one at the centre of the channel."""

    def found(place):
        return np.argsort(np.hypot(*(place - place[CENTRE]).T), kind="stable")[1 : number + 1]

    return found


def three_rows(place):
    """14 neighbours on the heights -1, 0, 1, where y^3 is y: however many there are, order 4 has no answer."""
    apart = 12 * np.abs(place - place[CENTRE])
    return np.flatnonzero((apart[:, 0] < 2.5) & (apart[:, 1] < 1.5) & (apart.max(axis=1) > 0.5))


def line(step):
    """Return a function that gives four neighbours on a line."""
    return lambda place: CENTRE + step * np.array([-2, -1, 1, 2])


FEW = {
    # order asked for, jitter, the neighbours of one particle, the order that is left for it
    **{f"{number} neighbours": (4, 0.2, nearest(number), 2) for number in (6, 8, 13)},  # 14 unknowns, 5 of order 2
    "three rows": (4, 0.0, three_rows, 2),
    **{f"order {n}, {m} neighbours": (n, 0.2, nearest(m), 0) for n in (2, 4) for m in (0, 1, 4)},
    **{f"order {n}, {way}": (n, 0.0, line(step), 0) for n in (2, 4) for way, step in (("row", 1), ("column", 12))},
    "diagonal": (4, 0.0, line(13), 0),
    "one place": (4, 0.2, lambda place: np.full(20, CENTRE + 1), 0),
}


@pytest.mark.parametrize("case", FEW)
def test_too_few_neighbours_leave_a_lower_order_or_nothing(assembled, case):
    order, jitter, choose, left = FEW[case]
    scheme = assembled(f"scheme.operators.order={order}", jitter=jitter)
    give_neighbours(scheme, CENTRE, choose(view(scheme.points.position)[: scheme.points.fluid]))
    assert (scheme.operators.order_reduced[None], scheme.operators.singular[None]) == ((1, 0) if left else (0, 1))
    if left:
        assert errors(scheme, left)[CENTRE] < ROUNDING
        assert errors(scheme, order)[CENTRE] > 1e-3
    else:
        assert all(np.all(row[CENTRE] == 0.0) for row in rows_of(scheme)[0])
    assert np.delete(errors(scheme, order), CENTRE).max() < ROUNDING  # those of all others are as they were


def test_singular_neighbourhoods_are_counted_anew_each_time(assembled):
    scheme = assembled(jitter=0.2)
    for i in (CENTRE, CENTRE + 2):
        give_neighbours(scheme, i, [i + 1])
    assert scheme.operators.singular[None] == 2
    scheme.particles.arrange(0.0)
    assert (scheme.operators.order_reduced[None], scheme.operators.singular[None]) == (0, 0)


def matrix_of(scheme, parity):
    """The rows of the Laplacian as a square matrix; ghosts have ``parity`` times what their source has."""
    points = scheme.points
    table, begin, end = view(points.neighbours), view(points.begin), view(points.end)
    rows, source = view(scheme.operators.laplacian), view(scheme.ghosts.source)
    matrix = np.zeros((points.fluid, points.fluid))
    for i in range(points.fluid):
        for j, value in zip(table[begin[i] : end[i]], rows[begin[i] : end[i]], strict=True):
            matrix[i, i] -= value
            if j < points.fluid:
                matrix[i, j] += value
            elif j < points.sentinel:
                matrix[i, source[j - points.capacity]] += parity * value
    return matrix


def set_right_side(solver, b, guess=None):
    """Give the solver ``b`` and a guess, zero without."""
    view(solver.b)[: b.size] = b
    view(solver.x)[: b.size] = 0.0 if guess is None else guess


@pytest.fixture
def counted(monkeypatch):
    """Return a function that gives a list, which grows with every iteration of a solver."""

    def count(solver):
        done, step = [], solver.step_half
        monkeypatch.setattr(solver, "step_half", lambda: (done.append(None), step()))
        return done

    return count


def solution(solver):
    return view(solver.x)[: solver.points.fluid].copy()


RESIDUAL = 1e-10
# coefficient, sigma: short and long viscous steps (times spacing^2), and hardly any sigma
SYSTEMS = [(1.0, 1.0), (30.0, 1.0), (-1.0, -1e-3)]


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize(("coefficient", "sigma"), SYSTEMS)
def test_the_solver_agrees_with_a_dense_one(assembled, order, coefficient, sigma):
    scheme = assembled(f"scheme.operators.order={order}", jitter=0.2)
    if sigma > 0:
        coefficient *= scheme.channel.spacing**2
    matrix = sigma * np.eye(scheme.points.fluid) - coefficient * matrix_of(scheme, -1.0)
    b = np.random.default_rng(0).uniform(-1.0, 1.0, scheme.points.fluid)
    solver = BiCGStab(scheme.operators, scheme.ghosts)
    set_right_side(solver, b)
    assert solver.solve(coefficient, RESIDUAL, sigma=sigma, max_iterations=1000)
    # what a residual of this size can mean; the residual that the recursion carries is off by rounding of 1e-14 or so
    farthest = np.linalg.norm(np.linalg.inv(matrix), 2) * RESIDUAL * np.linalg.norm(b)
    assert np.linalg.norm(solution(solver) - np.linalg.solve(matrix, b)) <= 1.01 * farthest


def test_the_solver_takes_fewer_iterations_from_a_good_guess(assembled, counted):
    scheme = assembled(jitter=0.2)
    solver, coefficient = scheme.closed.solver, 10 * scheme.channel.spacing**2
    exact = np.random.default_rng(0).uniform(-1.0, 1.0, scheme.points.fluid)
    iterations = counted(solver)
    for solved in (exact, np.zeros_like(exact)):  # the solution as a guess, and a right side of 0
        set_right_side(solver, solved - coefficient * matrix_of(scheme, -1.0) @ solved, solved)
        assert solver.solve(coefficient, RESIDUAL)
        assert not iterations
        assert np.array_equal(solution(solver), solved)
    b = exact
    set_right_side(solver, b)
    assert solver.solve(coefficient, RESIDUAL)
    from_zero, result = len(iterations), solution(solver)
    set_right_side(solver, b, result + 1e-6 * b)
    assert solver.solve(coefficient, RESIDUAL)
    assert np.allclose(solution(solver), result, rtol=0, atol=1e3 * RESIDUAL)  # twice the norm of b, with room
    assert 0 < len(iterations) - from_zero < from_zero


@pytest.mark.parametrize("most", [0, 1])
def test_the_solver_tells_when_it_has_not_converged(assembled, counted, most):
    scheme = assembled(jitter=0.2)
    b = np.random.default_rng(0).uniform(-1.0, 1.0, scheme.points.fluid)
    solver = BiCGStab(scheme.operators, scheme.ghosts)
    iterations = counted(solver)
    set_right_side(solver, b)
    assert solver.solve(100 * scheme.channel.spacing**2, RESIDUAL, max_iterations=most) is False
    assert len(iterations) == solver.iterations == most
    assert np.all(np.isfinite(solution(solver)))
    set_right_side(solver, np.full(scheme.points.fluid, np.nan))
    assert not solver.solve(10 * scheme.channel.spacing**2, RESIDUAL)
