"""Error measures: interpolation and wall shear on known fields, and every number of a sample."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from polymer_laws import oldroyd_b
from report_scene import unit_channel as make_channel

from tisph.geometry.motion import WallMotion
from tisph.measures.channel import Probes, interpolate
from tisph.measures.metrics import ROUNDINGS, fit_line, relative_error, sample_metrics
from tisph.snapshot import Snapshot


def make_snapshot(channel, u=None, t=1.8, jitter=0.2, seed=0):
    """Jittered particles with velocities ``u(x, y)``, the exact ones by default."""
    x, y = channel.jittered(seed, jitter)
    velocity = channel.exact_velocity(y, t) if u is None else u(x, y)
    at_rest = np.zeros_like(x)
    return Snapshot(t, 10, x, y, velocity, at_rest, np.full_like(x, channel.density), at_rest)


def measure(channel, snapshot, heights=10):
    """Sample metrics with tracers that read the exact velocity."""
    y = channel.probe_positions(heights)[1]
    return sample_metrics(channel, snapshot, (y, channel.exact_velocity(y, snapshot.t)))


@settings(max_examples=40, deadline=None)
@given(
    coefficients=st.lists(st.floats(-3, 3, allow_subnormal=False), min_size=6, max_size=6),
    jitter=st.floats(0, 0.49),
    seed=st.integers(0, 2**31),
)
def test_interpolation_is_exact_for_quadratic_fields_up_to_the_walls(coefficients, jitter, seed):
    channel = make_channel(rows=12)
    c0, cx, cy, cxx, cxy, cyy = coefficients

    def field(x, y):
        return c0 + cx * x + cy * y + cxx * x * x + cxy * x * y + cyy * y * y

    y = np.array([0.0, 0.01, 0.1, 0.5, 0.77, 0.99, 1.0])
    x = np.linspace(0.6, 1.4, 7)  # away from the periodic edge, where the field jumps
    values = interpolate(make_snapshot(channel, field, jitter=jitter, seed=seed), channel, x, y)
    # rounding 1e-16 * field (up to 20) * condition number of the 6 x 6 system: at points on a wall 1.5e4 on a
    # lattice, 2e5 in the worst of 300 disordered ones
    assert np.max(np.abs(values - field(x, y))) <= 4e-10


def test_interpolation_is_the_weighted_fit():
    """Of a field that no quadratic is: it depends on every weight, (1 - q)^4 (1 + 4 q) of q = distance/(3 spacings)."""
    channel = make_channel(rows=12)
    snapshot = make_snapshot(channel, lambda x, y: np.sin(9 * x) * np.cos(7 * y))
    for x, y in ((1.0, 0.0), (0.9, 0.04), (1.1, 0.5)):
        along, across = (snapshot.x - x) / 0.25, (snapshot.y - y) / 0.25
        q = np.minimum(np.hypot(along, across), 1.0)
        root = np.sqrt((1 - q) ** 4 * (1 + 4 * q))
        basis = np.stack([np.ones_like(q), along, across, along**2, along * across, across**2], 1)
        fit = np.linalg.lstsq(root[:, None] * basis, root * snapshot.u, rcond=None)[0]
        # rounding times the condition number of the six equations, 2e5 at most
        assert interpolate(snapshot, channel, [x], [y])[0] == pytest.approx(fit[0], abs=1e-10)


def test_interpolation_crosses_the_periodic_edge():
    """Moving particles and probes together along the channel changes nothing."""
    channel = make_channel(rows=20)
    snapshot = make_snapshot(channel, lambda x, y: np.sin(np.pi * x) + y**3)
    y = np.linspace(0.05, 0.95, 5)
    values = interpolate(snapshot, channel, np.full(5, 1.0), y)
    moved = (snapshot.x + 0.97) % 2.0
    shifted = Snapshot(1.8, 10, moved, *(getattr(snapshot, key) for key in ("y", "u", "v", "density", "pressure")))
    # rounding 4e-16 of positions over the radius 0.15, times the condition number 3e2 to 5e3
    assert np.max(np.abs(interpolate(shifted, channel, np.full(5, 1.97), y) - values)) <= 1e-12


def test_interpolation_error_is_far_below_the_errors_that_it_measures():
    """Third order at least: the quadratic basis leaves the third derivative and what disorder makes of it."""
    errors = []
    for rows in (25, 50, 100):
        channel = make_channel(rows)
        x, y = channel.probe_positions(10)
        values = Probes(channel, x, y).velocity(make_snapshot(channel))
        errors.append(np.max(np.abs(values - channel.exact_velocity(y, 1.8))) / 0.5)
    assert np.log2(errors[0] / errors[2]) / 2 > 2.7  # 3, less the scatter of one random sample
    assert errors[1] < 1e-4  # a tenth of the error bound 1.5e-3 of the flow at this time


def test_a_void_at_a_probe_is_no_exception():
    channel = make_channel(rows=20)
    full = make_snapshot(channel)
    keep = np.abs(full.y - 0.5) > 0.2
    holed = Snapshot(1.8, 10, *(getattr(full, key)[keep] for key in ("x", "y", "u", "v", "density", "pressure")))
    assert np.isnan(interpolate(holed, channel, [1.0, 1.0], [0.5, 0.9])).tolist() == [True, False]


def test_exact_particles_have_no_error():
    channel = make_channel()
    numbers = measure(channel, make_snapshot(channel))
    assert numbers["l2"] == numbers["rms"] == numbers["linf"] == 0.0
    assert (numbers["slope"], numbers["intercept"]) == (numbers["slope_exact"], numbers["intercept_exact"])
    assert (numbers["t"], numbers["t_star"]) == (1.8, pytest.approx(0.018, rel=1e-15))
    assert numbers["density_variation"] == numbers["max_transverse_velocity"] == 0.0
    # the errors of interpolation and fit, see above
    assert numbers["centreline"] == pytest.approx(numbers["centreline_exact"], abs=0.5e-4)
    assert numbers["wall_shear_top"] == pytest.approx(numbers["wall_shear_top_exact"], rel=2e-4)


def test_a_known_error_is_measured():
    """u = exact * (1 + 0.03) has l2 = 3 %; linf is 3 % of the largest velocity over the wall's."""
    channel = make_channel()
    exact = make_snapshot(channel)
    density, v = exact.density.copy(), exact.v.copy()
    density[17] *= 0.9
    v[3] = -0.004
    numbers = measure(channel, replace(exact, u=1.03 * exact.u, v=v, density=density))
    assert numbers["l2"] == pytest.approx(0.03, rel=1e-12)
    assert numbers["rms"] == pytest.approx(0.03 * np.sqrt(np.mean(exact.u**2)) / 0.5, rel=1e-12)
    assert numbers["linf"] == pytest.approx(0.03 * exact.u.max() / 0.5, rel=1e-12)
    assert numbers["density_variation"] == pytest.approx(0.1, rel=1e-12)
    assert numbers["max_transverse_velocity"] == 0.004


