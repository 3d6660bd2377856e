"""Entrance of a heated channel, and dispersion: printed values, equations by differences, and limits."""

import numpy as np
import pytest
from printed import matches
from scipy.special import jnp_zeros

from tisph.exact.passive_scalar import Dispersion, Entrance, parabola

PLATES, PIPE = {"width": 2.0, "pipe": False}, {"width": 1.5, "pipe": True}


def entrance(shape, flux=False, diffusivity=0.1, mean=2.0):
    """An entrance, and the distance at which x* = 1."""
    found = Entrance(shape["width"], parabola(mean, **shape), diffusivity, shape["pipe"], flux)
    return found, mean * found.hydraulic_diameter**2 / diffusivity


@pytest.mark.parametrize(
    ("shape", "flux", "developed", "local", "mean", "bulk"),
    [
        (PLATES, False, "7.5407009", "12.821726, 7.7404962, 7.5407016", "9.8248833", "0.6750319"),
        (PLATES, True, "8.2352941", "15.427055, 8.8031491, 8.2355025", None, "0.16"),
        (PIPE, False, "3.6567935", "10.130193, 4.916064, 3.7099883", "7.1552232", "0.75110567"),
        (PIPE, True, "4.3636364", "12.53816, 6.1481441, 4.5138862", None, "0.08"),
    ],
    ids=["plates, temperature", "plates, flux", "pipe, temperature", "pipe, flux"],
)
def test_entrances_have_the_printed_nusselt_numbers(shape, flux, developed, local, mean, bulk):
    """shared/reference/slip_layers_heat.md, section 3: Entrance of a heated channel."""
    found, length = entrance(shape, flux)
    assert found.hydraulic_diameter == pytest.approx(4.0 if shape is PLATES else 3.0)
    assert found.mean_velocity == pytest.approx(2.0, rel=1e-14)
    assert matches(found.developed_nusselt(), developed)
    assert matches(found.nusselt(np.array([0.001, 0.01, 0.05]) * length), local)
    assert matches(found.bulk(0.01 * length), bulk)
    if mean:
        assert matches(found.mean_nusselt(0.01 * length), mean, 2e-8)  # 9.824883356 rounds to another last digit
    assert found.nusselt(1e3 * length) == pytest.approx(found.developed_nusselt(), rel=1e-12)


@pytest.mark.parametrize(
    ("shape", "printed"), [(PLATES, "7.6306085, 7.5419647"), (PIPE, "3.6951782, 3.6572414")], ids=["plates", "pipe"]
)
def test_axial_conduction_has_the_printed_nusselt_numbers(shape, printed):
    """shared/reference/slip_layers_heat.md, section 3: Pe = V Dh/kappa = 10 and 100."""
    diameter = entrance(shape)[0].hydraulic_diameter
    found = [
        entrance(shape, diffusivity=2.0 * diameter / peclet)[0].developed_nusselt(axial_conduction=True)
        for peclet in (10, 100)
    ]
    assert matches(found, printed)
    fast = entrance(shape, diffusivity=2.0 * diameter / 1e6)[0]
    assert fast.developed_nusselt(axial_conduction=True) == pytest.approx(fast.developed_nusselt(), rel=1e-9)


@pytest.mark.parametrize("flux", [False, True], ids=["temperature", "flux"])
@pytest.mark.parametrize("shape", [PLATES, PIPE], ids=["plates", "pipe"])
def test_temperature_of_an_entrance_obeys_its_equation(shape, flux):
    """u T_x = kappa lap T by differences of 1e-3 of lengths, whose errors are some 1e-6; walls, inlet and bulk."""
    found, length = entrance(shape, flux)
    width, x, y = shape["width"], 0.01 * length, 0.83 * shape["width"]
    along, across = 1e-3 * x, 1e-3 * width
    slope = (found.temperature(x + along, y) - found.temperature(x - along, y)) / (2 * along)
    near = [found.temperature(x, y + step) for step in (-across, 0.0, across)]
    laplacian = (near[0] - 2 * near[1] + near[2]) / across**2
    if shape["pipe"]:
        laplacian += (near[2] - near[0]) / (2 * across * y)
    assert found.velocity(y) * slope == pytest.approx(0.1 * laplacian, rel=1e-4)
    half = width if shape["pipe"] else width / 2
    wall = [found.temperature(x, width - step) for step in (0.0, 1e-4 * width, 2e-4 * width)]
    gradient = (3 * wall[0] - 4 * wall[1] + wall[2]) / (2e-4 * width)
    if flux:
        assert gradient * half == pytest.approx(1.0, rel=1e-5)
        difference = wall[0] - found.bulk(x)
    else:
        assert abs(wall[0]) < 1e-12
        difference = found.bulk(x)
    flux_per_length = abs(gradient) * found.hydraulic_diameter
    assert flux_per_length / difference == pytest.approx(found.nusselt(x), rel=1e-5)
    assert found.temperature(1e-4 * length, width / 2 * (not shape["pipe"])) == pytest.approx(1.0 - flux, abs=1e-6)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    places = width * (nodes + 1) / 2
    carried = weights * found.velocity(places) * (places if shape["pipe"] else 1.0)
    assert carried @ found.temperature(x, places) / carried.sum() == pytest.approx(found.bulk(x), rel=1e-11)


