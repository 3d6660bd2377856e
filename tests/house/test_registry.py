"""The folders are the menu: a new file is a new member, without a list to edit."""

import sys

import pytest

from tisph import registry


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


def test_names_are_the_files_without_helpers(family):
    assert registry.names("menu") == ["alpha", "beta"]


def test_a_new_file_is_a_new_member(family):
    (family / "gamma.py").write_text('"""Third dish."""\n')
    assert registry.names("menu") == ["alpha", "beta", "gamma"]
    assert registry.summary("menu", "gamma") == "Third dish."


def test_summary_and_constant_do_not_import(family):
    """Importing beta would divide by zero."""
    assert registry.summary("menu", "beta") == "Second dish."
    assert registry.constant("menu", "beta", "SUPPORT") == 2.5
    assert registry.summary("menu", "alpha") == ""


def test_load_imports_only_the_chosen_one(family):
    assert registry.load("menu", "alpha").NAME == "alpha"
    assert f"{family.name}.beta" not in sys.modules


@pytest.mark.parametrize("name", ["delta", "_helper", "../alpha", ""])
def test_what_is_not_on_the_menu(family, name):
    for look in (registry.load, registry.summary):
        with pytest.raises(KeyError, match=r"menu has no member .*; it has alpha, beta"):
            look("menu", name)
    with pytest.raises(KeyError):
        registry.names("no_family")


def test_missing_constant(family):
    with pytest.raises(KeyError, match="SUPPORT"):
        registry.constant("menu", "alpha", "SUPPORT")


@pytest.mark.parametrize("name", list(registry.FAMILIES))
def test_every_member_has_a_summary(name):
    assert [member for member in registry.names(name) if not registry.summary(name, member)] == []


@pytest.mark.parametrize("kernel", registry.names("kernels"))
def test_every_kernel_tells_its_support(kernel):
    assert registry.constant("kernels", kernel, "SUPPORT") > 0
