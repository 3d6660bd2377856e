"""Configs of Taylor-Green vortices: derived numbers, the round trip, and bad input in one clear message."""

import pytest
from vortices import GOOD

from tisph import schemes
from tisph.config import load
from tisph.errors import ConfigError


@pytest.fixture
def case(tmp_path, monkeypatch):
    """Return a function that loads the good config with overrides, as if there were a scheme for it."""
    monkeypatch.setattr("tisph.config.schema._scheme", lambda config: iter(()))
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


def test_a_scheme_that_needs_walls_names_those_that_do_not(tmp_path, monkeypatch):
    boxes = {"wcsph": [(True, False)], "implicit": [(True, True)], "auto": [(True, True)]}
    monkeypatch.setattr("tisph.config.schema._boxes", boxes.get)
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    with pytest.raises(
        ConfigError, match=r'"wcsph": does not support the periodic axes of taylor_green; take auto or implicit'
    ):
        load(path, ["scheme={type: wcsph}"])


@pytest.mark.parametrize(
    ("given", "courant"), [("{accuracy: fast}", 2.0), ("{accuracy: high}", 0.15), ("{accuracy: balanced}", 1.0)]
)
def test_accuracy_sets_the_steps(tmp_path, given, courant):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD)
    config, reason = schemes.resolve(load(path, [f"scheme={given}"]))
    assert config.scheme.largest_courant == courant
    assert f"Courant number {courant:g}" in reason
