"""Profiles of an inlet: mean, slope, and developed flow against the exact flow of a channel without ends."""

import functools

import numpy as np
import pytest

from tisph import scenes
from tisph.exact._fluids import fluid_of
from tisph.exact.uniform_shear import UniformShear
from tisph.scenes._ends import profile_of

GAP, VELOCITY = 2.0, 0.5
ENDS = f"ends={{left: {{type: inlet, velocity: {VELOCITY}}}, right: {{type: outlet}}}}"
FLUIDS = {
    "carreau_yasuda": "time: 5.0, index: 0.5",
    "power_law": "index: 0.6, reference_rate: 1.0, least_rate: 1.0e-3",
    "giesekus": "relaxation_time: 2.0, solvent_fraction: 0.2, mobility: 0.2",
}
TABLE = "{heights: [0.0, 0.3, 1.0, 1.5, 2.0], velocities: [0.0, 2.0, 5.0, 4.0, 1.0]}"


@pytest.fixture
def loaded(load_flow):
    """Config of a channel with overrides."""
    return functools.partial(load_flow, "wide_channel")


def fluid(name):
    return f"fluid.rheology={{type: {name}, {FLUIDS[name]}}}"


def shear(config):
    """Stresses of the fluid of a config in uniform shear."""
    found = fluid_of(config.fluid.rheology, config.kinematic_viscosity, config.fluid.density)
    return UniformShear(found.flux, found.laws)


@pytest.mark.parametrize(("profile", "infinite"), [("parabolic", False), ("uniform", True), (TABLE, True)])
def test_infinite_numbers_behind_a_jump_at_a_wall_are_left_out(loaded, profile, infinite):
    body = "bodies=[{type: circle, centre: [2.0, 1.0], radius: 0.5}]"
    for bodies, forces in (((), ["bottom", "top"] if not infinite else []), ((body,), [""])):
        ends = f"ends={{left: {{type: inlet, velocity: {VELOCITY}, profile: {profile}}}, right: {{type: outlet}}}}"
        scene = scenes.of(loaded(ends, *bodies))
        series = scene.time_series()
        loads = [f"{kind}_{name}".strip("_") for name in forces for kind in ("drag", "lift")]
        drop = [] if infinite else ["pressure_drop"]
        assert series.columns == [*loads, "inflow", "outflow", *drop]
        assert len(series.sizes) == len(series.panels) == len(series.columns)
        assert ("pressure_drop" in scene.flow_quantities) is not infinite


def test_the_pressure_drop_has_its_mean_and_scatter_over_the_last_quarter(loaded):
    """Noise of 0.01 on a drop that rises by 0.06 in 100 times, beside a start of another one; later times are none."""
    scene = scenes.of(loaded(ENDS))
    times, column = np.linspace(0.0, 4.8, 481), scene.time_series().columns.index("pressure_drop")
    noise = np.random.default_rng(0).normal(scale=0.01, size=481)
    values = np.zeros((481, column + 1))
    values[:, column] = np.where(times < 3.0, 9.0, 2.0 + 0.06 * (times - 3.5)) + noise + (times > 4.0)
    found = scene.drop_in_time(4.0, (None, None, (times, values)))
    assert found["pressure_drop_mean"] == pytest.approx(2.0, abs=3e-3)  # 0.01/100^(1/2)
    assert found["pressure_drop_scatter"] == pytest.approx(0.01, rel=0.2)
    assert set(scene.drop_in_time(0.0, (None, None, (times, values))).values()) == {None}


PULSE = "{type: inlet, velocity: 1.0, amplitude: 0.8, angular_frequency: 1.0, phase: sin}"
PULSATING = f"ends={{left: {PULSE}, right: {{type: outlet}}}}"
SLIT = (PULSATING, "fluid.kinematic_viscosity=0.04", "initial.state=developed")  # Womersley number 5 by half the gap


