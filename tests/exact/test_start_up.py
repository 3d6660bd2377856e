"""Start-up between plane walls: against closed forms, literature, another order, and linear theory."""

import numpy as np
import pytest
from oracles.circular_couette import CircularCouette
from oracles.plane import Plane
from polymer_laws import law, steady_shear
from scipy.integrate import quad
from scipy.optimize import brentq

from tisph import registry
from tisph.exact import couette
from tisph.exact._fluids import InelasticFluid, ViscoelasticFluid
from tisph.exact.start_up import CircularStartUp, Flow, StartUp, Wall
from tisph.geometry.motion import Schedule, StressControlledWall, WallMotion

HEIGHTS = np.linspace(0.0, 1.0, 41)
COUETTE, POISEUILLE = Flow(1.0, top=Wall(1.0)), Flow(1.0, acceleration=2.0)
BOTH = Flow(1.0, Wall(-0.4), Wall(0.7), 3.0)
ACCURACY = 1e-8
"""That the module promises, relative to the largest value in the gap."""


def liquid(kind, fraction=0.1, relaxation_time=1.0):
    """A liquid of total viscosity 1 with one of KINDS as its polymer."""
    return ViscoelasticFluid(fraction, (law(kind, viscosity=1.0 - fraction, relaxation_time=relaxation_time),))


def viscous(name, **numbers):
    member = registry.load("rheology", name)
    return InelasticFluid(member.Law(member.Parameters(**numbers), 1.0), 1.0)


def apart(found, expected):
    return np.max(np.abs(found - expected)) / np.max(np.abs(expected))


@pytest.mark.parametrize(
    ("flow", "before", "fraction", "relaxation_time"),
    [(COUETTE, None, 0.1, 1.0), (Flow(1.0, top=Wall(0.2), acceleration=-1.0), BOTH, 0.3, 0.5)],
)
def test_oldroyd_b_is_met(flow, before, fraction, relaxation_time):
    found = StartUp(liquid("oldroyd_b", fraction, relaxation_time), flow, before)
    plane, old = Plane(1.0, 1.0, fraction, relaxation_time), before or Flow(1.0)
    walls = flow.bottom.speed - old.bottom.speed, flow.top.speed - old.top.speed
    slope = old.top.speed - old.bottom.speed + old.acceleration * (0.5 - HEIGHTS)
    developed = old.bottom.speed + (old.top.speed - old.bottom.speed) * HEIGHTS
    developed = developed + old.acceleration * HEIGHTS * (1.0 - HEIGHTS) / 2.0

    def fields(time):
        """Linear in what changes: the developed flow before and the start of the difference."""
        start = plane.fields(HEIGHTS, time, *walls, flow.acceleration - old.acceleration)
        return start + np.stack([developed, slope, (1.0 - fraction) * slope])

    for t in np.array([1e-5, 1e-3, 0.1, 1.0]) / fraction:
        xx, xy, yy = found.polymer_stress(HEIGHTS, t)
        velocity, rate, shear = fields(t)
        assert apart(found.velocity(HEIGHTS, t), velocity) < ACCURACY
        assert apart(xy, shear) < ACCURACY
        assert apart(xx, plane.normal_stress(HEIGHTS, t, fields, slope)) < 2 * ACCURACY
        # a slope: the accuracy times the number of times that the layer fits into the gap, 100 at most from here on
        assert apart(found.shear_rate(HEIGHTS, t), rate) < 10 * ACCURACY
        assert not np.any(yy)


