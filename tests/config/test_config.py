"""Configs that are good: defaults, derived numbers, overrides, and the round trip through the resolved YAML."""

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tisph.config import Config, load
from tisph.config.schema import DIVISION_TOLERANCE
from tisph.errors import ConfigError
from tisph.scenes.channel import Channel

CONFIGS = sorted((Path(__file__).parents[2] / "configs").glob("*.yaml"))

MINIMAL = {
    "scene": "channel",
    "fluid": {"density": 1000.0, "dynamic_viscosity": 1e-3},
    "geometry": {"gap": 0.01, "length": 0.02},
    "walls": {"top": {"velocity": 0.005}},
    "time": {"end": 2.7},
}


def write(folder, data):
    path = folder / "case.yaml"
    path.write_text(json.dumps(data))  # JSON is YAML 1.2
    return path


def load_data(folder, *overrides, **changes):
    return load(write(folder, {**MINIMAL, **changes}), overrides)


def test_defaults_of_the_shortest_config(tmp_path):
    config = load_data(tmp_path)
    assert (config.name, config.walls.treatment.type, config.walls.bottom.velocity) == ("case", "consistent_image", 0.0)
    assert (config.fluid.rheology.type, config.scheme.type, config.scheme.accuracy) == ("newtonian", "auto", "balanced")
    assert (config.particles_across, config.time.samples, config.start_time) == (50, (2.7,), 0.0)


def test_either_viscosity(tmp_path):
    # nu = mu / rho holds to rounding: 1e-3 / 1000 and its inverse
    dynamic = load_data(tmp_path)
    kinematic = load_data(tmp_path, fluid={"density": 1000.0, "kinematic_viscosity": 1e-6})
    assert dynamic.kinematic_viscosity == pytest.approx(1e-6, rel=1e-15)
    assert kinematic.dynamic_viscosity == pytest.approx(1e-3, rel=1e-15)


def test_either_resolution(tmp_path):
    across = load_data(tmp_path, discretisation={"particles_across": 40})
    spacing = load_data(tmp_path, discretisation={"spacing": 0.00025})
    for config in (across, spacing):
        assert (config.particles_across, config.columns) == (40, 80)
    assert across.spacing == spacing.spacing  # the same bits: both are gap / 40


def test_overrides_win_in_turn_key_by_key(tmp_path):
    config = load_data(tmp_path, "time.end=5", "time.end=7", "output.video=false", "walls.treatment={type: adami}")
    assert (config.time.end, config.output.video, config.walls.treatment.type) == (7.0, None, "adami")
    config = load_data(tmp_path, "discretisation.precision=f32", "output.video.fps=10", "output.checkpoint_every=0.5")
    assert (config.particles_across, config.discretisation.precision) == (50, "f32")
    assert (config.output.video.fps, config.output.video.frames) == (10, 120)


@pytest.mark.parametrize(
    ("stem", "name"),
    [("my case", "my_case"), ("...", "run"), ("12", "12"), ("Strömung", "Strömung"), ("O\u0308l", "Öl")],
)
def test_default_name_is_a_folder_name(tmp_path, stem, name):
    path = tmp_path / f"{stem}.yaml"
    path.write_text(json.dumps(MINIMAL))
    assert load(path).name == load(path, [f'name="{name}"']).name == name


def test_configs_are_frozen(tmp_path):
    with pytest.raises(ValueError, match="frozen"):
        load_data(tmp_path).time.end = 3.0


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_shipped_configs_load_and_resolve(tmp_path, path):
    config = load(path)
    assert config.name == path.stem
    resolved = tmp_path / "config.resolved.yaml"
    resolved.write_text(config.resolved_yaml())
    assert load(resolved) == config


def test_the_couette_configs_describe_one_flow():
    """The page's case in kg-cm-s and couette.yaml in SI have the same Reynolds number and lattice."""
    si, cgs = (load(path) for path in CONFIGS if path.stem in ("couette", "vm_sph_001_re50"))
    reynolds = [Channel.from_config(config).reynolds for config in (si, cgs)]
    assert reynolds == pytest.approx([50, 50], rel=1e-14)  # a few roundings
    assert (si.particles_across, si.columns) == (cgs.particles_across, cgs.columns)


same_folder = settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
names = st.from_regex(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,20}[A-Za-z0-9_-]", fullmatch=True)