def test_rms_is_a_measure_where_the_velocity_vanishes():
    """Twice the velocity of a wall at an instant at which hardly anything moves: l2 is no number to judge by."""
    channel = make_channel(initial_state="developed", top=WallMotion(0.5, angular_frequency=1.0))
    numbers = measure(channel, make_snapshot(channel, lambda x, y: np.full_like(x, 0.005), t=0.0))
    off = np.sqrt(np.mean((0.005 - channel.exact_velocity(channel.jittered(0, 0.2)[1], 0.0)) ** 2))
    assert numbers["rms"] == pytest.approx(off / 0.5, rel=1e-12)


def test_what_rounds_away_in_the_frame_is_nothing_to_be_relative_to():
    """100 particles that all move with twice, and with half, of what the frame's rounding leaves of a velocity."""
    nothing = ROUNDINGS * np.spacing(1e6)
    for factor, expected in ((2.0, 0.5), (0.5, None)):
        exact = np.full(100, 1e6 + factor * nothing)
        snapshot = SimpleNamespace(u=exact + nothing, reference={"u": exact}, weight=1.0)
        assert relative_error(SimpleNamespace(frame_velocity=1e6, fields=("u",)), snapshot) == expected


def polymer_snapshot(channel, t, shear_factor=1.0, normal_shift=0.0):
    """Jittered particles with the exact velocities and the exact stresses, altered as told; S_yy is not 0."""
    x, y = channel.jittered(0, 0.2)
    normal, shear, _ = channel.exact_polymer_stress(y, t)
    at_rest = np.zeros_like(x)
    stresses = {"stress_xx": normal + 0.3 + normal_shift, "stress_xy": shear_factor * shear, "stress_yy": at_rest + 0.3}
    velocity = channel.exact_velocity(y, t)
    return Snapshot(t, 10, x, y, velocity, at_rest, at_rest + channel.density, at_rest, **stresses)