@pytest.mark.parametrize("fraction", [0.01, 0.1, 0.9])
@pytest.mark.parametrize("time", [0.1, 2.0])
def test_driven_flow_follows_the_series_of_waters_and_king(fraction, time):
    """Rheol. Acta 9 (1970) 345-355: velocity over the steady mean, heights over half the gap, relaxation time 1."""
    n, heights, elasticity = (2 * np.arange(1, 10001) - 1) * np.pi, np.linspace(-0.9, 0.9, 19), 4.0
    alpha = 1 + fraction * elasticity * n**2 / 4
    beta = np.sqrt((alpha**2 - elasticity * n**2).astype(complex))
    gamma = 1 - (2 - fraction) * elasticity * n**2 / 4
    # (cosh + (gamma/beta) sinh) exp(-alpha time/2), each with its own exponential: cosh alone would overflow
    slow, fast = np.exp((beta - alpha) * time / 2), np.exp(-(beta + alpha) * time / 2)
    factor = ((1 + gamma / beta) * slow + (1 - gamma / beta) * fast).real / 2
    expected = 1.5 * (1 - heights**2) - 48 * np.sin(np.outer(1 + heights, n) / 2) @ (factor / n**3)
    found = StartUp(liquid("oldroyd_b", fraction), Flow(1.0, acceleration=12.0)).velocity(0.5 + 0.5 * heights, time)
    assert apart(found, expected) < ACCURACY


@pytest.mark.parametrize(("kind", "flow"), [("giesekus", COUETTE), ("fene_p", POISEUILLE)])
def test_flows_end_as_closed_forms_say(kind, flow):
    """In the end the shear stress is linear in y, and the polymer's is that of its closed form at the rate there."""
    now = liquid(kind, 0.2, 3.0)
    found = StartUp(now, flow)
    t = 200.0
    total, rate = found.shear_stress(HEIGHTS, t), found.shear_rate(HEIGHTS, t)
    if flow is POISEUILLE:
        assert np.allclose(total, 2.0 * (0.5 - HEIGHTS), atol=ACCURACY)
    else:
        assert np.allclose(total, total[0], rtol=ACCURACY)
        assert np.allclose(rate, 1.0, rtol=ACCURACY)
    stress = found.polymer_stress(HEIGHTS, t)
    for k, slope in enumerate(rate):
        expected = now.laws[0].stress(steady_shear(kind, 3.0 * abs(slope) + 1e-12))[:3]
        assert np.allclose(stress[:, k] * [1, np.sign(slope) or 1, 1], expected, rtol=1e-7, atol=ACCURACY)


def test_another_order_changes_nothing():
    now = liquid("fene_p", 0.1, 5.0)
    one, other = StartUp(now, COUETTE), StartUp(now, COUETTE, order=18, finest=5e-4)
    for t in (1e-3, 0.01):
        assert apart(one.velocity(HEIGHTS, t), other.velocity(HEIGHTS, t)) < ACCURACY
        for mine, its in zip(one.polymer_stress(HEIGHTS, t)[:2], other.polymer_stress(HEIGHTS, t)[:2], strict=True):
            assert apart(mine, its) < 3 * ACCURACY


def test_two_equal_modes_are_one():
    half, t = law("fene_p", viscosity=0.4, relaxation_time=1.0), 0.1
    coarse = {"order": 8, "finest": 0.03}  # the same error on both sides
    one, two = (StartUp(now, BOTH, **coarse) for now in (liquid("fene_p", 0.2), ViscoelasticFluid(0.2, (half, half))))
    assert apart(two.velocity(HEIGHTS, t), one.velocity(HEIGHTS, t)) < 1e-11
    assert apart(two.polymer_stress(HEIGHTS, t), one.polymer_stress(HEIGHTS, t)) < 1e-10


def developed_velocity(now, y):
    """Velocity of the developed flow POISEUILLE, from the wall: the shear stress is 2 (0.5 - y)."""

    def rate(y):
        return brentq(lambda rate: now.flux(rate) - 2.0 * (0.5 - y), -1e-9, 1e3, xtol=1e-14, rtol=1e-13)

    return quad(rate, 0.0, y, epsabs=1e-11, epsrel=1e-11, limit=200)[0]


