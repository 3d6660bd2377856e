"""Pages of the documentation: links, commands, keys, equations and messages that they name exist."""

import importlib
import re
from pathlib import Path

import _command_line
import _formulas
import _gallery as gallery
import _reference as page_of_keys
import pytest
import typer
from shell import pasted

import tisph
from tisph import cli, config, registry
from tisph.config import reference, schema

ROOT = Path(tisph.__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
COMMANDS = {name for name, one in typer.main.get_command(cli.app).commands.items() if not one.hidden}


def anchors(path):
    """Anchors of the headings of a page, as the usual forges make them."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    plain = [re.sub(r"[`*]|\[(.*?)\]\(.*?\)", r"\1", heading).lower() for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading).strip().replace(" ", "-") for heading in plain}


def test_readme_names_every_command():
    named = set(re.findall(r"tisph ([a-z]+)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert named >= COMMANDS


def test_names_in_the_code_are_those_of_the_glossary():
    tables = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").partition("\n## Terms")[0]
    rows = [line.split("|") for line in tables.splitlines() if line.startswith("| ")]
    names = {name for row in rows for name in re.findall(r"`(\w+)`", row[3])}
    code = " ".join(path.read_text(encoding="utf-8") for path in (ROOT / "tisph").rglob("*.py"))
    assert len(names) > 60
    assert names - set(re.findall(r"\w+", code)) == set()


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_commands_in_blocks_exist(path):
    blocks = re.findall(r"^```[a-z]*\n(.*?)^```", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    named = {name for block in blocks for name in re.findall(r"^tisph ([a-z]+)", block, flags=re.MULTILINE)}
    assert named <= COMMANDS


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(path):
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if link.startswith("http"):
            continue
        name, _, anchor = link.partition("#")
        target = (path.parent / name) if name else path
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link
    named = set(re.findall(r"\btest_\w+\.py", text))
    assert named <= {test.name for test in (ROOT / "tests").rglob("test_*.py")}


@pytest.fixture
def media(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "media")
    return importlib.import_module("make")


def test_pictures_have_the_settings_of_today(media):
    assert "\n".join(media.outdated()) == ""


def test_a_picture_with_other_settings_is_named(media, monkeypatch):
    monkeypatch.setitem(media.MOVIES, "cavity", (3.5, ["discretisation.particles_across=32"]))
    (line,) = media.outdated()
    assert "discretisation.particles_across was 64, is 32" in line
    assert line.endswith("Make it again: python media/make.py cavity")


def test_messages_are_those_of_the_program():
    """Words of the messages in the first column of the table, without what changes from case to case."""
    code = " ".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tisph").rglob("*.py")))
    _, table = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8").split("| message | what to do |")
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    parts = [part.strip() for cell in cells for text in re.findall(r"`([^`]+)`", cell) for part in text.split("...")]
    assert len(parts) > 6
    assert [text for text in parts if text not in code] == []


THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))
MODULES = {path.relative_to(ROOT).as_posix() for folder in ("tisph", "tests") for path in (ROOT / folder).rglob("*")}


@pytest.mark.parametrize("path", THEORY, ids=lambda path: path.name)
def test_equations_are_numbered_in_order(path):
    equations = re.findall(r"^\$\$.*\$\$$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    tags = [re.search(r"\\tag\{(\d+)([a-z]?)\}\$\$$", equation) for equation in equations]
    assert all(tags)
    expected, number = [], 0
    for letter in [tag[2] for tag in tags]:
        number += letter in ("", "a")  # 3a, 3b are the parts of one
        expected.append(f"{number}{letter}")
    assert [tag[1] + tag[2] for tag in tags] == expected


def test_formulas_can_be_drawn():
    parser = _formulas.mathtext.MathTextParser("path")
    for path in PAGES:
        for text in _formulas.CODE.split(path.read_text(encoding="utf-8"))[::2]:
            for pattern in (_formulas.DISPLAY, _formulas.INLINE):
                for formula in pattern.findall(text):
                    parser.parse(f"${_formulas.NUMBER.sub('', ' '.join(formula.split()))}$")
                text = pattern.sub("", text)


@pytest.mark.parametrize("path", THEORY, ids=lambda path: path.name)
def test_modules_exist(path):
    named = re.findall(r"`((?:\w+/)*\w+\.py|tisph/[\w/]*\w)/?`", path.read_text(encoding="utf-8"))
    assert [name for name in named if not any(("/" + module).endswith("/" + name) for module in MODULES)] == []


def keys():
    """Names in ``keys.yaml`` of all keys that the models have."""
    for family, model in {"scenes": "Config", **dict.fromkeys(reference.FAMILIES, "Parameters")}.items():
        for name in registry.names(family):
            for key, _ in reference.fields(getattr(registry.load(family, name), model)):
                above = reference.SAME_KEYS.get(family, family)
                yield reference.SIDES.sub(r"\1.SIDE", key) if family == "scenes" else f"{above}/{key}"
    yield from page_of_keys.study_keys()


def test_every_key_has_a_meaning_and_no_other_has():
    assert set(keys()) == set(reference.MEANINGS)
    assert all(re.fullmatch(r".*[a-zA-Z)\d²]\.|.*[.]", meaning) for meaning, *_ in reference.MEANINGS.values())


def test_every_key_of_every_scene_has_a_line():
    page = page_of_keys.keys_page()
    shared, *scenes = re.split(r"^## Scene `(\w+)`$", page, flags=re.MULTILINE)
    parts = dict(zip(scenes[::2], scenes[1::2], strict=True))
    assert list(parts) == registry.names("scenes")
    for name, part in parts.items():
        for key, _ in reference.fields(registry.load("scenes", name).Config):
            assert f"| `{key}` |" in shared + part.partition("\n## ")[0], (name, key)


def test_colours_are_those_that_configs_may_have():
    seen = {}
    for path in sorted((ROOT / "configs").glob("*.yaml")):
        one = config.load(path)
        if one.temperature or one.scalars:  # which may colour movies, too
            continue
        bodies = getattr(one, "bodies", ())
        seen[one.scene, one.fluid.rheology.type, one.axisymmetric, bool(bodies)] = one, bodies
    assert {scene for scene, *_ in seen} == set(registry.names("scenes"))
    for (scene, law, *_), (one, bodies) in seen.items():
        given = {"coordinates": one.coordinates} if scene == "region" else {}
        assert page_of_keys.colours(scene, law, bodies, **given) == schema.colours(one), (scene, law)


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


FLOWS = gallery.flows()
JOBS = {job.name: job for name, flow in FLOWS.items() for job in gallery.jobs(name, flow)}
SUMMARY = {"samples": [{"l2": 1.0e-3, "drag": 2.0, "drag_top": -1.5}, {"l2": 2.0e-5, "drag": 2.02, "drag_exact": 2.0}]}


def test_there_are_twelve_pages_with_two_exercises_each():
    assert len(FLOWS) >= 12
    assert {name: len(flow["try"]) for name, flow in FLOWS.items()} == dict.fromkeys(FLOWS, 2)


@pytest.mark.parametrize("name", JOBS)
def test_settings_of_a_page_are_those_of_a_config(name):
    assert config.load(JOBS[name].config, JOBS[name].settings).name


@pytest.mark.parametrize("name", FLOWS)
def test_each_number_in_a_text_is_asserted(name):
    flow = FLOWS[name]
    texts = [(flow[key], flow["numbers"]) for key in ("question", "story")]
    texts += [(exercise["answer"], exercise["numbers"]) for exercise in flow["try"]]
    for text, bounds in texts:
        used = set(gallery.re.findall(r"<<(\w+)>>", text))
        assert used <= {check["name"] for check in bounds}
        assert all("below" in check or {"equals", "within"} <= set(check) for check in bounds)


@pytest.mark.parametrize("name", FLOWS)
def test_commands_of_a_page_can_be_pasted(name, tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "DRAFT", True)  # no run is needed for its numbers
    monkeypatch.setattr(gallery.Job, "summary", lambda self: {"samples": []})
    lines = re.findall(r"^tisph .*", gallery.page(name, FLOWS[name]), flags=re.MULTILINE)
    commands = pasted(lines, tmp_path)
    shown = [tuple(word for word in words if "=" in word) for words in commands]
    jobs = gallery.jobs(name, FLOWS[name])
    unseen = {*gallery.MOVIE, *gallery.NO_MOVIE}
    assert sorted(shown) == sorted(tuple(text for text in job.settings if text not in unseen) for job in jobs)
    monkeypatch.chdir(ROOT)
    for run, *words in commands:
        assert (run, words[-2]) == ("run", "--out")
        assert config.load(words[0], [word for word in words if "=" in word]).name


def test_the_index_of_a_clone_shows_every_flow():
    """After a change of titles: ``python docs/_gallery.py``."""
    assert (gallery.PANELS / "index.md").read_text(encoding="utf-8") == gallery.clone_index()
    assert {path.name for path in gallery.PANELS.glob("*.jpg")} == {f"{name}-panel.jpg" for name in FLOWS}


def test_a_number_out_of_its_bound_is_named():
    small = {"name": "error", "key": "samples.0.l2", "below": 1.0e-4}
    near = {"name": "drag", "key": "samples.-1.drag", "equals": "samples.-1.drag_exact", "within": 1.0e-3}
    lines = gallery.failures("page", SUMMARY, [small, near])
    assert lines == [
        "gallery page page: error (samples.0.l2) is 0.001, not below 0.0001",
        "gallery page page: drag (samples.-1.drag) is 2.02, not 2 within 0.001",
    ]
    assert gallery.failures("page", SUMMARY, [small | {"below": 2.0e-3}, near | {"within": 0.02}]) == []


def test_texts_show_the_numbers_of_the_run():
    checks = [{"name": "error", "key": "samples.-1.l2"}, {"name": "drag", "key": "samples.-1.drag"}]
    assert gallery.filled("<<error>> and <<drag>>", SUMMARY, checks) == "2.0e-5 and 2.02"
    with pytest.raises(KeyError):
        gallery.filled("<<lift>>", SUMMARY, checks)


def test_a_run_is_made_again_when_its_settings_change():
    job = JOBS["couette"]
    assert gallery.Job(job.name, job.config, (*job.settings, "initial.seed=1")).stamp() != job.stamp()
