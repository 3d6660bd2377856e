"""Numbers of a run as arithmetic expressions, such as ``drag/superficial_velocity``.

The names are the numbers of a sample in summary.json; ``wall_shear``, the error of the wall shear stress;
``transverse``, the largest transverse velocity over the reference velocity; and dotted names of the whole run, such as
``cost.steps``. The functions are abs, max, sqrt, hypot, sin, cos, exp and log, the constant is pi. ``NAME off exact``
is the relative difference of a number to ``NAME_exact``.
"""

import ast
import math
from typing import Any

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.measures.wall_shear import wall_shear_error

FUNCTIONS = {name: getattr(math, name) for name in ("sqrt", "hypot", "sin", "cos", "exp", "log")}
FUNCTIONS |= {"abs": abs, "max": lambda *numbers: math.nan if any(map(math.isnan, numbers)) else max(numbers)}

ARITHMETIC = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Constant, ast.Name, ast.Call)
ARITHMETIC += (ast.Attribute, ast.Load)


class SuiteError(Exception):
    """An entry that cannot be understood: the key to blame, None for the entry itself, and the reason."""

    def __init__(self, key: str | None, text: str):
        super().__init__(text)
        self.key, self.text = key, text


class Number:
    """An arithmetic expression of numbers of a result; SuiteError where ``text`` is none."""

    def __init__(self, text: Any, key: str):
        self.text = str(text)
        self._off_exact = self.text.endswith(" off exact")
        source = self.text.removesuffix(" off exact")
        try:
            tree = ast.parse(source, mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise SuiteError(
                key, f"{self.text!r} is no arithmetic expression, such as drag/superficial_velocity"
            ) from None
        for node in ast.walk(tree):
            if not isinstance(node, ARITHMETIC) or (isinstance(node, ast.Constant) and not is_number(node.value)):
                raise SuiteError(key, f"{self.text!r}: only numbers, names, + - * / ** and {', '.join(FUNCTIONS)}")
            if isinstance(node, ast.Call) and getattr(node.func, "id", None) not in FUNCTIONS:
                raise SuiteError(key, f"{self.text!r}: the functions are {', '.join(FUNCTIONS)}")
        self._code = compile(_Lookup().visit(tree), "<suite>", "eval")
        self._name = source if self._off_exact else None

    def __call__(self, result, sample) -> float:
        """Its value in a ``sample`` of a result; NaN without a sample, or where one of its numbers has no value."""
        if sample is None:
            return math.nan
        lookup = lambda name: _number(result, sample, name)  # noqa: E731
        try:
            value = eval(self._code, {"__builtins__": {}, **FUNCTIONS, "number": lookup})
            value = abs(value / lookup(f"{self._name}_exact") - 1) if self._off_exact else value
        except (ArithmeticError, ValueError):
            return math.nan
        return math.nan if isinstance(value, complex) else value


class _Lookup(ast.NodeTransformer):
    """Makes every name of an expression a call of ``number`` with this name, and every number a float.

    Powers of floats overflow at once, powers of whole numbers take any time and memory.
    """

    def visit_Constant(self, node):
        return ast.copy_location(ast.Constant(float(node.value)), node)

    def visit_Call(self, node):
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Name(self, node):
        if node.id == "pi":
            return ast.copy_location(ast.Constant(math.pi), node)
        return self._call(node, node.id)

    def visit_Attribute(self, node):
        return self._call(node, ast.unparse(node))

    @staticmethod
    def _call(node, name):
        call = ast.Call(ast.Name("number", ast.Load()), [ast.Constant(name)], [])
        return ast.fix_missing_locations(ast.copy_location(call, node))


def is_number(value: Any) -> bool:
    """Tell whether a value of a suite is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number(result, sample, name):
    """The number ``name`` of a sample, or of the whole run where the name is dotted; NaN where it has no value."""
    if name == "transverse":
        return sample["max_transverse_velocity"] / result.reference_velocity
    if name == "wall_shear":
        value = wall_shear_error(sample)
    else:
        found = result.summary if "." in name else sample
        for part in name.split("."):
            if not isinstance(found, dict) or part not in found:
                raise ConfigError(f"{name}: no such number{nearest(part, list(found) if found else [])}")
            found = found[part]
        value = found
    return math.nan if value is None else value
