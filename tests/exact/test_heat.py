"""Conduction and viscous heating: printed values of the reference, other solutions, and balances of energy."""

import numpy as np
import pytest
from printed import matches
from scipy.special import j0, j1, jn_zeros, jnp_zeros

from tisph.exact import couette
from tisph.exact.heat import (
    CircularHeating,
    Conduction,
    ExponentialCouette,
    PipeHeating,
    PlaneHeating,
    Wall,
    rotating_mode,
)

PLANE, GAP = np.array([0.0, 0.25, 0.5, 0.75]), np.array([1.25, 1.5, 1.75])
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)

# Talbot's contour with 28 points: the largest exp(z) is 120, and terms of it are rounded to 1e-16 each
ROUNDING = 1e-13


@pytest.mark.parametrize(
    ("t", "held", "insulated"),
    [
        (0.02, "0.00017683416, 0.012419331, 0.21129955", "1.1466063e-6, 0.00017683498, 0.012419331, 0.21129955"),
        (0.1, "0.088343906, 0.26275627, 0.5760595", "0.050694637, 0.098721119, 0.26434868, 0.57624075"),
        (0.5, "0.24676252, 0.4954215, 0.74676251", "0.62922257, 0.65744286, 0.73781172, 0.85810127"),
    ],
)
def test_slab_has_the_printed_temperatures(t, held, insulated):
    """shared/reference/slip_layers_heat.md, section 3: Conduction."""
    of_bottom = {
        kind: Conduction((0.0, 1.0), (wall, Wall(1.0)), 1.0) for kind, wall in (("T", Wall(0.0)), ("q", Wall()))
    }
    assert abs(of_bottom["T"].temperature(0.0, t)) < ROUNDING
    assert matches(of_bottom["T"].temperature(PLANE[1:], t), held)
    assert matches(of_bottom["q"].temperature(PLANE, t), insulated)


@pytest.mark.parametrize(
    ("t", "printed"),
    [
        (0.02, "0.18941403, 0.010166377, 0.00013400358"),
        (0.1, "0.51826235, 0.21628634, 0.067372303"),
        (0.5, "0.67495456, 0.41101908, 0.19001761"),
        (1e3, "0.67807191, 0.4150375, 0.19264508"),
    ],
)
def test_cylinders_have_the_printed_temperatures(t, printed):
    """shared/reference/slip_layers_heat.md, section 3: Conduction."""
    found = Conduction((1.0, 2.0), (Wall(1.0), Wall(0.0)), 1.0, cylindrical=True)
    assert matches(found.temperature(GAP, t), printed)
    assert matches(2 * np.pi * found.heat_flux(1.0, 1e3), "9.0647203")


@pytest.mark.parametrize("t", [1e-7, 1e-3, 0.05, 0.3, 5.0])
def test_slab_with_given_temperatures_is_start_up_couette_flow(t):
    """The same equation, solved by images and series there."""
    y = np.linspace(0.0, 0.02, 41)
    heat = Conduction((0.0, 0.02), (Wall(301.0), Wall(290.0)), 4e-4, conductivity=3.0, initial=300.0)
    flow = {"gap": 0.02, "kinematic_viscosity": 4e-4, "bottom": 1.0, "top": -10.0}
    assert np.max(np.abs(heat.temperature(y, t) - 300.0 - couette.velocity(y, t, **flow))) < 10 * ROUNDING + 300 * 2e-16
    steepest = 10.0 / np.sqrt(4e-4 * t) + 10.0 / 0.02
    assert np.max(np.abs(heat.heat_flux(y, t) / -3.0 - couette.shear_rate(y, t, **flow))) < ROUNDING * steepest


