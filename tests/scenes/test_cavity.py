"""The cavity: what its config may say, its walls and corners, and that errors are given of a steady state alone."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from report_scene import Drawn, make_video

from tisph.cli.run import result_text
from tisph.exact.cavity import RegularCavity, centre_lines, extremes
from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import resolution
from tisph.measures.steadiness import Followed
from tisph.scenes._views import kinetic_energy
from tisph.scenes.cavity import Scene
from tisph.schemes._forecast import forecast
from tisph.simulation.state import start_snapshot, start_values

TIMES = np.linspace(0.0, 20.0, 401)
STEADY = np.full((401, 1), 0.03)


@pytest.fixture
def case(load_flow):
    return functools.partial(load_flow, "cavity")


@pytest.fixture
def regular(case):
    return Scene.from_config(case("walls.lid.profile=regular"))


def snapshot_of(scene, velocity=None, t=20.0):
    """The start, at another time and with the ``velocity`` (u, v) of places."""
    config = scene_initial(scene)
    start = replace(start_snapshot(scene, config, "f64"), t=t)
    return start if velocity is None else replace(start, **dict(zip("uv", velocity(start.x, start.y), strict=True)))


def scene_initial(scene):
    from types import SimpleNamespace

    return start_values(scene, SimpleNamespace(seed=0, jitter=0.2))


def measured(scene, snapshot, energies=STEADY):
    sizes = scene.time_series().judged_sizes
    series = (), np.array([0.03]), (TIMES, energies), Followed(TIMES, energies, sizes)
    return sample_metrics(scene, snapshot, series)


def test_the_sharp_lid_alone_slides_past_corners(case, regular):
    sharp = Scene.from_config(case("walls.lid.velocity=-2.0"))
    assert regular.corners == ()
    lid = np.array([[0.0, 1.0], [0.25, 1.0], [1.0, 1.0]])
    assert np.array_equal(sharp.bodies[2].velocity(lid), [[-2.0, 0.0]] * 3)
    assert np.allclose(regular.bodies[2].velocity(lid), [[0.0, 0.0], [0.5625, 0.0], [0.0, 0.0]], rtol=0, atol=1e-15)
    for corner in sharp.corners:
        inside = np.array(corner.place) + 0.01 * np.array(corner.along)
        assert np.allclose(corner.velocity(inside[None]), [[-2.0, 0.0]], rtol=0, atol=1e-12)


def test_the_layer_under_the_lid_grows_until_fluid_has_passed_it(case):
    """sqrt(nu t) up to t = width/U = 1/2: the depth is the width over the root of the Reynolds number, here 200."""
    scene = Scene.from_config(case("walls.lid.velocity=-2.0"))
    assert scene.thinnest_layer(0.25)[:2] == (pytest.approx(0.05, rel=1e-14), "the layer under the lid")
    assert scene.thinnest_layer(20.0)[0] == pytest.approx(200**-0.5, rel=1e-14)


@pytest.mark.parametrize(
    ("reynolds", "across", "resolved"), [(100, 25, True), (1000, 70, True), (1000, 50, False), (10000, 100, False)]
)
def test_a_layer_of_less_than_two_spacings_is_never_resolved(case, reynolds, across, resolved):
    scene = Scene.from_config(
        case(f"fluid.kinematic_viscosity={1 / reynolds}", f"discretisation.particles_across={across}")
    )
    found, reason = resolution(scene, 60.0)
    assert found == resolved
    assert resolved or reason.startswith(f"the layer under the lid is {across / reynolds**0.5:.2g} spacings thin")
    assert not resolution(scene, 0.01)[0]


def test_material_of_the_regular_lid_is_accelerated(regular):
    points = np.array([[0.2, 1.0], [0.7, 1.0]])
    lid, step = regular.bodies[2], np.array([1e-6, 0.0])
    slope = (lid.velocity(points + step) - lid.velocity(points - step)) / 2e-6
    assert np.allclose(lid.acceleration(points), lid.velocity(points)[:, :1] * slope, rtol=0, atol=1e-8)


def test_errors_of_the_exact_flow_are_those_of_the_interpolation(regular):
    flow = RegularCavity(1.0, 1.0, 1.0, 0.01)
    found = measured(regular, snapshot_of(regular, flow.velocity))
    assert (found["steady"], found["steady_reason"]) == (True, None)
    assert found["l2"] == 0.0
    for name in ("u_extreme", "v_min", "v_max"):
        # degree 6 among 30 across: a wave of 30 spacings is met to 1e-7; extremes lie where boundary layers end
        assert found[name] == pytest.approx(found[f"{name}_exact"], abs=2e-5)
    assert regular.extremes()["u_extreme"] == pytest.approx(flow.extremes()["u_min"])


def test_before_the_steady_state_there_are_no_errors(regular):
    state = snapshot_of(regular, RegularCavity(1.0, 1.0, 1.0, 0.01).velocity)
    rising = measured(regular, state, STEADY * (1 + 1e-3 * TIMES[:, None]))
    middles = 27.5 * 0.05  # of the first and the last third of 41 records, over 2.03 = 1/(5 pi^2 nu)
    assert rising["steady_change"] == pytest.approx(1e-3 * middles / 1.02, rel=1e-6)
    assert not rising["steady"]
    assert "changes" in rising["steady_reason"]
    early = measured(regular, replace(state, t=1.5))
    assert early["steady_reason"] == "the flow has run for 1.5, less than the time of viscous decay, 2.03"
    for found in (rising, early):
        assert found["l2"] is None
        assert found["u_extreme_exact"] is None


def test_the_sharp_lid_is_held_against_tables(case):
    scene = Scene.from_config(case())
    assert scene.extremes() == {
        "u_extreme": extremes(100)["u_min"],
        "v_min": extremes(100)["v_min"],
        "v_max": extremes(100)["v_max"],
    }
    assert Scene.from_config(case("fluid.kinematic_viscosity=0.02")).extremes() == {}
    assert Scene.from_config(case("geometry.height=2.0")).extremes() == {}
    # of liquid at rest the largest difference is the largest velocity there
    largest = max(np.abs(table.value[table.coordinate < 0.85]).max() for table in centre_lines(100))
    assert largest <= measured(scene, snapshot_of(scene))["centre_line_error"] < 0.7


def backwards(case):
    return Scene.from_config(case("walls.lid.velocity=-1.0"))


def test_a_reversed_lid_is_compared_with_the_same_tables(case):
    """Velocities of a smooth flow that is the mirror image of another have its errors."""

    def velocity(x, y):
        return 0.1 * np.cos(x) * y**2, 0.1 * x * (1 - x**2) * y

    def mirrored(x, y):
        u, v = velocity(1 - x, y)
        return -u, v

    errors = []
    for scene, flow in ((Scene.from_config(case()), velocity), (backwards(case), mirrored)):
        errors.append(measured(scene, snapshot_of(scene, flow))["centre_line_error"])
    assert errors[0] == pytest.approx(errors[1], rel=0.02)  # other places of the particles at the lid


def test_slow_flow_has_errors_after_its_start_whatever_its_energy_does(case):
    """A viscous time after it: energies scatter with the arrangement of particles."""
    scene = Scene.from_config(case("walls.lid.profile=regular", "fluid.kinematic_viscosity=1.0"))
    rising = np.linspace(0.03, 0.04, len(TIMES))[:, None]
    late, early = (measured(scene, snapshot_of(scene, t=t), rising) for t in (20.0, 0.9))
    assert not late["steady"]
    assert late["l2"] == pytest.approx(1.0)  # a fluid at rest
    assert early["l2"] is None


@pytest.mark.parametrize("growth", [0.0, 0.05])
def test_a_movie_draws_the_steady_reference_when_the_flow_is_steady(case, growth):
    scene = Scene.from_config(case())
    drawn = Drawn(scene, make_video(), "", 20.0)
    for t in np.linspace(16.0, 20.0, 9):  # a flow is steady that has not changed for a tenth of the run
        start = snapshot_of(scene, t=t)
        picture = drawn.render(replace(start, u=(1.0 + growth * (t - 20.0)) * start.y))
    panel = picture[drawn.layout.profile.inner.slices].astype(int)
    red = np.count_nonzero(panel[:, :, 0] > panel[:, :, 1] + 60)
    assert red == 0 if growth else red > 100


def test_a_run_says_at_its_end_whether_it_is_steady(case, regular):
    config, flow = case("walls.lid.profile=regular"), RegularCavity(1.0, 1.0, 1.0, 0.01)
    state = snapshot_of(regular, flow.velocity)
    cost = {f"wall_{part}_s": 0.2 for part in ("loop", "compile", "output", "import", "total")} | {"steps": 3}

    def printed(energies):
        sample = {"t": 20.0, **measured(regular, state, energies)}
        lines = result_text(config, regular, {"samples": [sample], "cost": cost}).splitlines()
        cells = ([cell.strip() for cell in line.strip("| ").split("|")][-3:] for line in (lines[0], lines[2]))
        return dict(zip(*cells, strict=True)), lines[3:]

    judged, rest = printed(STEADY)
    assert (judged["steady"], judged["resolved"]) == ("yes", "yes")
    assert not any("steady" in line for line in rest)
    judged, rest = printed(STEADY * (1 + 1e-3 * TIMES[:, None]))
    assert judged == {"resolved": "yes", "change": "1.3e-03", "steady": "no"}
    text = "kinetic energy changes by 1.3e-03 over the last 2, the time of viscous decay"
    assert f"sample 0 is not steady: {text}" in rest


def test_check_says_how_steep_the_stress_of_a_polymer_becomes(case):
    """Along the lid A_xx of an Oldroyd-B fluid grows 45-fold at De = 1/2, by midpoint steps; at 1/10 not at all."""
    lid, log = "walls.lid.profile=regular", 0.0

    def slope(x):
        u, strain = 16.0 * x**2 * (1.0 - x) ** 2, 32.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
        return (2.0 * strain - 1.0 / 0.5) / u

    start = next(place for place in np.linspace(0.01, 0.1, 901) if slope(place) > 0.0)
    for x in np.arange(start, 0.5, 1e-4):
        log = max(log, log + 1e-4 * slope(x + 0.5e-4))
    found = []
    for time in (0.5, 0.1):
        config = case(lid, f"fluid.rheology={{type: oldroyd_b, relaxation_time: {time}, solvent_fraction: 0.5}}")
        scene = Scene.from_config(config)
        found.append(scene.steepness)
        warned = [text for text in forecast(config)[1] if "polymer's stretch will change" in text]
        assert len(warned) == (time == 0.5)
    assert found == [pytest.approx(log, rel=1e-2), 0.0]  # the first place is found to 1e-4
    assert Scene.from_config(case(lid)).steepness == 0.0


def squeezed(places):
    """Places from 0 to 1 whose distances vary by a fifth of themselves."""
    return places + 0.1 / np.pi * np.sin(2.0 * np.pi * places)


def test_kinetic_energy_does_not_depend_on_how_evenly_particles_lie(regular):
    """The stream function is 16 x^2 (1 - x)^2 (y^3 - y^2); the mean over the particles is 2.7e-2 off."""
    scene = replace(regular, width=1.0, height=1.0, velocity=1.0)
    state = snapshot_of(scene)
    x, y = squeezed(state.x), squeezed(state.y)
    u = 16.0 * (x - x**2) ** 2 * (3.0 * y**2 - 2.0 * y)
    v = -32.0 * (x - x**2) * (1.0 - 2.0 * x) * (y**3 - y**2)
    exact = 0.5 * (256 / 630 * 2 / 15 + 1024 / 210 / 105)
    assert kinetic_energy(scene, replace(state, x=x, y=y, u=u, v=v)) == pytest.approx(exact, rel=5e-5)  # 1.5e-5 off


def test_a_lid_whose_velocity_is_given_at_times_is_smooth_in_between(case):
    """It is a spline without a slope at its ends; without ``smooth`` it is a polyline, whose kinks count as jumps."""
    lid = "walls.lid={times: [0.5, 1.0, 1.5], velocities: [0.0, -1.0, -2.0], profile: regular%s}"
    scene = Scene.from_config(case(lid % ", smooth: true"))
    kinked = Scene.from_config(case(lid % ""))
    middle, times = np.array([[0.5 * scene.width, scene.height]]), np.array([0.0, 0.5, 0.75, 1.0, 1.5, 9.0])
    at = [[each.bodies[2].velocity(middle, t)[0, 0] for t in times] for each in (scene, kinked)]
    assert at[0] == pytest.approx([0.0, 0.0, -0.3125, -1.0, -2.0, -2.0])  # of the cubic from slope 0 to slope -3
    assert at[1] == pytest.approx([0.0, 0.0, -0.5, -1.0, -2.0, -2.0])
    assert (scene.jump_times, kinked.jump_times) == ((), (0.5, 1.5))
    assert (scene.velocity, scene.velocity_scale) == (-2.0, 2.0)
    assert scene.bodies[2].at(0.75).acceleration(middle)[0, 0] == pytest.approx(-2.25)
    assert [each.bodies[2].steady for each in (scene, kinked, Scene.from_config(case()))] == [False, False, True]


def test_without_inertia_the_reference_follows_the_lid(case):
    lid = "walls.lid={times: [0.0, 1.0], velocities: [0.0, 2.0], profile: regular, smooth: true}"
    scene = Scene.from_config(case(lid, "fluid.inertia=false"))
    steady = RegularCavity(scene.width, scene.height, 2.0, np.inf)
    half = snapshot_of(scene, lambda x, y: 0.5 * np.array(steady.velocity(x, y)), t=0.5)
    found = measured(scene, half)
    assert found["l2"] < 1e-12
    assert found["v_max_exact"] == pytest.approx(0.5 * steady.extremes()["v_max"])
    with_inertia = Scene.from_config(case(lid))
    assert measured(with_inertia, replace(half, t=100.0))["l2"] is None
