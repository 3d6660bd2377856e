"""Start-up of an Oldroyd-B fluid: two forms, independent solutions, balances, limits, printed values."""

import numpy as np
import pytest
from exact_collocation import chebyshev_derivatives
from oldroyd_b_cases import ACCURACY, BOTH, COUETTE, FLUIDS, HEIGHTS, LINEAR, POISEUILLE, THIN, largest_difference
from oracles import _oldroyd_start, oldroyd_b
from oracles._oldroyd_start import Problem, Steady
from oracles.oldroyd_b import Flow
from scipy.integrate import quad
from scipy.linalg import expm

TABLE = {  # y = .1 .3 .5 .7 .9 in Couette flow, .1 .3 .5 in Poiseuille flow, of the fluid THIN
    ("velocity", "couette", 1.0): (0.18837393, 0.51395357, 0.73159931, 0.86299985, 0.95698233),
    ("velocity", "couette", 2.0): (0.07543081, 0.23467316, 0.41726273, 0.63147394, 0.87345356),
    ("shear_stress", "couette", 1.0): (0.52351457, 0.55325028, 0.58167385, 0.59244866, 0.59365406),
    ("shear_stress", "couette", 2.0): (0.80163681, 0.79419950, 0.78007766, 0.76335854, 0.75171871),
    ("normal_stress", "couette", 1.0): (0.34514637, 0.40614249, 0.49690080, 0.58756211, 0.67580284),
    ("velocity", "poiseuille", 0.5): (0.11261632, 0.28754440, 0.35463554),
    ("velocity", "poiseuille", 1.0): (0.06691634, 0.16173109, 0.19462959),
    ("velocity", "poiseuille", 5.0): (0.04578851, 0.10706435, 0.12755168),
}


@pytest.mark.parametrize(("quantity", "drive", "time"), TABLE)
def test_printed_values(quantity, drive, time):
    """Values of an independent solution: half a unit of the last decimal, but 1e-7 for its coarser normal stress."""
    expected = TABLE[quantity, drive, time]
    y = np.array([0.1, 0.3, 0.5, 0.7, 0.9])[: len(expected)]
    flow = {"couette": COUETTE, "poiseuille": POISEUILLE}[drive]
    computed = getattr(oldroyd_b, quantity)(y, time, fluid=THIN, flow=flow)
    assert np.max(np.abs(computed - expected)) <= (1e-7 if quantity == "normal_stress" else 0.51e-8)


@pytest.mark.parametrize("fluid", FLUIDS)
@pytest.mark.parametrize("flow", [COUETTE, POISEUILLE])
def test_contour_and_modes_agree_where_one_takes_over(fluid, flow):
    problem = oldroyd_b._problem(fluid, flow, None)
    time = _oldroyd_start.SWITCH * problem.solvent_fraction * problem.elasticity
    by_contour = _oldroyd_start.early(problem, HEIGHTS, time)
    by_modes = _oldroyd_start.late(problem, HEIGHTS, time)
    for contour, modes in zip(by_contour, by_modes, strict=True):
        assert largest_difference(contour, modes) <= ACCURACY


def collocated(fluid, flows, time, count):
    """Each flow with (nodes from 1 down to 0, velocity, stress), from rest, gap and density 1.

    Collocation in y and a matrix exponential in t: no transform and no mode in it.
    """
    nodes, first, second = chebyshev_derivatives(count)
    inner, size, rate = slice(1, -1), count - 1, 1 / fluid.relaxation_time
    matrix = np.zeros((size + count + 1, size + count + 1))
    matrix[:size, :size] = fluid.solvent_viscosity * second[inner, inner]
    matrix[:size, size:] = first[inner]
    matrix[size:, :size] = rate * fluid.polymer_viscosity * first[:, inner]
    matrix[size:, size:] = -rate * np.eye(count + 1)
    decay = expm(time * matrix)
    for flow in flows:
        walls = np.array([flow.top, flow.bottom])
        on_liquid = flow.acceleration + fluid.solvent_viscosity * second[inner][:, [0, -1]] @ walls
        on_stress = rate * fluid.polymer_viscosity * first[:, [0, -1]] @ walls
        steady = -np.linalg.solve(matrix, np.concatenate([on_liquid, on_stress]))
        state = steady - decay @ steady
        yield flow, (nodes, np.concatenate([[flow.top], state[:size], [flow.bottom]]), state[size:])


