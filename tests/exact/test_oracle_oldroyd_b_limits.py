"""Start-up of an Oldroyd-B fluid: limits, starts, symmetries, shapes, units and refusals."""

import warnings

import numpy as np
import pytest
from oldroyd_b_cases import (
    ACCURACY,
    ALL,
    BOTH,
    COUETTE,
    DEVELOPED,
    FLUIDS,
    HEIGHTS,
    LINEAR,
    THIN,
    largest_difference,
)
from oracles import _oldroyd_normal, _oldroyd_start, oldroyd_b, poiseuille
from oracles.oldroyd_b import Flow, Fluid

from tisph.exact import couette


def test_early_wall_is_that_of_a_half_space_of_solvent():
    """For t -> 0 u_y = U/sqrt(pi nu_s t) and S = 2 (eta_p/lambda) U sqrt(t/(pi nu_s)); hence S_xx = 2 t u_y S."""
    time = 1e-5
    rate, shear, normal = (function(1.0, time, fluid=THIN, flow=COUETTE) for function in ALL[1:])
    # the polymer's own share grows with eta_p t/(lambda eta_s) = 9e-5
    assert rate == pytest.approx(1 / np.sqrt(np.pi * 0.1 * time), rel=1e-4)
    assert shear == pytest.approx(0.9 * 2 * np.sqrt(time / (np.pi * 0.1)), rel=1e-4)
    assert normal == pytest.approx(2 * time * rate * shear, rel=1e-4)


@pytest.mark.parametrize("time", [0.0, 1e-4, 0.1, 1.0])
def test_without_polymer_the_flow_is_newtonian(time):
    water = Fluid(density=2.0, solvent_viscosity=3.0, polymer_viscosity=0.0, relaxation_time=0.7)
    unit = {"gap": 1.0, "kinematic_viscosity": 1.5}
    walls, drive = {**unit, "bottom": -0.4, "top": 0.7}, {**unit, "acceleration": 3.0}
    for function, wall, body in (
        (oldroyd_b.velocity, couette.velocity, poiseuille.velocity),
        (oldroyd_b.shear_rate, couette.shear_rate, poiseuille.shear_rate),
    ):
        expected = wall(HEIGHTS, time, **walls) + body(HEIGHTS, time, **drive)
        assert np.allclose(function(HEIGHTS, time, fluid=water, flow=BOTH), expected, rtol=1e-14, atol=1e-14)
    for function in ALL[2:]:
        assert np.all(function(HEIGHTS, time, fluid=water, flow=BOTH) == 0)


@pytest.mark.parametrize("time", [1e-4, 0.1, 1.0])
def test_little_polymer_changes_the_flow_little(time):
    """No jump between the Newtonian branch and the others: a polymer viscosity of 1e-9 changes the flow by 1e-9."""
    almost, water = (Fluid(1.0, 1.0, viscosity, 0.2) for viscosity in (1e-9, 0.0))
    for function in LINEAR[:2]:
        with_polymer, without = (function(HEIGHTS, time, fluid=fluid, flow=BOTH) for fluid in (almost, water))
        assert largest_difference(with_polymer, without) <= 2e-9


def test_fast_relaxation_is_newtonian_with_the_total_viscosity():
    """To first order in relaxation time * nu/gap^2 = 1e-7, times rates of change of some 10 at t* = 0.1."""
    quick = Fluid(1.0, 0.3, 0.7, 1e-7)
    newtonian = {"gap": 1.0, "kinematic_viscosity": 1.0, "bottom": 0.0, "top": 1.0}
    velocity, rate, shear = (function(HEIGHTS, 0.1, fluid=quick, flow=COUETTE) for function in LINEAR)
    assert largest_difference(velocity, couette.velocity(HEIGHTS, 0.1, **newtonian)) <= 1e-6
    assert largest_difference(rate, couette.shear_rate(HEIGHTS, 0.1, **newtonian)) <= 1e-6
    assert largest_difference(shear, 0.7 * rate) <= 1e-6


