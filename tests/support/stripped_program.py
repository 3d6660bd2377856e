"""A copy of the program without the code of optional parts: what a scene that uses none of them has to compile to.

Such code stands behind ``if ti.static(flag):``. Where the program with it and the program without it compile to the
same kernels, to the last instruction, a scene cannot pay for it. Run as a program in the folder of a copy, it takes
steps of the config that it is given.
"""

import ast
import math
import os
import shutil
import subprocess
import sys
from collections import Counter, deque
from pathlib import Path

FLAGS = ("carries_stress", "tracks_walls", "limits_tension", "has_artificial_viscosity", "has_body_force", "oscillates")
"""Attributes that compile in polymer stress, tension limit, artificial viscosity, body acceleration, moving walls."""

STEPS = 60
"""In which everything has happened once: rebuilt lists, a new time step, a balance of momentum."""


def copy(folder, flags=()):
    """Put a copy of the package into ``folder``, without what ``flags`` compile in; return the branches of each."""
    import tisph

    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(tisph.__file__).parent, folder / "tisph", ignore=ignored)
    deletion = Deletion(flags)
    for path in (folder / "tisph").rglob("*.py") if flags else ():
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
        test = node.test
        if not (isinstance(test, ast.Call) and ast.unparse(test.func) == "ti.static"):
            return node
        flag = getattr(test.args[0], "attr", None)
        if flag not in self.flags:
            return node
        self.found[flag] += 1
        return node.orelse or ast.Pass()


def compiled_kernels(program, config, home):
    """Names of the kernels in the cache in ``home`` once the copy in ``program`` has taken steps of ``config``.

    A name is a hash of all that a kernel is compiled from.
    """
    places = {"HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache"), "PYTHONPATH": str(program)}
    command = [sys.executable, __file__, config]
    done = subprocess.run(command, cwd=program, env={**os.environ, **places}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip().startswith(str(program)), "another copy ran"
    return {path.name for path in home.rglob("*.tic")}


def fields(scheme):
    """Every Taichi field that ``scheme`` holds, by the shortest path of attributes to it."""
    from tisph.runtime import ti

    found, visited, waiting = {}, {id(scheme)}, deque([("", scheme)])
    while waiting:
        path, owner = waiting.popleft()
        for name, value in _members(owner):
            if id(value) in visited:
                continue
            visited.add(id(value))
            if isinstance(value, ti.Field):
                found[f"{path}{name}"] = value
            else:
                waiting.append((f"{path}{name}.", value))
    return found


def _members(owner):
    if isinstance(owner, dict):
        return owner.items()
    if isinstance(owner, list | tuple):
        return enumerate(owner)
    return vars(owner).items() if type(owner).__module__.startswith("tisph.") and hasattr(owner, "__dict__") else ()


def size(field):
    """Bytes of the numbers in ``field``."""
    from tisph.runtime import ti

    each = {ti.f64: 8, ti.f32: 4, ti.i64: 8, ti.i32: 4, ti.u8: 1}[field.dtype]
    return math.prod(field.shape) * each * (field.n * field.m if isinstance(field, ti.MatrixField) else 1)


def take_steps(path):
    """Take steps of the config at ``path``; print where the program is."""
    import tisph
    from tisph import runtime, scenes, schemes
    from tisph.config import load
    from tisph.simulation.state import start_values

    config = load(path, ())
    scene = scenes.of(config)
    runtime.start(config.discretisation.precision, 1)
    chosen, _ = schemes.resolve(config)
    scheme = schemes.build(chosen, scene, [config.time.end], True)
    scheme.start(*start_values(scene, config.initial))
    while scheme.steps < STEPS:
        scheme.advance()
    print(tisph.__file__)
    runtime.stop()


if __name__ == "__main__":
    take_steps(sys.argv[1])
