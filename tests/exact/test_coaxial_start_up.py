"""Start-up between cylinders and along pipes: against modes, series, steady closed forms and the plane."""

from functools import lru_cache

import numpy as np
import pytest
from oracles.circular_couette import CircularCouette, Rotation, quotient
from oracles.plane import inverse
from polymer_laws import law, steady_shear
from scipy.special import jn_zeros, jv

from tisph.exact._fluids import InelasticFluid, ViscoelasticFluid
from tisph.exact.start_up import CircularStartUp, Flow, PipeStartUp, StartUp, Wall
from tisph.geometry.motion import WallMotion
from tisph.rheology import power_law

R = np.linspace(1.0, 2.0, 41)

INSIDE = np.array([1.05, 1.2, 1.5, 1.9])
ACCURACY = 1e-8
"""That the module promises, relative to the largest value in the gap."""


def liquid(kind, fraction=0.1, relaxation_time=1.0):
    """A liquid of total viscosity 1 with one of KINDS as its polymer."""
    return ViscoelasticFluid(fraction, (law(kind, viscosity=1.0 - fraction, relaxation_time=relaxation_time),))


def powers(index, least_rate=1e-3):
    numbers = power_law.Parameters(index=index, reference_rate=1.0, least_rate=least_rate)
    return InelasticFluid(numbers.law(1.0, 1.0), 1.0)


def start_up(now, inner=1.0, outer=0.0, before=None, radii=(1.0, 2.0), **elements):
    walls = [Wall(speed) for speed in (inner, outer)]
    return CircularStartUp(*radii, now, *walls, before and tuple(map(Wall, before)), **elements)


@lru_cache
def shared(kind):
    """Start-up with the inner cylinder that several tests look at."""
    return start_up(liquid(kind))


def points(edges):
    """Points and weights of Gauss's rule in each part between ``edges``."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    low, high = np.array(edges[:-1])[:, None], np.array(edges[1:])[:, None]
    return ((high + low + (high - low) * nodes) / 2).ravel(), ((high - low) / 2 * weights).ravel()


def apart(found, expected):
    return np.max(np.abs(found - expected)) / np.max(np.abs(expected))


def test_without_polymer_it_is_newtonian_flow():
    """The layer's closed form leaves the walls' curvature to the equations."""
    radii = (0.2, 1.2)
    found = start_up(ViscoelasticFluid(1.0, (law("oldroyd_b", viscosity=0.0),)), 0.3, -0.7, radii=radii)
    expected = CircularCouette(*radii, 1.0, Rotation(0.3), Rotation(-0.7))
    r = np.linspace(*radii, 41)
    for t in (1e-5, 0.01, 0.1):
        assert apart(found.velocity(r, t), expected.velocity(r, t)) < 1e-11
        assert apart(found.shear_rate(r, t), expected.shear_rate(r, t)) < 1e-11
        assert apart(np.array(found.torque(t, density=3.0)), np.array(expected.torque(t, density=3.0))) < 1e-11
    pressure = expected.pressure(r, 0.1, density=3.0)
    assert apart(found.pressure(r, 0.1, density=3.0), pressure) < 1e-11


@pytest.mark.parametrize("kind", ["oldroyd_b", "giesekus"])
def test_flows_end_as_closed_forms_say(kind):
    """In the end r^2 times the shear stress is the same everywhere, and the polymer's is that of the rate there."""
    now, found, t = liquid(kind), shared(kind), 60.0
    stress, rate = found.polymer_stress(R, t), found.shear_rate(R, t)
    moment = R**2 * (now.flux(rate) + stress[1])
    assert np.allclose(moment, moment[0], rtol=ACCURACY)
    torques = found.torque(t, density=2.0)
    assert torques == pytest.approx((4 * np.pi * moment[0], -4 * np.pi * moment[0]), rel=ACCURACY)
    for k, slope in enumerate(rate):
        expected = now.laws[0].stress(steady_shear(kind, abs(slope)))[:3]
        assert np.allclose(stress[:, k] * [1, -1, 1], expected, rtol=1e-7, atol=ACCURACY)
    if kind == "oldroyd_b":
        assert apart(found.velocity(R, t), 4 / 3 / R - R / 3) < ACCURACY
        assert apart(stress[0] - stress[2], 2 * 0.9 * rate**2) < ACCURACY