@pytest.mark.parametrize("before", [None, Flow(1.0, bottom=2.0, top=-0.5)])
def test_late_flow_is_developed(before):
    """At t = 100 the slowest mode, 1/(2 relaxation time) at least, is exp(-50) = 2e-22."""
    for function, developed in zip(ALL, DEVELOPED, strict=True):
        late = function(HEIGHTS, 100.0, fluid=THIN, flow=BOTH, before=before)
        assert largest_difference(late, developed(HEIGHTS, fluid=THIN, flow=BOTH)) <= 1e-13


@pytest.mark.parametrize("time", [0.0, 0.01, 1.0, 7.0])
def test_developed_flow_that_does_not_change_stays(time):
    for function, developed in zip(ALL, DEVELOPED, strict=True):
        same = function(HEIGHTS, time, fluid=THIN, flow=BOTH, before=BOTH)
        assert largest_difference(same, developed(HEIGHTS, fluid=THIN, flow=BOTH)) <= 1e-13


def test_stopped_flow_is_the_developed_one_less_the_start_up():
    for function, developed in zip(LINEAR, DEVELOPED, strict=False):
        stopped = function(HEIGHTS, 0.3, fluid=THIN, flow=Flow(1.0), before=COUETTE)
        start_up = function(HEIGHTS, 0.3, fluid=THIN, flow=COUETTE)
        assert largest_difference(stopped + start_up, developed(HEIGHTS, fluid=THIN, flow=COUETTE)) <= 1e-13


def test_the_start_has_wall_jumps_and_the_earlier_stress():
    y, before = np.array([0.0, 0.25, 1.0]), Flow(1.0, bottom=0.2, top=0.7, acceleration=3.0)
    arguments = {"fluid": THIN, "flow": BOTH, "before": before}
    inside = 0.2 + 0.5 * 0.25 + 3.0 * 0.25 * 0.75 / 2
    assert oldroyd_b.velocity(y, 0.0, **arguments) == pytest.approx([-0.4, inside, 0.7], rel=1e-15)
    assert oldroyd_b.shear_rate(y, 0.0, **arguments) == pytest.approx([np.inf, 1.25, -1.0], rel=1e-15)
    assert oldroyd_b.shear_stress(y, 0.0, **arguments) == pytest.approx([1.8, 1.125, -0.9], rel=1e-15)
    assert oldroyd_b.normal_stress(y, 0.0, **arguments) == pytest.approx([7.2, 2.8125, 1.8], rel=1e-15)
    assert oldroyd_b.shear_stress(y, 0.0, fluid=THIN, flow=BOTH).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("time", [0.004, 0.3, 5.0])
def test_swapping_the_walls_mirrors_the_flow(time):
    mirror = Flow(1.0, bottom=0.7, top=-0.4, acceleration=3.0)
    for function, sign in zip(ALL, (1, -1, -1, 1), strict=True):
        flow, mirrored = (function(HEIGHTS, time, fluid=THIN, flow=drive) for drive in (BOTH, mirror))
        assert largest_difference(sign * mirrored[::-1], flow) <= ACCURACY


@pytest.mark.parametrize("fluid", FLUIDS)
@pytest.mark.parametrize("time", [1e-5, 1e-4, 1e-3, 0.01, 0.7, 6.0])
def test_many_heights_are_interpolated_to_the_same_accuracy(fluid, time):
    many = np.linspace(0.0, 1.0, 2001)
    assert many.size > _oldroyd_start.FEW_HEIGHTS >= many[::20].size
    for function in LINEAR:
        few = function(many[::20], time, fluid=fluid, flow=BOTH)
        assert largest_difference(function(many, time, fluid=fluid, flow=BOTH)[::20], few) <= ACCURACY


def test_normal_stress_does_not_depend_on_what_was_asked_before():
    results = []
    for earlier in ((), (0.2, 3.0, 0.9)):
        _oldroyd_normal._kept.cache_clear()
        for time in earlier:
            oldroyd_b.normal_stress(HEIGHTS, time, fluid=THIN, flow=COUETTE)
        results.append(oldroyd_b.normal_stress(HEIGHTS, 1.1, fluid=THIN, flow=COUETTE))
    assert np.array_equal(*results)