def test_stress_errors_are_relative_to_the_exact_stresses():
    channel = make_channel(rows=20, **oldroyd_b(1.0, 0.5))
    exact = measure(channel, polymer_snapshot(channel, 50.0))
    assert exact["shear_stress_l2"] == 0.0
    # S_xx + 0.3 - 0.3 loses the digits of a stress of about 1e-4
    assert exact["normal_stress_l2"] <= 1e-11
    wrong = measure(channel, polymer_snapshot(channel, 50.0, shear_factor=0.98))
    assert wrong["shear_stress_l2"] == pytest.approx(0.02, rel=1e-10)
    normal = channel.exact_polymer_stress(channel.jittered(0, 0.2)[1], 50.0)[0]
    shifted = measure(channel, polymer_snapshot(channel, 50.0, normal_shift=1e-5))
    assert shifted["normal_stress_l2"] == pytest.approx(1e-5 / np.sqrt(np.mean(normal**2)), rel=1e-6)


def test_stress_errors_exist_only_with_polymer():
    channel = make_channel()
    assert not {"shear_stress_l2", "normal_stress_l2"} & measure(channel, make_snapshot(channel)).keys()
    at_start = measure(make_channel(**oldroyd_b(1.0, 0.5)), polymer_snapshot(make_channel(), 0.0))
    assert at_start["shear_stress_l2"] is None  # nothing to be relative to


PAGE_CASE = [  # t [s], kinematic viscosity, slope, intercept, centreline, du/dy at bottom and top wall
    (1.8, 0.01, 0.3460, -0.0973, 0.004204, 3.9e-6, 2.1026),
    (2.7, 0.01, 0.3941, -0.1044, 0.015712, 3.3e-4, 1.7168),
    (1.8, 0.1, 0.49975, -0.0342, 0.19613, 0.3316, 0.6700),
    (2.7, 0.1, 0.49999, -0.0141, 0.22784, 0.4304, 0.5696),
]


@pytest.mark.parametrize("row", PAGE_CASE)
def test_exact_numbers_of_the_verification_page(row):
    """The exact start-up at the page's output times, lines fitted at its 50 particle heights."""
    t, viscosity, *expected = row
    channel = make_channel(kinematic_viscosity=viscosity, density=1.0)
    numbers = measure(channel, make_snapshot(channel, t=t), heights=50)
    assert numbers["slope_exact"] == pytest.approx(expected[0], abs=0.51e-4)
    assert numbers["intercept_exact"] == pytest.approx(expected[1], abs=0.51e-4)
    assert numbers["centreline_exact"] == pytest.approx(expected[2], abs=0.51e-5)
    shears = [numbers[f"wall_shear_{wall}_exact"] / viscosity for wall in ("bottom", "top")]
    assert shears == pytest.approx(expected[3:], rel=0.02, abs=1e-6)  # two printed digits where small


def test_numbers_that_do_not_exist_are_null():
    """At t = 0 the fluid is at rest (no relative error), the stress on the moving wall infinite; a flow goes wrong."""
    channel = make_channel()
    numbers = measure(channel, make_snapshot(channel, t=0.0))
    assert (numbers["l2"], numbers["wall_shear_top_exact"], numbers["linf"]) == (None, None, 0.0)
    json.dumps(numbers, allow_nan=False)
    assert measure(channel, make_snapshot(channel), heights=1)["slope"] is None
    channel = make_channel(rows=20)
    snapshot = make_snapshot(channel)
    for field in (snapshot.u, snapshot.y, snapshot.density):
        field[5] = np.nan
    numbers = measure(channel, snapshot)
    assert (numbers["l2"], numbers["density_variation"]) == (None, None)
    json.dumps(numbers, allow_nan=False)


@given(slope=st.floats(-5, 5), intercept=st.floats(-5, 5), count=st.integers(2, 40))
def test_a_line_is_fitted_exactly(slope, intercept, count):
    y = (np.arange(count) + 0.5) / count
    # rounding of values up to 10, divided by the spread 0.25 of two tracers
    assert fit_line(y, slope * y + intercept) == pytest.approx((slope, intercept), abs=1e-13)
