"""Arithmetic formulas in configs and suites: their text is checked, so that nothing but arithmetic is evaluated."""

import ast
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from types import CodeType
from typing import Any

import numpy as np

ARITHMETIC: tuple[type[ast.AST], ...] = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)
ARITHMETIC += (ast.Constant, ast.Name, ast.Call, ast.Attribute, ast.Load)

LONGEST = 20_000
"""Characters of a formula: a manufactured source has some thousands."""

OF_PLACES: dict[str, Callable[..., Any]] = {
    name: getattr(np, name)
    for name in ("sqrt", "hypot", "sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "abs")
}
OF_PLACES |= {"min": lambda *values: reduce(np.minimum, values), "max": lambda *values: reduce(np.maximum, values)}
"""Functions of a formula of places and time, for arrays."""


class FormulaError(ValueError):
    """A text that is no formula; its message says what formulas may have."""


def is_number(value: Any) -> bool:
    """Return whether a value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


@cache
def compiled(source: str, functions: Sequence[str]) -> tuple[CodeType, frozenset[str]]:
    """Return the code of a formula with these ``functions``, and its names beside pi; FormulaError for other texts.

    In the code a name is a call of ``number`` with it. Numbers are floats: powers of floats overflow at once, powers of
    whole numbers take any time and memory.
    """
    try:
        tree = ast.parse(source, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise FormulaError("") from None
    for node in ast.walk(tree):
        if not isinstance(node, ARITHMETIC) or (isinstance(node, ast.Constant) and not is_number(node.value)):
            raise FormulaError(f"only numbers, names, + - * / ** and {', '.join(functions)}")
        if isinstance(node, ast.Call) and (getattr(node.func, "id", None) not in functions or node.keywords):
            raise FormulaError(f"the functions are {', '.join(functions)}")
    lookup = _Lookup()
    return compile(lookup.visit(tree), "<formula>", "eval"), frozenset(lookup.names)


class _Lookup(ast.NodeTransformer):
    """Replaces every name of a formula by a call of ``number`` with this name, and every number by a float."""

    def __init__(self) -> None:
        self.names: set[str] = set()

    def visit_Constant(self, node: Any) -> ast.AST:
        return ast.copy_location(ast.Constant(float(node.value)), node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Name(self, node: ast.Name | ast.Attribute) -> ast.AST:
        name = ast.unparse(node)
        if name == "pi":
            return ast.copy_location(ast.Constant(math.pi), node)
        self.names.add(name)
        call = ast.Call(ast.Name("number", ast.Load()), [ast.Constant(name)], [])
        return ast.fix_missing_locations(ast.copy_location(call, node))

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self.visit_Name(node)


def evaluated(code: CodeType, functions: dict[str, Callable[..., Any]], lookup: Callable[[str], Any]) -> Any:
    """Return the value of a ``compiled`` formula, whose names have the values that ``lookup`` returns."""
    return eval(code, {"__builtins__": {}, **functions, "number": lookup})


def names_in(formula: str) -> frozenset[str]:
    """Return the names among x, y and t in the text of a ``formula`` of places and time."""
    return compiled(formula, tuple(OF_PLACES))[1]


@dataclass(frozen=True)
class FieldFormula:
    """A number, or a formula of x, y and t as a text: the ``given`` value of a config."""

    given: float | str

    @property
    def varies(self) -> bool:
        """Whether the value depends on time."""
        return isinstance(self.given, str) and "t" in names_in(self.given)

    def __call__(self, x: np.ndarray, y: np.ndarray, t: float) -> np.ndarray:
        """Return the values (n,) at the places ``x``, ``y`` (n,) and the time ``t``."""
        if not isinstance(self.given, str):
            return np.full(np.shape(x), float(self.given))
        values = {"x": np.asarray(x, dtype=float), "y": np.asarray(y, dtype=float), "t": t}
        with np.errstate(all="ignore"):  # values that are not finite stop the run in words
            code, _ = compiled(self.given, tuple(OF_PLACES))
            return evaluated(code, OF_PLACES, values.__getitem__) + np.zeros(np.shape(x))
