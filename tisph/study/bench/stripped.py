"""A copy of the program without the code of its optional parts: what a scene that uses none of them has to cost.

Such code stands behind ``if ti.static(flag):``. Where the program with it and the program without it compile to the
same kernels, to the last instruction, a scene cannot pay for it.
"""

import ast
import os
import shutil
import tempfile
from collections import Counter
from pathlib import Path

import tisph

WHOLE, STRIPPED = "whole", "stripped"
"""Names of the folders of the two copies."""


def copy_twice(folder, flags):
    """Put a copy of the package into ``folder``/whole, and one without what ``flags`` compile in into /stripped.

    ``flags`` are names of attributes. Measuring takes minutes, in which the program itself may be edited: its copies
    stay what they are. Returns how many branches each flag had.
    """
    for name in (WHOLE, STRIPPED):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(Path(tisph.__file__).parent, folder / name / "tisph", ignore=ignored)
    return strip(folder / STRIPPED, flags)


def strip(package, flags):
    """Delete what ``flags`` compile in from the sources in ``package``; return how many branches each had."""
    deletion = Deletion(flags)
    for path in package.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "ti.static" in text:
            tree = ast.fix_missing_locations(deletion.visit(ast.parse(text)))
            path.write_text(ast.unparse(tree), encoding="utf-8")
    return deletion.found


class Deletion(ast.NodeTransformer):
    """Replaces branches on a compile-time flag by what is compiled without it; ``found`` counts them by flag."""

    def __init__(self, flags):
        self.flags = flags
        self.found = Counter()

    def visit_If(self, node):
        """Replace one branch."""
        self.generic_visit(node)
        flag = _flag(node.test)
        if flag not in self.flags:
            return node
        self.found[flag] += 1
        return node.orelse or ast.Pass()


def _flag(test):
    """The attribute that a ``ti.static(owner.attribute)`` asks for; None for any other condition."""
    if isinstance(test, ast.Call) and ast.unparse(test.func) == "ti.static" and isinstance(test.args[0], ast.Attribute):
        return test.args[0].attr
    return None


def added_kernels(uses):
    """Let each of ``uses``, called with an environment for processes, add to one empty cache of compiled kernels.

    Returns a set of names for each: a name is a hash of all that a kernel is compiled from.
    """
    added, known = [], set()
    with tempfile.TemporaryDirectory() as home:
        for use in uses:
            use({**os.environ, "HOME": home, "XDG_CACHE_HOME": f"{home}/.cache"})
            now = {path.name for path in Path(home).rglob("*.tic")}
            added.append(now - known)
            known = now
    return added
