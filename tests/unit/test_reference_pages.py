"""The generated pages of the reference: each key of a config and each command is there, with what it means."""

import re
import sys
from pathlib import Path

import pytest
import typer

import tisph
from tisph import cli, registry

DOCS = Path(tisph.__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def reference():
    sys.path.insert(0, str(DOCS))
    try:
        import _reference
    finally:
        sys.path.remove(str(DOCS))
    return _reference


def keys(reference):
    """Names in ``_keys.yaml`` of all keys that the models have."""
    for family, model in {"scenes": "Config", **dict.fromkeys(reference.FAMILIES, "Parameters")}.items():
        for name in registry.names(family):
            for key, _ in reference.fields(getattr(registry.load(family, name), model)):
                yield reference.SIDES.sub("walls.SIDE", key) if family == "scenes" else f"{family}/{key}"


def test_every_key_has_a_meaning_and_no_other_has(reference):
    assert set(keys(reference)) == set(reference.MEANINGS)
    assert all(re.fullmatch(r".*[a-zA-Z)\d²]\.|.*[.]", meaning) for meaning, _ in reference.MEANINGS.values())


def test_every_key_of_every_scene_has_a_line(reference):
    page = reference.keys_page()
    shared, *scenes = re.split(r"^## Scene `(\w+)`$", page, flags=re.MULTILINE)
    parts = dict(zip(scenes[::2], scenes[1::2], strict=True))
    assert list(parts) == registry.names("scenes")
    for name, part in parts.items():
        for key, _ in reference.fields(registry.load("scenes", name).Config):
            assert f"| `{key}` |" in shared + part.partition("\n## ")[0], (name, key)


def test_ranges_and_defaults_are_those_of_the_models(reference):
    lines = {line.split(" | ")[0]: line for line in reference.keys_page().splitlines() if line.startswith("| `")}
    assert "number at least 0.8 and at most 3 | `1.0` |" in lines["| `discretisation.smoothing_ratio`"]
    assert "number above 0 and at most 1 or `auto` | `auto` |" in lines["| `time.cfl`"]
    assert "| `f64`, `f32` | `f64` |" in lines["| `discretisation.precision`"]
    assert "mass/length³ | number above 0 |  |" in lines["| `fluid.density`"]


def test_every_command_and_option_has_a_line(reference):
    page = reference.commands_page()
    shown = [(name, one) for name, one in typer.main.get_command(cli.app).commands.items() if not one.hidden]
    for name, command in shown:
        part = page.partition(f"## `tisph {name}`\n")[2].partition("\n## ")[0]
        assert "\ntisph " in part, f"{name}: no example"
        for parameter in command.params:
            option = parameter.opts[0]
            shown = option.startswith("-") and not getattr(parameter, "hidden", False)
            assert not shown or f"`{option}`" in part, (name, option)
