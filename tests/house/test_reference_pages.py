"""The generated pages of the reference: each key of a config and each command is there, with what it means."""

import re
from pathlib import Path

import _command_line
import _reference as reference
import typer

import tisph
from tisph import cli, config, registry
from tisph.config import checks

DOCS = Path(tisph.__file__).parents[1] / "docs"
CONFIGS = DOCS.parent / "configs"


def keys():
    """Names in ``_keys.yaml`` of all keys that the models have."""
    for family, model in {"scenes": "Config", **dict.fromkeys(reference.FAMILIES, "Parameters")}.items():
        for name in registry.names(family):
            for key, _ in reference.fields(getattr(registry.load(family, name), model)):
                above = reference.SAME_KEYS.get(family, family)
                yield reference.SIDES.sub("walls.SIDE", key) if family == "scenes" else f"{above}/{key}"
    yield from reference.study_keys()


def test_every_key_has_a_meaning_and_no_other_has():
    assert set(keys()) == set(reference.MEANINGS)
    assert all(re.fullmatch(r".*[a-zA-Z)\d²]\.|.*[.]", meaning) for meaning, *_ in reference.MEANINGS.values())


def test_every_key_of_every_scene_has_a_line():
    page = reference.keys_page()
    shared, *scenes = re.split(r"^## Scene `(\w+)`$", page, flags=re.MULTILINE)
    parts = dict(zip(scenes[::2], scenes[1::2], strict=True))
    assert list(parts) == registry.names("scenes")
    for name, part in parts.items():
        for key, _ in reference.fields(registry.load("scenes", name).Config):
            assert f"| `{key}` |" in shared + part.partition("\n## ")[0], (name, key)


def test_ranges_and_defaults_are_those_of_the_models():
    lines = {line.split(" | ")[0]: line for line in reference.keys_page().splitlines() if line.startswith("| `")}
    assert "number at least 0.8 and at most 3 | `1.0` |" in lines["| `discretisation.smoothing_ratio`"]
    assert "number above 0 and at most 1 or `auto` | `auto` |" in lines["| `time.cfl`"]
    assert "| `f64`, `f32` | `f64` |" in lines["| `discretisation.precision`"]
    assert "mass/length³ | number above 0 |  |" in lines["| `fluid.density`"]


def lines_of(text):
    """Lines of the tables in a text, by their keys."""
    return {line.split("`")[1]: line for line in text.splitlines() if line.startswith("| `")}


def test_defaults_in_words_are_what_the_program_fills_in():
    lines = lines_of(reference.keys_page().partition("\n## Scene `cavity`")[0])
    plain = config.load(CONFIGS / "couette_minimal.yaml", ["scheme.type=wcsph"])
    across = plain.discretisation.particles_across
    assert f"| `{across}`, without a spacing |" in lines["discretisation.particles_across"]
    assert plain.time.samples == (plain.time.end,)
    assert lines["time.samples"].endswith("| the end |")
    assert plain.name == "couette_minimal"
    assert lines["name"].endswith("| name of the file |")
    sound = plain.scheme.equation_of_state.sound_speed
    assert f"| `{sound}`, without" in lines_of(reference.keys_page())["equation_of_state.sound_speed"]
    words = '{"amplitude": 1.0, "angular_frequency": 1.0}'
    swinging = config.load(CONFIGS / "couette_minimal.yaml", [f"walls.top={words}"])
    assert f"| `{swinging.walls.top.phase}`, with an amplitude |" in lines["walls.inner.phase"]


def test_colours_are_those_that_configs_may_have():
    seen = {}
    for path in sorted(CONFIGS.glob("*.yaml")):
        one = config.load(path)
        bodies = getattr(one, "bodies", ())
        seen[one.scene, one.fluid.rheology.type, one.axisymmetric, bool(bodies)] = one, bodies
    assert {scene for scene, *_ in seen} == set(registry.names("scenes"))
    for (scene, law, *_), (one, bodies) in seen.items():
        given = {"coordinates": one.coordinates} if scene == "region" else {}
        assert reference.colours(scene, law, bodies, **given) == checks.colours(one), (scene, law)


def test_page_names_the_colours_of_each_scene():
    for scene in registry.names("scenes"):
        text, laws = reference.about(scene), registry.names("rheology")
        for name in {name for law in laws for name in reference.colours(scene, law, bodies=(None,))}:
            assert f"`{name}`" in text, (scene, name)


def test_modes_are_polymers_with_a_fraction():
    page = reference.keys_page().partition("### `multi_mode`")[2].partition("\n### ")[0]
    lines = lines_of(page)
    assert re.findall(r"`(\w+)`", lines["modes"].partition("`type`:")[2]) == [
        name for name in registry.names("rheology") if hasattr(registry.load("rheology", name), "Mode")
    ]
    assert "number above 0 and at most 1" in lines["modes.fraction"]


def test_keys_that_take_a_name_list_all_names():
    lines = lines_of(reference.keys_page())
    for key, family in {"scene": "scenes", "discretisation.kernel": "kernels"}.items():
        assert f"| {reference.code(registry.names(family))} |" in lines[key]
    for family in reference.WITHOUT_KEYS:
        assert all(f"- `{name}`: " in reference.keys_page() for name in registry.names(family))


def test_every_command_and_option_has_a_line():
    page = _command_line.commands_page()
    shown = [(name, one) for name, one in typer.main.get_command(cli.app).commands.items() if not one.hidden]
    for name, command in shown:
        part = page.partition(f"## `tisph {name}`\n")[2].partition("\n## ")[0]
        assert "\ntisph " in part, f"{name}: no example"
        for parameter in command.params:
            option = parameter.opts[0]
            shown = option.startswith("-") and not getattr(parameter, "hidden", False)
            assert not shown or f"`{option}`" in part, (name, option)
