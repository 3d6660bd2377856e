"""Parts of the two-dimensional scheme: weights and lengths of steps, scatter of loads, curvature of walls."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tisph import scenes
from tisph.config import load
from tisph.geometry.body import Body
from tisph.geometry.circle import Circle
from tisph.geometry.polygon import Polygon
from tisph.geometry.wanted_spacing import WantedSpacing
from tisph.schemes._forecast import estimates
from tisph.schemes._step_control import LARGEST_MULTISTEP_FACTOR
from tisph.schemes.implicit.planar import BETWEEN_WALLS, COST, OVERHEAD, STARTING, _guessed_steps
from tisph.schemes.implicit.planar.step_limits import FIRST
from tisph.schemes.implicit.planar.time_levels import TimeWeights
from tisph.schemes.implicit.planar.wall_boundary import LOAD_STEPS, WallLoads, scatter, scatter_of_each
from tisph.schemes.implicit.planar.wall_points import WallPoints, WallsOfRevolution

STEPS = [0.3, 0.25, 0.2, 0.28]
NOW = 1.7


@pytest.fixture
def times():
    return TimeWeights(STEPS, STEPS[0])


def values(function, first=0):
    """Values at the ends of the steps before now, newest first."""
    return function(NOW - np.cumsum(STEPS))


def test_differences_paths_and_values_between_are_exact_for_cubics(times):
    leading, back = times.bdf()
    rate = (leading * NOW**3 - back @ values(lambda t: t**3)) / STEPS[0]
    assert rate == pytest.approx(3 * NOW**2, rel=1e-12)
    assert back[3] == 0.0
    way = times.step_integral() @ values(lambda t: t**3)
    assert way == pytest.approx((NOW**4 - (NOW - STEPS[0]) ** 4) / 4, rel=1e-12)
    early = TimeWeights([0.1, 0.1], 0.1).step_integral()  # values that are not known yet weigh nothing
    assert early == pytest.approx([0.15, -0.05, 0, 0], abs=1e-12)
    assert times.interpolation(0.1, 4) @ values(lambda t: t**3) == pytest.approx((NOW - 0.1) ** 3, rel=1e-12)
    assert times.extrapolation(2) @ values(lambda t: 2 * t)[:2] == pytest.approx(2 * NOW, rel=1e-12)


def test_the_error_is_that_of_the_differences(times):
    # of t^4, whose error the differences of third order make in a step: (rate of the differences - rate) h / g
    leading, back = times.bdf()
    before = values(lambda t: t**4)
    found = (back @ before + STEPS[0] * 4 * NOW**3) / leading
    error, order = times.step_error(NOW**4 - times.extrapolation(4) @ before, leading, 1.0)
    assert order == 3
    assert error == pytest.approx(abs(found - NOW**4), rel=1e-9)


def test_the_error_of_the_first_step_is_half_its_squared_change():
    """In units of the velocities: of a change by 0.2 at a speed of 4."""
    error, order = TimeWeights([0.0], 0.1).step_error(0.2, 1.0, 4.0)
    assert (error, order) == (pytest.approx(0.5 * (0.2 / 4.0) ** 2 * 4.0, rel=1e-14), 1)


FLOWS = {
    "scene: taylor_green\ngeometry: {length: 1.0}\ninitial: {velocity: 1.0}": (400, 1.0),
    "scene: cavity\ngeometry: {width: 1.0, height: 1.0}\nwalls: {lid: {velocity: 1.0}}": (400, BETWEEN_WALLS),
    "scene: annulus\ngeometry: {inner_radius: 1.0, outer_radius: 2.0}\nwalls: {inner: {angular_velocity: 1.0}}": (
        round(3 * math.pi * 400),
        BETWEEN_WALLS,
    ),
}


def test_every_start_of_an_unknown_flow_costs_its_growing_steps():
    """Steps of 0.02 begin with a fiftieth of that and grow by 1.5: they are as long at t = 0.04."""
    scene = SimpleNamespace(inertia=True, reference_velocity=1.0, bodies=(), rheology=None, spacing=0.1, start_time=0.0)
    scene.axisymmetric, scene.fields, scene.kept_mean_velocity, scene.flows_through = False, (), None, False
    scene.acceleration, scene.kinematics = 0.0, None
    scene.kinematic_viscosity, scene.reference_length = 0.0, 1.0  # nothing decays
    scene.wanted_spacing = WantedSpacing(0.1)
    found = []
    for changes in ((), (2.0,), (0.5,)):
        scene.jump_times = changes
        found += _guessed_steps(scene, [1.0], None, 0.2)
    grow = math.log(2.0 / FIRST) / math.log(LARGEST_MULTISTEP_FACTOR)
    assert found == [round(48 + grow), round(48 + grow), round(46 + 2 * grow)]


def test_flow_around_the_axis_takes_no_step_shorter():
    """Of configs/taylor_vortices.yaml: 223 measured up to t = 40; by the speed of the wall it would be 1040."""
    sample = estimates(load(Path(__file__).parents[2] / "configs" / "taylor_vortices.yaml"))["samples"][1]
    least, most = sample.steps_range(sample.steps)
    assert least < 223 < most < 1040


def test_steps_of_a_start_grow_as_the_tolerance_allows():
    """From t = 0.01 to 0.1 they are ln(10)/ln(1 + a STARTING), a = 0.0557 for the tolerance 2e-6 and 3.5 a for 3e-4."""
    config = Path(__file__).parents[2] / "configs" / "cylinder_in_channel.yaml"
    for tolerance, part in ((2e-6, 0.0557), (3e-4, 0.195)):
        early, late = estimates(load(config, [f"time.tolerance={tolerance}", "time.samples=[0.01, 0.1]"]))["samples"]
        assert late.steps - early.steps == pytest.approx(math.log(10) / math.log1p(part * STARTING), abs=1.0)


@pytest.mark.parametrize("flow", FLOWS, ids=lambda flow: flow.split()[1])
def test_a_particle_between_walls_is_stated_to_cost_more(flow, tmp_path):
    """Measured: 1.3 to 2.3 times as much in the annulus as in the vortex, 5900 particles each."""
    liquid = "fluid: {density: 1.0, kinematic_viscosity: 0.01}"
    (tmp_path / "case.yaml").write_text(
        f"{flow}\n{liquid}\ndiscretisation: {{particles_across: 20}}\ntime: {{end: 1.0}}"
    )
    found, (particles, factor) = estimates(load(tmp_path / "case.yaml")), FLOWS[flow]
    assert found["run_time"] == pytest.approx(found["steps"] * (OVERHEAD + particles * factor * COST), rel=1e-14)


def test_random_forces_have_the_scatter_they_were_made_with():
    # of 8 differences in each of 400 windows: the mean square is known to 1 / sqrt(1600), its root to half of that
    noise = np.random.default_rng(0).normal(scale=0.01, size=(400, 12, 2, 2)) * [[0.1], [1.0]]
    forces = np.array([[2.0, 0.0], [1.0, 0.0]]) + noise
    found = [scatter(np.linspace(1.0, 0.0, 12), each, np.zeros((12, 2))) for each in forces]
    assert {number for _, number in found} == {1}
    measured = np.sqrt(np.mean([value**2 for value, _ in found]))
    # over the larger force, 2; both components count
    assert measured == pytest.approx(0.01 * np.sqrt(2.0) / 2.0, rel=0.05)


def test_scatter_is_of_what_is_not_smooth_relative_to_force_or_torque():
    times = np.array([2.0, 1.7, 1.5, 1.1, 0.4, 0.3])
    forces = np.stack([1.0 + times - 0.3 * times**3, 0.0 * times], axis=1)[:, None]
    assert scatter(times, forces, 0.0 * forces[:, :, 0])[0] < 1e-14  # of a cubic, over uneven steps: rounding
    # between coaxial cylinders the forces are 0 by symmetry; their rounding is no scatter of the load
    forces = np.random.default_rng(0).normal(scale=1e-6, size=(12, 1, 2))
    assert scatter(np.linspace(1.0, 0.0, 12), forces, np.full((12, 1), 2.0))[0] < 1e-5
    assert scatter(np.linspace(1.0, 0.0, 12), forces, np.zeros((12, 1)))[0] > 0.1
    # few steps, or no force
    assert scatter(np.arange(4.0)[::-1], np.ones((4, 1, 2)), np.ones((4, 1))) is None
    assert scatter(np.arange(6.0)[::-1], np.zeros((6, 1, 2)), np.zeros((6, 1))) is None


def test_each_load_has_its_own_scatter_and_size():
    """In 48 steps scatter and root mean square of noise are known to 10 %."""
    noise = np.random.default_rng(0).normal(size=(48, 1, 3)) * [0.01, 0.002, 0.003]
    found, size = scatter_of_each(np.linspace(1.0, 0.0, 48), np.array([2.0, 0.0, 0.1]) + noise)
    assert found[0] == pytest.approx([0.01, 0.002, 0.003], rel=0.3)
    assert size[0] == pytest.approx([2.0, 0.002, 0.1], rel=0.3)
    assert np.isnan(scatter_of_each(np.arange(4.0)[::-1], np.ones((4, 1, 3)))).all()


def loads_of(forces):
    """Loads on a body with these ``forces`` (steps,) in steps of length 1, the last one newest."""
    loads = object.__new__(WallLoads)
    loads.walls = SimpleNamespace(bodies=[Body(Circle(1.0))])
    loads.loads = [np.array([[[force, 0.0, 0.0, 0.0]]]) for force in forces[: -LOAD_STEPS - 1 : -1]]
    loads.times = [np.array(float(time)) for time in range(len(forces), 0, -1)][: 2 * LOAD_STEPS]
    return loads


def test_a_force_that_jumps_in_every_tenth_step_scatters_at_all_times():
    """By jumps of 0.08 in a tenth of the steps: 0.025, a little less beside cubics through other jumps."""
    random = np.random.default_rng(0)
    forces = 1.0 + 0.08 * (random.uniform(size=400) < 0.1) * random.choice([-1.0, 1.0], 400)
    found = [loads_of(forces[:steps]).scatter([0])[0] for steps in range(2 * LOAD_STEPS, 400)]
    assert min(found) > 0.01
    assert np.median(found) == pytest.approx(forces.std(), rel=0.2)


def test_a_rough_start_is_forgotten_after_as_many_steps():
    forces = np.concatenate([np.random.default_rng(0).normal(1.0, 0.1, 20), np.ones(30)])
    assert loads_of(forces[:30]).scatter([0])[0] > 0.01
    assert loads_of(forces[:42]).scatter([0])[0] < 1e-14


def test_operators_use_polar_coordinates_near_curved_walls_only():
    """Of particles 0.2 from walls of radius 1, from outside and inside, from a flat one, and too far from one."""
    normal = np.array([[0.6, 0.8], [0.0, 1.0], [1.0, 0.0], [0.6, 0.8]])
    planes = np.column_stack([normal, np.zeros(4)])[:, None]
    distances, curvatures = np.array([0.2, 0.2, 0.2, 1.0])[:, None], np.array([1.0, -1.0, 0.0, 1.0])[:, None]
    found = WallPoints.polar_map(SimpleNamespace(), None, planes, distances, curvatures, np.full(4, 0.1))
    assert found == pytest.approx(np.array([[0.6 / 1.2, -0.8 / 1.2], [0.0, 1.0 / 0.8], [0.0, 0.0], [0.0, 0.0]]))


def curvatures_along(shape, spacing):
    """Those that operators use along a line half a spacing off the wall of a body across the edge of a cell."""
    body = Body(shape, (0.05, 2.0), angle=0.3, periods=(4.0, np.inf))
    boundary = body.boundary_points(0.05 * spacing)
    points = boundary.point + 0.5 * spacing * boundary.normal
    return WallPoints([body], spacing, (0.0, 0.0)).nearest_walls(points % [4.0, 9.0], 0.0)[2][:, 0]


def test_curvature_varies_continuously_where_corners_begin():
    """By a part of its window at most every twentieth of a spacing; its jump would be one of the operators."""
    square = Polygon(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)), 0.4)
    found = curvatures_along(square, 0.1)
    assert np.abs(np.diff(found)).max() < 0.06 * 2.5
    assert found.max() == pytest.approx(2.5, rel=0.05)
    assert found.min() == 0.0
    assert curvatures_along(Circle(0.4), 0.1) == pytest.approx(2.5, rel=1e-12)


CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize(
    ("config", "across"),
    [("pipe", False), ("taylor_vortices", False), ("spin_up", False), ("sphere_in_tube", True), ("rotating_end", True)],
)
def test_flow_along_spheres_and_plates_goes_to_the_axis(config, across):
    scene = scenes.of(load(CONFIGS / f"{config}.yaml"))
    assert WallsOfRevolution(scene.bodies, scene.spacing, scene.origin).across_axis == across
