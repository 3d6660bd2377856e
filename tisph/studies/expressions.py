"""Arithmetic expressions in YAML: numbers of a run, such as ``drag/superficial_velocity``, and values of configs.

The functions are abs, max, sqrt, hypot, sin, cos, exp and log, the constant is pi. In checks of suites a name is one of

- a number of a sample in summary.json;
- ``wall_shear``, the error of the wall shear stress;
- ``transverse``, the largest transverse velocity over the reference velocity;
- a dotted name of the whole run, such as ``cost.steps``.

``NAME off exact`` is the relative difference of a number to ``NAME_exact``.
"""

import math
from collections.abc import Callable
from types import CodeType
from typing import TYPE_CHECKING, Any

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.formula import FormulaError, compiled, evaluated
from tisph.measures.channel import wall_shear_error

if TYPE_CHECKING:
    from tisph.studies.processes import Result

FUNCTIONS: dict[str, Callable[..., float]] = {
    name: getattr(math, name) for name in ("sqrt", "hypot", "sin", "cos", "exp", "log")
}
FUNCTIONS |= {"abs": abs, "max": lambda *numbers: math.nan if any(map(math.isnan, numbers)) else max(numbers)}


class SuiteError(Exception):
    """An entry that cannot be understood: the key to blame, None for the entry itself, and the reason."""

    def __init__(self, key: str | None, text: str):
        super().__init__(text)
        self.key, self.text = key, text


def _compiled(source: str, key: str) -> CodeType:
    """Return the code of an expression, in which a name is a call of ``number`` with it; SuiteError for other texts."""
    try:
        return compiled(source, tuple(FUNCTIONS))[0]
    except FormulaError as error:
        reason = f": {error}" if str(error) else " is no arithmetic expression, such as drag/superficial_velocity"
        raise SuiteError(key, f"{source!r}{reason}") from None


def filled(template: Any, names: dict[str, Any]) -> Any:
    """Return plain data in which the value of an expression replaces every text that begins with =.

    ``names`` (name -> plain data): values of the names in expressions; they may contain expressions. Numbers become
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
    value = evaluated(_compiled(template[1:], template), FUNCTIONS, lambda name: filled(names[name], names))
    return digits(value) if isinstance(value, float) else value


class Number:
    """An arithmetic expression of numbers of a result; SuiteError where ``text`` is no such expression."""

    def __init__(self, text: Any, key: str):
        self.text = str(text)
        self._off_exact = self.text.endswith(" off exact")
        source = self.text.removesuffix(" off exact")
        self._code = _compiled(source, key)
        self._name = source if self._off_exact else None

    def __call__(self, result: "Result | None", sample: dict[str, Any] | None) -> float:
        """Return the value in a ``sample`` of a result; NaN without a sample, or if one of its numbers has no value.

        Only ``transverse`` and dotted names need the result.
        """
        if sample is None:
            return math.nan

        def lookup(name: str) -> float:
            return _number(result, sample, name)

        try:
            value = evaluated(self._code, FUNCTIONS, lookup)
            value = abs(value / lookup(f"{self._name}_exact") - 1) if self._off_exact else value
        except (ArithmeticError, ValueError):
            return math.nan
        return math.nan if isinstance(value, complex) else value


def _number(result: Any, sample: dict[str, Any], name: str) -> float:
    """Return the number ``name`` of a sample, or of the whole run if the name is dotted; NaN where it has no value."""
    if name == "transverse":
        return sample["max_transverse_velocity"] / result.reference_velocity
    if name == "wall_shear":
        value = wall_shear_error(sample)
    else:
        found: Any = result.summary if "." in name else sample
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