@pytest.mark.parametrize(
    "now",
    [
        viscous("power_law", index=0.5, reference_rate=1.0, least_rate=1e-3),
        viscous("carreau_yasuda", time=10.0, index=0.4),
    ],
    ids=["thinning", "carreau"],
)
def test_developed_flow_of_inelastic_fluids(now):
    found = StartUp(now, POISEUILLE)
    t = 200.0  # of a liquid whose viscosity falls to 0.2, and that takes 5 times as long
    expected = [developed_velocity(now, y) for y in HEIGHTS[:21]]
    assert apart(found.velocity(HEIGHTS[:21], t), np.array(expected)) < ACCURACY
    assert np.allclose(found.shear_stress(HEIGHTS, t), 2.0 * (0.5 - HEIGHTS), atol=1e-7)


def test_power_law_and_plug_of_the_textbook():
    """u = n/(n+1) (g/K)^(1/n) (h^(1+1/n) - |y - h|^(1+1/n)), h = 1/2; Bingham plug: (g h - yield stress)^2/(2 g K)."""
    found = StartUp(viscous("power_law", index=0.5, reference_rate=1.0, least_rate=1e-4), POISEUILLE)
    expected = 4.0 / 3.0 * (0.5**3 - np.abs(HEIGHTS - 0.5) ** 3)
    # rates up to the least rate, 1e-4, differ, in the middle 0.01 of the gap: 1e-6 of a velocity of 0.17
    assert apart(found.velocity(HEIGHTS, 20.0), expected) < 1e-5
    numbers = {"yield_stress": 0.4, "index": 1.0, "reference_rate": 1.0, "regularisation": 300.0}
    plug = StartUp(viscous("herschel_bulkley", **numbers), POISEUILLE).velocity(0.5, 20.0)
    assert plug == pytest.approx((1.0 - 0.4) ** 2 / 4.0, rel=8e-3)  # it creeps: by 2.2/m, of first order in 1/m


def test_what_was_asked_before_changes_nothing():
    one, other = (StartUp(liquid("giesekus"), COUETTE) for _ in range(2))
    other.velocity(HEIGHTS, 5e-4)
    assert np.array_equal(one.velocity(HEIGHTS, [[1e-5], [2e-4]]), other.velocity(HEIGHTS, [[1e-5], [2e-4]]))


def test_the_start_itself():
    found = StartUp(liquid("giesekus"), COUETTE)
    assert np.array_equal(found.velocity(HEIGHTS, 0.0), HEIGHTS == 1.0)
    assert found.shear_stress(1.0, 0.0) == np.inf
    assert not np.any(found.polymer_stress(HEIGHTS, 0.0))
    with pytest.raises(ValueError, match="for t >= 0 only"):
        found.velocity(0.5, -1.0)
    with pytest.raises(ValueError, match="solvent_viscosity must be above 0"):
        ViscoelasticFluid(0.0, ())
    with pytest.raises(ValueError, match="gap of 2"):
        StartUp(liquid("giesekus"), COUETTE, Flow(2.0))
    swinging = Flow(1.0, Wall(), WallMotion(1.0, 0.0, 3.0))
    with pytest.raises(ValueError, match="Newtonian"):
        StartUp(liquid("giesekus"), swinging, swinging)


GAP, NU = 0.7, 0.3
PLACES_IN_GAP = np.linspace(0.0, GAP, 41)
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


PLANE = Plane(GAP, NU)


def compare(solved, expected):
    """Velocity and shear rate at all places and times; ``expected`` of places and a time."""
    for t in TIMES:
        velocity, rate = expected(PLACES_IN_GAP, t)[:2]
        assert_close(solved.velocity(PLACES_IN_GAP, t), velocity)
        assert_close(solved.shear_rate(PLACES_IN_GAP, t), rate)


def test_couette_is_its_layer_to_the_last_bit():
    solved, walls = StartUp(FLUID, Flow(GAP, Wall(-0.4), Wall(1.0))), {"bottom": -0.4, "top": 1.0}
    assert (solved.velocity(PLACES_IN_GAP, 0.1) == couette.velocity(PLACES_IN_GAP, 0.1, **SETTING, **walls)).all()
    compare(solved, lambda y, t: [part(y, t, **SETTING, **walls) for part in (couette.velocity, couette.shear_rate)])
    compare(solved, lambda y, t: PLANE.fields(y, t, **walls))