@pytest.mark.parametrize("t", [1e-5, 1e-3, 0.1, 2.0])
def test_circle_is_a_series_of_bessel_functions(t):
    """With T = 1 at the wall, and with the heat flux 1 into a circle that warms up as 2 t (Carslaw and Jaeger 7.8)."""
    r, k = np.array([[0.0], [0.3], [0.9], [1.0]]), jn_zeros(0, 2000)
    held = Conduction((0.0, 1.0), (Wall(), Wall(1.0)), 1.0, cylindrical=True)
    series = 1 - np.sum(2 * j0(k * r) / (k * j1(k)) * np.exp(-(k**2) * t), axis=1)
    assert np.max(np.abs(held.temperature(r[:, 0], t) - series)) < 2 * ROUNDING
    heated = Conduction((0.0, 1.0), (Wall(), Wall(heat_flux=1.0)), 1.0, cylindrical=True)
    k = jnp_zeros(0, 2000)
    modes = np.sum(2 * j0(k * r) / (k**2 * j0(k)) * np.exp(-(k**2) * t), axis=1)
    series = 2 * t + r[:, 0] ** 2 / 2 - 0.25 - modes
    assert np.max(np.abs(heated.temperature(r[:, 0], t) - series)) < 2 * ROUNDING * max(1.0, t)


@pytest.mark.parametrize("cylindrical", [False, True], ids=["slab", "cylinders"])
@pytest.mark.parametrize("walls", [(Wall(2.0), Wall(heat_flux=0.7)), (Wall(heat_flux=-0.4), Wall(heat_flux=0.9))])
def test_walls_bring_the_heat_that_conduction_stores(cylindrical, walls):
    """rho c times the integral of T grows by the heat from the walls; k = 3, kappa = 0.5; Gauss's quadrature."""
    found = Conduction((1.0, 2.5), walls, 0.5, conductivity=3.0, initial=1.0, cylindrical=cylindrical)
    y, t = 1.75 + 0.75 * NODES, 0.25 + 0.2 * NODES
    area = y if cylindrical else np.ones_like(y)
    stored = [6.0 * 0.75 * WEIGHTS @ (area * found.temperature(y, time)) for time in (0.05, 0.45)]
    ends = (1.0, 2.5) if cylindrical else (1.0, 1.0)
    gained = 0.2 * WEIGHTS @ (ends[0] * found.heat_flux(1.0, t) - ends[1] * found.heat_flux(2.5, t))
    assert stored[1] - stored[0] == pytest.approx(gained, abs=1e-11)
    for end, wall, sign in zip((1.0, 2.5), walls, (1.0, -1.0), strict=True):
        if wall.temperature is None:
            assert sign * found.heat_flux(end, 1e-4) == pytest.approx(wall.heat_flux, abs=1e-11)


def test_start_of_conduction_has_the_new_wall_temperatures():
    found = Conduction((0.0, 1.0), (Wall(2.0), Wall()), 1.0, initial=1.0)
    assert found.temperature(np.array([0.0, 0.5, 1.0]), 0.0).tolist() == [2.0, 1.0, 1.0]
    assert found.temperature(PLANE[:, None], np.array([0.0, 0.1, 0.2])).shape == (4, 3)
    with pytest.raises(ValueError, match="t > 0"):
        found.heat_flux(0.5, 0.0)
    with pytest.raises(ValueError, match="must grow"):
        Conduction((1.0, 0.5), (Wall(), Wall()), 1.0)


@pytest.mark.parametrize(
    ("insulated", "k", "rate"), [(False, "3.8317060", "14.681971"), (True, "1.8411838", "3.3899577")]
)
def test_rotating_mode_keeps_its_form(insulated, k, rate):
    """shared/reference/slip_layers_heat.md, section 3: rate, wavenumber from the slope on the axis, wall."""
    case = {"radius": 1.0, "diffusivity": 1.0, "angular_velocity": 2.0, "insulated": insulated}
    early, late = (rotating_mode(0.4, 1.0 + 2.0 * t, t, **case) for t in (0.0, 0.1))
    assert matches(-np.log(late / early) / 0.1, rate)
    small = rotating_mode(1e-3, 0.0, 0.0, **case), rotating_mode(2e-3, 0.0, 0.0, **case)
    slope = (4 * small[0] - small[1] / 2) / 3e-3  # T = k r/2 - (k r)^3/16
    assert 2 * slope == pytest.approx(float(k), abs=1e-7)
    wall = [rotating_mode(r, 0.3, 0.0, **case) for r in (1 - 1e-5, 1 + 1e-5)]
    assert abs(wall[1] - wall[0] if insulated else wall[1] + wall[0]) < 1e-9


