"""Natural convection: printed values, the flux from wall to wall, work against friction, and limits."""

import numpy as np
import pytest
from printed import matches

from tisph.exact.convection import HeatedCavity, Rolls, critical, growth_rate, marginal_rayleigh

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2


@pytest.mark.parametrize(
    ("slip", "rayleigh", "wavenumber"),
    [
        ((0.0, 0.0), "1707.76178", "3.116324"),
        ((0.0, np.inf), "1100.64961", "2.682322"),
        ((np.inf, np.inf), "657.511365", "2.221441"),
        ((0.1, 0.1), "1186.05657", "2.8245"),
    ],
)
def test_convection_starts_at_the_printed_rayleigh_numbers(slip, rayleigh, wavenumber):
    """shared/reference/slip_layers_heat.md, section 3: Buoyancy; turned upside down, and as the root of the growth."""
    least, k = critical(slip)
    assert matches(least, rayleigh, 2e-8)  # 27 pi^4/4 = 657.51136448 is printed with another last digit
    assert matches(k, wavenumber)
    assert marginal_rayleigh(k, slip[::-1]) == pytest.approx(least, rel=1e-10)
    for prandtl in (0.71, 5.0):
        rates = [growth_rate(k, least * part, prandtl, slip) for part in (0.99, 1.0, 1.01)]
        assert rates[0] < -0.01
        assert abs(rates[1]) < 1e-7
        assert rates[2] > 0.01


def test_free_plates_have_closed_forms():
    """Ra_c = 27 pi^4/4 at k = pi/2^(1/2); s of v = sin(pi y): (s/Pr + a)(s + a) a = Ra k^2 with a = pi^2 + k^2."""
    free = np.inf, np.inf
    least, k = critical(free)
    assert least == pytest.approx(27 * np.pi**4 / 4, rel=1e-10)
    assert k == pytest.approx(np.pi / np.sqrt(2), rel=1e-7)
    a, prandtl, rayleigh = np.pi**2 + 9.0, 0.3, 1500.0
    sum_of_rates, product = a * (1 + prandtl), prandtl * (a**2 - rayleigh * 9.0 / a)
    expected = (-sum_of_rates + np.sqrt(sum_of_rates**2 - 4 * product)) / 2
    assert growth_rate(3.0, rayleigh, prandtl, free) == pytest.approx(expected, rel=1e-9)


def test_rolls_grow_at_the_printed_rates():
    """shared/reference/slip_layers_heat.md, section 3: Buoyancy, k H = 3.117."""
    assert matches(growth_rate(3.117, 2000.0, 1.0), "2.146311")
    assert matches(growth_rate(3.117, 1500.0, 0.71), "-1.4327074")


@pytest.mark.parametrize(
    ("rayleigh", "prandtl", "nusselt", "speed"),
    [(2000.0, 1.0, "1.21205", "4.9255"), (5000.0, 0.71, "2.11026", "17.706")],
)
def test_saturated_rolls_have_the_printed_values(rayleigh, prandtl, nusselt, speed):
    """shared/reference/slip_layers_heat.md, section 3: Buoyancy; in units of a layer of height 2 and kappa 3."""
    found = Rolls(rayleigh, prandtl, 3.117 / 2, height=2.0, diffusivity=3.0, temperatures=(7.0, 5.0))
    assert matches(found.nusselt, nusselt)
    assert matches(found.largest_velocity * 2.0 / 3.0, speed)
    for order in (24, 32):
        other = Rolls(rayleigh, prandtl, 3.117, order=order)
        assert other.nusselt == pytest.approx(found.nusselt, rel=1e-8)
    step, x = 1e-4, 2 * np.pi / 3.117 * np.linspace(0.0, 2.0, 65)[:-1]
    below = (7.0 - found.temperature(x, step)) / step
    half = (7.0 - found.temperature(x, 2 * step)) / (2 * step)
    assert np.mean(2 * below - half) == pytest.approx(found.nusselt, rel=1e-6)  # dT/height = 1


def test_buoyancy_of_rolls_works_against_friction():
    """The integral of the squared vorticity is Ra (Nu - 1) per area; its fluid rises where it is warm, div u = 0."""
    found, step, length = Rolls(3000.0, 0.71, 3.0), 1e-5, np.pi / 3.0
    x, y = np.meshgrid(length * NODES, step + (1 - 2 * step) * NODES, indexing="ij")
    right, left, upper, lower = (
        found.velocity(x + dx, y + dy) for dx, dy in ((step, 0), (-step, 0), (0, step), (0, -step))
    )
    vorticity = (right[1] - left[1] - upper[0] + lower[0]) / (2 * step)
    divergence = (right[0] - left[0] + upper[1] - lower[1]) / (2 * step)
    assert np.abs(divergence).max() < 1e-6 * np.abs(vorticity).max()
    mean = WEIGHTS @ vorticity**2 @ WEIGHTS
    assert mean == pytest.approx(3000.0 * (found.nusselt - 1.0), rel=1e-4)
    carried = WEIGHTS @ (found.velocity(x, y)[1] * found.temperature(x, y)) @ WEIGHTS
    assert carried == pytest.approx(found.nusselt - 1.0, rel=1e-4)
    assert found.velocity(0.0, 0.5)[1] > 0.0
    assert found.temperature(0.0, 0.5) > found.temperature(length, 0.5)
    assert np.abs(found.velocity(x, 0.0)).max() < 1e-10


