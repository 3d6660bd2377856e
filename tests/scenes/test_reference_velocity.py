"""A config that says its reference velocity: numbers refer to it in every scene, references do not change."""

from pathlib import Path

import pytest

from tisph import registry, scenes
from tisph.config.loader import load, loaded
from tisph.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = {
    "annulus": "circular_couette",
    "cavity": "cavity",
    "channel": "couette",
    "eccentric_annulus": "eccentric_annulus",
    "lattice": "cylinder_lattice",
    "pipe": "pipe",
    "region": "turned_box",
    "shear_layer": "shear_layer",
    "sphere_in_tube": "sphere_in_tube",
    "taylor_couette": "taylor_vortices",
    "taylor_green": "taylor_green",
}
REST = {
    "name": "still",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.1},
    "discretisation": {"particles_across": 20},
    "time": {"end": 0.1},
}
BETWEEN = {"inner_radius": 1.0, "outer_radius": 2.0}
CIRCLE = [{"centre": [1.0, 1.0], "radius": 0.4}]
AT_REST = {
    "annulus": {"geometry": BETWEEN, "walls": {}},
    "channel": {"geometry": {"gap": 1.0, "length": 2.0}},
    "eccentric_annulus": {"geometry": {**BETWEEN, "eccentricity": 0.3}, "walls": {}},
    "lattice": {"geometry": {"length": 2.0, "height": 2.0}, "bodies": CIRCLE},
    "pipe": {"geometry": {"radius": 1.0, "length": 2.0}},
    "region": {"geometry": {"length": 2.0, "height": 2.0}, "bodies": CIRCLE},
    "sphere_in_tube": {"geometry": {"tube_radius": 1.0, "sphere_radius": 0.4, "length": 3.0}},
    "taylor_couette": {"geometry": {**BETWEEN, "length": 2.0}, "walls": {}},
}


def test_every_scene_is_here():
    assert set(SCENES) == set(registry.names("scenes"))


@pytest.mark.parametrize("name", SCENES)
def test_numbers_refer_to_the_given_velocity_and_references_to_the_flow(name):
    path = CONFIGS / f"{SCENES[name]}.yaml"
    own = scenes.of(load(path))
    for factor in (1e-2, 1e2):
        velocity = factor * own.reference_velocity
        scene = scenes.of(load(path, [f"reference.velocity={velocity!r}"]))
        assert scene.reference_velocity == velocity
        assert scene.reynolds == pytest.approx(factor * own.reynolds, rel=1e-12)
        assert scene.peak_velocity >= max(own.peak_velocity, velocity)
        assert f"{velocity:.6g}" in " ".join(text for _, text in scene.parameters())
        assert scene.in_flow_frame().reference_velocity == velocity


@pytest.mark.parametrize("scene", AT_REST)
def test_a_fluid_that_nothing_moves_needs_a_velocity(scene):
    with pytest.raises(ConfigError, match=r"nothing moves: .* or a reference\.velocity"):
        loaded({**REST, "scene": scene, **AT_REST[scene]}, {})
    still = scenes.of(loaded({**REST, "scene": scene, **AT_REST[scene], "reference": {"velocity": 3.0}}, {}))
    assert still.reference_velocity == 3.0
    assert still.time_series(**({"count": 3} if scene == "channel" else {})).columns


@pytest.mark.parametrize("value", ["0", "-1", ".nan", ".inf", "fast", "null"])
def test_a_velocity_is_positive_and_finite(value):
    with pytest.raises(ConfigError, match=r"reference\.velocity"):
        load(CONFIGS / "couette.yaml", [f"reference.velocity={value}"])


def test_the_key_is_in_a_resolved_config_only_where_it_is_given(tmp_path):
    given = load(CONFIGS / "cylinder_lattice.yaml", ["reference.velocity=2"])
    assert "reference" not in load(CONFIGS / "cylinder_lattice.yaml").resolved()
    (tmp_path / "again.yaml").write_text(given.resolved_yaml())
    assert load(tmp_path / "again.yaml", [f"name={given.name}"]) == given
