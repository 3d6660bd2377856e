"""The journal bearing: what its config may say, its walls, and that errors are given of slow and steady flow alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import Drawn, make_video

from tisph import scenes
from tisph.geometry.body import smallest_gap
from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import resolution
from tisph.measures.steadiness import Followed
from tisph.report.plots import history_figure, profile_figure
from tisph.scenes._views import kinetic_energy
from tisph.scenes.eccentric_annulus import LOADS
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies

TIMES = np.linspace(0.0, 0.5, 101)
STEADY = np.full((101, 5), 0.03)


@pytest.fixture
def case(load_flow):
    """Return a function that gives the scene of the case with overrides."""
    return lambda *overrides: scenes.of(load_flow("bearing", *overrides))


def snapshot_of(scene, t=0.5, loads=(0.0, 0.0, 0.0, 0.0)):
    """The state of the start at another time, with the ``LOADS`` of its cylinders."""
    start = start_snapshot(scene, start_values(scene, SimpleNamespace(seed=0, jitter=0.2)), "f64")
    inner, outer, x, y = loads
    forces = np.array([[[x, y, inner, 0.0], [-x, -y, outer, 0.0]]] * 2)
    return replace(start, t=t, bodies=Bodies.at(t, scene.bodies, forces))


def stokes_snapshot(scene, t=0.5):
    """Stokes flow, with its pressure, which has a constant of its own, and what it does to the cylinders."""
    flow, viscosity = scene.stokes(0.4, -0.1), {"dynamic_viscosity": 20.0}
    state = snapshot_of(scene, t, (*flow.torque(**viscosity), *flow.force(**viscosity)))
    u, v = flow.velocity(state.x, state.y)
    return replace(state, u=u, v=v, pressure=3.0 + flow.pressure(state.x, state.y, **viscosity))


def measured(scene, snapshot, energies=STEADY):
    return sample_metrics(scene, snapshot, series_of(scene, TIMES, energies))


def series_of(scene, times, energies):
    return (), np.array([0.03]), (times, energies), Followed(times, energies, scene.time_series().judged_sizes)


def test_the_inner_axis_is_off_by_its_part_of_the_mean_gap(case):
    scene = case("geometry.eccentricity=0.7", "discretisation.particles_across=12")
    assert scene.bodies[0].centre == pytest.approx((0.7, 0.0))
    assert scene.bodies[1].centre == (0.0, 0.0)
    gap, what = scene.narrowest(0.0)[1][:2]
    assert gap == pytest.approx(smallest_gap(scene.bodies)[0], rel=1e-6)
    assert "gap between the cylinders" in what
    x, y = scene.jittered(0, 0.2)
    assert len(x) == scene.particles == round(3 * np.pi * 12**2)
    assert np.all((np.hypot(x, y) < 2.0) & (np.hypot(x - 0.7, y) > 1.0))


def test_a_gap_of_three_spacings_is_resolved(case):
    for eccentricity, resolved in (("0.8", True), ("0.83", False)):
        found, reason = resolution(case(f"geometry.eccentricity={eccentricity}"), 0.5)
        assert found == resolved
        assert resolved or "gap between the cylinders" in reason


def test_a_start_in_stokes_flow_is_that_of_what_the_cylinders_did(case):
    scene = case("initial.state=developed")
    x, y = scene.jittered(0, 0.2)
    assert np.array_equal(list(scene.initial(x, y).values()), scene.stokes(0.4, -0.1).velocity(x, y))
    assert resolution(scene, 0.0) == (True, None)
    stopped = case("initial.state=developed", "walls.inner.angular_velocity_before=-1.0")
    assert np.array_equal(stopped.initial(x, y)["u"], stopped.stokes(-1.0, -0.1).velocity(x, y)[0])
    assert not resolution(stopped, 1e-4)[0]  # the layer at the inner cylinder
    assert not np.any(list(case().initial(x, y).values()))


def test_stokes_flow_has_no_errors(case):
    scene = case()
    found = measured(scene, stokes_snapshot(scene))
    assert (found["steady"], found["resolved"]) == (True, True)
    assert found["l2"] == found["linf"] == 0.0
    assert found["l2_pressure"] < 1e-14  # of a mean that is taken away
    assert all(found[name] == found[f"{name}_exact"] for name in LOADS)
    assert found["torque_inner_exact"] < 0 < found["torque_outer_exact"]  # against the motion of each


def test_errors_are_those_of_velocity_and_pressure(case):
    scene = case()
    exact = stokes_snapshot(scene)
    found = measured(scene, replace(exact, u=1.01 * exact.u, v=1.01 * exact.v, pressure=1.1 * exact.pressure))
    assert found["l2"] == pytest.approx(0.01, rel=1e-9)
    assert found["l2_pressure"] == pytest.approx(0.1, rel=1e-5)  # the mean over the particles is not quite 0


def test_flow_that_is_fast_or_not_yet_steady_has_no_reference(case):
    scene, faster = case(), case("fluid.kinematic_viscosity=0.3")
    assert (scene.reynolds, faster.reynolds) == pytest.approx((0.04, 4 / 3))
    rising = measured(scene, stokes_snapshot(scene), STEADY * (1 + 3.0 * TIMES[:, None]))
    early = measured(scene, stokes_snapshot(scene, 0.01))
    fast = sample_metrics(faster, stokes_snapshot(faster, 20.0), series_of(faster, 40 * TIMES, STEADY))
    assert (rising["steady"], early["steady"], fast["steady"]) == (False, False, True)
    for found in (rising, early, fast):
        assert found["torque_inner"] is not None
        assert all(found[name] is None for name in ("l2", "linf", "l2_pressure", "torque_inner_exact", "force_y_exact"))


def test_the_profile_crosses_both_gaps_and_the_inner_cylinder(case):
    (profile,) = case().profiles()
    x = np.array([-2.0, -0.5, 0.5, 1.5, 2.0])
    assert profile.exact(x, 0.0, 0.5) == pytest.approx([0.2, -0.4, 0.0, 0.4, -0.2], abs=1e-12)
    assert case("fluid.kinematic_viscosity=0.3").profiles()[0].exact is None


@pytest.mark.parametrize("colour", ["speed", "vorticity", "pressure"])
def test_pictures_are_drawn(case, colour):
    scene = case()
    snapshot = stokes_snapshot(scene)
    video = make_video(640, 320, colour, "streamlines")
    frame = Drawn(scene, video, "bearing", 0.5).render(snapshot)
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 50
    series = scene.time_series()
    values = series.measure(snapshot)
    assert values[1:] == pytest.approx([measured(scene, snapshot)[name] for name in LOADS])
    assert profile_figure(scene, [snapshot]).axes
    assert history_figure(scene, {}, np.array([0.4, 0.5]), np.array([values, values])).axes


def test_history_has_the_torques_and_the_force_of_stokes_flow(case):
    scene = case()
    values = scene.time_series().measure(stokes_snapshot(scene))
    axes = history_figure(scene, {}, np.array([0.4, 0.5]), np.array([values, values])).axes
    levels = [line.get_ydata()[0] for panel in axes for line in panel.lines if line.get_label().startswith("exact")]
    flow = scene.stokes(scene.inner.velocity(0.0), scene.outer.velocity(0.0))
    viscosity = {"dynamic_viscosity": scene.dynamic_viscosity}
    assert levels == pytest.approx([*flow.torque(**viscosity), *flow.force(**viscosity)])
    fast = case("fluid.kinematic_viscosity=0.3").time_series()
    assert not fast.levels


def test_kinetic_energy_is_the_mean_over_the_area_between_the_circles(case):
    """The exact one has nodes on lines from the inner axis; the mean over the particles is 1e-2 off."""
    scene = case("discretisation.particles_across=16")
    state = snapshot_of(scene)
    flow, inner = scene.stokes(0.4, -0.1), scene.bodies[0]
    heights, weights = np.polynomial.legendre.leggauss(30)
    turns = 2.0 * np.pi * np.arange(100) / 100
    away = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    first, along = scene.inner_radius, scene.offset * away[:, 0]
    last = -along + np.sqrt(along**2 + scene.outer_radius**2 - scene.offset**2)
    radii = first + 0.5 * (heights[:, None] + 1.0) * (last - first)
    areas = weights[:, None] * (last - first) * radii
    x, y = (centre + radii * part for centre, part in zip(inner.centre, away.T, strict=True))
    square = np.square(flow.velocity(x, y)).sum(axis=0)
    u, v = flow.velocity(state.x, state.y)
    found = kinetic_energy(scene, replace(state, u=u, v=v))
    assert found == pytest.approx(0.5 * (areas * square).sum() / areas.sum(), rel=1e-5)