def test_weak_rolls_grow_with_the_root_of_the_excess():
    """v ~ (Ra - Ra_c)^(1/2) and Nu - 1 ~ Ra - Ra_c; below Ra_c the layer is at rest."""
    least = marginal_rayleigh(3.117)
    weak, twice = (Rolls(least * (1 + excess), 1.0, 3.117) for excess in (1e-3, 2e-3))
    assert twice.largest_velocity / weak.largest_velocity == pytest.approx(np.sqrt(2.0), rel=1e-3)
    assert (twice.nusselt - 1.0) / (weak.nusselt - 1.0) == pytest.approx(2.0, rel=5e-3)
    with pytest.raises(ValueError, match=r"above 1707\.76"):
        Rolls(1700.0, 1.0, 3.117).velocity(0.0, 0.5)


@pytest.mark.parametrize(
    ("rayleigh", "nusselt", "u", "v", "psi", "local"),
    [
        (1e3, "1.11779", "3.649448, 0.81323", "3.697438, 0.17833", "1.174643", "1.50631, 0.08842, 0.69125"),
        (1e4, "2.244816", "16.18333, 0.82323", "19.62822, 0.11886", "5.073673", "3.53107, 0.1442, 0.584966"),
        (1e5, "4.521636", "34.74067, 0.85461", "68.63537, 0.065858", "9.115582", "7.72014, 0.0821, 0.727951"),
    ],
)
def test_heated_cavity_has_the_printed_values(rayleigh, nusselt, u, v, psi, local):
    """shared/reference/slip_layers_heat.md, section 3: Buoyancy, "sizes agree to 5e-7"; local Nu 3e-6 by the order."""
    found = HeatedCavity(rayleigh, 0.71, width=2.0, height=2.0, diffusivity=3.0)
    unit, numbers = 3.0 / 2.0, found.extremes()
    assert matches(found.nusselt, nusselt)
    for name, place, printed in (("u_max", "y_u_max", u), ("v_max", "x_v_max", v)):
        assert matches([numbers[name] / unit, numbers[place] / 2.0], printed, 5e-7 * numbers[name] / unit)
    assert matches(-found.stream_function(1.0, 1.0) / 3.0, psi)
    largest = [numbers["nusselt_max"], numbers["y_nusselt_max"] / 2.0, numbers["nusselt_min"]]
    assert matches(largest, local, 3e-6)
    assert WEIGHTS @ found.local_nusselt(2.0 * NODES) == pytest.approx(found.nusselt, rel=1e-6)


def test_heated_cavity_has_the_flux_of_its_middle():
    """The mean of u T - T_x on x = width/2 is Nu, in a cavity twice as high as wide; by symmetry of a half turn."""
    found = HeatedCavity(2e4, 7.0, height=2.0, temperatures=(3.0, 1.0), order=32)
    y, step = 2.0 * NODES, 1e-5
    gradient = (found.temperature(0.5 + step, y) - found.temperature(0.5 - step, y)) / (2 * step)
    flux = found.velocity(0.5, y)[0] * (found.temperature(0.5, y) - 2.0) - gradient
    assert WEIGHTS @ flux / 2.0 == pytest.approx(found.nusselt, rel=1e-8)
    x = np.array([0.0, 0.13, 0.5, 1.0])
    assert found.temperature(x, 0.3) == pytest.approx(4.0 - found.temperature(1.0 - x, 1.7), abs=1e-12)
    assert found.temperature(np.array([0.0, 1.0]), 0.8) == pytest.approx([3.0, 1.0], abs=1e-12)
    assert np.abs(found.velocity(x, 2.0)).max() < 1e-9


def test_a_cavity_of_little_buoyancy_conducts():
    found = HeatedCavity(1e-3, 0.71, order=20)
    assert found.nusselt == pytest.approx(1.0, abs=1e-9)
    assert found.temperature(0.25, 0.6) == pytest.approx(0.25, abs=1e-6)
    # lap lap psi = -Ra T_x = Ra, so that psi scales with Ra
    twice = HeatedCavity(2e-3, 0.71, order=20)
    assert twice.stream_function(0.5, 0.5) == pytest.approx(2 * found.stream_function(0.5, 0.5), rel=1e-6)


def test_cavities_without_a_solution_on_the_grid_are_refused():
    with pytest.raises(ValueError, match="no steady convection"):
        HeatedCavity(1e9, 0.71, order=8).velocity(0.5, 0.5)