@pytest.mark.parametrize("fluid", FLUIDS)
@pytest.mark.parametrize("time", [0.3, 2.0])
def test_against_an_independent_solution_of_the_equations(fluid, time):
    for flow, (nodes, velocity, stress) in collocated(fluid, (COUETTE, POISEUILLE, BOTH), time, 64):
        # rounding in the reference grows with the number of nodes: 5e-12 at 64, 2e-11 at 96; for the stress, small
        # beside the viscous one where the polymer is a tenth, 6e-10 and 2e-9
        assert largest_difference(oldroyd_b.velocity(nodes, time, fluid=fluid, flow=flow), velocity) <= 2e-11
        assert largest_difference(oldroyd_b.shear_stress(nodes, time, fluid=fluid, flow=flow), stress) <= 2e-9


def waters_king(height, time, solvent_fraction, elasticity, terms):
    """Velocity over developed mean velocity by the series of Waters and King; ``height`` from mid gap over half gap.

    ``time`` is over relaxation time, ``elasticity`` relaxation time * viscosity/(density * half gap^2).
    """
    n = (2 * np.arange(1, terms + 1) - 1) * np.pi
    alpha = 1 + solvent_fraction * elasticity * n**2 / 4
    beta = np.sqrt((alpha**2 - elasticity * n**2).astype(complex))
    gamma = 1 - (2 - solvent_fraction) * elasticity * n**2 / 4
    # (cosh + (gamma/beta) sinh) exp(-alpha time/2), each with its own exponential: cosh alone would overflow
    slow, fast = np.exp((beta - alpha) * time / 2), np.exp(-(beta + alpha) * time / 2)
    factor = ((1 + gamma / beta) * slow + (1 - gamma / beta) * fast).real / 2
    return 1.5 * (1 - height**2) - 48 * np.sin(np.outer(1 + height, n) / 2) @ (factor / n**3)


@pytest.mark.parametrize("fluid", FLUIDS[:5])
@pytest.mark.parametrize("time", [0.1, 0.5, 2.0])
def test_against_the_series_of_waters_and_king(fluid, time):
    flow, half = Flow(2.0, acceleration=0.3), 1.0
    total = fluid.solvent_viscosity + fluid.polymer_viscosity
    mean = fluid.density * flow.acceleration * half**2 / (3 * total)
    elasticity = fluid.relaxation_time * total / fluid.density / half**2
    heights = np.linspace(-0.9, 0.9, 19)
    numbers = (time / fluid.relaxation_time, fluid.solvent_viscosity / total, elasticity)
    velocity = oldroyd_b.velocity(half * (1 + heights), time, fluid=fluid, flow=flow)
    # terms fall as 48/(n^3 pi^3) at least, and between the walls those left out cancel in pairs, to the last of them
    # over sin(0.05 pi): 1.2e-12 at 10000
    expected = mean * waters_king(heights, *numbers, terms=10000)
    assert np.max(np.abs(velocity - expected)) <= 1e-11 * np.max(np.abs(expected))


@pytest.mark.parametrize(("fraction", "elasticity", "k"), [(0.75, 1.0, 2.0), (0.1, 1.0, np.pi), (0.5, 0.01, np.pi)])
def test_modes_with_equal_complex_and_real_eigenvalues(fraction, elasticity, k):
    """One mode against the exponential of its matrix; in the first case the eigenvalues are equal to the last bit."""
    flow, rest = Steady(bottom=0.3, top=-0.7, drive=2.0), Steady(0.0, 0.0, 0.0)
    problem = Problem(fraction, elasticity, rest, flow)
    matrix = np.array([[-fraction * k**2, -k], [(1 - fraction) * k / elasticity, -1 / elasticity]])
    discriminant = np.trace(matrix) ** 2 - 4 * k**2 / elasticity
    assert discriminant == 0 if k == 2 else abs(discriminant) > 1
    start = np.array(_oldroyd_start._modes(problem, np.array([k]), 0.0))[:, 0]
    for time in (0.01, 0.3):
        computed = np.array(_oldroyd_start._modes(problem, np.array([k]), time))[:, 0]
        # rounding of eigenvalues up to 110, times the time, in exponents
        assert np.max(np.abs(computed - expm(time * matrix) @ start)) <= 1e-14 * np.max(np.abs(start))


