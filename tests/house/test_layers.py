"""Imports run strictly downwards without any circle, and everything that needs no Taichi works without it.

That no import is hidden from this file, and which file imports Taichi, is checked by ruff (TID in pyproject.toml).
"""

import ast
import functools
import graphlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import tisph

PACKAGE = Path(tisph.__file__).parent

# Each part may import the parts in the levels below its own, and itself. Parts of one level are independent.
LEVELS = [
    ["errors", "events", "formula", "snapshot", "registry", "size_class", "text_table", "version"],
    ["folder"],
    ["config", "exact", "geometry"],
    ["measures", "references"],
    ["bodies"],
    ["suspensions"],
    ["scenes"],
    ["rheometry"],
    ["report"],
    ["runtime"],
    ["numerics", "rheology"],
    ["schemes"],
    ["observers"],
    ["results"],
    ["simulation"],
    ["assessment"],
    ["studies"],
    ["cli"],
    ["__main__"],
    ["interface"],
]
LEVEL_OF = {part: level for level, parts in enumerate(LEVELS) for part in parts}
WITHOUT_TAICHI = ["bodies", "suspensions", "config", "scenes", "exact", "geometry", "measures", "report", "assessment"]
WITHOUT_TAICHI += ["references", "rheometry", "schemes/wcsph/kernels"]
FILES = sorted(PACKAGE.rglob("*.py"))


def module_of(path):
    """Dotted name of the module in the file ``path``."""
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


def part_of(path):
    """Folder or file right below the package that ``path`` belongs to."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


MODULES = {module_of(path): path for path in FILES}
PARTS = {part_of(path) for path in FILES}


@functools.cache
def nodes(path):
    """All syntax nodes of a file."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@functools.cache
def imported_modules(path, types=True):
    """Dotted names of all modules that a file imports, also inside functions; for types alone only with ``types``."""
    checking = [node for node in nodes(path) if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    left_out = set() if types else {below for node in checking for below in ast.walk(node)}
    found = []
    for node in nodes(path):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node not in left_out:
            # `from tisph import config` names its module in the list
            found += [f"{node.module}.{alias.name}" for alias in node.names]
    return found


@functools.cache
def file_graph():
    """Modules of the package that each of its modules imports when it runs, lazily or not."""

    def found(name):
        while name and name not in MODULES:
            name = name.rpartition(".")[0]
        return name

    return {
        module: {found(name) for name in imported_modules(path, types=False)} & MODULES.keys() - {module}
        for module, path in MODULES.items()
    }


def circle(graph):
    """Return the nodes of a circle in a graph of what each node imports, from the first one to the first one."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


def package_of(module):
    """The package that a module belongs to: its folder, however deep."""
    path = MODULES[module]
    return module if path.name == "__init__.py" else module.rpartition(".")[0]


def package_graph(graph):
    """Packages that each package imports; a package and one inside it count as one."""
    found = {}
    for module, imported in graph.items():
        for other in imported:
            one, another = package_of(module), package_of(other)
            if not (f"{one}.".startswith(f"{another}.") or f"{another}.".startswith(f"{one}.")):
                found.setdefault(one, set()).add(another)
    return found


def test_every_part_has_a_level():
    assert PARTS - {"__init__"} - set(LEVEL_OF) == set(), "give it one in LEVELS"


def test_imports_run_downwards():
    upwards = []
    for path in FILES:
        part = part_of(path)
        if part == "__init__":
            continue
        imported = {module.split(".")[1] for module in imported_modules(path) if module.startswith("tisph.")}
        others = imported & PARTS - {part}
        upwards += [f"{path} imports {other}" for other in others if LEVEL_OF[other] >= LEVEL_OF[part]]
    assert upwards == []


@pytest.mark.parametrize("of", [dict, package_graph], ids=["files", "packages"])
def test_nothing_imports_one_another_in_a_circle(of):
    assert circle(of(file_graph())) == []


def test_scenes_and_configs_are_not_any():
    """So that mypy knows what a function asks of a scene, a config or a flow."""
    names = {"scene", "config", "channel", "problem", "case"}
    functions = [(path, node) for path in FILES for node in nodes(path) if isinstance(node, ast.FunctionDef)]
    untyped = [
        f"{path}:{node.lineno}"
        for path, node in functions
        for one in (*node.args.args, *node.args.kwonlyargs)
        if one.arg in names and (one.annotation is None or ast.unparse(one.annotation) == "Any")
    ]
    assert untyped == []


def test_nothing_inside_uses_the_public_names():
    """``tisph/__init__.py`` imports what they stand for on first use, without an import statement."""
    assert [module for module, imported in file_graph().items() if "tisph" in imported] == []


def imports_taichi(program):
    """Whether a Python program of its own imports Taichi; that it runs is asserted."""
    command = [sys.executable, "-c", f"import sys\n{program}\nprint('taichi' in sys.modules)"]
    done = subprocess.run(command, cwd=PACKAGE.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip().splitlines()[-1] == "True"


def modules_without_taichi():
    yield from ("tisph", "tisph.snapshot", "tisph.errors", "tisph.registry", "tisph.schemes.wcsph", "tisph.cli")
    for part in WITHOUT_TAICHI:
        name = f"tisph.{part}".replace("/", ".")
        yield name
        yield from (item.name for item in pkgutil.walk_packages([str(PACKAGE / part)], f"{name}."))


def test_no_taichi_where_none_is_needed():
    assert not imports_taichi(f"import {', '.join(modules_without_taichi())}")


def test_members_of_families_load_without_taichi():
    program = """
from tisph import registry
for family in ("walls", "schemes", "rheology"):
    for name in registry.names(family):
        registry.load(family, name)
"""
    assert not imports_taichi(program)


def test_reading_any_config_imports_no_taichi():
    program = "import glob\nfrom tisph.config import load\nfor path in sorted(glob.glob('configs/*.yaml')): load(path)"
    assert not imports_taichi(program)


CHECKED = {
    "few": ["couette_adami", "couette", "oldroyd_b_couette", "power_law_poiseuille", "ringing_plate"],
    "": ["circular_couette", "cavity", "cylinder_lattice", "turned_box", "shear_layer", "taylor_green"],
}
"""Configs of all scenes, schemes and kinds of fluid; in a channel fewer particles make the same estimate sooner."""


@pytest.mark.parametrize("few", CHECKED)
def test_checking_a_config_imports_no_taichi(few):
    overrides = ["discretisation.particles_across=12"] if few else []
    program = f"""
from tisph.schemes._forecast import described, forecast
from tisph.config import load
for name in {CHECKED[few]}:
    config = load(f"configs/{{name}}.yaml", {overrides})
    numbers, warnings = forecast(config)
    print(*described(config, numbers, warnings), sep="\\n")
"""
    assert not imports_taichi(program)
