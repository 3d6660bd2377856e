"""Polymer stress of an Oldroyd-B liquid: its law, its force, and its state on the walls."""

import numpy as np
import pytest
from case_from_text import to_end
from rates import LINEAR_EOS, RatesOf, impose

from tisph.runtime import real, ti, view

pytestmark = pytest.mark.taichi

OLDROYD = "fluid.rheology={type: oldroyd_b, relaxation_time: 0.5, solvent_fraction: 0.4}"
WALLS = "walls.treatment.type=consistent_image"
RATE, MODULUS = 2.0, 0.6 * 0.01 / 0.5


def upper_convected(stress, gradient):
    """dS/dt of an Oldroyd-B polymer, with matrices: L S + S L^T - S/lambda + G (L + L^T)."""
    return gradient @ stress + stress @ gradient.T - RATE * stress + MODULUS * (gradient + gradient.T)


def test_rates_are_exact_for_linear_velocity_and_stress(make):
    # on any arrangement; stress linear in y, velocity (b y, c y): the gradient is the same everywhere
    b, c = 0.7, -0.2
    scheme = make(LINEAR_EOS, OLDROYD, jitter=0.3)
    constant, slope = np.array([0.3, -0.1, 0.2]), np.array([0.05, 0.4, -0.3])
    _, y = impose(
        scheme,
        lambda x, y: (b * y, c * y),
        lambda x, y: 0 * y,
        lambda x, y: tuple(constant[:, None] + slope[:, None] * y),
    )
    rates = RatesOf(scheme)
    acceleration, _, transport = rates.arrays()
    assert np.allclose(acceleration[:, 0], slope[1] + b * transport[:, 1], atol=1e-9)
    assert np.allclose(acceleration[:, 1], slope[2] + c * transport[:, 1], atol=1e-9)
    gradient = np.array([[0.0, b], [0.0, c]])
    for i, found in enumerate(rates.stress.to_numpy()):
        xx, xy, yy = constant + slope * y[i]
        rate = upper_convected(np.array([[xx, xy], [xy, yy]]), gradient)
        expected = np.array([rate[0, 0], rate[0, 1], rate[1, 1]]) + slope * transport[i, 1]
        assert np.allclose(found, expected, atol=1e-9)


def test_acoustic_and_elastic_waves_limit_the_first_time_step(make):
    # 0.25 h / (sqrt(c^2 + c_e^2) + U), with rho c_e^2 the modulus of the polymer; no impulse has strained it
    # h is the spacing
    scheme = make(OLDROYD, "fluid.rheology.relaxation_time=0.1", "walls.treatment.type=comoving_image")
    modulus, fastest = 0.6 * 0.01 / 0.1, scheme.scene.peak_velocity
    expected = 0.25 * scheme.scene.spacing / (np.sqrt(scheme.sound_speed**2 + modulus) + fastest)
    assert scheme.time_step_limit() == pytest.approx(expected, rel=1e-12)


def test_the_walls_see_the_slope_of_a_parabolic_profile(make):
    # u - u_W = a d + b d^2 is fitted exactly, whatever the arrangement
    scheme = make(LINEAR_EOS, OLDROYD, WALLS, "walls.top.velocity=0.5", jitter=0.3)
    a, b = 0.8, -0.6

    def profile(y):
        return np.where(y < 0.5, a * y + b * y * y, 0.5 + 0.3 * (1 - y) + 0.2 * (1 - y) ** 2)

    impose(scheme, lambda x, y: (profile(y), 0 * y), lambda x, y: 0 * y, lambda x, y: (0 * y, 0 * y, 0 * y))
    track = scheme.walls.track

    @ti.kernel
    def slope(top: ti.template()) -> ti.types.vector(4, real()):
        gradient = track.gradient(scheme.now, 3, top)
        return ti.Vector([gradient[0, 0], gradient[0, 1], gradient[1, 0], gradient[1, 1]])

    assert np.allclose(slope(0).to_numpy(), [0, a, 0, 0], atol=1e-12)
    assert np.allclose(slope(1).to_numpy(), [0, -0.3, 0, 0], atol=1e-12)  # d/dy = -d/dd at the top


def test_wall_stress_of_a_driven_flow_has_the_curvature_of_its_law(make):
    # S_xy,y on the wall = -(eta_p/eta) g (1 - exp(-eta t/(eta_s lambda))): momentum and stress law at a resting wall
    drive = ("drive.acceleration=0.02", "walls.top.velocity=0.0", "time.end=0.6")
    scheme = make(OLDROYD, WALLS, *drive, jitter=0.2)
    to_end(scheme)
    expected = -0.6 * 0.02 * (1 - np.exp(-0.6 / (0.4 * 0.5)))
    slopes = scheme.walls.track.slope.to_numpy()[:, :12, 1]
    # midpoint steps of 0.01 against a decay in 0.2: (dt/tau)^2/6 of the change
    assert np.allclose(slopes, expected, rtol=1e-3)