def test_poiseuille_from_rest_and_developed():
    flow = Flow(GAP, acceleration=2.0)
    compare(StartUp(FLUID, flow), lambda y, t: PLANE.fields(y, t, acceleration=2.0))
    parabola = PLACES_IN_GAP * (GAP - PLACES_IN_GAP) / NU
    assert_close(StartUp(FLUID, flow, flow).velocity(PLACES_IN_GAP, TIMES[-1]), parabola)


def test_an_oscillating_wall_step_by_step():
    now, wall = viscous("power_law", index=1.0, reference_rate=1.0, least_rate=1.0), WallMotion(0.6, -0.8, 40.0)
    found = StartUp(now, Flow(1.0, top=wall))
    for t in (1e-3, 0.1):
        assert apart(found.velocity(HEIGHTS, t), Plane(1.0, 1.0).fields(HEIGHTS, t, top=wall)[0]) < ACCURACY


@pytest.mark.parametrize("wall", OSCILLATIONS, ids=str)
def test_oscillating_wall_from_rest_and_in_its_periodic_state(wall):
    flow = Flow(GAP, Wall(), wall)
    compare(StartUp(FLUID, flow), lambda y, t: PLANE.fields(y, t, top=wall))
    compare(StartUp(FLUID, flow, flow), lambda y, t: PLANE.periodic(y, t, wall))


def test_scheduled_wall():
    compare(StartUp(FLUID, Flow(GAP, Wall(), RAMPS)), lambda y, t: PLANE.scheduled(y, t, RAMPS.breakpoints))


CYLINDERS = [
    (WallMotion(0.0, before=1.0), WallMotion(0.5, before=0.5)),
    (WallMotion(1.0, 0.5, 7.0), WallMotion(0.0, 2.0, 3.0)),
]


RAMPS = Schedule((0.0, 0.3, 0.5), (1.0, 2.0, -1.0))
STEPS = Schedule((0.0, 0.2, 0.2, 0.5, 0.5), (1.0, 1.0, -2.0, -2.0, 0.5))


@pytest.mark.parametrize(
    "fluid",
    [
        liquid("oldroyd_b", 0.3),
        liquid("giesekus", 0.5),
        viscous("power_law", index=0.7, reference_rate=1.0, least_rate=0.1),
    ],
)
def test_a_drive_with_steps_is_a_frame_that_accelerates(fluid):
    """In the frame of the velocity V = integral of g the walls move at -V, with kinks where g has steps."""
    kinks = np.array([0.0, 0.2, 0.5, 2.0])
    speeds = np.array([float(STEPS.displacement(t)) for t in kinks])
    wall = Schedule(tuple(kinks), tuple(-speeds))
    driven, moved = StartUp(fluid, Flow(1.0, pulsation=STEPS)), StartUp(fluid, Flow(1.0, wall, wall))
    for t in (0.1, 0.3, 0.9):
        expected = moved.velocity(HEIGHTS, t) + STEPS.displacement(t)
        assert apart(driven.velocity(HEIGHTS, t), expected) < 2e-6  # what the module promises of inelastic fluids


def test_a_drive_with_ramps_is_a_sum_of_starts():
    """Linear fluids: the flow is the start under the first value, and those under all later changes dg."""
    fluid, plane = liquid("oldroyd_b", 0.3), Plane(1.0, 1.0, 0.3, 1.0)
    found = StartUp(fluid, Flow(1.0, acceleration=0.5, pulsation=RAMPS)).velocity(HEIGHTS, 0.7)
    expected = plane.fields(HEIGHTS, 0.7, 0.0, 0.0, 1.5)[0]
    nodes, weights = np.polynomial.legendre.leggauss(24)
    for begin, end, slope in ((0.0, 0.3, 1.0 / 0.3), (0.3, 0.5, -3.0 / 0.2)):
        half = 0.5 * (end - begin)
        for node, weight in zip(begin + half * (nodes + 1.0), half * weights, strict=True):
            expected = expected + weight * slope * plane.fields(HEIGHTS, 0.7 - node, 0.0, 0.0, 1.0)[0]
    assert apart(found, expected) < 1e-7


