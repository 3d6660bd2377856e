"""The channel: derived numbers, clock, positions, every flow, and references of fluids without closed forms."""

import numpy as np
import pytest
from polymer_laws import oldroyd_b

from tisph import registry
from tisph.config import load
from tisph.geometry.motion import WallMotion
from tisph.measures.flow import PolymerParameters
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


def test_jitter_is_uniform_and_belongs_to_its_seed():
    channel = Channel(**WATER)
    shift = (np.array(channel.jittered(7, 0.2)) - channel.lattice()) / 0.0002
    # 5000 uniform numbers in +-0.2: mean within 5 of its standard deviations 0.2/sqrt(3*5000)
    assert np.max(np.abs(shift.mean(axis=1))) < 0.0082
    assert np.all((shift.max(axis=1) > 0.199) & (shift.max(axis=1) < 0.2 + 1e-12))
    assert np.all((shift.min(axis=1) < -0.199) & (shift.min(axis=1) > -0.2 - 1e-12))
    assert np.array_equal(channel.jittered(7, 0.2), channel.jittered(7, 0.2))
    assert not np.array_equal(channel.jittered(7, 0.2), channel.jittered(8, 0.2))
    assert np.array_equal(channel.jittered(7, 0.0), channel.lattice())
    for jitter in (-0.1, 0.5, float("nan")):
        with pytest.raises(ValueError, match="jitter"):
            channel.jittered(0, jitter)


NU, GAP, DENSITY = 0.01, 1.0, 2.0
Y = np.linspace(0.0, GAP, 21)
AT_REST = WallMotion(0.0)
SWINGING = WallMotion(0.1, -0.3, 0.4)


def make_channel(bottom=AT_REST, top=AT_REST, **changes):
    numbers = {
        "gap": GAP,
        "length": 1.0,
        "density": DENSITY,
        "kinematic_viscosity": NU,
        "initial_state": "rest",
        "start_time": 0.0,
        "spacing": 0.02,
        "columns": 50,
        "rows": 50,
        "units": None,
        **changes,
    }
    return Channel(bottom=bottom, top=top, **numbers)


def from_yaml(folder, *overrides):
    path = folder / "case.yaml"
    path.write_text(
        "scene: channel\nfluid: {density: 2.0, kinematic_viscosity: 0.01}\ngeometry: {gap: 1.0, length: 1.0}\n"
        "walls: {top: {velocity: 0.5}}\ntime: {end: 9.0}\n"
    )
    return Channel.from_config(load(path, overrides))


def test_from_config_reads_motion_drive_and_polymer(tmp_path):
    swinging = "walls.bottom={amplitude: -0.5, angular_frequency: 2.0, phase: %s}"
    assert from_yaml(tmp_path, swinging % "sin").bottom == WallMotion(0.0, -0.5, 2.0)
    assert from_yaml(tmp_path, swinging % "cos").bottom == WallMotion(-0.5, 0.0, 2.0)
    stopped = from_yaml(tmp_path, "walls.top={velocity: 0, velocity_before: 0.5}", "initial.state=developed")
    assert (stopped.bottom, stopped.top) == (WallMotion(0.0), WallMotion(0.0, before=0.5))
    assert from_yaml(tmp_path, "drive.acceleration=-0.02").acceleration == -0.02
    polymer = from_yaml(tmp_path, "fluid.rheology={type: oldroyd_b, relaxation_time: 3.0, solvent_fraction: 0.25}")
    assert (polymer.polymer, stopped.polymer) == (PolymerParameters(3.0, 0.25), None)


def test_velocities_of_a_driven_flow():
    # g H^2 / nu = 24: mean 2, peak 3
    driven = make_channel(acceleration=-0.24)
    assert (driven.reference_velocity, driven.peak_velocity) == pytest.approx((2.0, 3.0), rel=1e-15)
    fast = make_channel(top=WallMotion(-2.5), acceleration=0.24)
    assert (fast.reference_velocity, fast.peak_velocity) == pytest.approx((2.5, 5.5), rel=1e-15)
    couette_flow = make_channel(top=WallMotion(0.5), bottom=WallMotion(-0.7))
    assert couette_flow.reference_velocity == couette_flow.peak_velocity == 0.7


