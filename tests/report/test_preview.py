"""The picture of a config before it runs: each scene has one, with motions, ends, spacing, drive and drawn paths."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.quiver import Quiver
from PIL import Image
from typer.testing import CliRunner

import tisph
from tisph import cli, registry, scenes
from tisph.config import load
from tisph.report import style
from tisph.report.preview import preview

ROOT = Path(__file__).parents[2]
COARSE = "discretisation.particles_across=20"
SHOWN = {
    "annulus": ("circular_couette", ["1 rad/s"]),
    "cavity": ("cavity", ["1 m/s"]),
    "channel": ("couette", ["0.005 m/s"]),
    "eccentric_annulus": ("eccentric_annulus", ["rad/s"]),
    "lattice": ("cylinder_lattice", ["drive 515.3 m/s²"]),
    "pipe": ("pipe", ["drive 4 m/s²"]),
    "region": ("rotating_end", ["turns, 1 rad/s"]),
    "shear_layer": ("shear_layer", []),
    "sphere_in_tube": ("falling_ball", ["free", "force on the sphere 0.5 N"]),
    "taylor_couette": ("taylor_vortices", ["turns, 1 rad/s"]),
    "taylor_green": ("taylor_green", []),
}
"""Scene -> a config, and words in its picture."""


def drawn(name, *changes):
    """Return the figure of a config of ``configs/``."""
    config = load(ROOT / "configs" / f"{name}.yaml", changes)
    return preview(config, scenes.of(config))


def words(figure):
    return [text.get_text() for text in [*figure.texts, *figure.axes[0].texts]]


def arrows(figure):
    """Return the components (n, 2) of all arrows."""
    found = [each for each in figure.axes[0].collections if isinstance(each, Quiver)]
    return np.concatenate([np.stack([each.U, each.V], axis=1) for each in found]) if found else np.empty((0, 2))


def test_every_scene_has_a_config_here():
    assert set(SHOWN) == set(registry.names("scenes"))


@pytest.mark.parametrize("scene", SHOWN)
def test_each_scene_has_a_picture_with_its_motion(scene, tmp_path):
    name, expected = SHOWN[scene]
    figure = drawn(name, COARSE)
    assert [word for word in expected if not any(word in text for text in words(figure))] == []
    figure.save(tmp_path / "a.png")
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
    assert (pixels < 250).any(axis=2).mean() > 0.03  # text alone is a hundredth


def test_a_wall_that_oscillates_has_arrows_both_ways():
    one_way, both = arrows(drawn("couette", COARSE)), arrows(drawn("oscillating_wall_fast", COARSE))
    assert (one_way[:, 0] > 0.0).all()
    assert (both[:, 0] > 0.0).sum() == (both[:, 0] < 0.0).sum() > 0
    assert "±0.5 cm/s" in words(drawn("oscillating_wall_fast", COARSE))


@pytest.mark.parametrize(("name", "unit"), [("stopped_wall", "cm/s"), ("circular_couette_stopped", "rad/s")])
def test_a_wall_that_has_stopped_says_how_it_moved(name, unit):
    assert any(text.endswith(f"{unit} before t = 0") for text in words(drawn(name, COARSE)))


def test_an_inlet_has_its_profile_and_an_outlet_its_name():
    figure = drawn("backward_step", COARSE)
    profile = arrows(figure)[:, 0]
    assert profile.argmax() == pytest.approx(len(profile) / 2, abs=1)
    assert profile.min() < 0.2 * profile.max()
    assert "outlet" in words(figure)
    assert any(text.startswith("inlet, 1.") for text in words(figure))


@pytest.mark.parametrize("most", [0, 100_000])
def test_a_spacing_that_varies_is_seen(monkeypatch, most):
    """As colours of the particles, or shaded where there are too many of them."""
    monkeypatch.setattr("tisph.report.preview.MOST_PARTICLES", most)
    figure = drawn("ellipse_refined")
    assert len(figure.axes) == 2
    low, high = figure.axes[1].get_ylim()
    assert low == pytest.approx(0.005, rel=0.2)
    assert high == pytest.approx(1 / 24, rel=0.01)


def test_heat_at_walls_is_named():
    assert any("temperature" in text for text in words(drawn("convection_rolls", COARSE)))


def test_the_path_of_a_file_is_over_the_shape():
    config = load(ROOT / "docs" / "examples" / "stenosis.yaml", [COARSE])
    axes = preview(config, scenes.of(config)).axes[0]
    (path,) = (line for line in axes.lines if line.get_label() == "path of stenosis.csv")
    assert path.get_color() == style.EXACT
    assert path.get_ydata().min() == pytest.approx(0.6, abs=0.01)


def test_the_command_writes_the_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    config = str(ROOT / "configs" / "couette.yaml")
    done = CliRunner().invoke(cli.app, ["check", config, "--picture"])
    assert done.exit_code == 0
    assert done.output.splitlines()[-1].split() == ["picture", "couette.png"]
    assert CliRunner().invoke(cli.app, ["check", config, "--picture", "own.png"]).exit_code == 0
    assert tisph.check(config).picture("python.png").is_file()
    sizes = {Image.open(name).size for name in ("couette.png", "own.png", "python.png")}
    assert len(sizes) == 1
    refused = CliRunner().invoke(cli.app, ["check", config, "own.png"])
    assert (refused.exit_code, "needs --picture" in refused.stderr) == (2, True)
    assert CliRunner().invoke(cli.app, ["check", config, "--picture", "none/own.png"]).exit_code != 0
