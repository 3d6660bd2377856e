"""Configs of Taylor-Green vortices: derived numbers, the round trip, and bad input in one clear message."""

import pytest
from vortices import GOOD

from tisph import schemes
from tisph.config import load
from tisph.errors import ConfigError


@pytest.fixture
def case(tmp_path, monkeypatch):
    """Return a function that loads the good config with overrides, as if there were a scheme for it."""
    monkeypatch.setattr("tisph.config.checks._scheme", lambda config: iter(()))
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    return lambda *overrides: load(path, overrides)


def test_numbers_of_one_period(case):
    config = case()
    assert (config.particles_across, config.columns, config.rows, config.spacing) == (20, 20, 20, 0.05)
    assert config.extent == (1.0, 1.0)
    assert config.start_time == 0.0


def test_numbers_of_several_periods(case):
    config = case("geometry.cells=[3, 2]", "geometry.length=0.5")
    assert config.extent == (1.5, 1.0)
    assert (config.columns, config.rows, config.spacing) == (60, 40, 0.025)
    by_spacing = case("geometry.cells=[3, 2]", "discretisation={spacing: 0.05}")
    assert (by_spacing.particles_across, by_spacing.columns, by_spacing.rows) == (20, 60, 40)


def test_the_resolved_config_is_equal_and_has_no_sections_of_a_channel(case, tmp_path):
    config = case("geometry.cells=[3, 2]", "output.video.color_by=vorticity")
    path = tmp_path / "config.resolved.yaml"
    path.write_text(config.resolved_yaml())
    assert load(path) == config
    keys = [line.split(":")[0] for line in config.resolved_yaml().splitlines() if not line.startswith((" ", "-"))]
    assert keys == [
        *("name", "scene", "units", "fluid", "geometry", "initial", "discretisation", "scheme", "time", "output"),
        "runtime",
    ]


BAD = [
    ("geometry.cells=[0, 1]", ["geometry.cells.0 = 0: must be at least 1"]),
    ("geometry.cells=[1.5, 1]", ["geometry.cells.0 = 1.5: must be a whole number"]),
    ("geometry.cells=[1]", ["geometry.cells.1: is missing"]),
    ("geometry.cells=2", ["geometry.cells = 2: must be a list"]),
    ("geometry.lenght=2.0", ["geometry.lenght = 2.0: unknown key; nearest: length; allowed: length, cells"]),
    ("geometry.gap=2.0", ["geometry.gap = 2.0: unknown key; allowed: length, cells"]),
    (
        "walls={}",
        ["walls: unknown key; allowed: name, title, scene, units, fluid, geometry, initial, reference, discretisation"],
    ),
    ("initial.velocity=0", ["initial.velocity = 0: must be greater than 0"]),
    ("initial={}", ["initial.velocity: is missing"]),
    ("initial.jitter=0.5", ["initial.jitter = 0.5: must be less than 0.5"]),
    ("initial.state=rest", ["initial.state", "unknown key", "allowed: velocity, jitter, seed"]),
    ("fluid.kinematic_viscosity=0", ["fluid.kinematic_viscosity = 0: must be greater than 0"]),
    (
        "fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}",
        ["fluid.rheology.type", "must be newtonian"],
    ),
    (
        "discretisation={spacing: 0.03}",
        ["must divide the period 1; nearest valid spacing: 0.030303030303 or 0.0294117647059"],
    ),
    ("discretisation.particles_across=9", ["at least 10 particles must fit across the period"]),
    ("discretisation={spacing: 0.2}", ["at least 10 particles must fit across the period (spacing at most 0.1)"]),
    ("geometry.cells=[1000, 1000]", ["makes 4e+08 particles", "at most 20000000 particles are allowed"]),
    ("time.samples=[0.5, 2.5]", ["time.samples.1 = 2.5: must be inside the run, 0 to 2"]),
    (
        "output.video.color_by=conformation_trace",
        ["must be 'speed', 'u', 'v', 'vorticity', 'pressure', 'shear_rate', 'shear_stress',"],
    ),
    ("output.video.color_by=vorticty", ["'error' or 'dye'; nearest: vorticity"]),
]


@pytest.mark.parametrize(("override", "wanted"), BAD, ids=[override[:60] for override, _ in BAD])
def test_bad_input_is_named(case, override, wanted):
    with pytest.raises(ConfigError) as caught:
        case(override)
    text = str(caught.value)
    assert text.startswith("--set ") or "case.yaml:5: discretisation" in text
    assert [part for part in wanted if part not in text] == []
    assert "\n" not in text


def test_a_scheme_that_needs_walls_names_those_that_do_not(tmp_path, monkeypatch):
    boxes = {"wcsph": [(True, False)], "implicit": [(True, True)], "auto": [(True, True)]}
    monkeypatch.setattr("tisph.config.checks._boxes", boxes.get)
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    with pytest.raises(
        ConfigError, match=r'"wcsph": does not support the periodic axes of taylor_green; take auto or implicit'
    ):
        load(path, ["scheme={type: wcsph}"])


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        ("discretisation.particles_across=8", ["particles_across", "at least", "three cells"]),
        ("scheme={type: implicit, operators: {order: 2}}", ["scheme.operators.order", "must be 4"]),
        ("scheme={type: wcsph}|time.tolerance=1e-5", ["time.tolerance", "is for scheme implicit"]),
        ("scheme={type: wcsph}|walls={treatment: {type: adami}}", ["walls: unknown key"]),
        ("scheme={type: wcsph}|discretisation.smoothing_ratio=3", ["at least 28 particles must fit across"]),
        (
            "scheme={type: wcsph}|fluid.rheology={type: oldroyd_b, relaxation_time: 1.0, solvent_fraction: 0.5}",
            ["fluid.rheology.type", "must be newtonian"],
        ),
    ],
)
def test_what_the_scheme_cannot_serve_is_named(tmp_path, override, wanted):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    with pytest.raises(ConfigError) as caught:
        load(path, override.split("|"))
    assert [part for part in wanted if part not in str(caught.value)] == []


@pytest.mark.parametrize(
    ("given", "courant"), [("{accuracy: fast}", 2.0), ("{accuracy: high}", 0.15), ("{accuracy: balanced}", 1.0)]
)
def test_accuracy_sets_the_steps(tmp_path, given, courant):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    config, reason = schemes.resolve(load(path, [f"scheme={given}"]))
    assert config.scheme.largest_courant == courant
    assert f"Courant number {courant:g}" in reason
