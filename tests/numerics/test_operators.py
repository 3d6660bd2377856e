"""Operators on disordered particles: exactness, order, symmetries; and the table of pair weights."""

import numpy as np
import pytest
from rates import LINEAR_EOS, RatesOf, impose

from tisph import registry, runtime
from tisph.runtime import ti
from tisph.schemes.wcsph.operators._pairs import WeightTable
from tisph.schemes.wcsph.operators.consistent import DIFFUSION

pytestmark = pytest.mark.taichi


def test_linear_fields_are_exact_on_any_arrangement(make):
    # velocity (a + b y, c y), compression e + f y: all that is linear and periodic in x
    scheme = make(LINEAR_EOS, jitter=0.3)
    a, b, c, e, f = 0.3, 0.7, -0.2, 0.01, 0.02
    _, y = impose(scheme, lambda x, y: (a + b * y, c * y), lambda x, y: e + f * y)
    acceleration, compression, transport = RatesOf(scheme).arrays()
    s = e + f * y
    expected = np.stack([b * transport[:, 1], c * transport[:, 1] - 25.0 * f / (1 + s)], 1)
    # 40 neighbours of size 1e2 in sums of 1e3: rounding of 1e-16 grows to below 1e-10 over spacing^2
    assert np.allclose(acceleration, expected, atol=1e-9)
    assert np.allclose(compression, -(1 + s) * c + transport[:, 1] * f, atol=1e-9)


def test_laplacian_and_gradient_converge_at_second_order_on_the_lattice(make):
    errors, wave = [], 2 * np.pi
    for across in (12, 24):
        scheme = make(LINEAR_EOS, f"discretisation.particles_across={across}")
        x, y = impose(scheme, lambda x, y: (np.sin(wave * x), 0 * x), lambda x, y: 1e-3 * np.cos(wave * x))
        acceleration, compression, _ = RatesOf(scheme).arrays()
        inside = (y > 0.4) & (y < 0.6)
        s = 1e-3 * np.cos(wave * x)
        slope = 25.0 * 1e-3 * wave * np.sin(wave * x) / (1 + s)
        exact = slope - 0.01 * wave**2 * np.sin(wave * x)
        # the smoothing length is the spacing
        diffusion = -DIFFUSION * scheme.scene.spacing * 5.0 * wave**2 * s
        exact_compression = -(1 + s) * wave * np.cos(wave * x) + diffusion
        errors.append(
            (np.abs(acceleration[:, 0] - exact)[inside].max(), np.abs(compression - exact_compression)[inside].max())
        )
    orders = np.log2(np.array(errors[0]) / np.array(errors[1]))
    # second order, less what the next term of the expansion takes at 12 points a wave
    assert np.all(orders > 1.8)


def test_shift_points_away_from_a_crowded_side(make):
    # one particle moved up by a fifth of a spacing: pushed back down, its neighbour above pushed up
    scheme = make()
    places = scheme.particles.mid_position.to_numpy()
    now = scheme.now
    i = int(np.argmin(np.hypot(places[now, :144, 0] - 0.5, places[now, :144, 1] - 0.5)))
    above = int(np.argmin(np.hypot(*(places[now, :144] - places[now, i] - [0, 1 / 12]).T)))
    places[now, i, 1] += 0.2 / 12
    scheme.particles.mid_position.from_numpy(places)
    _, _, transport = RatesOf(scheme).arrays()
    assert transport[i, 1] < 0 < transport[above, 1]
    assert abs(transport[i, 0]) < 1e-12
    assert np.abs(transport).max() < 0.5 * scheme.operators.shift_speed[None]


@pytest.mark.parametrize("operators", ["consistent", "standard"])
def test_a_sheared_lattice_feels_no_force(make, operators):
    # uniform shear on a point-symmetric arrangement: forces cancel in pairs, divergence is zero
    scheme = make(LINEAR_EOS, f"scheme.operators={operators}", "walls.treatment.type=comoving_image")
    impose(scheme, lambda x, y: (y, 0 * y), lambda x, y: 0 * y)
    acceleration, compression, _ = RatesOf(scheme).arrays()
    assert np.abs(acceleration).max() < 1e-12
    assert np.abs(compression).max() < 1e-12