def test_numbers_of_a_polymer():
    channel = make_channel(top=WallMotion(0.5), **oldroyd_b(4.0, 0.25))
    # a few roundings each
    assert channel.solvent_viscosity == pytest.approx(0.0025, rel=1e-14)
    assert channel.polymer_viscosity == pytest.approx(0.0075, rel=1e-14)
    assert channel.elastic_speed == pytest.approx(np.sqrt(0.0075 / 4), rel=1e-14)
    assert channel.weissenberg == pytest.approx(2.0, rel=1e-14)
    assert channel.elasticity == pytest.approx(0.04, rel=1e-14)
    newtonian = make_channel(top=WallMotion(0.5))
    assert newtonian.solvent_viscosity == newtonian.kinematic_viscosity
    assert newtonian.polymer_viscosity == newtonian.elastic_speed == newtonian.weissenberg == newtonian.elasticity == 0


POLYMER = oldroyd_b(10.0, 0.2)  # 10 = a tenth of the viscous time
FLOWS = {
    "driven": make_channel(acceleration=0.02),
    "backflow": make_channel(top=WallMotion(0.25), acceleration=-0.02),
    "swinging_bottom": make_channel(bottom=SWINGING, top=WallMotion(0.2)),
    "both_swinging": make_channel(bottom=WallMotion(0.2, 0.0, 3.0), top=SWINGING, acceleration=0.01),
    "periodic": make_channel(bottom=SWINGING, top=WallMotion(0.2), acceleration=0.01, initial_state="developed"),
    "stopped": make_channel(top=WallMotion(0.0, before=0.5), initial_state="developed"),
    "stopped_and_driven": make_channel(
        bottom=WallMotion(-0.1), top=WallMotion(0.1, before=0.5), acceleration=0.01, initial_state="developed"
    ),
    "stopped_beside_swinging": make_channel(
        bottom=SWINGING, top=WallMotion(0.0, before=0.5), initial_state="exact", start_time=1.0
    ),
    "polymer": make_channel(bottom=WallMotion(-0.1), top=WallMotion(0.5), acceleration=0.01, **POLYMER),
    "polymer_stopped": make_channel(
        top=WallMotion(0.0, before=0.5), acceleration=0.01, initial_state="developed", **POLYMER
    ),
}
each_flow = pytest.mark.parametrize("channel", FLOWS.values(), ids=FLOWS)


@each_flow
def test_the_fluid_sticks_to_both_walls(channel):
    t = np.array([1.0, 3.0, 30.0])
    # 1e-11 of velocities up to 0.6, which the solution of the polymer flow has
    for y, wall in ((0.0, channel.bottom), (GAP, channel.top)):
        assert np.allclose(channel.exact_velocity(y, t), wall.velocity(t), rtol=0, atol=1e-11)


@each_flow
def test_momentum_changes_by_wall_shear_and_drive(channel):
    """density * d/dt of the flow rate = shear stress at the top - at the bottom + density * acceleration * gap."""
    points, weights = np.polynomial.legendre.leggauss(80)
    y = GAP * (points + 1) / 2

    def momentum(t):
        return DENSITY * GAP / 2 * weights @ channel.exact_velocity(y[:, None], np.asarray(t))

    t, step = np.array([1.0, 3.0, 30.0]), 2e-3
    ahead, behind, double_ahead, double_behind = (momentum(t + k * step) for k in (1, -1, 2, -2))
    change = (8 * (ahead - behind) - (double_ahead - double_behind)) / (12 * step)
    bottom, top = channel.exact_wall_shear(t)
    # fourth-order difference: step^4 / 30 * 3^5 * 0.03 for the fastest swing, 4e-12; rounding 1e-11 / step of the
    # velocities with polymer, 5e-9
    assert np.allclose(change, top - bottom + DENSITY * GAP * channel.acceleration, rtol=0, atol=1e-8)