@pytest.mark.parametrize(("inner", "outer"), CYLINDERS, ids=["stop", "oscillation"])
def test_cylinders(inner, outer):
    before = tuple(Wall(wall.before or 0.0) for wall in (inner, outer))
    radii = 1.0, 1.0 + GAP
    solved = CircularStartUp(*radii, FLUID, inner, outer, before if any(wall.speed for wall in before) else None)
    expected = CircularCouette(*radii, NU, inner, outer)
    periodic = CircularStartUp(*radii, FLUID, inner, outer, (inner, outer)) if inner.oscillates else None
    places = radii[0] + PLACES_IN_GAP[:, None], TIMES[None]
    for name in ("velocity", "shear_rate"):
        assert_close(getattr(solved, name)(*places), getattr(expected, name)(*places))
        if periodic:
            assert_close(getattr(periodic, name)(*places), getattr(expected, f"settled_{name}")(*places))
    for time in TIMES[2:]:
        pressures = [flow.pressure(radii[0] + PLACES_IN_GAP, time, density=1.3) for flow in (solved, expected)]
        assert_close(*pressures)


OFF_WALL = np.linspace(0.1, 1.0, 10)
SMOOTH = 1e-9
"""That the module promises a wall without a jump, relative to the largest value; the series have more digits."""


def newtonian(plate):
    law = registry.load("rheology", "newtonian").Law(1.0)
    return StartUp(InelasticFluid(law, 1.0), Flow(1.0, top=plate))


def creep(y, t):
    """Velocity under the stress 1 from t = 0 on: y less the even modes of a wall at rest and a free one."""
    k = (np.arange(400)[:, None] + 0.5) * np.pi
    return y - np.sum(2.0 * (-1.0) ** np.arange(400)[:, None] / k**2 * np.sin(k * y) * np.exp(-k * k * t), axis=0)


def test_a_massless_wall_and_a_newtonian_fluid():
    found = newtonian(StressControlledWall(1.0))
    for t in (1e-3, 0.1, 1.0):
        assert np.max(np.abs(found.velocity(OFF_WALL, t) - creep(OFF_WALL, t))) < SMOOTH * creep(1.0, t)
        assert found.shear_stress(1.0, t) == pytest.approx(1.0, abs=SMOOTH)


def test_stress_is_taken_away_again():
    found = newtonian(StressControlledWall(0.0, steps=((0.0, 1.0), (0.5, 0.0))))
    for t in (0.51, 1.0):
        expected = creep(OFF_WALL, t) - creep(OFF_WALL, t - 0.5)
        assert np.max(np.abs(found.velocity(OFF_WALL, t) - expected)) < SMOOTH * expected.max()


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_stress_controlled_wall_on_an_oldroyd_b_fluid(mass):
    # Laplace transform of the linear problem, inverted by Talbot's contour: 1e-13 before the waves of a cycle add up
    fraction, t = 0.1, 0.1
    member = registry.load("rheology", "oldroyd_b")
    laws = member.Parameters(relaxation_time=1.0, solvent_fraction=fraction).laws(1.0)
    found = StartUp(ViscoelasticFluid(fraction, laws), Flow(1.0, top=StressControlledWall(1.0, mass_per_area=mass)))

    def transform(p):
        nu = fraction + (1.0 - fraction) / (1.0 + p)
        q = np.sqrt(p / nu)
        return np.sinh(q) / (p * (mass * p * np.sinh(q) + nu * q * np.cosh(q)))

    terms = 24
    angle = np.arange(1, terms) * np.pi / terms
    cotangent = 1.0 / np.tan(angle)
    delta = 0.4 * terms * np.concatenate([[1.0], angle * (cotangent + 1j)])
    weight = np.exp(delta) * np.concatenate([[0.5], 1.0 + 1j * angle * (1.0 + cotangent**2) - 1j * cotangent])
    expected = 0.4 / t * np.sum((weight * transform(delta / t)).real)
    assert found.velocity(1.0, t) == pytest.approx(expected, rel=SMOOTH)
