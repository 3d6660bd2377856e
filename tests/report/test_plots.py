"""Profiles and histories as pictures: axes, lines, legends, and the steady state."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from report_scene import make_channel, make_polymer_channel, make_snapshot

from tisph import scenes
from tisph.config.loader import loaded
from tisph.geometry.motion import WallMotion
from tisph.report.plots import history_figure, profile_figure
from tisph.snapshot import Bodies, Snapshot

PNG_SIZE = (1320, 720)


@pytest.fixture
def figures(monkeypatch):
    """The figures that are saved during the test."""
    saved = []
    save = Figure.savefig

    def remember(self, *arguments, **settings):
        saved.append(self)
        return save(self, *arguments, **settings)

    monkeypatch.setattr(Figure, "savefig", remember)
    return saved


def legend_texts(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def history(channel, count, times):
    y = channel.probe_positions(count)[1]
    return {"count": count}, times, np.array([channel.exact_velocity(y, t) for t in times])


def test_profiles_show_the_interpolated_profile_on_the_exact_curve_and_its_error(tmp_path, figures):
    channel = make_channel(rows=20, initial_state="developed")
    snapshots = [make_snapshot(channel, t, slip=1e-3) for t in (1.8, 20.0)]
    profile_figure(channel, snapshots).save(tmp_path / "profiles.png")
    assert Image.open(tmp_path / "profiles.png").size == PNG_SIZE
    velocity, error = figures[0].axes
    dots, line, curve = velocity.lines[:3]
    u, y = dots.get_data()
    assert np.allclose(u - channel.exact_velocity(y, 1.8), 1e-3 * channel.reference_velocity, rtol=1e-9)
    u, y = line.get_data()
    assert np.array_equal(u, channel.profiles()[0].interpolated(channel, snapshots[0], y))
    # the developed flow is linear, which fits of degree 4 represent up to rounding
    assert np.allclose(u, channel.exact_velocity(y, 1.8) + 1e-3 * channel.reference_velocity, rtol=0, atol=1e-12)
    u, y = curve.get_data()
    assert np.array_equal(u, channel.exact_velocity(y, 1.8))
    assert (y[0], y[-1]) == (0.0, channel.gap)
    for drawn in error.lines[:2]:
        assert np.allclose(drawn.get_xdata(), 1e-3, rtol=1e-7)
    assert legend_texts(figures[0])[0].startswith("t = 1.8 s,  t* = 0.018,  L2 error")


def test_profiles_with_polymer_show_its_stresses_on_their_exact_curves(tmp_path, figures):
    channel = make_polymer_channel()
    snapshots = [make_snapshot(channel, t) for t in (0.5, 5.0)]
    snapshots = [replace(s, stress_xy=s.stress_xy + 1e-5, stress_yy=s.stress_yy + 3e-5) for s in snapshots]
    profile_figure(channel, snapshots).save(tmp_path / "profiles.png")
    assert Image.open(tmp_path / "profiles.png").size == (1320, 1260)
    shear, normal = figures[0].axes[2:]
    for index, t in enumerate((0.5, 5.0)):
        for axes, component, shift in ((shear, 1, 1e-5), (normal, 0, -3e-5)):
            dots, line, curve = axes.lines[3 * index : 3 * index + 3]
            for drawn in (dots, line):
                stress, y = drawn.get_data()
                # Stresses of 4e-4 in doubles: 1e-19 of rounding in each, some hundred times as much in the fits.
                assert np.allclose(stress - channel.exact_polymer_stress(y, t)[component], shift, rtol=0, atol=1e-16)
            stress, y = curve.get_data()
            # their line is as at the particles: the bounds of rounding are the fits' again
            assert np.allclose(stress, channel.exact_polymer_stress(y, t)[component], rtol=0, atol=1e-18)
    assert [axes.get_xlabel().split(" [")[0] for axes in (shear, normal)] == [
        "polymer shear stress Sxy",
        "first normal stress difference N1 = Sxx \N{MINUS SIGN} Syy",
    ]


def test_profiles_meet_the_walls_of_bodies_and_have_gaps_in_them():
    """A velocity that is quadratic in x and y and 0 on the wall of the cylinder, as fits of degree 6 represent it."""
    scene = scenes.of(loaded(LATTICE, {}))
    x, y = (np.ravel(each) for each in np.meshgrid(*2 * [(np.arange(32) + 0.5) / 32]))
    squared = (x - 0.5) ** 2 + (y - 0.5) ** 2
    fluid = squared > 0.25**2
    rest = np.zeros(fluid.sum())
    snapshot = Snapshot(0.0, 0, x[fluid], y[fluid], squared[fluid] - 0.25**2, rest, rest, rest)
    snapshot = replace(snapshot, bodies=Bodies.at(0.0, scene.bodies))
    profile, height = scene.profiles()[0], np.array([0.2, 0.22, 0.25, 0.3, 0.5])
    found = profile.interpolated(scene, snapshot, height)
    assert found[:3] == pytest.approx((height[:3] - 0.5) ** 2 - 0.25**2, abs=1e-12)
    assert np.isnan(found[3:]).all()


def test_history_shows_tracers_on_the_exact_history(tmp_path, figures):
    channel = make_channel()
    settings, times, u = history(channel, 5, np.linspace(0.0, 20.0, 30))
    y = channel.probe_positions(5)[1]
    history_figure(channel, settings, times, u).save(tmp_path / "history.png")
    assert Image.open(tmp_path / "history.png").size == PNG_SIZE
    markers, curve = figures[0].axes[0].lines[:2]
    t, velocity = markers.get_data()
    assert np.array_equal(velocity, channel.exact_velocity(y[-1], t))  # the highest tracer comes first
    t, velocity = curve.get_data()
    assert np.array_equal(velocity, channel.exact_velocity(y[-1], t))
    assert (t[0], t[-1]) == (0.0, 20.0)
    heights = ["y/H = 0.9", "y/H = 0.7", "y/H = 0.5", "y/H = 0.3", "y/H = 0.1"]
    assert legend_texts(figures[0]) == [*heights, "exact", "not resolved"]
    (shaded,) = figures[0].axes[0].patches
    # the layer is two spacings of 1e-3 deep at t = 4; the last of the times before that is 5 * 20 / 29
    assert (shaded.get_x(), shaded.get_x() + shaded.get_width()) == (0.0, pytest.approx(times[5]))


def test_legends_stay_short_and_overlap_no_other_text(tmp_path, figures):
    channel = make_channel(top=WallMotion(-2.5e-4), bottom=WallMotion(1e-4))  # the longer kind of error label
    for many in (30, 12):
        snapshots = [make_snapshot(channel, t) for t in np.linspace(1, 20, many)]
        profile_figure(channel, snapshots).save(tmp_path / "profiles.png")
        history_figure(channel, *history(channel, many, np.linspace(0.0, 20.0, 30))).save(tmp_path / "history.png")
    # twelve of them, "exact", and "not resolved" in the history
    assert [len(legend_texts(figure)) for figure in figures] == [13, 14] * 2
    for figure in figures:
        box = figure.legends[0].get_window_extent()
        assert 0 <= box.x0 < box.x1 <= PNG_SIZE[0]
        assert not any(box.overlaps(axes.get_tightbbox()) for axes in figure.axes)


BOX = {"fluid": {"density": 2.0, "kinematic_viscosity": 0.5}, "time": {"end": 1.0}}
LATTICE = {**BOX, "scene": "lattice", "geometry": {"length": 1.0, "height": 1.0}, "drive": {"acceleration": 1.0}}
LATTICE |= {"bodies": [{"centre": [0.5, 0.5], "radius": 0.25}], "discretisation": {"particles_across": 32}}
CAVITY = {**BOX, "scene": "cavity", "geometry": {"width": 1.0, "height": 1.0}, "walls": {"lid": {"velocity": 1.0}}}


def test_a_body_alone_has_the_drag_that_drives_the_fluid():
    figure = history_figure(scenes.of(loaded(LATTICE, {})), {}, np.linspace(0.0, 1.0, 11), np.zeros((11, 4)))
    level = figure.axes[0].lines[1].get_ydata()[0]
    assert level == pytest.approx(2.0 * (1.0 - np.pi * 0.25**2), rel=1e-9)  # density, acceleration 1, area
    assert [len(axes.lines) for axes in figure.axes[1:]] == [1, 1, 1]


@pytest.mark.parametrize(("start", "shown"), [(0.0, 0.0), (np.inf, 1.0), (50.0, 1.0)])
def test_a_start_that_is_not_resolved_is_shown_unless_it_is_large(start, shown):
    """Numbers from 1 to 2 at resolved times; the axis has a tenth more on both sides."""
    values, resolved = np.array([start, *np.linspace(1.0, 2.0, 10)])[:, None], np.arange(11) > 0
    (axes,) = history_figure(scenes.of(loaded(CAVITY, {})), {}, np.linspace(0.0, 1.0, 11), values, resolved).axes
    margin = 0.1 * (2.0 - shown)
    assert axes.get_ylim() == pytest.approx((shown - margin, 2.0 + margin), rel=1e-12)
