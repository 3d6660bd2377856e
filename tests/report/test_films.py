"""Films of a phenomenon: eddies, marks, events, steady values, colours of each frame, walls that slip or turn."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import END, Drawn, make_annulus, make_channel, make_snapshot, make_video, shown, unit_channel

from tisph import scenes
from tisph.config import load
from tisph.report import style
from tisph.report.layout import arrange
from tisph.report.movie import build_figure
from tisph.report.overlays import BodyTracks, StreamFunction, Streamlines, Turning, paint_marks
from tisph.report.panels import TimePanel
from tisph.report.quantities import quantity
from tisph.scenes._views import TimeSeries
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Bodies

WIDE = make_video(1280, 640)


def scene_of(name, *changes):
    return scenes.of(load(Path(__file__).parents[2] / "configs" / f"{name}.yaml", changes))


def start_of(scene):
    return start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.0, seed=0)), "f64")


# --- streamlines


def test_eddies_beside_a_flow_have_lines_of_their_own():
    """Fluid flows through between psi = -1 and 1; beside it an eddy reaches to -1.04, one that an error makes to 1."""
    scene = scene_of("contraction", "discretisation.particles_across=32")
    streams = Streamlines(scene, arrange(scene, 640, 320))
    streams.step, streams.eddy_step = 0.2, 0.01
    levels = streams.levels(StreamFunction(np.zeros((2, 2)), (-1.04, 1.0), beside=1.0))
    between = (np.arange(10) - 4.5) * 0.2
    assert levels == pytest.approx([-1.035, -1.025, -1.015, -1.005, *between], abs=1e-9)
    streams.eddy_step = 1e-5  # less than errors
    assert streams.levels(StreamFunction(np.zeros((2, 2)), (-1.04, 1.0), beside=1.0)) == pytest.approx(between)


def test_a_stream_function_is_constant_along_a_wall_at_rest():
    """Whatever the errors of the flow: here fluid goes into the bottom wall, and out of it."""
    scene = scene_of("backward_step", "discretisation.particles_across=16")
    snapshot = start_of(scene)
    wrong = 0.1 * np.sin(4.0 * snapshot.x)
    streams = Streamlines(scene, arrange(scene, 640, 320))
    stream = streams.measured(replace(snapshot, u=np.ones_like(wrong), v=wrong))
    bottom = stream.psi[0, streams._axes[0] > 1.2]
    assert np.isfinite(bottom).all()
    assert np.ptp(bottom) < 1e-3 * np.ptp(stream.ends)


# --- marks, events, steady values


def test_a_mark_is_at_its_place():
    channel = unit_channel()
    layout = arrange(channel, 1280, 640)
    panel = np.full((*layout.box.shape, 3), 255, dtype=np.uint8)
    paint_marks(panel, layout, [("", 0.7, 0.25)])
    rows, columns = np.nonzero(panel[:, :, 1] < 128)
    column, row = layout.pixel_positions(0.7, 0.25)
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx((column, row), abs=0.6)


def series_of(**more):
    return TimeSeries("", "a", "number", 1.0, ["a"], [("a", None)], lambda _: np.zeros(1), **more)


def painted(panel, channel, times, values):
    """Return a frame with the numbers ``values`` at ``times``."""
    picture = np.full((640, 1280, 3), 255, dtype=np.uint8)
    for t, value in zip(times, values, strict=True):
        picture[:] = 255
        panel.paint(picture, t, np.array([value]))
    return picture[arrange(channel, 1280, 640).series.inner.slices]


def test_the_first_time_of_an_event_is_marked():
    channel = unit_channel()
    event = ("contact", lambda values: values[0] < 0.5)
    panel = TimePanel(channel, arrange(channel, 1280, 640), series_of(event=event), 10.0, (0.0, 1.0))
    before = painted(panel, channel, [0.0, 1.0], [1.0, 0.6])
    after = painted(panel, channel, [2.0, 3.0, 4.0], [0.4, 0.45, 0.7])
    lines = [
        np.flatnonzero((part == style.rgb(style.MUTED)).all(axis=2).mean(axis=0) > 0.5) for part in (before, after)
    ]
    assert [len(each) for each in lines] == [0, 1]
    assert lines[1][0] == pytest.approx(0.2 * before.shape[1], abs=1.5)  # t = 2 of 10


def test_numbers_without_a_value_say_so():
    channel = unit_channel()
    panel = TimePanel(channel, arrange(channel, 1280, 640), series_of(), 10.0, (0.0, 1.0))
    inside = painted(panel, channel, [0.0], [np.nan])
    rows, columns = np.nonzero(inside[:, :, 0] < 200)
    assert (rows.mean(), columns.mean()) == pytest.approx(np.array(inside.shape[:2]) / 2, rel=0.1)
    assert (painted(panel, channel, [1.0], [0.5]) < 200).any()


@pytest.mark.parametrize(("last", "known"), [(0.0, [0.08]), (0.01, [])])
def test_values_of_a_flow_that_has_become_steady_are_drawn(last, known):
    """``last``: slope of a number at the end, which is not steady then."""
    scene = scene_of("cylinder_in_channel")
    series = scene.movie_series().only("drag", "drag", "force")
    panel = TimePanel(scene, arrange(scene, 1280, 640), series, 40.0, (0.0, 0.1))
    times = np.linspace(0.0, 40.0, 100)
    panel.know(times, (0.08 * (1.0 - np.exp(-times)) + last * times)[:, None])
    assert panel.settled == pytest.approx(known)
    assert panel.known.tolist() == [True]


def test_few_free_bodies_have_their_paths_since_the_start():
    scene = scene_of("drafting_kissing_tumbling")
    layout = arrange(scene, 1280, 640)
    tracks, panel = BodyTracks(scene, layout), np.full((*layout.box.shape, 3), 255, dtype=np.uint8)
    bodies = Bodies.at(0.0, scene.bodies)
    for step in range(100):  # more than the paths of particles have
        panel[:] = 255
        moved = bodies.centre + np.array([0.02 * step, 0.0])
        tracks.paint(panel, SimpleNamespace(t=float(step), bodies=replace(bodies, centre=moved)))
    dark = np.flatnonzero(panel[:, :, 0].min(axis=0) < 100) / layout.pixels_per_length
    assert dark.min() == pytest.approx(0.5, abs=0.03)
    assert dark.max() == pytest.approx(0.9 + 99 * 0.02, abs=0.06)


# --- colours


def test_colours_of_each_frame_show_a_flow_that_has_decayed():
    scene = make_annulus()
    start = start_of(scene)
    flow = replace(start, u=-start.y * start.x**2, v=start.x**3)
    drawn = Drawn(scene, make_video(1280, 640, color_by="speed", limits="frame"))
    boxes, numbers = [], []
    bar = drawn.movie._layout.colour_bar
    beside = slice(bar.top - 9, bar.bottom + 9), slice(bar.right + 7, bar.right + 60)
    for part in (1.0, 0.25):
        frame = drawn.render(replace(flow, u=part * flow.u, v=part * flow.v))
        boxes.append(frame[drawn.layout.box.slices].copy().astype(int))
        numbers.append(frame[beside].copy())
    assert np.abs(boxes[0] - boxes[1]).max() <= 4  # limits are rounded up to three digits
    assert not np.array_equal(*numbers)
    fixed = Drawn(scene, make_video(1280, 640, color_by="speed"))
    boxes = [fixed.render(replace(flow, u=part * flow.u, v=part * flow.v)).astype(int) for part in (1.0, 0.25)]
    assert np.abs(boxes[0] - boxes[1])[fixed.layout.box.slices].max() > 50


@pytest.mark.parametrize(("name", "base"), [("cavity_oldroyd_b", 2.0), ("spin_up", 3.0)])
def test_colours_of_the_conformation_trace_begin_at_its_value_at_rest(name, base):
    fluid = "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}"
    scene = scene_of(name, fluid)
    view = scene.movie_view("conformation_trace", 1.0)
    seen = quantity(view, scene, "auto", ((0.0, 5.0), (0.0, 5.0)))  # relative to the base
    assert seen.colour_range == pytest.approx((base, base + 5.0))
    assert seen.profile_range == pytest.approx((base - 0.4, base + 5.4))


def test_given_limits_of_both_signs_have_diverging_colours():
    channel = make_channel()
    colour_map = [shown("u", channel, END, limits).colour_map for limits in ("auto", (0.0, 0.01), (-0.01, 0.01))]
    assert colour_map == [style.COLOUR_MAP, style.COLOUR_MAP, style.DIVERGING_MAP]


# --- walls


@pytest.mark.parametrize("name", ["circular_couette_slip", "couette_slip"])
def test_the_profile_shows_the_velocity_of_walls_along_which_fluid_slips(name):
    scene = scene_of(name)
    profile = scene.movie_view("speed", scene.time_scale).profile
    velocity, places = profile.of_slip_walls(scene.slip_wall_velocity, 0.0)
    walls = {"circular_couette_slip": ([1.0, 0.0], [1.0, 2.0])}.get(name)
    walls = walls or ([float(wall.velocity(0.0)) for wall in scene.pair], [0.0, scene.gap])
    assert (velocity.tolist(), places.tolist()) == walls
    low, high = shown("speed", scene, scene.time_scale).profile_range
    assert low < min(walls[0]) < max(walls[0]) < high
    plain = scene_of("couette")
    assert not len(plain.movie_view("speed", 1.0).profile.of_slip_walls(plain.slip_wall_velocity, 0.0)[0])


def test_a_wall_that_turns_around_the_axis_says_which_way():
    scene = scene_of("taylor_vortices")
    turning = Turning(scene, arrange(scene, 1280, 640))
    assert turning.words(0, 0.0) == "\N{CIRCLED DOT OPERATOR} 1 rad/s"
    backwards = scene_of("taylor_vortices", "walls.inner.angular_velocity=-1.0")
    assert Turning(backwards, arrange(backwards, 1280, 640)).words(0, 0.0) == "\N{CIRCLED TIMES} 1 rad/s"


def test_the_torque_of_taylors_vortices_is_over_the_laminar_one():
    scene = scene_of("taylor_vortices")
    series, torque = scene.movie_series(), scene.laminar_torque
    snapshot = SimpleNamespace(bodies=SimpleNamespace(torque=np.array([-2.0, 3.0]) * torque))
    snapshot.u = snapshot.v = snapshot.w = snapshot.y = snapshot.weight = np.ones(3)
    assert series.measure(snapshot) == pytest.approx([2.0, 3.0])
    assert series.levels == [1.0, 1.0]


# --- words and lines


def test_long_titles_shrink_and_slow_flow_has_no_reynolds_number():
    scene = scene_of("cavity_oldroyd_b")
    drawn = Drawn(
        scene, WIDE, "A polymer solution is stretched beneath a lid that starts within half a relaxation time"
    )
    movie = drawn.movie
    panel = TimePanel(scene, movie._layout, movie._series, 1.0, (0.0, 1.0))
    seen = quantity(movie._view, scene, "auto")
    with style.plot_style():
        figure = build_figure(scene, movie._layout, movie._title, seen, panel, "streamlines")
    texts = {text.get_text(): text for text in figure.axes[0].texts}
    assert movie._title in texts
    assert 15 <= texts[movie._title].get_fontsize() < 20
    assert any(text.startswith("no inertia     Wi = 1") for text in texts)
    assert "streamlines" in texts


def test_a_profile_beyond_the_shown_part_is_drawn():
    channel = make_channel(length=0.1)  # ten heights, of which four are shown; the profile is in the middle
    drawn = Drawn(channel, make_video(1280, 640, style="field"))
    frame = drawn.render(make_snapshot(channel, 1.0))
    inside = frame[drawn.layout.profile.inner.slices].astype(float)
    assert (np.abs(inside - style.rgb(style.PARTICLES)).max(axis=2) < 20).any(axis=1).mean() > 0.9


def test_particles_are_pale_dots_behind_their_profile():
    """A particle beside the curve: its dot is there, paler than the curve."""
    channel = make_channel(initial_state="developed")
    drawn = Drawn(channel, WIDE)
    snapshot = make_snapshot(channel, 1.0)
    u = snapshot.u.copy()
    u[snapshot.y > 0.0095] += 0.002  # a row of particles, which the fits follow only in part
    inside = drawn.render(replace(snapshot, u=u))[drawn.layout.profile.inner.slices].astype(float)
    ink = np.array([255.0, 255.0, 255.0]) - style.rgb(style.PARTICLES)
    cover = ((255.0 - inside) / ink).min(axis=2)
    assert (np.abs(cover - 1.0) < 0.05).any()
    assert (np.abs(cover - 0.35) < 0.03).any()
