"""The double shear layer: a start that is divergence-free and smooth, and numbers and pictures without a reference."""

from types import SimpleNamespace

import numpy as np
import pytest
from flows import flow_text
from PIL import Image

from tisph.config import load
from tisph.measures.metrics import sample_metrics
from tisph.observers.history import History, read_history
from tisph.observers.samples import Samples, read_samples
from tisph.report.plots import history_figure, profile_figure
from tisph.scenes.shear_layer import Scene
from tisph.simulation.state import start_snapshot, start_values

GOOD = flow_text("shear_layers")


@pytest.fixture
def case(tmp_path, monkeypatch):
    """Return a function that loads the good config with overrides, as if there were a scheme for it."""
    monkeypatch.setattr("tisph.config.schema._scheme", lambda config: iter(()))
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    return lambda *overrides: load(path, overrides)


@pytest.fixture
def scene(case):
    return Scene.from_config(case())


@pytest.fixture
def start(scene):
    return start_snapshot(scene, start_values(scene, SimpleNamespace(seed=0, jitter=0.2)), "f64")


def test_the_start_is_divergence_free_and_smooth_across_the_edges(scene):
    """u depends on y alone and v on x alone; where the two halves meet, values agree and slopes are next to nothing."""
    x, y = np.meshgrid(np.linspace(0.0, 2.0, 7), np.linspace(0.0, 2.0, 9))
    fields = scene.initial(x, y)
    assert np.all(fields["u"] == fields["u"][:, :1])
    assert np.all(fields["v"] == fields["v"][:1])
    step = 1e-6
    ends = scene.initial(0.0, np.array([0.0, step, 2.0 - step, 2.0, 1.0 - step, 1.0, 1.0 + step]))["u"]
    assert ends[0] == ends[3]
    assert ends[1] == pytest.approx(ends[2], rel=1e-12)
    assert ends[4] == pytest.approx(ends[6], rel=1e-12)
    slopes = np.abs(np.diff(ends)[[0, 2, 4, 5]]) / step
    assert slopes.max() < 1e-4 * scene.speed / scene.thickness  # 4 exp(-2 L/(4 d)) = 1.5e-5, with room for rounding


def test_numbers_of_the_start(scene, start):
    found = sample_metrics(scene, start, None)
    assert (found["l2"], found["rms"], found["linf"]) == (None, None, None)
    assert (found["t_star"], found["resolved"]) == (0.0, True)
    # mean of tanh^2 over a stream of width L/2 is 1 - 4 d/L, of the perturbation e^2/2; 3600 places at random
    expected = 0.5 * 0.5**2 * (1 - 4 * 0.08 / 2.0 + 0.05**2 / 2)
    assert found["kinetic_energy"] == pytest.approx(expected, rel=5e-3)
    # mean of sech^4 is 8 d/(3 L) of (U/d)^2, and of the cosine; 2.4 spacings in a layer resolve it to some per cent
    square = (0.5 / 0.08) ** 2 * 8 * 0.08 / (3 * 2.0) + 0.5 * (0.05 * 0.5 * np.pi) ** 2
    assert found["dissipation"] == pytest.approx(1e-3 * square, rel=0.05)
    assert found["divergence_over_gradient"] < 0.05
    assert abs(found["mean_u"]) < 0.01 * scene.speed
    assert 0.5 < found["min_distance"] == found["nearest_two"] < 1.0
    assert 0.7 < found["max_void_radius"] == found["largest_hole"] < 1.0


def test_thin_layers_are_not_resolved(case):
    scene = Scene.from_config(case("initial.thickness=0.05"))
    start = start_snapshot(scene, start_values(scene, SimpleNamespace(seed=0, jitter=0.0)), "f64")
    found = sample_metrics(scene, start, None)
    assert found["reason"].startswith("the shear layer of the start is 1.5 spacings thin")


def test_files_and_pictures_do_without_a_reference(scene, start, tmp_path):
    history = History(tmp_path / "history.csv", scene, scene.time_series(), 4.0)
    history.observe(start)
    history.close()
    assert (tmp_path / "history.csv").read_text().splitlines()[0] == "t,kinetic_energy,resolved"
    history_figure(scene, {}, *read_history(tmp_path / "history.csv")).save(tmp_path / "history.png")
    samples = Samples(tmp_path / "samples.h5", scene, [0.0])
    samples.observe(start)
    samples.close()
    profile_figure(scene, read_samples(tmp_path / "samples.h5")).save(tmp_path / "profiles.png")
    assert Image.open(tmp_path / "profiles.png").size == (1320, 720)