@pytest.mark.parametrize(
    ("wavenumber", "real", "imaginary"),
    [
        (np.pi, "-15.098733", "-32.052768"),
        (1.0, "-1.4807138", "-10.014855"),
        (0.5, "-0.3693264", "-5.0018167"),
    ],
)
def test_slowest_modes_have_the_printed_rates(wavenumber, real, imaginary):
    """shared/reference/slip_layers_heat.md, section 3: Passive scalar, Pe = 10; also with H = 2 and D = 3."""
    for width, diffusivity in ((1.0, 1.0), (2.0, 3.0)):
        unit = diffusivity / width**2
        flow = Dispersion(width, parabola(10.0 * diffusivity / width, width), diffusivity)
        rate = flow.rate(wavenumber / width) / unit
        assert matches(rate.real, real)
        assert matches(rate.imag, imaginary)


@pytest.mark.parametrize(
    ("velocity", "pipe", "divisor"),
    [
        (parabola(3.0, 2.0), False, 210.0),
        (lambda y: 3.0 * y, False, 30.0),
        (parabola(3.0, 2.0, pipe=True), True, 48.0),
    ],
    ids=["Poiseuille", "Couette", "pipe"],
)
def test_long_waves_disperse_as_taylor_and_aris_found(velocity, pipe, divisor):
    """D_eff, and s = -i k V - D_eff k^2 up to terms of k^3 (they are imaginary) and k^4."""
    flow = Dispersion(2.0, velocity, 0.5, pipe)
    assert flow.effective_diffusivity == pytest.approx(0.5 * (1 + (3.0 * 2.0 / 0.5) ** 2 / divisor), rel=1e-12)
    k = 1e-3
    rate = flow.rate(k)
    assert -rate.real / k**2 == pytest.approx(flow.effective_diffusivity, rel=1e-5)
    assert -rate.imag / k == pytest.approx(3.0, rel=1e-4)


@pytest.mark.parametrize("pipe", [False, True], ids=["plates", "pipe"])
def test_modes_obey_the_equation_and_insulated_walls(pipe):
    """s f = kappa (lap f - k^2 f) - i k u f by differences of 1e-3, with errors of some 1e-6."""
    flow, k, y, step = Dispersion(1.0, parabola(5.0, 1.0, pipe), 0.5, pipe), 2.0, 0.37, 1e-3
    near = flow.mode(k, np.array([y - step, y, y + step]))
    laplacian = (near[0] - 2 * near[1] + near[2]) / step**2 + pipe * (near[2] - near[0]) / (2 * step * y)
    right = 0.5 * (laplacian - k**2 * near[1]) - 1j * k * flow.velocity(y) * near[1]
    assert abs(right / near[1] - flow.rate(k)) < 1e-4 * abs(flow.rate(k))
    wall = flow.mode(k, 1.0 - 1e-4 * np.arange(3))
    assert abs(3 * wall[0] - 4 * wall[1] + wall[2]) / 2e-4 < 1e-5
    nodes, weights = np.polynomial.legendre.leggauss(40)
    places = (nodes + 1) / 2
    area = weights * (places if pipe else 1.0)
    assert area @ flow.mode(k, places) / area.sum() == pytest.approx(1.0, rel=1e-12)


def test_a_fluid_at_rest_or_in_plug_flow_does_not_disperse():
    for speed in (0.0, 2.0):
        flow = Dispersion(1.0, lambda y, speed=speed: speed + 0.0 * y, 0.3)
        assert flow.effective_diffusivity == pytest.approx(0.3, rel=1e-13)
        assert flow.rate(1.7) == pytest.approx(-0.3 * 1.7**2 - 1.7j * speed, abs=1e-12)


def test_plug_flow_in_a_heated_pipe_has_a_closed_nusselt_number():
    """u = V: conduction in a cylinder in the time x/V, Nu = 8 with a given flux; local Nu by zeros of J1."""
    flow = Entrance(1.0, lambda r: 2.0 + 0.0 * r, 0.5, pipe=True, flux=True)
    assert flow.developed_nusselt() == pytest.approx(8.0, rel=1e-12)
    time = 0.5 * 0.3 / 2.0
    difference = 0.25 - 2 * np.sum(np.exp(-(jnp_zeros(0, 50) ** 2) * time) / jnp_zeros(0, 50) ** 2)
    assert flow.nusselt(0.3) == pytest.approx(2 / difference, rel=1e-10)
