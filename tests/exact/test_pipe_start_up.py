"""Start-up along a pipe or an annular one: against Bessel series, modes of Oldroyd-B flow, and steady closed forms."""

import numpy as np
import pytest
from oracles._annulus_modes import modes, velocities
from polymer_laws import law
from scipy.special import jn_zeros, jv

from tisph.exact.start_up import InelasticFluid, PipeStartUp, ViscoelasticFluid, Wall
from tisph.geometry.motion import WallMotion
from tisph.rheology import power_law

RADII = np.linspace(0.0, 1.0, 41)
ROOTS = jn_zeros(0, 2000)[:, None]
UNIT = 2 / (ROOTS * jv(1, ROOTS))
"""Coefficients of 1 = sum UNIT J0(ROOTS r)."""

NEWTONIAN, REST = ViscoelasticFluid(1.0, ()), (Wall(), Wall())
ACCURACY = 1e-8
"""That the module promises, relative to the largest value in the gap."""


def pipe(fluid, walls=REST, before=None, inner=0.0, **drive):
    return PipeStartUp((inner, 1.0), fluid, walls, before, **drive)


def oldroyd_b(fraction):
    return ViscoelasticFluid(fraction, (law("oldroyd_b", viscosity=1.0 - fraction, relaxation_time=1.0),))


def powers(index, least_rate=1e-4):
    numbers = power_law.Parameters(index=index, reference_rate=1.0, least_rate=least_rate)
    return InelasticFluid(numbers.law(1.0, 1.0), 1.0)


def apart(found, expected):
    return np.max(np.abs(found - expected)) / np.max(np.abs(expected))


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
    inelastic = pipe(powers(1.0), pulsation=swing, acceleration=2.0)
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


def test_an_annular_pipe_follows_its_modes():
    """Acceleration 1 and an inner pipe that jumps: steady flow less pi (1/(k^2 (q + 1)) - 1/(q^2 - 1)) u_n.

    Radii 1/3 and 1; the first part by twofold partial integration of a mode over r dr, the second of ``modes``.
    """
    inner, walls = 1 / 3, (Wall(1.0), Wall())
    found, r = pipe(NEWTONIAN, walls, None, inner, acceleration=1.0), np.linspace(1 / 3, 1.0, 41)
    k, quotient = modes(3.0, 2000, 0)
    share = np.log(r) / np.log(inner)
    steady = share + (1 - r**2 - (1 - inner**2) * share) / 4
    coefficients = np.pi * (inner**2 / (k**2 * (quotient + 1)) - 1 / (quotient**2 - 1))
    for t in (1e-5, 1e-3, 0.1, 1.0):
        decay = coefficients * np.exp(-((k / inner) ** 2) * t)
        assert apart(found.velocity(r, t), steady - decay @ velocities(k[:, None], r / inner, 0)) < ACCURACY
    forces = found.force(5.0, density=2.0)
    assert sum(forces) == pytest.approx(2 * np.pi * (1 - inner**2), rel=ACCURACY)
    developed = pipe(NEWTONIAN, walls, walls, inner, acceleration=1.0)
    assert apart(developed.velocity(r, 0.3), steady) < 1e-12


def oldroyd_modes(r, t, fraction):
    """Velocity and S_xr from rest, acceleration and relaxation time 1, as in ``test_circular_start_up``.

    u = sum (UNIT/k^2 + a) J0(k r) and S = (1 - fraction) sum (UNIT/k^2 + b) d/dr J0(k r), da/dt = -nu_s k^2 a -
    nu_p k^2 b, db/dt = a - b, both -UNIT/k^2 at first.
    """
    k, fading = ROOTS, np.exp(-36 * (np.arange(len(ROOTS)) / len(ROOTS)) ** 6)[:, None]
    half, whole = fraction * k**2 - 1, fraction * k**2 + 1
    root = np.sqrt((half**2 - 4 * (1 - fraction) * k**2).astype(complex))
    grown = np.exp((root - whole) * t / 2), np.exp((-root - whole) * t / 2)
    swing, mean = ((grown[0] - grown[1]) / root).real, ((grown[0] + grown[1]) / 2).real
    start = -UNIT / k**2 * fading
    a, b = start * (mean - swing * (half / 2 + (1 - fraction) * k**2)), start * (mean + swing * (1 + half / 2))
    u = (1 - r**2) / 4 + (a * jv(0, k * r)).sum(axis=0)
    return u, -(1 - fraction) * (r / 2 + (b * k * jv(1, k * r)).sum(axis=0))


def test_oldroyd_b_follows_its_modes_to_the_parabola():
    found, r = pipe(oldroyd_b(0.1), acceleration=1.0), np.array([0.0, 0.1, 0.5, 0.9])
    for t in (0.02, 0.5, 3.0):
        u, stress = oldroyd_modes(r, t, 0.1)
        assert apart(found.velocity(r, t), u) < ACCURACY
        assert apart(found.polymer_stress(r, t)[1], stress) < ACCURACY
    t = 60.0
    assert apart(found.velocity(RADII, t), (1 - RADII**2) / 4) < ACCURACY
    along, _, across = found.polymer_stress(RADII, t)
    assert apart(along, 2 * 0.9 * (RADII / 2) ** 2) < ACCURACY
    assert not np.any(across)
    (excess,) = found.conformation_excess(RADII, t)
    assert apart(excess[1], -RADII / 2) < ACCURACY


def test_the_shear_stress_of_developed_flow_is_linear():
    fluid = ViscoelasticFluid(0.1, (law("giesekus", viscosity=0.9, relaxation_time=1.0),))
    found = pipe(fluid, before=REST, acceleration=4.0)
    for t in (0.0, 1.0):
        assert apart(found.shear_stress(RADII, t), -2 * RADII) < ACCURACY


@pytest.mark.parametrize("index", [0.5, 1.5])
def test_steady_flow_of_a_power_law_in_a_pipe(index):
    """u = n/(n + 1) (1 - r^(1 + 1/n)), of the shear stress -r (Bird, Armstrong and Hassager 1987, section 4.2)."""
    found, n = pipe(powers(index), acceleration=2.0), index
    expected = n / (n + 1) * (1 - RADII ** (1 + 1 / n))
    # rates up to the least rate, 1e-4, differ, up to r = 0.01 at n = 0.5: 1e-6 of a velocity of 1/3
    assert apart(found.velocity(RADII, 20.0), expected) < 5e-6
    # that of the elements next to the axis at n = 1.5, where the stress bends
    assert apart(found.shear_stress(RADII, 20.0), -RADII) < 5e-6


def test_what_is_no_pipe_is_refused():
    with pytest.raises(ValueError, match="grow outwards"):
        pipe(NEWTONIAN, inner=-0.1)
    with pytest.raises(ValueError, match="only a Newtonian fluid has a periodic flow"):
        pipe(oldroyd_b(0.5), before=REST, pulsation=WallMotion(1.0, 0.0, 2.0))
