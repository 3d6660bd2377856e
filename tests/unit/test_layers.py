"""Imports run strictly downwards, and everything that needs no Taichi works without it."""

import ast
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import tisph

PACKAGE = Path(tisph.__file__).parent

# Each part may import the parts in the levels below its own, and itself. Parts of one level are independent.
LEVELS = [
    ["endings", "errors", "folder", "snapshot", "registry"],
    ["config", "exact", "geometry"],
    ["equation_of_state", "verification"],
    ["bodies"],
    ["scenes"],
    ["report"],
    ["runtime"],
    ["liquid", "particles", "periodic"],
    ["domain"],
    ["neighbours"],
    ["operators", "kernels", "least_squares"],
    ["walls", "rheology"],
    ["schemes"],
    ["observers"],
    ["simulation"],
    ["study", "assessment"],
    ["results"],
    ["cli"],
    ["__main__"],
    ["interface"],
]
LEVEL_OF = {part: level for level, parts in enumerate(LEVELS) for part in parts}
WITHOUT_TAICHI = ["bodies", "config", "scenes", "exact", "geometry", "verification", "report", "assessment"]
FILES = sorted(PACKAGE.rglob("*.py"))


def part_of(path):
    relative = path.relative_to(PACKAGE)
    return relative.parts[0].removesuffix(".py")


PARTS = {part_of(path) for path in FILES}


def imported_modules(path):
    """Dotted names of all modules that a file imports, also inside functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            # `from tisph import config` names its module in the list
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_run_downwards(path):
    part = part_of(path)
    if part == "__init__":
        return
    assert part in LEVEL_OF, f"{part} has no level yet: give it one in LEVELS"
    for module in imported_modules(path):
        package, _, below = module.partition(".")
        other = below.partition(".")[0]
        if package == "tisph" and other in PARTS - {part}:
            assert LEVEL_OF[other] < LEVEL_OF[part], f"{part} imports {module}"


def test_taichi_is_imported_in_one_place():
    importers = {
        part_of(path) for path in FILES for module in imported_modules(path) if module.split(".")[0] == "taichi"
    }
    assert importers <= {"runtime"}


def test_kernel_files_do_not_postpone_annotations():
    """Taichi reads the annotations of kernels; as strings they mean nothing to it."""
    bad = [path for path in FILES if "runtime" in path.read_text() and "__future__" in path.read_text()]
    assert bad == []


def modules_without_taichi():
    yield from ("tisph", "tisph.snapshot", "tisph.errors", "tisph.registry", "tisph.equation_of_state", "tisph.cli")
    for part in WITHOUT_TAICHI:
        yield f"tisph.{part}"
        yield from (item.name for item in pkgutil.walk_packages([str(PACKAGE / part)], f"tisph.{part}."))


def test_no_taichi_where_none_is_needed():
    modules = list(modules_without_taichi())
    program = f"import sys\nimport {', '.join(modules)}\nsys.exit('taichi' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], cwd=PACKAGE.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