def test_times_and_heights_broadcast():
    """One call over a grid of heights and times, across both forms and the start, equals the single calls."""
    t, y = np.array([0.5, 0.0, 0.02, 4.0, 0.5]), HEIGHTS[1:-1]
    for function in ALL:
        grid = function(y[:, None], t[None, :], fluid=THIN, flow=BOTH)
        assert grid.shape == (99, 5)
        for column, time in enumerate(t):
            assert np.array_equal(grid[:, column], function(y, time, fluid=THIN, flow=BOTH))
        assert np.ndim(function(0.5, 0.02, fluid=THIN, flow=BOTH)) == 0
        assert function(np.zeros(0), 0.1, fluid=THIN, flow=BOTH).shape == (0,)
    for developed in DEVELOPED:
        assert np.ndim(developed(0.5, fluid=THIN, flow=BOTH)) == 0


def test_units_drop_out():
    """With units of length L, time T and mass M: results in L/T, 1/T and M/(L T^2)."""
    length, second, mass = 0.01, 30.0, 5.0
    viscosity, speed, stress = mass / (length * second), length / second, mass / (length * second**2)
    fluid = Fluid(mass / length**3, 0.1 * viscosity, 0.9 * viscosity, second)
    flow = Flow(length, -0.4 * speed, 0.7 * speed, 3.0 * speed / second)
    before, unit_before = Flow(length, top=-speed), Flow(1.0, top=-1.0)
    for function, scale in zip(ALL, (speed, 1 / second, stress, stress), strict=True):
        scaled = function(length * HEIGHTS, 0.6 * second, fluid=fluid, flow=flow, before=before) / scale
        unit = function(HEIGHTS, 0.6, fluid=THIN, flow=BOTH, before=unit_before)
        assert largest_difference(scaled, unit) <= ACCURACY
    for function, scale in zip(DEVELOPED, (speed, 1 / second, stress, stress), strict=True):
        scaled = function(length * HEIGHTS, fluid=fluid, flow=flow) / scale
        assert largest_difference(scaled, function(HEIGHTS, fluid=THIN, flow=BOTH)) <= ACCURACY


@pytest.mark.parametrize("fluid", [Fluid(1.0, 0.01, 0.99, 1e-4), Fluid(1.0, 1e-3, 0.5, 1e6), Fluid(1e3, 0.01, 1, 1)])
def test_extreme_fluids_and_times_overflow_nowhere(fluid):
    """At the walls too, and with velocities between those of the walls but for what the drive adds."""
    drive = fluid.density * BOTH.acceleration / (8 * fluid.solvent_viscosity)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for time in (1e-9, 1e-3, 1.0, 1e5):
            assert np.all(np.abs(oldroyd_b.velocity(HEIGHTS, time, fluid=fluid, flow=BOTH)) <= 0.7 + drive)
            for function in LINEAR[1:]:
                assert np.all(np.isfinite(function(HEIGHTS, time, fluid=fluid, flow=BOTH)))


def test_what_has_no_solution_is_refused():
    with pytest.raises(ValueError, match="t >= 0"):
        oldroyd_b.velocity(0.5, -1.0, fluid=THIN, flow=COUETTE)
    with pytest.raises(ValueError, match=r"gap of 2\.0, the flow one of 1\.0"):
        oldroyd_b.velocity(0.5, 1.0, fluid=THIN, flow=COUETTE, before=Flow(2.0))


@pytest.mark.parametrize("name", ["density", "solvent_viscosity", "polymer_viscosity", "relaxation_time"])
def test_impossible_fluids_are_refused_with_a_specific_message(name):
    numbers = {"density": 1.0, "solvent_viscosity": 0.1, "polymer_viscosity": 0.9, "relaxation_time": 1.0}
    for value in (-1.0, np.nan) if name == "polymer_viscosity" else (-1.0, 0.0, np.nan):
        with pytest.raises(ValueError, match=name):
            Fluid(**{**numbers, name: value})