@same_folder
@given(names, st.floats(1e-6, 1e6), st.floats(-1e3, 1e3))
def test_round_trip_of_any_name_and_number_through_resolved_yaml(tmp_path, name, density, speed):
    """Those of other keys are in tests/config/test_every_key.py."""
    walls, fluid = {**MINIMAL["walls"], "bottom": {"velocity": speed}}, {"density": density, "dynamic_viscosity": 1e-3}
    config = load_data(tmp_path, name=name, fluid=fluid, walls=walls)
    resolved = tmp_path / "config.resolved.yaml"
    resolved.write_text(config.resolved_yaml())
    again = load(resolved)
    assert (again, again.resolved_yaml()) == (config, config.resolved_yaml())


def outcome(path, *overrides):
    """Return the config, or the message of the ConfigError."""
    try:
        return load(path, overrides)
    except ConfigError as error:
        return str(error)


@same_folder
@given(st.integers(6, 400), st.floats(0.2, 20), st.floats(1e-3, 1e3))
def test_every_suggested_length_is_accepted(tmp_path, rows, aspect, gap):
    """Where gap and length share no spacing, what the message names makes whole columns, at about that resolution."""
    data = {**MINIMAL, "geometry": {"gap": gap, "length": aspect * gap}, "discretisation": {"particles_across": rows}}
    _, _, text = str(outcome(write(tmp_path, data))).partition("nearest valid geometry.length: ")
    lengths, _, others = text.partition("; nearest valid particles_across: ")
    for length in lengths.split(" or ") if lengths else ():
        geometry = {"gap": gap, "length": float(length)}
        assert isinstance(outcome(write(tmp_path, {**data, "geometry": geometry})), Config) or rows < 10
    for other in map(int, others.split(" or ") if others else ()):
        assert rows / 2 <= other <= 2 * rows
        data["discretisation"]["particles_across"] = other
        assert "no whole number" not in str(outcome(write(tmp_path, data)))


@same_folder
@given(st.integers(10, 200), st.floats(0.001, 0.999), st.floats(1e-3, 1e3))
def test_every_suggested_spacing_is_accepted(tmp_path, rows, fraction, gap):
    """The length is ten gaps, so that each spacing that divides the gap will do."""
    geometry = {"gap": gap, "length": 10 * gap}
    bad = {**MINIMAL, "geometry": geometry, "discretisation": {"spacing": gap / (rows + fraction)}}
    _, _, spacings = str(outcome(write(tmp_path, bad))).partition("nearest valid spacing: ")
    found = [
        load_data(tmp_path, geometry=geometry, discretisation={"spacing": float(s)}) for s in spacings.split(" or ")
    ]
    assert [config.particles_across for config in found] == [rows, rows + 1]


@same_folder
@given(st.integers(6, 200), st.integers(1, 40), st.floats(0.1, 10))
def test_division_has_a_tolerance_for_decimal_rounding(tmp_path, rows, thousandths, gap):
    """A spacing typed with ten digits divides; one off by a thousandth and more does not."""
    geometry = {"gap": gap, "length": 10 * gap}
    typed = {"spacing": float(f"{gap / rows:.11g}")}
    assert load_data(tmp_path, geometry=geometry, discretisation=typed).particles_across == rows
    off = {"spacing": gap / (rows * (1 + thousandths * 1e-3 / rows))}
    assert 1e-3 / rows > DIVISION_TOLERANCE
    with pytest.raises(ConfigError, match="must divide the gap"):
        load_data(tmp_path, geometry=geometry, discretisation=off)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ({"accuracy": "fast"}, "auto"),
        ({"largest_strain": 0.3}, "implicit"),
        ({"operators": {"order": 2}}, "implicit"),
        ({"operators": "standard"}, "wcsph"),  # this and what follows as it has always been
        ({"equation_of_state": {"gamma": 1}}, "wcsph"),
        ({"artificial_viscosity": 0.1}, "wcsph"),
        ({}, "wcsph"),
    ],
)
def test_the_keys_of_a_scheme_decide_its_type(tmp_path, given, wanted):
    config = load_data(tmp_path, scheme=given, walls={"treatment": {}, "top": {"velocity": 0.005}})
    scheme = config.scheme
    assert (scheme.type, config.walls.treatment.type) == (wanted, "consistent_image")
    for key, value in given.items():
        assert getattr(scheme, key) == value or isinstance(value, dict)


@pytest.mark.parametrize("key", ["probes", "tracers"])
def test_probes_may_be_called_by_their_former_name(tmp_path, key):
    config = load_data(tmp_path, f"{key}.x=0.01", **{key: {"count": 5}})
    assert (config.probes.count, config.probes.x) == (5, 0.01)
    assert config.resolved()["tracers"] == {"count": 5, "x": 0.01}  # older versions read it
    assert type(config).model_validate(config.resolved()) == config
