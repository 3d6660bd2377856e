"""Taylor-Green vortices as a scene: start, numbers of a sample, history, files and pictures, from the exact flow."""

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from PIL import Image
from report_scene import Drawn, make_video
from vortices import crowded, make_scene, make_snapshot, scaled

from tisph.geometry.wanted_spacing import InBox
from tisph.measures.metrics import sample_metrics
from tisph.observers.history import History, read_history
from tisph.observers.samples import Frames, Samples, read_frames
from tisph.report.labels import error_label
from tisph.report.plots import history_figure
from tisph.simulation.state import start_snapshot, start_values

ROUNDING = 1e-13  # relative, of sums over hundreds of particles of values with 1e-16


def measure(scene, snapshot):
    series = scene.time_series()
    return sample_metrics(scene, snapshot, (series.places, series.measure(snapshot)))


@pytest.mark.parametrize("cells", [(1, 1), (2, 1)])
def test_particles_start_in_the_box_with_the_exact_flow(cells):
    scene = make_scene(cells=cells)
    values = start_values(scene, SimpleNamespace(seed=3, jitter=0.3))
    snapshot = start_snapshot(scene, values, "f64")
    assert len(snapshot.x) == scene.particles == 400 * cells[0]
    assert 0 <= snapshot.x.min() < snapshot.x.max() < cells[0]
    assert 0 <= snapshot.y.min() < snapshot.y.max() < cells[1]
    found = measure(scene, snapshot)
    assert (found["t"], found["l2"], found["l2_pressure"]) == (0.0, 0.0, 0.0)


def test_particles_near_a_finer_disc_fill_the_periodic_box():
    """As many as the scene says, with the exact flow, nearest to one another in the disc."""
    disc = InBox((0.9, 0.5), (0.9, 0.5), 0.0125, 0.1, (1.0, 1.0))
    scene = replace(make_scene(), spacing_sources=(disc,))
    position, velocity, _ = start_values(scene, SimpleNamespace(seed=3, jitter=0.1))
    assert 400 < scene.particles == len(position) < 6400
    assert np.array_equal(velocity[:, 0], scene.exact("u", *position.T, 0.0))
    assert ((position >= 0.0) & (position < 1.0)).all()
    in_disc = np.count_nonzero(disc.distance(position, 0.0) < 0.1)
    # a hundred particles around the disc may each be on either side
    assert in_disc == pytest.approx(np.pi * (0.1 / 0.0125) ** 2, abs=10)


def test_the_exact_flow_has_no_error():
    scene = make_scene(across=40)
    found = measure(scene, make_snapshot(scene, pressure=5.0))
    for name in ("l2", "rms", "linf", "momentum_drift", "density_variation"):
        assert found[name] == 0.0
    assert found["l2_pressure"] < ROUNDING * 100  # an offset of 5 in pressures of 0.5 costs digits
    assert found["kinetic_energy"] == pytest.approx(found["kinetic_energy_exact"], rel=ROUNDING)
    # what the fit of the gradients errs by: (50/40)^4 times 1e-4, and some room for the worst place
    assert found["dissipation"] == pytest.approx(found["dissipation_exact"], rel=1e-3)
    assert found["divergence_over_gradient"] < 1e-3


def test_errors_are_those_of_the_velocity_vector():
    scene = make_scene()
    snapshot = make_snapshot(scene)
    off = replace(snapshot, u=snapshot.u + 0.003, v=snapshot.v - 0.004)
    found = measure(scene, off)
    speeds = np.sqrt(np.mean(snapshot.u**2 + snapshot.v**2))
    assert found["l2"] == pytest.approx(0.005 / speeds, rel=1e-12)  # differences of 5e-3 with 1e-16 of rounding
    assert found["rms"] == pytest.approx(0.005, rel=1e-12)
    assert found["linf"] == pytest.approx(0.005, rel=1e-12)
    assert found["momentum_drift"] == pytest.approx(0.005, rel=1e-12)


def test_energy_does_not_depend_on_where_the_particles_are():
    """A plain mean over 400 places at random would be off by a per cent."""
    scene = make_scene()
    snapshot = make_snapshot(scene, jitter=0.49)
    assert measure(scene, snapshot)["kinetic_energy"] == pytest.approx(0.25 * np.exp(-0.04 * np.pi**2 * 2), rel=1e-12)


def test_norms_and_means_are_integrals_where_particles_crowd():
    """16 times as many particles an area in the corners as in the middle: without weights l2 is off by a fifth."""
    scene = make_scene(across=32)
    snapshot = crowded(scene)
    bump = 1.0 + np.cos(2 * np.pi * snapshot.x)  # of the mean 1 and the mean square 3/2
    found = measure(scene, replace(snapshot, u=snapshot.u + 0.01 * bump, pressure=snapshot.pressure + 0.01 * bump))
    decay = np.exp(-0.04 * np.pi**2 * 2)  # of squares of velocities, and of pressures
    expected = {
        "l2": 0.01 * np.sqrt(1.5 / (0.5 * decay)),
        "rms": 0.01 * np.sqrt(1.5),
        "momentum_drift": 0.01,
        "kinetic_energy": 0.25 * decay + 0.5 * 0.01**2 * 1.5,
        "l2_pressure": 0.01 * np.sqrt(0.5) / (0.5 * decay),
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=ROUNDING)


