"""The channel scene: derived numbers, the run's clock, particle and tracer positions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tisph.config import load
from tisph.exact import couette
from tisph.geometry.motion import WallMotion
from tisph.scenes.channel import Channel

WATER = {
    "gap": 0.01,
    "length": 0.02,
    "density": 1000.0,
    "kinematic_viscosity": 1e-6,
    "bottom": WallMotion(-0.001),
    "top": WallMotion(0.005),
    "initial_state": "rest",
    "start_time": 0.0,
    "spacing": 0.0002,
    "columns": 100,
    "rows": 50,
    "units": None,
}
START_UP = {"gap": 0.01, "kinematic_viscosity": 1e-6, "bottom": -0.001, "top": 0.005}
HEIGHTS = np.linspace(0.0, 0.01, 21)


@pytest.mark.parametrize(("state", "time"), [("rest", 0.0), ("developed", 0.0), ("exact", 3.0)])
def test_from_config_reads_every_number(tmp_path, state, time):
    path = tmp_path / "water.yaml"
    path.write_text(
        f"""
        scene: channel
        units: {{length: cm}}
        fluid: {{density: 1000.0, kinematic_viscosity: 1.0e-6}}
        geometry: {{gap: 0.01, length: 0.02}}
        walls: {{bottom: {{velocity: -0.001}}, top: {{velocity: 0.005}}}}
        initial: {{state: {state}, time: {time}}}
        time: {{end: 5.0}}
        """,
        encoding="utf-8",
    )
    config = load(path)
    channel = Channel.from_config(config)
    assert channel == Channel(
        **{**WATER, "initial_state": state, "start_time": time, "units": config.units, "spacing": config.spacing}
    )
    assert channel.spacing == pytest.approx(0.0002, rel=1e-15)
    assert channel.units.length == "cm"


def test_dimensionless_numbers():
    channel = Channel(**WATER)
    assert channel.reference_velocity == 0.005
    # products of three numbers: a few roundings
    assert channel.reynolds == pytest.approx(50.0, rel=1e-15)
    assert channel.viscous_time == pytest.approx(100.0, rel=1e-15)
    assert channel.dynamic_viscosity == pytest.approx(1e-3, rel=1e-15)


def test_the_faster_wall_is_the_reference_whatever_its_direction():
    assert Channel(**{**WATER, "bottom": WallMotion(-0.02)}).reference_velocity == 0.02


def test_from_rest_the_exact_solution_is_the_start_up():
    channel = Channel(**WATER)
    assert np.array_equal(channel.exact_velocity(HEIGHTS, 1.8), couette.velocity(HEIGHTS, 1.8, **START_UP))
    assert not channel.initial_velocity(HEIGHTS[1:-1]).any()


def test_an_exact_start_takes_up_the_start_up_at_its_own_time():
    channel = Channel(**{**WATER, "initial_state": "exact", "start_time": 3.0})
    started = couette.velocity(HEIGHTS, 3.0, **START_UP)
    assert np.array_equal(channel.initial_velocity(HEIGHTS), started)
    assert np.array_equal(channel.exact_velocity(HEIGHTS, 3.0), started)


def test_a_developed_flow_stays_linear():
    channel = Channel(**{**WATER, "initial_state": "developed"})
    linear = -0.001 + 0.6 * HEIGHTS
    # two roundings of numbers up to 0.006
    assert np.allclose(channel.initial_velocity(HEIGHTS), linear, rtol=0, atol=2e-18)
    assert np.array_equal(channel.exact_velocity(HEIGHTS, 7.0), channel.initial_velocity(HEIGHTS))
    assert channel.exact_velocity(HEIGHTS[:, None], np.arange(3.0)).shape == (21, 3)
    assert channel.exact_wall_shear(2.0) == pytest.approx((6e-4, 6e-4), rel=1e-14)


def test_wall_shear_is_a_stress_and_late_equal_on_both_walls():
    channel = Channel(**WATER)
    # t* = 4: the slowest mode is exp(-39); 6e-4 = viscosity 1e-3 * 0.006 / 0.01
    assert channel.exact_wall_shear(400.0) == pytest.approx((6e-4, 6e-4), rel=1e-14)


def test_early_wall_shear_is_that_of_two_half_spaces():
    channel = Channel(**WATER)
    bottom, top = channel.exact_wall_shear(0.1)  # t* = 0.001: exp(-1/(4 t*)) = 3e-109
    thickness = np.sqrt(np.pi * 1e-6 * 0.1)
    assert (bottom, top) == pytest.approx((1e-3 * 0.001 / thickness, 1e-3 * 0.005 / thickness), rel=1e-14)


def test_lattice_is_cell_centres_row_by_row_from_the_bottom():
    x, y = Channel(**{**WATER, "spacing": 0.0025, "rows": 4, "columns": 8}).lattice()
    assert x.shape == y.shape == (32,)
    # one rounding of the product
    assert x[:8] == pytest.approx(0.0025 * (np.arange(8) + 0.5), rel=1e-15)
    assert np.all(y[:8] == y[0])
    assert y[::8] == pytest.approx([0.00125, 0.00375, 0.00625, 0.00875], rel=1e-15)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32), jitter=st.floats(0, 0.499))
def test_jittered_particles_stay_in_their_cells(seed, jitter):
    channel = Channel(**WATER)
    centres, positions = channel.lattice(), channel.jittered(seed, jitter)
    for centre, position, size in zip(centres, positions, (0.02, 0.01), strict=True):
        # rounding of positions up to 0.02
        assert np.max(np.abs(position - centre)) <= jitter * 0.0002 + 1e-17
        assert position.min() > 0
        assert position.max() < size


def test_jitter_is_uniform_and_belongs_to_its_seed():
    channel = Channel(**WATER)
    shift = (np.array(channel.jittered(7, 0.2)) - channel.lattice()) / 0.0002
    # 5000 uniform numbers in +-0.2: mean within 5 of its standard deviations 0.2/sqrt(3*5000)
    assert np.max(np.abs(shift.mean(axis=1))) < 0.0082
    assert np.all(shift.max(axis=1) > 0.199)
    assert np.all(shift.min(axis=1) < -0.199)
    assert np.array_equal(channel.jittered(7, 0.2), channel.jittered(7, 0.2))
    assert not np.array_equal(channel.jittered(7, 0.2), channel.jittered(8, 0.2))
    assert np.array_equal(channel.jittered(7, 0.0), channel.lattice())


@pytest.mark.parametrize("jitter", [-0.1, 0.5, float("nan")])
def test_jitter_that_leaves_the_cell_is_refused(jitter):
    with pytest.raises(ValueError, match="jitter"):
        Channel(**WATER).jittered(0, jitter)


def test_tracers_stand_on_a_vertical_line_at_the_centres_of_equal_parts():
    x, y = Channel(**WATER).probe_positions(4)
    assert x.tolist() == [0.01] * 4
    assert y == pytest.approx([0.00125, 0.00375, 0.00625, 0.00875], rel=1e-15)
    assert Channel(**WATER).probe_positions(2, 0.003)[0].tolist() == [0.003, 0.003]
