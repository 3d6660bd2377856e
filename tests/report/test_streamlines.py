"""Streamlines of a movie frame: where the stream function of exact flows says, and none within bodies."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from report_scene import END, Drawn, make_annulus, make_channel, make_snapshot, make_video

from tisph.report.layout import arrange
from tisph.report.overlays import Streamlines
from tisph.simulation.state import start_snapshot, start_values
from tisph.snapshot import Snapshot

ACROSS = 40
BOX = SimpleNamespace(
    extent=(1.0, 1.0), origin=(0.0, 0.0), periodic=(True, True), spacing=1 / ACROSS, reference_velocity=1.0,
    bodies=(), walls=(), axisymmetric=False, seen=lambda snapshot: BOX,
)  # fmt: skip


def lines(scene, snapshot):
    """Return the lines in a frame of ``scene``."""
    return Streamlines(scene, arrange(scene, 640, 320)).lines(snapshot)


def lines_of(u, v):
    """Return the lines in a periodic box of disordered particles with velocities u(x, y), v(x, y)."""
    place = (np.arange(ACROSS**2) % ACROSS, np.arange(ACROSS**2) // ACROSS)
    jitter = np.random.default_rng(0).uniform(-0.2, 0.2, (2, ACROSS**2))
    x, y = (np.array(place) + 0.5 + jitter) / ACROSS
    nothing = np.zeros(ACROSS**2)
    return lines(BOX, Snapshot(0.0, 0, x, y, u(x, y) + nothing, v(x, y) + nothing, nothing, nothing))


def test_as_much_flows_between_any_two_lines_of_vortices():
    wave = 2 * np.pi
    found = lines_of(
        lambda x, y: np.sin(wave * x) * np.cos(wave * y), lambda x, y: -np.cos(wave * x) * np.sin(wave * y)
    )
    psi = [np.sin(wave * line[:, 0]) * np.sin(wave * line[:, 1]) / wave for line in found]
    assert max(np.ptp(each) for each in psi) < 0.01 / wave  # 0.003: means of the nearest, the disorder averaged away
    levels = np.sort([each.mean() for each in psi])
    assert np.abs(levels * wave - np.round(levels * wave / 0.2 - 0.5) * 0.2 - 0.1).max() < 0.02
    assert {round(level * wave / 0.2 - 0.5) for level in levels} == set(range(-5, 5))


@pytest.mark.parametrize(("u", "v"), [(1.0, 0.0), (0.0, -1.0), (1.0, 0.5)])
def test_lines_go_through_a_periodic_box_where_fluid_does(u, v):
    found = lines_of(lambda x, y: u, lambda x, y: v)
    assert len(found) == 10
    for line in found:
        across = (line - line[0]) @ [-v, u]
        assert np.abs(across).max() < 1e-6  # what takes the free constant tilts them by 1e-9 times nodes
        assert np.all((np.abs(line[[0, -1]] - 0.5) > 0.5 - 1e-9).any(axis=1))  # from side to side


@pytest.fixture(scope="module")
def annulus():
    """The scene, and its particles in the steady flow around the inner cylinder."""
    scene = make_annulus()
    snapshot = start_snapshot(scene, start_values(scene, SimpleNamespace(jitter=0.0, seed=0)), "f64")
    radius = np.hypot(snapshot.x, snapshot.y)
    speed = (4.0 / radius - radius) / 3.0
    return scene, replace(snapshot, u=-speed * snapshot.y / radius, v=speed * snapshot.x / radius)


def test_lines_between_cylinders_are_circles_and_none_is_within_a_body(annulus):
    scene, snapshot = annulus
    radii = [np.hypot(*line.T) for line in lines(scene, snapshot)]
    assert max(np.ptp(each) for each in radii) < 0.01  # 0.003, with eight particles across: of second order
    flow = np.sort([(4.0 * np.log(each.mean()) - each.mean() ** 2 / 2.0 + 0.5) / 3.0 for each in radii])
    between = (4.0 * np.log(2.0) - 1.5) / 3.0
    # the extremes are those at nodes, up to half a spacing from a wall: a hundredth of the flow
    assert flow / between == pytest.approx((np.arange(10) + 0.5) / 10, abs=0.02)


def test_streamlines_cover_the_fluid_and_not_the_bodies(annulus):
    scene, snapshot = annulus
    plain, lined = (Drawn(scene, make_video(overlay=each), "", END) for each in ("none", "streamlines"))
    changed = np.any(lined.render(snapshot) != plain.render(snapshot), axis=2)[plain.layout.box.slices]
    rows, columns = np.mgrid[: changed.shape[0], : changed.shape[1]] + 0.5
    radius = np.hypot(columns - changed.shape[1] / 2, rows - changed.shape[0] / 2) / plain.layout.pixels_per_length
    pixel = 1 / plain.layout.pixels_per_length
    assert changed[(radius > 1.05) & (radius < 1.5)].mean() > 0.2
    assert not changed[(radius < 1.0 - 2 * pixel) | (radius > 2.0 + 2 * pixel)].any()


def test_fluid_at_rest_and_a_run_that_went_wrong_have_no_lines():
    channel = make_channel()
    plain, lined = (Drawn(channel, make_video(overlay=each), "", END) for each in ("none", "streamlines"))
    snapshot = make_snapshot(channel, 5.0)
    assert not np.array_equal(lined.render(snapshot), plain.render(snapshot))
    snapshot.u[3] = np.nan
    assert np.array_equal(lined.render(snapshot), plain.render(snapshot))
    assert lines_of(lambda x, y: 1e-6 * np.sin(9 * x), lambda x, y: 0.0) == []
