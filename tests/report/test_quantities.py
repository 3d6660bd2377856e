import numpy as np
import pytest
from report_scene import make_channel, make_polymer_channel, make_snapshot, shown

from tisph.geometry.motion import WallMotion
from tisph.scenes.channel import Channel

DEVELOPED = {"initial_state": "developed"}
PARABOLA = 2e-3 * 0.01**2 / 8e-6  # largest speed g H^2/(8 nu) of the developed driven flow


def test_plane_couette_reaches_from_rest_to_the_wall_velocity():
    speed = shown("speed", make_channel(), end=20.0)
    assert speed.colour_range == (0.0, 0.005)
    assert speed.profile_range == pytest.approx((-0.08 * 0.005, 1.08 * 0.005))


def test_ranges_fit_the_run_and_not_the_flow_that_it_would_become():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    long, short = (shown("speed", channel, end).colour_range[1] for end in (300.0, 5.0))
    assert long == pytest.approx(PARABOLA, rel=1e-12)  # three digits, rounded up: 0.025
    # At mid-gap t* = 0.05 the walls are not felt: u is close to g t, and rounding up adds 1 % at most.
    assert short == pytest.approx(2e-3 * 5.0, rel=0.1)


def test_profile_axis_shows_a_flow_back():
    channel = make_channel(acceleration=-4e-3)
    speed = shown("speed", channel, end=300.0)
    # Developed: u = U eta - 4 P eta (1 - eta) with P = g H^2/(8 nu) = 0.05, smallest at eta = (1 - U/4P)/2.
    eta = 0.5 * (1.0 - 0.005 / 0.2)
    lowest = 0.005 * eta - 0.2 * eta * (1.0 - eta)
    width = 0.005 - lowest
    # Looked at in steps of a hundredth of the gap: 4 P (1/200)^2 = 5e-6 above the minimum at most, plus its margin.
    assert speed.profile_range == pytest.approx((lowest - 0.08 * width, 0.005 + 0.08 * width), abs=6e-6)
    assert speed.colour_range[1] == pytest.approx(-lowest, rel=0.01)  # rounded up to three digits


@pytest.mark.parametrize("frequency", [0.3, 20.0])
def test_profile_axis_shows_all_of_an_oscillation(frequency):
    channel = make_channel(top=WallMotion(0.0, -0.005, frequency), **DEVELOPED)
    speed = shown("speed", channel, end=20.0)
    # 2000 times over 64 periods are 30 a period: the largest is missed by 1 - cos(pi/30) = 0.5 % at most.
    assert speed.profile_range == pytest.approx((-1.16 * 0.005, 1.16 * 0.005), rel=0.01)


def test_range_covers_what_the_fluid_does_before_a_wall_stops():
    channel = make_channel(top=WallMotion(0.0, before=0.005), **DEVELOPED)
    assert shown("speed", channel, end=20.0).colour_range == (0.0, 0.005)


def test_range_covers_an_early_overshoot():
    class Overshooting(Channel):
        def exact_velocity(self, y, t):
            return 0.005 * (1.0 + 1.8 * np.exp(-(((t - 1.0) / 0.5) ** 2))) + 0.0 * np.asarray(y)

    channel = Overshooting(**vars(make_channel()))
    # Around t = 1 the times are 0.3 apart: within 0.15 of the peak, exp(-0.09) = 0.91 of the overshoot.
    assert shown("speed", channel, end=100.0).colour_range[1] >= 0.005 * (1.0 + 1.8 * 0.91)


def test_run_that_ends_before_anything_moves_has_axes_all_the_same():
    channel = make_channel(top=WallMotion(0.0), acceleration=2e-3)
    speed = shown("speed", channel, end=0.0)
    assert speed.colour_range == (0.0, 1.0)
    assert speed.profile_range[0] < speed.profile_range[1]


def test_shear_stress_is_centred_at_zero_and_reaches_what_the_run_reaches():
    channel = make_polymer_channel()
    for end, largest in ((0.5, 2e-4), (5.0, 4e-4)):
        stress = shown("shear_stress", channel, end)
        assert stress.colour_range == (-largest, largest)
        assert stress.profile_range == pytest.approx((-1.16 * largest, 1.16 * largest))
    assert stress.unit == "Pa"


def test_quantities_take_discs_and_profile_from_the_snapshot():
    channel = make_polymer_channel()
    snapshot = make_snapshot(channel, 1.0)
    object.__setattr__(snapshot, "v", snapshot.u * 0.75)
    speed, stress = (shown(name, channel, 1.0) for name in ("speed", "shear_stress"))
    assert np.allclose(channel.movie_view("speed", 1.0).of(snapshot), 1.25 * np.abs(snapshot.u), rtol=1e-14)
    assert np.array_equal(speed.profile.of(snapshot), snapshot.u)
    assert np.array_equal(channel.movie_view("shear_stress", 1.0).of(snapshot), snapshot.stress_xy)
    assert np.array_equal(stress.profile.of(snapshot), snapshot.stress_xy)
    y = np.array([0.0, 0.01])
    assert stress.profile.exact(None, y, 1.0).tolist() == [4e-4, -4e-4]