def test_divergence_is_seen():
    scene = make_scene(across=40)
    snapshot = make_snapshot(scene, t=0.0)
    k = 2 * np.pi
    swelling = replace(snapshot, u=snapshot.u + 0.01 * np.sin(k * snapshot.x))
    # div u = 0.01 k cos kx; the largest gradient is that in the middle of a vortex, of components k and -k
    assert measure(scene, swelling)["divergence_over_gradient"] == pytest.approx(0.01 / np.sqrt(2), rel=0.05)


def test_pressure_error_leaves_out_the_mean():
    scene = make_scene()
    snapshot = make_snapshot(scene)
    found = measure(scene, replace(snapshot, pressure=1.1 * snapshot.pressure + 7.0))
    exact = scene.exact("pressure", snapshot.x, snapshot.y, snapshot.t)
    scatter = np.std(exact) / np.sqrt(np.mean(exact**2))
    assert found["l2_pressure"] == pytest.approx(0.1 * scatter, rel=1e-9)  # digits lost to the offset


def test_profiles_are_of_the_particles_on_the_centre_lines():
    scene = make_scene(cells=(2, 1))
    snapshot = make_snapshot(scene)
    u, v, p = scene.profiles()
    assert [(one.name, one.line.along, one.line.place) for one in (u, v, p)] == [
        ("u", "y", 1.0),
        ("v", "x", 0.5),
        ("p", "y", 1.0),
    ]
    on_line = u.line.particles(snapshot)
    assert 10 <= len(on_line) <= 40
    assert np.abs(snapshot.x[on_line] - 1.0).max() <= 0.5 * scene.spacing
    assert np.all(np.diff(snapshot.y[on_line]) >= 0)
    assert v.line.ends == (0.0, 2.0)
    # what a particle on the line has differs from the curve by (k spacing/2)^2/2 at most
    values, exact = u.of(snapshot)[on_line], u.exact(*u.line.points(snapshot.y[on_line]), snapshot.t)
    assert np.abs(values - exact).max() <= 0.5 * (np.pi * scene.spacing) ** 2


def test_history_of_the_kinetic_energy(tmp_path):
    scene = make_scene()
    path = tmp_path / "history.csv"
    history = History(path, scene, scene.time_series(), 2.0)
    for t in (0.0, 1.0, 2.0):
        history.observe(scaled(make_snapshot(scene, t), 0.99))
    history.close()
    assert path.read_text().splitlines()[0] == "t,kinetic_energy,resolved,kinetic_energy_exact"
    times, values = read_history(path)
    assert times.tolist() == [0.0, 1.0, 2.0]
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    assert np.allclose(values[:, 0], 0.99**2 * table[:, 3], rtol=ROUNDING)
    history_figure(scene, {}, times, values).save(tmp_path / "history.png")
    assert Image.open(tmp_path / "history.png").size == (1320, 720)


def test_samples_have_the_reference_beside_them(tmp_path):
    scene = make_scene()
    snapshot = make_snapshot(scene)
    samples = Samples(tmp_path / "samples.h5", scene, [0.5])
    samples.observe(snapshot)
    samples.close()
    with h5py.File(tmp_path / "samples.h5") as file:
        stored = file["sample_000"]
        for name in ("u", "v", "pressure"):
            assert np.array_equal(stored[f"{name}_exact"], getattr(snapshot, name))


@pytest.mark.parametrize("view", ["speed", "pressure"])
def test_frames_keep_the_pressure_where_it_is_shown(tmp_path, view):
    scene = make_scene()
    movie = SimpleNamespace(add=lambda snapshot: None, close=lambda: None)
    frames = Frames(tmp_path / "frames.h5", movie, [0.5], more=scene.movie_fields(view))
    frames.observe(make_snapshot(scene))
    frames.close()
    (kept,) = read_frames(tmp_path / "frames.h5")
    assert len(kept.pressure) == (scene.particles if view == "pressure" else 0)


def make_renderer(color_by, **changes):
    video = make_video(960, 480, color_by, style="particles")
    return Drawn(make_scene(**changes), video, "vortices", 2.0)


def test_error_in_the_picture_is_that_of_what_is_shown():
    view = {name: make_renderer(name) for name in ("speed", "vorticity", "pressure")}
    snapshot = make_snapshot(view["speed"].scene)
    off = scaled(replace(snapshot, pressure=2.0 * snapshot.pressure), 1.01)
    labels = {name: error_label(renderer.scene, renderer.quantity.error)(off) for name, renderer in view.items()}
    assert labels["speed"] == labels["vorticity"] == "L2 error 1.0×10⁻²"
    assert labels["pressure"].startswith("L2 error of p 1.0×10⁰") or labels["pressure"].startswith("L2 error of p 9.9")
