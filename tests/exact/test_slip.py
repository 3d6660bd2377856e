"""Start-up flow along walls with slip: against modes, whose eigenvalue equations have the slip lengths (b, b')."""

import numpy as np
import pytest

from tisph.exact._fluids import ViscoelasticFluid
from tisph.exact.start_up import CircularStartUp, Flow, PipeStartUp, SlippingWall, StartUp, Wall
from tisph.geometry.motion import StressControlledWall, WallMotion

WATER = ViscoelasticFluid(1.0, ())
ACCURACY = 1e-8
"""Of the solution, relative to the wall speed; the values have eight digits."""


def wall(slip_length, motion):
    """A wall in a fluid of viscosity 1."""
    return SlippingWall(motion, 1.0 / slip_length) if slip_length else motion


def plane(below, above, speed, acceleration):
    """The flow between planes 1 apart."""
    return Flow(1.0, wall(below, Wall()), wall(above, Wall(speed)), acceleration)


SHEARED, DRIVEN, FILM = plane(0.1, 0.05, 1.0, 0.0), plane(0.1, 0.05, 0.0, 1.0), plane(0.0, np.inf, 0.0, 1.0)
BOTH_SLIP, OUTER_SLIPS = (wall(0.1, Wall(1.0)), wall(0.2, Wall())), (Wall(1.0), wall(np.inf, Wall()))
STARTS = [
    # flow between planes or walls between cylinders, time, u at five places from wall to wall, torque per length
    (SHEARED, 0.02, [3.6058183e-7, 8.7287172e-5, 0.0071455212, 0.14400882, 0.81117872], None),
    (SHEARED, 0.5, [0.083017293, 0.29219937, 0.50685556, 0.72821844, 0.95449845], None),
    (DRIVEN, 0.1, [0.027035903, 0.072009318, 0.083335763, 0.067582842, 0.015385383], None),
    (FILM, 0.02, [0.0, 0.018303352, 0.019952027, 0.019999618, 0.019999998], None),
    (FILM, 0.5, [0.0, 0.16124274, 0.26874072, 0.32991594, 0.34972726], None),
    (BOTH_SLIP, 0.02, [0.60539382, 0.088872813, 0.0038019805, 4.124461e-5, 1.8304556e-7], None),
    (BOTH_SLIP, 0.5, [0.79516633, 0.53468291, 0.34748866, 0.20514879, 0.091618546], None),
    (BOTH_SLIP, 20.0, [0.8, 0.55, 11 / 30, 0.2214285714, 0.1], 4.0 * np.pi),
    # the layer of a wall that jumps reaches a wall without friction
    (OUTER_SLIPS, 0.02, [1, 0.18773253, 0.010062646, 0.00013269105, 8.2842524e-7], None),
    (OUTER_SLIPS, 0.5, [1, 0.77645147, 0.64934459, 0.60673099, 0.64639283], 0.0),
    (OUTER_SLIPS, 20.0, [1, 1.25, 1.5, 1.75, 2], 0.0),
]


@pytest.mark.parametrize(("case", "time", "expected", "torque"), STARTS)
def test_start_up_between_planes_and_between_cylinders(case, time, expected, torque):
    if isinstance(case, Flow):
        solution, first = StartUp(WATER, case), 0.0
    else:
        solution, first = CircularStartUp(1.0, 2.0, WATER, *case), 1.0
    assert np.abs(solution.velocity(first + np.linspace(0.0, 1.0, 5), time) - expected).max() < ACCURACY
    if torque is not None:
        assert solution.torque(time, density=1.0)[1] == pytest.approx(torque, rel=1e-8, abs=1e-7)


def test_periodic_flow_of_an_oscillating_wall_with_slip():
    flow = Flow(1.0, wall(0.05, Wall()), wall(0.1, WallMotion(1.0, 0.0, 20.0)))
    cosine = [-0.011057848, -0.057297594, -0.039756963, 0.17133465, 0.71764595]
    sine = [0.0045792006, 0.045257723, 0.15136002, 0.28725289, 0.17253877]
    found, angle = StartUp(WATER, flow, flow), 20.0 * 0.7
    expected = np.array(cosine) * np.cos(angle) + np.array(sine) * np.sin(angle)
    assert np.abs(found.velocity(np.linspace(0.0, 1.0, 5), 0.7) - expected).max() < ACCURACY


def test_developed_flow_stays_the_parabola_with_slip():
    y, found = np.linspace(0.0, 1.0, 21), StartUp(WATER, DRIVEN, DRIVEN)
    expected = -0.5 * y**2 + 0.55 / 1.15 * (y + 0.1)
    assert np.abs(found.velocity(y, [[0.0], [0.3]]) - expected).max() < ACCURACY


def test_after_a_jump_the_stress_is_that_of_the_whole_speed():
    found = StartUp(WATER, SHEARED)
    assert found.shear_stress(np.array([0.0, 1.0]), 0.0) == pytest.approx([0.0, 20.0])
    # u at the wall grows as 2 sqrt(t/pi)/b
    late = 20.0 - 400.0 * 2.0 * np.sqrt(1e-7 / np.pi)
    assert found.shear_stress(1.0, 1e-7) == pytest.approx(late, abs=20.0 * 400.0 * 1e-7 * 1.1)


def test_a_wall_under_stress_moves_with_a_wall_that_jumps():
    found = StartUp(WATER, Flow(1.0, Wall(1.0), StressControlledWall(0.5)))
    assert found.velocity(np.array([0.0, 1.0]), 20.0) == pytest.approx([1.0, 1.5], abs=ACCURACY)


def test_spin_up_and_pipe():
    spin_up = CircularStartUp(0.0, 1.0, WATER, Wall(), wall(0.1, Wall(1.0)))
    expected = [0.096068988, 0.26405767, 0.93069895]
    assert np.abs(spin_up.velocity(np.array([0.25, 0.5, 1.0]), 0.1) - expected).max() < ACCURACY
    pipe = PipeStartUp((0.0, 1.0), WATER, (Wall(), wall(0.1, Wall())), acceleration=4.0)
    expected = [1.0772242, 0.86105667, 0.18504691]
    assert np.abs(pipe.velocity(np.array([0.0, 0.5, 1.0]), 0.5) - expected).max() < 5e-8  # seven digits
