"""Families, scenes and schemes have what the written protocols ask for; a new file is a new member."""

import ast
import inspect
import re
import sys
from pathlib import Path

import pytest

from tisph import registry, scenes
from tisph.config import load, schema
from tisph.config.base import Model
from tisph.measures.flow import FlowInBox
from tisph.scenes import _scene
from tisph.schemes import _protocol

CONFIGS = Path(__file__).parents[2] / "configs"
CHOICES = ["auto"]
SCENES = {path.stem: re.search(r"^scene: (\w+)", path.read_text(), re.MULTILINE) for path in CONFIGS.glob("*.yaml")}
EXAMPLES = {scene[1]: name for name, scene in sorted(SCENES.items(), reverse=True)} | {"region": "turned_box"}
"""By each scene: one config of it."""


def public(cls):
    """Names of the public members of a class, those that are only annotated among them."""
    return {name for name in {*vars(cls), *inspect.get_annotations(cls)} if not name.startswith("_")}


def undocumented(cls):
    """Public members of a class in its source that neither have a docstring nor are followed by one."""
    (tree,) = ast.parse(inspect.getsource(cls)).body
    following = dict(zip(tree.body, [*tree.body[1:], None], strict=True))
    for node, after in following.items():
        if isinstance(node, ast.FunctionDef):
            if not ast.get_docstring(node) and not node.name.startswith("_"):
                yield node.name
        elif isinstance(node, ast.Assign | ast.AnnAssign) and not (
            isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        ):
            yield ast.unparse(node)


def arguments(function):
    """Names of the arguments of a function without ``self``; names that begin with _ are given by position only."""
    return [name.lstrip("_") for name in inspect.signature(function).parameters if name != "self"]


PROTOCOLS = [
    FlowInBox,
    _scene.Scene,
    _protocol.Scheme,
    _protocol.SchemeEstimates,
    _protocol.Member,
    _protocol.SchemeMember,
    _protocol.ChoiceMember,
]


@pytest.mark.parametrize("protocol", PROTOCOLS, ids=lambda protocol: protocol.__name__)
def test_protocols_explain_each_member(protocol):
    assert protocol.__doc__
    assert list(undocumented(protocol)) == []


def test_every_scene_has_an_example():
    assert sorted(EXAMPLES) == registry.names("scenes")


@pytest.mark.parametrize("name", EXAMPLES)
def test_scenes_have_what_runs_ask_of_them(name):
    config = load(CONFIGS / f"{EXAMPLES[name]}.yaml")
    scene = scenes.of(config)
    assert isinstance(config, schema.Config)
    assert isinstance(scene, _scene.Scene)
    for member in public(schema.Config) - {"model_config"}:
        getattr(config, member)
    left_out = {"columns", "rows"} if scene.bodies else set()
    left_out |= set() if scene.fields else {"exact"}
    for member in (public(_scene.Scene) | public(FlowInBox)) - left_out:
        getattr(scene, member)  # a property that raises NotImplementedError is missing
        given, asked = getattr(type(scene), member, None), getattr(_scene.Scene, member, None)
        if inspect.isfunction(asked):
            assert given.__doc__ or member not in vars(type(scene)), member
            kinds = {each.kind for each in inspect.signature(asked).parameters.values()}
            if inspect.Parameter.VAR_KEYWORD not in kinds:
                assert arguments(getattr(scene, member)) == arguments(asked), member
            if asked.__code__.co_names[-1:] == ("NotImplementedError",):
                assert given is not asked, f"{member} is missing"


@pytest.mark.parametrize("name", registry.names("schemes"))
def test_modules_of_schemes_have_what_the_program_asks_of_them(name):
    module = registry.load("schemes", name)
    protocol = _protocol.ChoiceMember if name in CHOICES else _protocol.SchemeMember
    assert issubclass(module.Parameters, Model)
    assert module.Parameters.model_fields["type"].default == name
    assert registry.constant("schemes", name, "PERIODIC")
    for member in public(protocol) | public(_protocol.Member):
        given, asked = getattr(module, member), getattr(protocol, member, None)
        if inspect.isfunction(asked):
            assert given.__doc__, member
            assert arguments(given) == arguments(asked), member


@pytest.fixture
def family(tmp_path, monkeypatch):
    """Return a family of two members and a helper, in a package of its own."""
    package = tmp_path / "menu_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text('"""A menu."""\n')
    (package / "beta.py").write_text('"""Second dish.\n\nMore about it.\n"""\n\nSUPPORT = 2.5\nraise_ = 1 / 0\n')
    (package / "alpha.py").write_text("NAME = 'alpha'\n")
    (package / "_helper.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(registry.FAMILIES, "menu", package.name)
    yield package
    for name in [name for name in sys.modules if name.startswith(package.name)]:
        del sys.modules[name]


def test_members_are_the_files_without_helpers_new_ones_too(family):
    assert registry.names("menu") == ["alpha", "beta"]
    (family / "gamma.py").write_text('"""Third dish."""\n')
    assert registry.names("menu") == ["alpha", "beta", "gamma"]
    assert registry.summary("menu", "gamma") == "Third dish."


def test_summary_constant_and_load_import_no_other_member(family):
    """Importing beta would divide by zero."""
    assert registry.summary("menu", "beta") == "Second dish."
    assert registry.constant("menu", "beta", "SUPPORT") == 2.5
    assert registry.summary("menu", "alpha") == ""
    assert registry.load("menu", "alpha").NAME == "alpha"


@pytest.mark.parametrize("name", ["delta", "_helper", "../alpha", ""])
def test_what_is_not_on_the_menu(family, name):
    for look in (registry.load, registry.summary):
        with pytest.raises(KeyError, match=r"menu has no member .*; it has alpha, beta"):
            look("menu", name)
    with pytest.raises(KeyError):
        registry.names("no_family")
    with pytest.raises(KeyError, match="SUPPORT"):
        registry.constant("menu", "alpha", "SUPPORT")


@pytest.mark.parametrize("name", list(registry.FAMILIES))
def test_every_member_has_a_summary(name):
    assert [member for member in registry.names(name) if not registry.summary(name, member)] == []
