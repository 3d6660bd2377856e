"""Open ends in what a user gets of them: samples, exports, movies with tracks, dye and streamlines, plots."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from report_scene import at_start

import tisph
from tisph.observers.samples import Description, Samples, read_samples
from tisph.observers.vtk import has_outlines
from tisph.report.field import Dye
from tisph.report.layout import arrange
from tisph.report.movie import Movie
from tisph.report.overlays import Streamlines, Tracks
from tisph.report.plots import history_figure
from tisph.results.export import export
from tisph.snapshot import Bodies

CASE = """
scene: channel
fluid: {density: 1.0, kinematic_viscosity: 0.05}
geometry: {gap: 1.0, length: 2.0}
ends:
  left: {type: inlet, velocity: 1.0}
  right: {type: outlet}
initial: {state: developed}
discretisation: {particles_across: 12}
time: {end: 1.0}
"""
CIRCLE = "bodies=[{type: circle, centre: [1.0, 0.5], radius: 0.25}]"
MIRRORED = "ends={left: {type: outlet}, right: {type: inlet, velocity: 1.0}}"


@pytest.fixture
def make(tmp_path):
    return at_start(tmp_path, CASE)


def later(scene, snapshot, t, **changes):
    """The ``snapshot`` at time ``t`` with known loads and flow rates; the first two particles have entered anew."""
    passages = snapshot.passages + (np.arange(len(snapshot.x)) < 2)
    bodies = Bodies.at(t, scene.bodies, np.ones((2, len(scene.bodies), 4)))
    known = {"bodies": bodies, "passages": passages, "flow_rates": np.array([1.0, -1.0]), "backflow": 0.1}
    return replace(snapshot, **{"t": t, "step": 1, **known, **changes})


# --- files


def test_samples_keep_passages_flow_rates_and_backflow(make, tmp_path):
    _, scene, start = make()
    samples = Samples(tmp_path / "samples.h5", scene, [0.0, 1.0])
    for snapshot in (start, later(scene, start, 1.0)):
        samples.observe(snapshot)
    samples.close()
    first, last = read_samples(tmp_path / "samples.h5")
    assert (first.passages.dtype.kind, first.passages.any()) == ("i", False)
    assert (first.flow_rates, first.backflow) == (None, None)
    assert (last.passages.sum(), last.flow_rates.tolist(), last.backflow) == (2, [1.0, -1.0], 0.1)


def test_exports_have_passages_and_no_ends(make, tmp_path):
    config, scene, start = make(CIRCLE)
    (tmp_path / "config.resolved.yaml").write_text(config.resolved_yaml())
    samples = Samples(tmp_path / "samples.h5", scene, [0.0, 1.0], about=Description(config, scene))
    for snapshot in (start, later(scene, start, 1.0)):
        samples.observe(snapshot)
    samples.close()
    run = tisph.open(tmp_path)
    assert run.samples[-1]["passages"][:3].tolist() == [1, 1, 0]
    assert np.load(export(run, "npz"))["passages"].sum(axis=1).tolist() == [0, 2]
    assert "passages" in export(run, "csv").read_text().splitlines()[2].split(",")
    assert ":passages:I:1" in export(run, "extxyz").read_text().splitlines()[1]
    with h5py.File(export(run, "vtkhdf")) as file, h5py.File(tmp_path / "samples_bodies.vtkhdf") as bodies:
        assert file["VTKHDF/PointData/passages"][-len(start.x) :].sum() == 2
        assert bodies["VTKHDF/CellData/body"][:].tolist() == [0, 0]  # the circle, at both times
    assert not has_outlines(make()[1])  # without bodies there is no file of them


# --- numbers


@pytest.mark.parametrize(("bodies", "names"), [((), ["inflow", "outflow"]), ((CIRCLE,), ["drag", "lift"])])
def test_a_movie_shows_forces_or_flow_rates_and_needs_no_pressure(make, bodies, names):
    _, scene, start = make(*bodies)
    series, snapshot = scene.movie_series(), later(scene, start, 1.0, pressure=np.empty(0))
    assert list(series.columns) == names
    assert series.measure(snapshot) == pytest.approx([1.0, 1.0])


def test_imbalance_and_backflow_are_relative_to_the_reference(make):
    """That has a velocity of 3 through a width of 0.5."""
    _, scene, start = make("geometry.gap=0.5", "ends.left.velocity=3.0")
    found = scene.diagnostics(later(scene, start, 1.0, flow_rates=np.array([1.0, -0.7])), [])
    assert found["mass_imbalance"] == pytest.approx(0.3 / 1.5, rel=1e-12)
    assert found["backflow"] == pytest.approx(0.1 / 3.0, rel=1e-12)


# --- pictures


@pytest.mark.parametrize("color", ["speed", "v", "vorticity", "pressure", "shear_stress", "dye"])
def test_every_colour_has_its_frame(make, color):
    config, scene, start = make(f"output.video.color_by={color}")
    movie = Movie("", scene, config.output.video, "test", 1.0)
    frames = [movie.frame(snapshot) for snapshot in (start, later(scene, start, 0.5))]
    assert np.any(frames[0] != frames[1])


def test_a_long_channel_is_shown_to_its_outlet(make):
    _, scene, _ = make("geometry.length=7.0")
    assert arrange(scene, 1280, 640).shown_length == 7.0


def test_streamlines_go_from_the_inlet_to_the_outlet(make):
    _, scene, start = make()
    layout = arrange(scene, 640, 320)
    streams = Streamlines(scene, layout)
    lines = streams.lines(streams.measured(start))
    assert len(lines) == 10
    for line in lines:
        assert np.sort(line[[0, -1], 0]) == pytest.approx([0.0, 2.0])
        assert np.ptp(line[:, 1]) < 0.2 * scene.spacing
    s = np.sort([line[:, 1].mean() for line in lines])
    shares = 3.0 * s**2 - 2.0 * s**3  # of the flow below a line
    assert shares == pytest.approx((np.arange(10) + 0.5) / 10, abs=0.02)  # of a mean over 6 particles


def test_a_track_ends_where_its_particle_leaves(make):
    _, scene, _ = make()
    layout = arrange(scene, 1280, 640)
    tracks, panel = Tracks(scene, layout), np.full((layout.box.height, layout.box.width, 3), 255, dtype=np.uint8)
    for t, x, passages in ((0.0, 0.7, 0), (1.0, 0.9, 0), (2.0, 0.1, 1), (3.0, 0.3, 1)):  # no jump over half the box
        panel[:] = 255
        tracks.paint(panel, SimpleNamespace(t=t, x=np.array([x]), y=np.array([0.5]), passages=np.array([passages])))
    columns = np.flatnonzero((panel[:, :, 0] < 100).any(axis=0)) / layout.pixels_per_length
    head = 4.0 * layout.scale / layout.pixels_per_length
    parts = [(low - head < columns) & (columns < high + head) for low, high in ((0.1, 0.3), (0.7, 0.9))]
    assert np.logical_or(*parts).all()
    assert all(part.any() for part in parts)


@pytest.mark.parametrize(("pattern", "bands"), [("stripes", 6), ("checkerboard", 6), ("blob", 3)])
def test_dye_enters_in_bands_and_stays_with_its_particles(make, pattern, bands):
    _, scene, start = make()
    dye = Dye(scene, pattern)
    first = dye.of(start)
    entered = replace(start, x=0.0 * start.x, passages=start.passages + (start.x > 1.0))
    colours = dye.of(entered)
    assert np.array_equal(colours[start.x <= 1.0], first[start.x <= 1.0])
    new = colours[start.x > 1.0][np.argsort(start.y[start.x > 1.0])]
    assert np.count_nonzero(np.diff(new)) == bands - 1
    assert np.array_equal(dye.of(replace(entered, y=1.0 - entered.y)), colours)


def test_a_constant_number_is_not_on_the_edge_of_its_plot(make):
    _, scene, _ = make()
    values = np.ones((20, len(scene.time_series().columns)))
    for axes in history_figure(scene, {}, np.linspace(0.0, 1.0, 20), values).axes:
        assert axes.get_ylim()[1] > 1.03


@pytest.mark.parametrize(
    ("overrides", "known"),
    [
        ((), True),
        ((MIRRORED,), True),
        ((CIRCLE,), False),
        (("initial.state=rest",), False),
        (("ends.left={type: inlet, velocity: 1.0, profile: uniform}",), False),
        (("ends.left={type: inlet, velocity: 1.0, amplitude: 0.5, angular_frequency: 2.0}",), False),
    ],
)
def test_the_profile_has_its_reference_where_poiseuille_flow_is_exact(make, overrides, known):
    _, scene, start = make(*overrides)
    profile, _ = scene.profiles()
    assert (profile.exact is not None) == known
    if known:
        assert profile.exact(1.0, start.y, 0.7) == pytest.approx(start.u)
        assert profile.extremes(0.0, 1.0) == pytest.approx(tuple(sorted((0.0, 1.5 * np.sign(start.u[0])))))
