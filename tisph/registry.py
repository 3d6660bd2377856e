"""The menu of choices: one package a family, one module a member, listed from the folders.

A module whose name starts with an underscore is a helper, not a member. A member is imported, and compiled, only for
a config that names it.
"""

import ast
import functools
import importlib
import importlib.util
import pkgutil
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

FAMILIES = {
    "scenes": "tisph.scenes",
    "walls": "tisph.schemes.wcsph.walls",
    "schemes": "tisph.schemes",
    "rheology": "tisph.rheology",
    "bodies": "tisph.bodies",
    "suspensions": "tisph.suspensions",
    "kernels": "tisph.schemes.wcsph.kernels",
    "operators": "tisph.schemes.wcsph.operators",
    "exact": "tisph.exact",
}


def names(family: str) -> list[str]:
    """Return the sorted member names of ``family``; KeyError for an unknown family. Imports no member."""
    folders = [str(folder) for folder in _folders(family)]
    return sorted(item.name for item in pkgutil.iter_modules(folders) if not item.name.startswith("_"))


def modules(family: str) -> list[str]:
    """Return the dotted names of the modules of all members of ``family``; KeyError for an unknown family."""
    return [f"{FAMILIES[family]}.{name}" for name in names(family)]


def load(family: str, name: str) -> ModuleType:
    """Import one member (this may import Taichi); KeyError where ``names(family)`` does not have it."""
    module = f"{FAMILIES[family]}.{name}"
    if module not in sys.modules or name.startswith("_"):
        _member_file(family, name)
    return importlib.import_module(module)


def compiled(family: str, name: str) -> ModuleType:
    """Import the kernels of a member, the module ``_NAME`` beside it. The member itself needs no Taichi."""
    _member_file(family, name)
    return importlib.import_module(f"{FAMILIES[family]}._{name}")


def summary(family: str, name: str) -> str:
    """Return the first line of the member's docstring, empty without one; read without importing it."""
    docstring = ast.get_docstring(_syntax_tree(family, name)) or ""
    return docstring.partition("\n")[0]


def constant(family: str, name: str, attribute: str) -> Any:
    """Return the value of a module-level literal ``attribute = ...`` of a member, read without importing it.

    KeyError where the member has no such literal.
    """
    for statement in _syntax_tree(family, name).body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == attribute:
            return ast.literal_eval(statement.value)
    raise KeyError(f"{FAMILIES[family]}.{name} has no literal {attribute}")


def _syntax_tree(family: str, name: str) -> ast.Module:
    return _parsed(_member_file(family, name).read_text(encoding="utf-8"))


_parsed = functools.cache(ast.parse)


def _member_file(family: str, name: str) -> Path:
    """Return the source file of a member: a module, or the ``__init__`` of a package."""
    if name not in names(family):
        raise KeyError(f"{family} has no member {name!r}; it has {', '.join(names(family))}")
    candidates = [
        path for folder in _folders(family) for path in (folder / f"{name}.py", folder / name / "__init__.py")
    ]
    return next(path for path in candidates if path.is_file())


def _folders(family: str) -> list[Path]:
    specification = importlib.util.find_spec(FAMILIES[family])
    places = specification.submodule_search_locations if specification else None
    return [Path(folder) for folder in places or ()]