@pytest.mark.parametrize("fluid", FLUIDS)
@pytest.mark.parametrize("before", [None, Flow(1.0, bottom=0.2, top=-0.5, acceleration=3.0)])
@pytest.mark.parametrize("time", [1e-3, 0.2, 3.0])
def test_momentum_balance_with_the_total_stress_on_the_walls(fluid, before, time):
    """d/dt int density u dy = tau(H) - tau(0) + density g H, tau = solvent viscosity * u_y + S_xy."""
    arguments = {"fluid": fluid, "flow": BOTH, "before": before}
    points, weights = np.polynomial.legendre.leggauss(150)
    step = 1e-3 * time
    later, earlier = (weights @ oldroyd_b.velocity((points + 1) / 2, time + h, **arguments) / 2 for h in (step, -step))
    walls = np.array([0.0, 1.0])
    stress = oldroyd_b.total_shear_stress(walls, time, **arguments)
    solvent = fluid.solvent_viscosity * oldroyd_b.shear_rate(walls, time, **arguments)
    assert stress == pytest.approx(solvent + oldroyd_b.shear_stress(walls, time, **arguments), rel=1e-14)
    # the central difference of sqrt(t) is off by 1/8 (step/t)^2 = 1e-7 of it, of an oscillation at 5/time by 4e-6
    scale = 3.0 + np.abs(stress).sum()
    assert (later - earlier) / (2 * step) == pytest.approx(stress[1] - stress[0] + 3.0, abs=4e-6 * scale)


@pytest.mark.parametrize("time", [0.05, 0.5, 4.0])
def test_stresses_obey_their_equations(time):
    """relaxation_time dS/dt + S = source, with polymer_viscosity u_y and 2 relaxation_time u_y S_xy."""
    arguments = {"fluid": THIN, "flow": BOTH, "before": Flow(1.0, top=-0.5)}
    rate, shear = (function(HEIGHTS, time, **arguments) for function in LINEAR[1:])
    step = 1e-4 * time
    for function, source in ((oldroyd_b.shear_stress, 0.9 * rate), (oldroyd_b.normal_stress, 2 * rate * shear)):
        later, earlier = (function(HEIGHTS, time + h, **arguments) for h in (step, -step))
        residual = (later - earlier) / (2 * step) + function(HEIGHTS, time, **arguments) - source
        # the central difference is off by (step/t)^2 = 1e-8, and has the accuracy, 1e-11, over 2 step >= 1e-5
        assert np.max(np.abs(residual)) <= 1e-6 * np.max(np.abs(source))


@pytest.mark.parametrize("height", [0.0, 0.3, 0.97])
@pytest.mark.parametrize("before", [None, Flow(1.0, bottom=0.2, top=-0.5)])
def test_normal_stress_is_the_integral_over_the_history(height, before):
    """Adaptive quadrature in sqrt(s) at one height: other panels, and no interpolation across the gap."""
    arguments, time = {"fluid": THIN, "flow": BOTH, "before": before}, 1.3

    def integrand(root):
        rate, shear = (function(height, root**2, **arguments) for function in LINEAR[1:])
        return 4 * root * np.exp(root**2 - time) * rate * shear

    history = quad(integrand, 1e-9, np.sqrt(time), epsabs=1e-8, epsrel=1e-8, limit=200)[0]
    old = oldroyd_b.developed_normal_stress(height, fluid=THIN, flow=before) if before else 0.0
    expected = old * np.exp(-time) + history
    assert oldroyd_b.normal_stress(height, time, **arguments) == pytest.approx(expected, abs=2e-8)