@each_flow
def test_shear_at_the_walls_is_the_slope_of_the_velocity(channel):
    """Solvent viscosity times a one-sided difference of u, plus the polymer's stress."""
    solvent, t, d = DENSITY * channel.solvent_viscosity, 3.0, 1e-3
    walls = ((0.0, d), (GAP, -d))
    for shear, (wall, step) in zip(channel.exact_wall_shear(t), walls, strict=True):
        u = channel.exact_velocity(wall + step * np.arange(5), t)
        slope = np.array([-25, 48, -36, 16, -3]) @ u / (12 * step)
        # step^4 / 5 * fifth derivative 0.2 (w / nu)^(5/2) of the fastest swing, w = 3, times viscosity: 1.3e-9
        assert shear == pytest.approx(solvent * slope + channel.exact_polymer_stress(wall, t)[1], abs=2e-9)


@pytest.mark.parametrize("fluid", [{}, POLYMER], ids=["newtonian", "polymer"])
def test_a_stopped_wall_goes_from_the_old_flow_to_the_new(fluid):
    settings = {"acceleration": 0.01, "initial_state": "developed", **fluid}
    channel = make_channel(bottom=WallMotion(0.3), top=WallMotion(0.0, before=0.5), **settings)
    old = make_channel(bottom=WallMotion(0.3), top=WallMotion(0.5), **settings)
    new = make_channel(bottom=WallMotion(0.3), top=WallMotion(0.0), **settings)
    inside = Y[:-1]
    # 1e-11 is what the polymer flow reaches; after t* = 10 the slowest mode has fallen by exp(-99)
    assert np.allclose(channel.initial_velocity(inside), old.exact_velocity(inside, 0.0), rtol=0, atol=1e-11)
    assert np.allclose(channel.exact_velocity(Y, 1000.0), new.exact_velocity(Y, 0.0), rtol=0, atol=1e-11)
    for mine, theirs in zip(
        channel.exact_polymer_stress(inside, 0.0), old.exact_polymer_stress(inside, 0.0), strict=True
    ):
        assert np.allclose(mine, theirs, rtol=0, atol=1e-11)


@pytest.mark.parametrize("fluid", [{}, POLYMER], ids=["newtonian", "polymer"])
def test_an_exact_start_takes_up_the_flow_that_started_at_zero(fluid):
    for top, state in ((WallMotion(0.5), "rest"), (WallMotion(0.0, before=0.5), "developed")):
        late = make_channel(top=top, initial_state="exact", start_time=3.0, **fluid)
        from_zero = make_channel(top=top, initial_state=state, **fluid)
        assert np.array_equal(late.initial_velocity(Y), from_zero.exact_velocity(Y, 3.0))
        assert np.array_equal(late.exact_polymer_stress(Y, late.start_time), from_zero.exact_polymer_stress(Y, 3.0))


def test_developed_flow_is_steady_or_periodic():
    channel = make_channel(top=WallMotion(0.25), acceleration=-0.02, initial_state="developed")
    steady = 0.25 * Y - Y * (1 - Y)
    assert np.allclose(channel.exact_velocity(Y[:, None], np.arange(3.0)), steady[:, None], rtol=0, atol=1e-15)
    periodic = make_channel(top=SWINGING, initial_state="developed")
    period = 2 * np.pi / 0.4
    # rounding of the phase, 1e-16 * 0.4 * 16 per radian
    assert np.allclose(periodic.initial_velocity(Y), periodic.exact_velocity(Y, period), rtol=0, atol=1e-15)
    assert periodic.initial_velocity(Y)[-4:-1].any()
    assert not make_channel(top=SWINGING).initial_velocity(Y)[:-1].any()