def test_pressure_balances_hoop_stress_and_inertia():
    """dp/dr by differences, of a liquid with all normal stresses; no mean over the area."""
    found, t, step = shared("giesekus"), 0.4, 1e-4
    along, _, across = found.polymer_stress(INSIDE, t)
    steps = step * np.array([-2.0, -1.0, 1.0, 2.0])
    around = INSIDE[:, None] + steps

    def slope(values):
        return values @ np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)

    expected = found.velocity(INSIDE, t) ** 2 / INSIDE + (across - along) / INSIDE
    expected += slope(found.polymer_stress(around, t)[2])
    pressure = found.pressure(around, t, density=2.0)
    assert apart(slope(pressure), 2.0 * expected) < 1e-8  # rounding, 1e-13 over the step
    nodes, weights = np.polynomial.legendre.leggauss(200)
    r = 1.5 + 0.5 * nodes
    assert abs(np.sum(weights * r * found.pressure(r, t, density=2.0))) < 1e-9
    assert not np.any(found.pressure(R, 0.0, density=2.0))


def test_a_narrow_gap_is_a_plane_channel():
    """To first order in gap/radius: errors of two gaps differ by ten."""
    now, time, heights = liquid("giesekus"), 0.06, np.linspace(0.0, 1.0, 21)
    coarse = {"order": 10, "finest": 0.03}
    plane, errors = StartUp(now, Flow(1.0, bottom=Wall(1.0)), **coarse), []
    for radius in (1e3, 1e4):
        found = start_up(now, 1 / radius, radii=(radius, radius + 1), **coarse)
        errors.append(
            [
                apart(found.velocity(radius + heights, time), plane.velocity(heights, time)),
                apart(found.polymer_stress(radius + heights, time), plane.polymer_stress(heights, time)),
            ]
        )
    assert max(errors[0]) < 5e-3
    assert np.divide(*errors) == pytest.approx([10.0, 10.0], rel=0.05)


def test_it_goes_on_from_a_developed_flow():
    now = liquid("oldroyd_b", 0.3, 0.5)
    found = start_up(now, 0.0, before=(1.0, 0.0))
    turning = 4 / 3 / R - R / 3
    assert apart(found.velocity(R, 1e-9)[5:], turning[5:]) < ACCURACY  # inside of the layer
    assert apart(found.polymer_stress(R, 0.0)[1], 0.7 * -8 / 3 / R**2) < ACCURACY
    balance = CircularCouette(1.0, 2.0, 1.0, Rotation(1.0), Rotation(0.0))
    hoop = 2 * 0.7 * 0.5 * (8 / 3) ** 2 * R**-4 / 4  # of -int N1/r dr
    difference = found.pressure(R, 0.0, density=1.0) - balance.pressure(R, 0.0, density=1.0, settled=True) - hoop
    assert np.ptp(difference) < ACCURACY * hoop[0]


def test_a_fluid_in_one_cylinder_spins_up():
    """u = r + 2 sum J1(k r)/(k J0(k)) exp(-k^2 t), k the roots of J1, of unit radius, viscosity, angular velocity.

    From G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.5. Pressure in the end: r^2/2 less its mean, 1/4.
    """
    found = CircularStartUp(0.0, 1.0, ViscoelasticFluid(1.0, ()), None, Wall(1.0))
    r, k = np.linspace(0.0, 1.0, 41), jn_zeros(1, 2000)[:, None]
    for t in (1e-5, 1e-3, 0.1, 1.0):
        decay = 2 * np.exp(-(k**2) * t) / jv(0, k)
        assert apart(found.velocity(r, t), r + (decay / k * jv(1, k * r)).sum(axis=0)) < 1e-11
        # relative to the angular velocity, over the depth of the layer while there is one
        error = found.shear_rate(r, t) + (decay * jv(2, k * r)).sum(axis=0)
        assert np.max(np.abs(error)) < 1e-11 / min(1.0, np.sqrt(t))
    assert np.max(np.abs(found.pressure(r, 5.0, density=3.0) - 3.0 * (r**2 / 2 - 0.25))) < 1e-10
    assert np.max(np.abs(found.torque(5.0, density=3.0))) < 1e-10


@pytest.mark.parametrize("kind", ["giesekus", "power_law"])
def test_other_fluids_in_one_cylinder_end_in_rigid_rotation(kind):
    """And their angular momentum, of the density 3, grows by the torque."""
    now = liquid(kind) if kind == "giesekus" else powers(0.5)
    found = CircularStartUp(0.0, 1.0, now, None, Wall(1.0))
    r, weights = points((0.0, 0.25, 0.5, 0.75, 0.9, 1.0))
    before, after = (6 * np.pi * weights @ (r**2 * found.velocity(r, t)) for t in (0.01, 0.16))
    roots, weights = points((0.1, 0.15, 0.2, 0.3, 0.4))
    taken = -2 * weights @ (roots * found.torque(roots**2, density=3.0)[1])
    r = np.linspace(0.0, 1.0, 41)
    assert apart(found.velocity(r, 25.0), r) < ACCURACY
    assert taken == pytest.approx(after - before, rel=ACCURACY)