def test_plates_with_both_drives_obey_the_energy_equation():
    """Dissipation = heat to the walls; closed forms of Couette and Poiseuille flow as limits."""
    gap, mu, k = 2.0, 3.0, 0.5
    flow = PlaneHeating(gap, mu, k, speeds=(-0.2, 1.0), pressure_gradient=4.0, temperatures=(1.0, 2.0))
    y = 1.0 + NODES
    assert flow.velocity(np.array([0.0, gap])) == pytest.approx([-0.2, 1.0], abs=1e-15)
    assert flow.temperature(np.array([0.0, gap])) == pytest.approx([1.0, 2.0], abs=1e-14)
    rate = 0.6 + 4.0 / mu * (1.0 - y)
    out = flow.heat_flux(gap) - flow.heat_flux(0.0)
    assert out == pytest.approx(mu * WEIGHTS @ rate**2, rel=1e-13)
    speed = PlaneHeating(gap, mu, k, speeds=(0.0, 1.5), temperatures=(1.0, 2.0))
    y = np.linspace(0.0, gap, 9)
    couette_form = 1.0 + y / gap + mu * 1.5**2 / (2 * k) * (y / gap) * (1 - y / gap)
    assert speed.temperature(y) == pytest.approx(couette_form, rel=1e-14)
    assert PlaneHeating(gap, mu, k, speeds=(0.0, 1.5)).heat_flux(gap) == pytest.approx(mu * 1.5**2 / (2 * gap))
    mean = 0.7
    pressed = PlaneHeating(gap, mu, k, pressure_gradient=12 * mu * mean / gap**2)
    assert pressed.temperature(y) == pytest.approx(3 * mu * mean**2 / (4 * k) * (1 - (2 * y / gap - 1) ** 4), abs=1e-14)
    assert pressed.heat_flux(gap) == pytest.approx(6 * mu * mean**2 / gap, rel=1e-13)


def test_circular_heating_has_the_printed_values():
    """shared/reference/slip_layers_heat.md, section 3: Viscous heating."""
    flow = CircularHeating((1.0, 2.0), (1.0, 0.0), 1.0, 1.0)
    assert matches(flow.temperature(GAP), "0.21076254, 0.20770432, 0.12080568")
    assert matches(flow.heat_flux(np.array([1.0, 2.0])) * [-1.0, 1.0], "1.6319622, 0.51735225")
    assert flow.velocity(np.array([1.0, 2.0])) == pytest.approx([1.0, 0.0], abs=1e-15)
    walls = CircularHeating((1.0, 2.0), (1.0, 0.0), 1.0, 1.0, temperatures=(3.0, 1.0))
    conduction = 1.0 + 2.0 * np.log(2.0 / GAP) / np.log(2.0)
    assert walls.temperature(GAP) == pytest.approx(flow.temperature(GAP) + conduction, rel=1e-14)


def test_the_work_of_a_pipe_leaves_as_heat():
    """G times the flow rate pi G R^4/(8 mu) is the heat through the wall per length; T'' and T'/r by differences."""
    pipe = PipeHeating(1.5, 2.0, 0.3, 4.0, 1.0)
    assert 2 * np.pi * 1.5 * pipe.heat_flux(1.5) == pytest.approx(16.0 * np.pi * 1.5**4 / 16.0, rel=1e-14)
    assert pipe.temperature(1.5) == 1.0
    assert pipe.velocity(np.array([0.0, 1.5])) == pytest.approx([4.0 * 1.5**2 / 8.0, 0.0])
    slope = (pipe.temperature(0.7 + 1e-5) - pipe.temperature(0.7 - 1e-5)) / 2e-5
    assert -0.3 * slope == pytest.approx(pipe.heat_flux(0.7), rel=1e-9)


