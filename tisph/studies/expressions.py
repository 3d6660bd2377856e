"""Arithmetic expressions in YAML: numbers of a run, such as ``drag/superficial_velocity``, and values of configs.

The functions are abs, max, sqrt, hypot, sin, cos, exp and log, the constant is pi. In checks of suites the names are
the numbers of a sample in summary.json; ``wall_shear``, the error of the wall shear stress; ``transverse``, the largest
transverse velocity over the reference velocity; and dotted names of the whole run, such as ``cost.steps``. ``NAME off
exact`` is the relative difference of a number to ``NAME_exact``.
"""

import ast
import math
from collections.abc import Callable
from functools import cache
from types import CodeType
from typing import Any

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.measures.channel import wall_shear_error

FUNCTIONS = {name: getattr(math, name) for name in ("sqrt", "hypot", "sin", "cos", "exp", "log")}
FUNCTIONS |= {"abs": abs, "max": lambda *numbers: math.nan if any(map(math.isnan, numbers)) else max(numbers)}

ARITHMETIC = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Constant, ast.Name, ast.Call)
ARITHMETIC += (ast.Attribute, ast.Load)


class SuiteError(Exception):
    """An entry that cannot be understood: the key to blame, None for the entry itself, and the reason."""

    def __init__(self, key: str | None, text: str):
        super().__init__(text)
        self.key, self.text = key, text


@cache
def _compiled(source: str, key: str) -> CodeType:
    """Return the code of an expression, in which a name is a call of ``number`` with it; SuiteError for other texts."""
    try:
        tree = ast.parse(source, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise SuiteError(key, f"{source!r} is no arithmetic expression, such as drag/superficial_velocity") from None
    for node in ast.walk(tree):
        if not isinstance(node, ARITHMETIC) or (isinstance(node, ast.Constant) and not is_number(node.value)):
            raise SuiteError(key, f"{source!r}: only numbers, names, + - * / ** and {', '.join(FUNCTIONS)}")
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) not in FUNCTIONS:
            raise SuiteError(key, f"{source!r}: the functions are {', '.join(FUNCTIONS)}")
    return compile(_Lookup().visit(tree), "<suite>", "eval")


def _evaluated(code: CodeType, lookup: Callable[[str], Any]) -> Any:
    return eval(code, {"__builtins__": {}, **FUNCTIONS, "number": lookup})


def filled(template: Any, names: dict[str, Any]) -> Any:
    """Return plain data in which every text that begins with = is replaced by the value of this expression.

    ``names`` (name -> plain data): values of the names in expressions, which may have expressions, too. Numbers become
    floats of twelve digits. A map ``{repeat: N, each: ITEM}`` becomes a list of N items with k = 0, 1, ... N - 1.
    """
    if isinstance(template, dict) and "repeat" in template:
        return [filled(template["each"], {**names, "k": k}) for k in range(template["repeat"])]
    if isinstance(template, dict):
        return {key: filled(value, names) for key, value in template.items()}
    if isinstance(template, list):
        return [filled(value, names) for value in template]
    if not (isinstance(template, str) and template.startswith("=")):
        return template
    value = _evaluated(_compiled(template[1:], template), lambda name: filled(names[name], names))
    return digits(value) if isinstance(value, float) else value


class Number:
    """An arithmetic expression of numbers of a result; SuiteError where ``text`` is none."""

    def __init__(self, text: Any, key: str):
        self.text = str(text)
        self._off_exact = self.text.endswith(" off exact")
        source = self.text.removesuffix(" off exact")
        self._code = _compiled(source, key)
        self._name = source if self._off_exact else None

    def __call__(self, result, sample) -> float:
        """Its value in a ``sample`` of a result; NaN without a sample, or where one of its numbers has no value."""
        if sample is None:
            return math.nan
        lookup = lambda name: _number(result, sample, name)  # noqa: E731
        try:
            value = _evaluated(self._code, lookup)
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


def digits(number: float) -> float:
    """Return the number to twelve digits: 1.8, not 1.7999999999999998."""
    return float(f"{number:.12g}")


def merged(config: dict[str, Any], *changes: dict[str, Any]) -> dict[str, Any]:
    """Return a copy of a nested dict with the values of ``changes`` put in their place, in turn."""
    result = dict(config)
    for change in changes:
        for key, value in change.items():
            result[key] = merged(result.get(key, {}), value) if isinstance(value, dict) else value
    return result