def test_what_pressure_does_goes_with_one_over_the_density(make):
    # of standard operators, on particles and through the walls: the same pressures at compression 0 and 0.5
    scheme = make(LINEAR_EOS, "scheme.operators=standard", jitter=0.2)
    impose(scheme, lambda x, y: (0 * y, 0 * y), lambda x, y: 0.01 * np.sin(2 * np.pi * x) + 0.02 * y)
    found = []
    for compression in (0.0, 0.5):
        scheme.particles.mid_compression.fill(compression)
        acceleration = RatesOf(scheme).arrays()[0]
        found.append(np.append(acceleration, scheme.boundaries.wall_forces(scheme.now)))
    assert np.abs(found[0][-2:]).min() > 1e-4
    assert np.allclose(found[0], 1.5 * found[1], rtol=1e-12, atol=1e-12)  # rounding of sums of numbers up to 1e2


def test_artificial_viscosity_pushes_only_approaching_pairs(make):
    # a pure compression along y and its opposite: only the first is resisted
    found = []
    for viscosity in (1.0, 0.0):
        scheme = make(LINEAR_EOS, f"scheme.artificial_viscosity={viscosity}", "scheme.operators=standard")
        rates = RatesOf(scheme)
        for sign in (-1.0, 1.0):
            _, y = impose(scheme, lambda x, y, sign=sign: (0 * y, sign * y * y), lambda x, y: 0 * y)
            found.append(rates.arrays()[0][(y > 0.3) & (y < 0.7)])
    approaching, receding, *without = found
    assert np.abs(approaching - without[0]).max() > 0.1
    assert np.abs(receding - without[1]).max() < 1e-12


def test_the_pressure_cutoff_limits_tension(make):
    scheme = make("scheme.equation_of_state={type: tait, gamma: 7, sound_speed: 5.0, pressure_cutoff: -0.1}")

    @ti.kernel
    def pressure_at(s: float) -> float:
        return scheme.fluid.pressure(s)

    assert pressure_at(-0.01) == pytest.approx(-0.1, abs=1e-15)
    assert pressure_at(0.01) == pytest.approx(25 / 7 * (1.01**7 - 1), rel=1e-13)
    assert pressure_at(-0.003) == pytest.approx(25 / 7 * (0.997**7 - 1), rel=1e-13)


@pytest.mark.parametrize("name", registry.names("kernels"))
def test_the_table_follows_the_kernel(name):
    runtime.start("f64", 1)
    kernel = registry.load("kernels", name)
    length = 0.3
    table = WeightTable(kernel, length)
    q = np.linspace(0.3, kernel.SUPPORT, 1001)
    weights = ti.field(ti.f64, shape=q.size)
    squares = ti.field(ti.f64, shape=q.size)
    squares.from_numpy((q * length) ** 2)

    @ti.kernel
    def look_up():
        for i in weights:
            weights[i] = table.at(squares[i])

    look_up()
    exact = np.array([kernel.slope_over_q(distance) for distance in q])
    # linear interpolation: (interval)^2 / 8 times the second derivative in q^2, both of order 1e-3 and 1 to 10,
    # for distances from 0.3 h on: closer pairs do not occur
    assert np.abs(weights.to_numpy() - exact).max() < 1e-5 * kernel.slope_over_q(1e-3)
    # up to sqrt(2) times the support: with the least one (test_verlet.py) no pair of a list gets that far
    squares.from_numpy(np.linspace(1.001, 1.99, q.size) * (kernel.SUPPORT * length) ** 2)
    look_up()
    assert not weights.to_numpy().any()
    squares.fill(np.nan)
    look_up()
    assert np.isnan(weights.to_numpy()).all()