def test_walls_and_drive_balance_the_momentum_of_a_fluid_that_carries_stress(make):
    scheme = make(OLDROYD, WALLS, "drive.acceleration=0.02", "walls.bottom.velocity=-0.2", "time.end=1.0")
    to_end(scheme)
    balance = scheme.momentum_balance()
    assert balance["closure"] < 1e-3  # measured: 3e-5; a liquid whose shear stress does not count leaves 0.3


def test_wall_points_start_with_the_stress_of_the_fluid_there(make):
    scheme = make(OLDROYD, WALLS, "drive.acceleration=0.3", "initial.state=developed")
    track, channel, columns = scheme.walls.track, scheme.scene, int(view(scheme.lists.cells.columns))
    xx, xy, _ = channel.exact_polymer_stress(np.array([0.0, channel.gap]), channel.start_time)
    count = int(view(track.count))
    for field in (track.stress, track.mid_stress):
        found = view(field)[:, :count]
        assert found == pytest.approx(np.stack([xx, xy, 0.0 * xx], 1)[:, None].repeat(count, 1), rel=1e-9)
    expected = (np.arange(count) + 0.5) * channel.spacing / channel.length * columns
    assert np.array_equal(view(track.column)[:, :count], np.tile(expected.astype(int), (2, 1)))


def test_walls_are_periodic_and_linear_between_their_points(make):
    scheme = make(OLDROYD, WALLS, "drive.acceleration=0.02", jitter=0.2)
    for _ in range(3):  # the upper wall is on its way
        scheme.advance()
    track, random = scheme.walls.track, np.random.default_rng(0)
    slope, compression = random.normal(size=(2, 12, 3)), 0.1 * random.normal(size=(2, 12))
    view(track.mid_slope)[:, :12], view(track.compression)[:, :12] = slope, compression
    x = np.linspace(0.0, 1.0, 41)
    found = ti.field(real(), shape=(2, 41, 2))

    @ti.kernel
    def evaluate():
        for n in range(41):
            for top in ti.static(range(2)):
                found[top, n, 0] = track.curvature_at(top, n / 40)
                found[top, n, 1] = track.slope_at(top, n / 40)[1]

    evaluate()
    viscosity = 0.4 * 0.01
    for top in range(2):
        points = view(track.origin)[top] + np.arange(12) / 12
        curvature = (-0.02 - slope[top, :, 1] / (1.0 + compression[top])) / viscosity
        for part, values in enumerate((curvature, slope[top, :, 1])):
            assert np.allclose(found.to_numpy()[top, :, part], np.interp(x, points, values, period=1.0), rtol=1e-9)


def test_wall_stress_obeys_the_law_under_a_steady_shear(make):
    # developed Couette flow: S_xy = eta_p U/H, S_xx = 2 lambda eta_p (U/H)^2 stay, on walls and particles
    scheme = make(OLDROYD, WALLS, "initial.state=developed", "time.end=1.0", jitter=0.2)
    snapshot = to_end(scheme)
    wall = scheme.walls.track.stress.to_numpy()[:, :12]
    xy, xx = 0.6 * 0.01 * 0.5, 2 * 0.5 * 0.6 * 0.01 * 0.25
    # linear fields are exact on any arrangement, and rounding grows with the number of steps
    for found, expected in ((wall[..., 1], xy), (wall[..., 0], xx), (snapshot.stress_xy, xy), (snapshot.stress_xx, xx)):
        assert np.abs(found - expected).max() < 1e-10
    assert np.abs(snapshot.stress_yy).max() < 1e-10


@pytest.mark.parametrize("treatment", ["adami", "virtual_image"])
def test_every_treatment_carries_stress(make, treatment):
    # a uniform stress exerts no force, at the walls neither
    scheme = make(LINEAR_EOS, OLDROYD, f"walls.treatment.type={treatment}", jitter=0.3)
    impose(
        scheme, lambda x, y: (0 * y, 0 * y), lambda x, y: 0 * y, lambda x, y: (0 * y + 0.3, 0 * y + 0.2, 0 * y - 0.1)
    )
    if scheme.walls.has_dummies:
        scheme.walls.refresh(scheme.now)
    acceleration, _, _ = RatesOf(scheme).arrays()
    assert np.abs(acceleration[:, 1]).max() < 1e-10
