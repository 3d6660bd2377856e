"""The numerical reference of a run against closed forms (``oracles``): velocity and shear rate at all times.

Bound: 1e-8 of the largest value in the gap, that which ``tisph/exact/start_up.py`` promises; measured: 1e-10.
"""

import numpy as np
import pytest
from oracles import oscillating_wall, poiseuille, scheduled_wall
from oracles.circular_couette import CircularCouette

from tisph.exact import couette
from tisph.exact.start_up import CircularStartUp, Flow, StartUp, ViscoelasticFluid, Wall
from tisph.geometry.motion import Schedule, WallMotion

GAP, NU = 0.7, 0.3
HEIGHTS = np.linspace(0.0, GAP, 41)
TIMES = GAP**2 / NU * np.array([1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0])
FLUID = ViscoelasticFluid(NU, ())
SETTING = {"gap": GAP, "kinematic_viscosity": NU}
OSCILLATIONS = [WallMotion(*numbers) for numbers in ((1.0, 0.0, 3.0), (0.0, 1.0, 3.0), (0.4, -1.0, 300.0))]
RAMPS = Schedule((0.0, 0.2, 0.2, 0.5), (0.3, 1.0, -0.5, 0.2))


def assert_close(found, expected, bound=1e-8):
    finite = np.isfinite(expected)
    assert (np.isfinite(found) == finite).all()
    difference = np.where(finite, np.abs(np.where(finite, found, 0.0) - np.where(finite, expected, 0.0)), 0.0)
    largest = np.abs(np.where(finite, expected, 0.0)).max(axis=0)
    assert (difference.max(axis=0) <= bound * largest).all()


def compare(solved, velocity, shear_rate, times=TIMES):
    places = HEIGHTS[:, None], times[None]
    assert_close(solved.velocity(*places), velocity(*places))
    assert_close(solved.shear_rate(*places), shear_rate(*places))


def closed(module, **numbers):
    def bound(name):
        return lambda y, t: getattr(module, name)(y, t, **SETTING, **numbers)

    return bound("velocity"), bound("shear_rate")


def test_couette_is_its_layer_to_the_last_bit():
    solved = StartUp(FLUID, Flow(GAP, Wall(-0.4), Wall(1.0)))
    assert (solved.velocity(HEIGHTS, 0.1) == couette.velocity(HEIGHTS, 0.1, **SETTING, bottom=-0.4, top=1.0)).all()
    compare(solved, *closed(couette, bottom=-0.4, top=1.0))


def test_poiseuille_from_rest():
    compare(StartUp(FLUID, Flow(GAP, acceleration=2.0)), *closed(poiseuille, acceleration=2.0))


def test_poiseuille_developed_stays():
    flow = Flow(GAP, acceleration=2.0)
    expected = poiseuille.developed_velocity(HEIGHTS, **SETTING, acceleration=2.0)
    assert_close(StartUp(FLUID, flow, flow).velocity(HEIGHTS, TIMES[-1]), expected)


@pytest.mark.parametrize("wall", OSCILLATIONS, ids=str)
def test_oscillating_wall_from_rest(wall):
    compare(StartUp(FLUID, Flow(GAP, Wall(), wall)), *closed(oscillating_wall, wall=wall))


@pytest.mark.parametrize("wall", OSCILLATIONS, ids=str)
def test_oscillating_wall_in_its_periodic_state(wall):
    flow = Flow(GAP, Wall(), wall)
    periodic = [
        lambda y, t, form=form: form(y, t, **SETTING, wall=wall)
        for form in (oscillating_wall.periodic_velocity, oscillating_wall.periodic_shear_rate)
    ]
    compare(StartUp(FLUID, flow, flow), *periodic)


def test_scheduled_wall():
    compare(StartUp(FLUID, Flow(GAP, Wall(), RAMPS)), *closed(scheduled_wall, breakpoints=RAMPS.breakpoints))


CYLINDERS = [
    (WallMotion(2.0), WallMotion(0.0)),
    (WallMotion(0.0, before=1.0), WallMotion(0.5, before=0.5)),
    (WallMotion(1.0, 0.5, 7.0), WallMotion(0.0, 2.0, 3.0)),
]


@pytest.mark.parametrize(("inner", "outer"), CYLINDERS, ids=["start", "stop", "oscillation"])
def test_cylinders(inner, outer):
    before = tuple(Wall(wall.before or 0.0) for wall in (inner, outer))
    radii = 1.0, 1.0 + GAP
    solved = CircularStartUp(*radii, FLUID, inner, outer, before if any(wall.speed for wall in before) else None)
    expected = CircularCouette(*radii, NU, inner, outer)
    for name in ("velocity", "shear_rate"):
        places = radii[0] + HEIGHTS[:, None], TIMES[None]
        assert_close(getattr(solved, name)(*places), getattr(expected, name)(*places))
    for time in TIMES[2:]:
        pressures = [flow.pressure(radii[0] + HEIGHTS, time, density=1.3) for flow in (solved, expected)]
        assert_close(*pressures)


def test_cylinders_that_oscillate_in_their_periodic_state():
    walls, radii = CYLINDERS[-1], (1.0, 1.0 + GAP)
    solved, expected = CircularStartUp(*radii, FLUID, *walls, walls), CircularCouette(*radii, NU, *walls)
    for name in ("velocity", "shear_rate"):
        places = radii[0] + HEIGHTS[:, None], TIMES[None]
        assert_close(getattr(solved, name)(*places), getattr(expected, f"settled_{name}")(*places))


def test_only_a_newtonian_fluid_starts_from_a_periodic_state():
    from tisph.rheology.oldroyd_b import Parameters

    laws = Parameters(type="oldroyd_b", relaxation_time=1.0, solvent_fraction=0.5).laws(NU)
    flow = Flow(GAP, Wall(), OSCILLATIONS[0])
    with pytest.raises(ValueError, match="Newtonian"):
        StartUp(ViscoelasticFluid(0.5 * NU, laws), flow, flow)