def test_polymer_stress_from_rest_and_developed():
    """S_xy = polymer viscosity * rate, S_xx = 2 relaxation time * polymer viscosity * rate^2 in steady flow."""
    assert not np.any(FLOWS["polymer"].exact_polymer_stress(Y, 0.0))
    steady = make_channel(top=WallMotion(0.5), initial_state="developed", **POLYMER)
    normal, shear, _ = steady.exact_polymer_stress(Y, 4.0)
    assert np.allclose(shear, DENSITY * 0.008 * 0.5, rtol=1e-12, atol=0)
    assert np.allclose(normal, 2 * 10.0 * DENSITY * 0.008 * 0.25, rtol=1e-12, atol=0)


OIL = {"gap": 0.5, "kinematic_viscosity": 0.5, "top": WallMotion(1.0), "spacing": 0.01, "columns": 100}
UNIT_Y = np.linspace(0.0, 0.5, 21)


def rheology(name, **numbers):
    return registry.load("rheology", name).Parameters(**numbers)


def test_giesekus_has_all_stresses_in_the_units_of_the_config():
    liquid = rheology("giesekus", relaxation_time=0.4, solvent_fraction=0.2, mobility=0.3)
    channel = make_channel(**OIL, polymer=PolymerParameters(0.4, 0.2), rheology=liquid)
    assert not channel.exact_polymer_stress(UNIT_Y, 0.0)[0].any()
    end = 30.0
    rate = 1.0 / 0.5
    xx, xy, yy = channel.exact_polymer_stress(UNIT_Y, end)
    modulus = 2.0 * 0.8 * 0.5 / 0.4  # density * kinematic viscosity of the polymer/relaxation time
    c = np.array([xx, xy, yy])[:, 10] / modulus
    law = registry.load("rheology", "giesekus").Law(liquid, 0.4)
    assert np.abs(law.rate_in_shear(c, rate)).max() < 1e-7 * np.abs(c).max()
    assert channel.exact_wall_shear(end) == pytest.approx((xy[0] + 2.0 * 0.1 * rate,) * 2, rel=1e-7)
    assert yy[10] < 0


def test_a_flow_of_several_modes_and_one_that_stops():
    modes = [{"type": "oldroyd_b", "relaxation_time": 0.4, "fraction": part} for part in (0.5, 0.3)]
    both = rheology("multi_mode", solvent_fraction=0.2, modes=modes)
    moving = {
        **OIL,
        "top": WallMotion(0.0, before=1.0),
        "initial_state": "developed",
        "polymer": PolymerParameters(0.4, 0.2),
    }
    one = rheology("oldroyd_b", relaxation_time=0.4, solvent_fraction=0.2)
    solved, closed = make_channel(**moving, rheology=both), make_channel(**moving, rheology=one)
    scale = np.abs(closed.exact_polymer_stress(UNIT_Y, 0.0)).max()
    for t in (0.01, 0.3):
        # the accuracy of tisph.exact.start_up
        assert np.allclose(solved.exact_velocity(UNIT_Y, t), closed.exact_velocity(UNIT_Y, t), atol=1e-8)
        mine, its = solved.exact_polymer_stress(UNIT_Y, t), closed.exact_polymer_stress(UNIT_Y, t)
        assert np.allclose(mine, its, atol=2e-8 * scale)


def test_an_inelastic_fluid():
    liquid = rheology("power_law", index=0.8, reference_rate=2.0, least_rate=1e-3)
    channel = make_channel(**OIL, rheology=liquid)
    # at the reference rate the viscosity is the fluid's; least rate over reference rate, squared: 3e-7
    assert channel.exact_wall_shear(30.0) == pytest.approx((2.0 * 0.5 * 2.0,) * 2, rel=1e-6)
    assert np.allclose(channel.exact_velocity(UNIT_Y, 30.0), 2.0 * UNIT_Y, atol=1e-8)
    assert not channel.exact_polymer_stress(UNIT_Y, 30.0)[0].any()