RADII = np.linspace(0.0, 1.0, 41)
ROOTS = jn_zeros(0, 2000)[:, None]
UNIT = 2 / (ROOTS * jv(1, ROOTS))
"""Coefficients of 1 = sum UNIT J0(ROOTS r)."""

NEWTONIAN, REST = ViscoelasticFluid(1.0, ()), (Wall(), Wall())


def pipe(fluid, walls=REST, before=None, inner=0.0, **drive):
    return PipeStartUp((inner, 1.0), fluid, walls, before, **drive)


def test_oldroyd_b_ends_in_the_parabola():
    found, t = pipe(liquid("oldroyd_b"), acceleration=1.0), 60.0
    assert apart(found.velocity(RADII, t), (1 - RADII**2) / 4) < ACCURACY
    along, _, across = found.polymer_stress(RADII, t)
    assert apart(along, 2 * 0.9 * (RADII / 2) ** 2) < ACCURACY
    assert not np.any(across)
    (excess,) = found.conformation_excess(RADII, t)
    assert apart(excess[1], -RADII / 2) < ACCURACY


@pytest.mark.parametrize("index", [0.5, 1.5])
def test_steady_flows_of_a_power_law(index):
    """r^2 K rate^n is constant around the axis, the stress is -r along it (Bird et al. 1987, section 4.2)."""
    steepness, t = 2.0 / index, 10.0
    scale = 1.0 / (1.0 - 2.0**-steepness)
    around = start_up(powers(index))
    # the least rate, 1e-3 of those of the flow, changes viscosities by 1e-6 of themselves
    assert apart(around.velocity(R, t), R * scale * (R**-steepness - 2.0**-steepness)) < 1e-6
    torque = 2 * np.pi * 3.0 * (steepness * scale) ** index
    assert np.allclose(around.torque(t, density=3.0), (-torque, torque), rtol=1e-6)
    along = pipe(powers(index, least_rate=1e-4), acceleration=2.0)
    # rates up to the least rate, 1e-4, differ, up to r = 0.01 at n = 0.5: 1e-6 of a velocity of 1/3
    assert apart(along.velocity(RADII, 20.0), index / (index + 1) * (1 - RADII ** (1 + 1 / index))) < 5e-6
    # that of the elements next to the axis at n = 1.5, where the stress bends
    assert apart(along.shear_stress(RADII, 20.0), -RADII) < 5e-6


def test_a_pipe_from_rest_is_that_of_szymanski():
    """u = (1 - r^2)/4 - sum UNIT J0(k r)/k^2 exp(-k^2 t)."""
    found = pipe(NEWTONIAN, acceleration=3.0)
    for t in (1e-5, 1e-3, 0.1, 1.0):
        decay = 3 * UNIT * np.exp(-(ROOTS**2) * t) / ROOTS**2
        u = 0.75 * (1 - RADII**2) - (decay * jv(0, ROOTS * RADII)).sum(axis=0)
        rate = -1.5 * RADII + (decay * ROOTS * jv(1, ROOTS * RADII)).sum(axis=0)
        # the series ends where its terms are 2/k^4 = 1e-15, the slope's 2/k^3 = 1e-12, of a layer of 1e-5
        assert apart(found.velocity(RADII, t), u) < ACCURACY
        assert apart(found.shear_rate(RADII, t), rate) < ACCURACY
        assert found.force(t, density=2.0) == pytest.approx((0.0, -4 * np.pi * rate[-1]), rel=ACCURACY)


def test_a_pipe_that_jumps_carries_its_fluid_along():
    """The layer's closed form, over half of the pipe, leaves the curvature to the equations."""
    found = pipe(NEWTONIAN, (None, Wall(1.0)))
    for t in (1e-5, 1e-3, 0.1, 1.0):
        decay = UNIT * np.exp(-(ROOTS**2) * t)
        assert apart(found.velocity(RADII, t), 1 - (decay * jv(0, ROOTS * RADII)).sum(axis=0)) < 1e-11
        error = found.shear_rate(RADII, t) - (decay * ROOTS * jv(1, ROOTS * RADII)).sum(axis=0)
        # round-off, of a polynomial's slope at the axis: up to 1.7e-11 at t = 1, on some processors
        assert np.max(np.abs(error)) < 5e-11 / min(1.0, np.sqrt(t))