@pytest.mark.parametrize(
    ("nahme", "printed"),
    [
        (1.0, "0.11778304, 0.92419624, 0.46209812, 0.087903813, 0.24264069"),
        (5.0, "0.48550782, 0.7196865, 1.7992162, 0.3567827, 0.2198039"),
        (20.0, "1.252763, 0.41883964, 4.1883964, 0.89130942, 0.17416574"),
    ],
)
def test_exponential_couette_flow_has_the_printed_values(nahme, printed):
    """shared/reference/slip_layers_heat.md, section 3, and in other units: gap 2, mu0 3, k 5, a 0.1, T0 300."""
    flow = ExponentialCouette(2.0, 3.0, 5.0, 0.1, np.sqrt(nahme * 5.0 / 0.3), 300.0)
    assert flow.nahme == pytest.approx(nahme, rel=1e-14)
    numbers = [
        0.1 * (flow.temperature(1.0) - 300.0),
        flow.stress * 2.0 / (3.0 * flow.speed),
        0.1 * flow.heat_flux(2.0) * 2.0 / 5.0,
        0.1 * (flow.temperature(0.5) - 300.0),
        flow.velocity(0.5) / flow.speed,
    ]
    assert matches(numbers, printed)
    assert flow.heat_flux(2.0) - flow.heat_flux(0.0) == pytest.approx(flow.stress * flow.speed, rel=1e-13)


UNIT = {"gap": 1.0, "viscosity": 1.0, "conductivity": 1.0, "coefficient": 1.0}


def test_a_stress_has_a_cold_and_a_hot_flow():
    """shared/reference/slip_layers_heat.md, section 3: at G = 2."""
    cold, hot = (ExponentialCouette.of_stress(np.sqrt(2.0), **UNIT, hot=hot) for hot in (False, True))
    assert matches([cold.nahme, hot.nahme], "3.1160939, 136.74489")
    assert matches(cold.speed / np.sqrt(2.0), "1.2482175")
    for flow in (cold, hot):
        assert flow.stress == pytest.approx(np.sqrt(2.0), rel=1e-13)


def test_stresses_above_the_largest_are_refused():
    """Its square is G = 3.513830719, where Na = 18.21374 and the fluid is warmest by 1.18684."""
    largest = np.sqrt(3.513830719)
    turning = ExponentialCouette.of_stress(largest * (1 - 1e-13), **UNIT)
    assert turning.nahme == pytest.approx(18.21374, abs=5e-3)  # the root of the distance from the largest stress
    assert turning.temperature(0.5) == pytest.approx(1.18684, abs=2e-4)
    with pytest.raises(ValueError, match=r"up to 1\.87452146.*heats without end"):
        ExponentialCouette.of_stress(largest * (1 + 1e-9), **UNIT)
    with pytest.raises(ValueError, match=r"up to 18\.7452146"):
        ExponentialCouette.of_stress(20.0, gap=2.0, viscosity=8.0, conductivity=5.0, coefficient=0.1)


def test_without_heating_the_exponential_flow_is_that_of_one_viscosity():
    """Na -> 0: T - T0 = (mu U^2/(2 k)) (y/H)(1 - y/H), to the relative order Na."""
    flow = ExponentialCouette(1.0, 1.0, 1.0, 1.0, 1e-4)
    plain = PlaneHeating(1.0, 1.0, 1.0, speeds=(0.0, 1e-4))
    assert flow.temperature(PLANE) == pytest.approx(plain.temperature(PLANE), rel=1e-7, abs=1e-15)
    assert flow.velocity(PLANE) == pytest.approx(plain.velocity(PLANE), rel=1e-8)