def test_developed_pulsating_flow_satisfies_its_equation(loaded):
    """u_t - nu u_yy is the same at all heights, u is 0 at walls and has the given mean; values of finite elements."""
    inlet = scenes.of(loaded(*SLIT)).inlet
    node, weight = np.polynomial.legendre.leggauss(40)
    places, step = np.stack([0.0 * node, 0.5 * GAP * (1.0 + node)], axis=1), np.array([0.0, 1e-3])
    for t, centre, gradient in ((14.1372, 2.4528, 0.269), (17.2788, 0.5472, None)):
        u, walls = inlet.velocity(places, t)[:, 0], inlet.velocity(np.array([[0.0, 0.0], [0.0, GAP]]), t)
        assert 0.5 * weight @ u == pytest.approx(1.0 + 0.8 * np.sin(t), rel=1e-12)
        assert np.abs(walls).max() < 1e-14
        assert inlet.velocity(np.array([[0.0, 0.5 * GAP]]), t)[0, 0] == pytest.approx(centre, abs=1e-4)
        along = np.tile([0.0, 1.0], (len(places), 1))
        slopes = [inlet.tangential_gradient(places + way * step, along, t)[:, 0] for way in (-1.0, 1.0)]
        drop = inlet.acceleration(places, t)[:, 0] - 0.04 * (slopes[1] - slopes[0]) / 2e-3
        assert np.ptp(drop) < 1e-5  # differences of the slope, with a step of 1e-3
        assert gradient is None or drop[0] == pytest.approx(gradient, abs=5e-4)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (SLIT, "its profile is that of developed flow whose mean velocity changes so"),
        ((*SLIT, "ends.left.profile=parabolic"), "the flow behind it develops from that"),
        ((*SLIT, "fluid={density: 1.0, kinematic_viscosity: 0.04, inertia: false}"), "develops from that"),
        ((ENDS,), "width 2 m"),
    ],
)
def test_check_says_what_enters_where_the_inflow_changes(loaded, changes, words):
    assert dict(scenes.of(loaded(*changes)).parameters())["inlet"].endswith(words)


CASES = [*(f"ends.left.profile={one}" for one in ("parabolic", "uniform", TABLE)), *map(fluid, FLUIDS)]


@pytest.mark.parametrize("change", CASES, ids=[change[:40] for change in CASES])
def test_mean_is_one_and_slope_is_the_derivative(loaded, change):
    low, pieces = 0.25, 1000
    profile = profile_of(loaded(ENDS, change), low, low + GAP)
    # Gauss points in many pieces: exact but for pieces with a knot, where third derivatives of a spline jump
    points, weights = np.polynomial.legendre.leggauss(4)
    y = low + GAP / pieces * (np.arange(pieces)[:, None] + 0.5 * (1.0 + points))
    assert np.mean(profile.value(y) @ weights / 2) == pytest.approx(1.0, abs=1e-10)
    y, step = y[1:-1], 1e-4
    differences = (profile.value(y + step) - profile.value(y - step)) / (2 * step)
    # step^2/6 times third derivatives; in the power-law fluid the slope has a kink at mid-gap
    assert np.median(np.abs(profile.slope(y) - differences)) < 1e-6
    assert np.abs(profile.slope(y) - differences).max() < 1e-3


@pytest.mark.parametrize("name", FLUIDS)
def test_developed_profile_is_the_exact_flow_of_a_channel(loaded, name):
    config = loaded(ENDS, fluid(name))
    profile = profile_of(config, 0.0, GAP)
    stress, _ = shear(config).steady(float(VELOCITY * profile.slope(0.0)))
    drive = f"drive.acceleration={2.0 * stress / GAP!r}"
    channel = scenes.of(loaded(drive, fluid(name), "initial.state=developed"))
    y = np.linspace(0.0, GAP, 101)
    # both have errors of some 1e-8, see exact/start_up.py and RATES of exact/uniform_shear.py
    assert np.abs(profile.value(y) - channel.exact_velocity(y, 0.0) / VELOCITY).max() < 1e-7


def test_a_table_goes_through_its_points(loaded):
    profile = profile_of(loaded(ENDS, f"ends.left.profile={TABLE}"), 1.0, 1.0 + GAP)
    values = profile.value(1.0 + np.array([0.0, 0.3, 1.0, 1.5, 2.0]))
    assert values / values[2] == pytest.approx([0.0, 0.4, 1.0, 0.8, 0.2], abs=1e-14)


def test_steady_states_are_the_limit_of_long_shear(loaded):
    flow, rates = shear(loaded(ENDS, fluid("giesekus"))), np.linspace(0.0, 5.0, 4)
    stresses = np.transpose(flow._stresses(flow.steady_states(rates), rates))
    for rate, found in zip(rates, stresses, strict=True):
        assert found == pytest.approx(flow.steady(rate), rel=1e-8, abs=1e-12)  # tolerance of the integration in time


def test_flow_with_a_yield_stress_has_the_asked_mean(loaded):
    law = "type: herschel_bulkley, index: 1.0, reference_rate: 1.0, yield_stress: 0.3, regularisation: 1000.0"
    flow = shear(loaded(ENDS, f"fluid.rheology={{{law}}}", "ends.left.profile=uniform"))
    distances, rates = flow.developed(VELOCITY, GAP)
    # u_mean of a Bingham fluid by Buckingham and Reiner, for the wall stress of the profile; errors by regularisation
    stress = 0.05 * rates[-1] + 0.2
    share = 0.2 / stress
    assert GAP / 2 * stress / (3 * 0.05) * (1 - 1.5 * share + 0.5 * share**3) == pytest.approx(VELOCITY, rel=2e-3)
    assert (np.diff(distances) > 0).all()