@pytest.mark.parametrize("frequency", [1.0, 400.0])
def test_an_oscillating_pressure_gradient_is_that_of_womersley(frequency):
    """Periodic flow, from rest less what decays of it: UNIT Re[A/(iw + k^2)] of each mode."""
    swing, amplitude = WallMotion(0.3, 1.0, frequency), 0.3 - 1.0j
    rest, periodic = (pipe(NEWTONIAN, before=b, pulsation=swing, acceleration=2.0) for b in (None, REST))
    inelastic = pipe(powers(1.0, least_rate=1e-4), pulsation=swing, acceleration=2.0)
    root = np.sqrt(-1j * frequency)
    for t in (0.01, 0.1, 3.0):
        profile = amplitude / (1j * frequency) * (1 - jv(0, root * RADII) / jv(0, root))
        u = (profile * np.exp(1j * frequency * t)).real + (1 - RADII**2) / 2
        start = (amplitude / (1j * frequency + ROOTS**2)).real + 2 / ROOTS**2
        decay = (UNIT * start * np.exp(-(ROOTS**2) * t) * jv(0, ROOTS * RADII)).sum(axis=0)
        assert apart(periodic.velocity(RADII, t), u) < 1e-12
        assert apart(rest.velocity(RADII, t), u - decay) < ACCURACY
        if t < 1.0:  # step by step
            assert apart(inelastic.velocity(RADII, t), u - decay) < 2 * ACCURACY


def test_what_oscillated_before_decays():
    """The wall is at rest as it is at t = 0, the fluid is not: Re[-i k^2/(iw + k^2)] of each mode decays."""
    swing = WallMotion(0.0, 1.0, 5.0)
    found, before = pipe(NEWTONIAN, before=(None, swing)), pipe(NEWTONIAN, (None, swing), (None, swing))
    assert apart(found.velocity(RADII, 0.0), before.velocity(RADII, 0.0)) < 1e-12
    first = -UNIT * (5j / (5j + ROOTS**2) * -1j).real  # of J0(ROOTS r) at t = 0
    u = (first * np.exp(-(ROOTS**2) * 0.1) * jv(0, ROOTS * RADII)).sum(axis=0)
    assert apart(found.velocity(RADII, 0.1), u) < ACCURACY


def test_an_annular_pipe_follows_its_transform():
    """Acceleration 1 and an inner pipe that jumps, of radii 1/3 and 1: inverse Laplace transforms."""
    inner, walls = 1 / 3, (Wall(1.0), Wall())
    found, r = pipe(NEWTONIAN, walls, None, inner, acceleration=1.0), np.linspace(1 / 3, 1.0, 41)
    share = np.log(r) / np.log(inner)
    steady = share + (1 - r**2 - (1 - inner**2) * share) / 4

    def transform(p):
        p = p[:, None]
        at_inner, at_outer = (quotient(r, np.sqrt(p), *radii, 0) for radii in ((inner, 1.0), (1.0, inner)))
        return (1 - at_inner - at_outer) / p**2 + at_inner / p

    for t in (1e-5, 1e-3, 0.1, 1.0):
        assert apart(found.velocity(r, t), inverse(transform, t)) < ACCURACY
    forces = found.force(5.0, density=2.0)
    assert sum(forces) == pytest.approx(2 * np.pi * (1 - inner**2), rel=ACCURACY)
    developed = pipe(NEWTONIAN, walls, walls, inner, acceleration=1.0)
    assert apart(developed.velocity(r, 0.3), steady) < 1e-12


def test_the_shear_stress_of_developed_flow_is_linear():
    found = pipe(liquid("giesekus"), before=REST, acceleration=4.0)
    for t in (0.0, 1.0):
        assert apart(found.shear_stress(RADII, t), -2 * RADII) < ACCURACY


def test_what_is_neither_annulus_nor_pipe_is_refused():
    for make in (lambda: start_up(liquid("giesekus"), radii=(2.0, 1.0)), lambda: pipe(NEWTONIAN, inner=-0.1)):
        with pytest.raises(ValueError, match="grow outwards"):
            make()
    with pytest.raises(ValueError, match="only a Newtonian fluid has a periodic flow"):
        pipe(liquid("oldroyd_b", 0.5), before=REST, pulsation=WallMotion(1.0, 0.0, 2.0))
