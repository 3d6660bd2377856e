"""Checks of a suite: bounds of numbers of its runs.

An entry of ``checks`` in a suite has one of these forms, and becomes one criterion for each of its runs, times and
numbers. ``t`` or ``t_star`` (t* = t over the time scale of the scene) choose samples, by one time or a list of times;
without either the number is read from the last sample of a run that reached its end.

- {run: fine, t: [1.8, 2.7], at_most: {l2: 1.0e-3, wall_shear: 0.01}}    # or at_least; a bound, or one for each time
- {run: fine, t: 2.7, off_exact: {torque_inner: 1.0e-3}}                 # relative difference to torque_inner_exact
- {run: fine, t: 2.7, over: coarse, at_most: {l2: 0.5}}                  # the ratio of the numbers of two runs
- {run: fine, t: 2.7, near: coarse, within: {l2: 0.05}}                  # their relative difference
- {run: fine, number: drag/superficial_velocity, called: resistance, expected: 51.53, within: 3.0e-3}
- {order: l2, runs: {coarse: 25, fine: 50}, t: 2.7, at_least: 3.5}       # order of convergence; particles across
- {run: again, same_bits_as: fine}
- {run: other_units, same_velocities_as: fine, within: 1.0e-6}           # over the reference velocity
- {run: fine, momentum_closes: 0.01}                                     # summary.json: momentum.closure
- {run: fine, measure: resolved_samples, at_most: 0}                     # a function of ``studies/measures.py``
- {run: fine, t: 2.7, measure: stated_error, with: {field: velocity}, within_factor: 3}   # from 1/3 to 3

A number is an expression, see ``studies/expressions.py``. In ``expected``, and in ``with``, the name of a reference may
stand for a number, with a factor or without (tisph references): ``expected: 0.002*dfg_2d_1.drag_coefficient``.
"""

import inspect
import math
import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tisph.config.fields import nearest
from tisph.formula import is_number
from tisph.measures.metrics import fitted_order
from tisph.references import table
from tisph.studies import measures
from tisph.studies.expressions import Number, SuiteError
from tisph.studies.processes import Result

COMPARED = ("run", "t", "t_star", "over", "near")

FORMS: dict[str, tuple[str, ...]] = {
    "number": (*COMPARED, "called", "expected", "at_most", "at_least", "within"),
    "order": ("runs", "t", "t_star", "case", "called", "expected", "at_least"),
    "same_bits_as": ("run",),
    "same_velocities_as": ("run", "within"),
    "momentum_closes": ("run",),
    "measure": ("run", "t", "case", "called", "with", "expected", "within", "within_factor", "at_most"),
    "at_most": (*COMPARED, "at_least", "off_exact"),
    "at_least": (*COMPARED, "off_exact"),
    "off_exact": COMPARED,
    "within": COMPARED,
}
"""Key that makes an entry a check (the first of these keys that the entry has) -> other keys that it may have."""

BOUNDS = {"at_most": "<=", "at_least": ">=", "off_exact": "<=", "within": "<="}


@dataclass(frozen=True)
class Check:
    """One line of the verification table; ``value`` is NaN where the runs gave no number."""

    case: str
    quantity: str
    value: float
    bound: str
    passed: bool


@dataclass(frozen=True)
class Criterion:
    """A number, computed from the results of ``runs`` (names), and the range of values that pass."""

    case: str
    quantity: str
    bound: str
    runs: tuple[str, ...]
    value: Callable[..., float]
    accepts: Callable[[float], bool]

    def judge(self, *results: Result) -> Check:
        """Return the check from the results of ``runs``, in their order."""
        value = float(self.value(*results))
        return Check(self.case, self.quantity, value, self.bound, bool(self.accepts(value)))


def bounded(
    case: str,
    quantity: str,
    bound: float,
    value: Callable[..., float],
    runs: tuple[str, ...] | None = None,
    sign: str = "<=",
) -> Criterion:
    """Return the ``Criterion`` value ``sign`` bound, where ``value`` is a function of the results of ``runs``.

    Without ``runs`` the only run is ``case``.
    """
    holds = {"<=": operator.le, ">=": operator.ge, "=": operator.eq}[sign]
    text = f"{sign} {bound:g}"
    return Criterion(case, quantity, text, runs or (case,), value, lambda number: holds(number, bound))


def criteria(entry: dict[str, Any], names: set[str]) -> Iterator[Criterion]:
    """Yield the criteria of an entry of ``checks``; ``names`` are the names of the runs. Raises SuiteError."""
    kind = next((key for key in FORMS if key in entry), None)
    if kind is None:
        raise SuiteError(None, f"a check needs one of {', '.join(FORMS)}")
    for key in entry:
        if key not in (kind, *FORMS[kind]):
            hint = nearest(key, list(FORMS[kind]))
            raise SuiteError(key, f"unknown key of a check by {kind}{hint}; allowed: {', '.join(FORMS[kind])}")
    for key in ("run", "near", "over", "same_bits_as", "same_velocities_as", "runs"):
        for name in _listed(entry.get(key, ())):
            if not isinstance(name, str) or name not in names:
                raise SuiteError(key, f"there is no run {name!r}{nearest(str(name), sorted(names))}")
    entry = _with_references(entry)
    if kind == "order":
        yield from _orders(entry)
        return
    runs = _listed(_given(entry, "run"))
    if kind == "measure":
        for time in _listed(entry["t"]) if "t" in entry else [None]:
            yield _measure(entry, tuple(runs), time)
        return
    for run in runs:
        if kind == "same_bits_as":
            other = entry[kind]
            yield bounded(run, f"arrays that differ from {other}", 0, _differing_arrays, (run, other), "=")
        elif kind == "same_velocities_as":
            other = entry[kind]
            yield bounded(run, f"velocities off {other}", _bound(entry, "within"), _difference, (run, other))
        elif kind == "momentum_closes":
            yield bounded(run, "momentum closure", _bound(entry, kind), lambda result: result.closure)
        else:
            yield from _of_numbers(entry, run)


def of_references() -> Iterator[Criterion]:
    """Yield a criterion, without a run, for each value of the table of references beside the reference itself."""
    for flow in table.flows():
        for pair in table.pairs(flow):
            words = f"{pair.name} of {pair.other.source} off {pair.reference.source}"
            if pair.other.wrong:
                words += ", known as wrong"
            sign, holds = (">", operator.gt) if pair.other.wrong else ("<=", operator.le)

            def difference(pair: table.Pair = pair) -> float:
                return pair.difference

            yield Criterion(
                flow, words, f"{sign} {pair.allowed:.3g}", (), difference, partial(_holds, holds, pair.allowed)
            )


def _holds(compare: Callable[[float, float], bool], bound: float, number: float) -> bool:
    return compare(number, bound)


def _with_references(entry: dict[str, Any]) -> dict[str, Any]:
    """Return an entry with values of the table of references in place of their names. Raises SuiteError."""

    def replaced(value: Any, key: str) -> Any:
        if isinstance(value, list):
            return [replaced(one, key) for one in value]
        if isinstance(value, dict):
            return {name: replaced(one, key) for name, one in value.items()}
        if not isinstance(value, str) or (key == "with" and not table.ENTRY.fullmatch(value)):
            return value
        try:
            return table.number(value)
        except ValueError as error:
            raise SuiteError(key, str(error)) from None

    return {key: replaced(value, key) if key in ("expected", "with") else value for key, value in entry.items()}


def _given(entry: dict[str, Any], key: str) -> Any:
    if key not in entry:
        raise SuiteError(None, f"{key} is missing")
    return entry[key]


def _bound(entry: dict[str, Any], key: str) -> float:
    value = _given(entry, key)
    if not is_number(value):
        raise SuiteError(key, f"{value!r}: must be a number, such as 1.0e-3")
    return value


def _listed(value: Any) -> list:
    return list(value) if isinstance(value, list | tuple | dict) else [value]


def _times(entry: dict[str, Any]) -> list[tuple[str, Callable[[Result], Any]]]:
    """Return (words, function that chooses the sample of a result) for each time of an entry."""
    if "t" in entry and "t_star" in entry:
        raise SuiteError("t_star", "give t or t_star, not both")
    for key, sign in (("t", "t"), ("t_star", "t*")):
        if key in entry:
            times = _listed(entry[key])
            for time in times:
                if not is_number(time):
                    raise SuiteError(key, f"{time!r}: must be a number, or a list of numbers")
            return [(f" at {sign} = {time:g}", partial(Result.sample, time=time, key=key)) for time in times]
    return [("", lambda result: result.last)]


def _of_numbers(entry: dict[str, Any], run: str) -> Iterator[Criterion]:
    """Yield the criteria of numbers of a run at all times of an entry."""
    times = _times(entry)
    for key in BOUNDS:
        for number, words, bounds in _bounded_numbers(entry, key):
            if not isinstance(bounds, list):
                bounds = [bounds] * len(times)
            if len(bounds) != len(times) or not all(map(is_number, bounds)):
                raise SuiteError(key, f"{words}: must be a number, or a list of as many numbers as there are times")
            for (at, sample), bound in zip(times, bounds, strict=True):
                yield _criterion(entry, key, bound, run, number, words, at, sample)


def _bounded_numbers(entry: dict[str, Any], key: str) -> Iterator[tuple[Number, str, Any]]:
    """Yield each number that an entry bounds by ``key``, its words, and its bounds."""
    if key not in entry:
        return
    if "number" in entry:
        number = Number(entry["number"], "number")
        yield number, entry.get("called", number.text), entry[key]
    elif not isinstance(entry[key], dict):
        raise SuiteError(key, "must be a map of numbers and their bounds, such as {l2: 1.0e-3}")
    else:
        for text, bounds in entry[key].items():
            number = Number(f"{text} off exact" if key == "off_exact" else text, key)
            yield number, number.text, bounds


def _criterion(
    entry: dict[str, Any],
    key: str,
    bound: float,
    run: str,
    number: Number,
    words: str,
    at: str,
    sample: Callable[[Result], Any],
) -> Criterion:
    """Return the criterion of a number of a run at one time, alone or compared with a value or another run."""

    def value(result: Result) -> float:
        return number(result, sample(result))

    compared = [name for name in ("expected", "near", "over") if name in entry]
    if len(compared) > 1:
        raise SuiteError(compared[1], f"give one of {' and '.join(compared)}")
    if ("expected" in entry or "near" in entry) != (key == "within"):
        raise SuiteError(key, "within is the relative difference to expected or near; other bounds have neither")
    if "expected" in entry:
        expected = _bound(entry, "expected")
        return bounded(run, f"{words} off {expected:g}{at}", bound, lambda ours: abs(value(ours) / expected - 1))
    if not compared:
        return bounded(run, f"{words}{at}", bound, value, sign=BOUNDS[key])
    other = entry[compared[0]]

    def ratio(ours: Result, theirs: Result) -> float:
        return value(ours) / value(theirs)

    if "near" in entry:
        return bounded(run, f"{words} off {other}{at}", bound, lambda *both: abs(ratio(*both) - 1), (run, other))
    return bounded(run, f"{words} over {other}'s{at}", bound, ratio, (run, other), BOUNDS[key])


def _orders(entry: dict[str, Any]) -> Iterator[Criterion]:
    """Yield the criteria of the order of convergence, which is fitted over all resolutions."""
    resolutions, expected = _given(entry, "runs"), entry.get("expected")
    across = resolutions.values() if isinstance(resolutions, dict) else ()
    if len(across) < 2 or not all(is_number(number) and number > 0 for number in across):
        raise SuiteError("runs", "must be a map of two runs or more and their particles across")
    for text in _listed(entry["order"]):
        number = Number(text, "order")
        for words, sample in _times(entry):

            def fitted(*results: Result, number: Number = number, sample: Callable = sample) -> float:
                values = [number(result, sample(result)) for result in results]
                errors = values if expected is None else [abs(value / expected - 1) for value in values]
                return fitted_order(resolutions.values(), errors)

            case, name = entry.get("case", "/".join(resolutions)), entry.get("called", f"{number.text} order")
            yield bounded(case, f"{name}{words}", _bound(entry, "at_least"), fitted, tuple(resolutions), ">=")


def _measure(entry: dict[str, Any], runs: tuple[str, ...], time: Any) -> Criterion:
    """Return the criterion of a function of ``measures.py``, at a ``time`` if there is one."""
    name, given, at = str(entry["measure"]), entry.get("with", {}), ""
    if not isinstance(given, dict):
        raise SuiteError("with", "must be a map of the parameters of the measure")
    if time is not None:
        if not is_number(time):
            raise SuiteError("t", f"{time!r}: must be a number, or a list of numbers")
        given, at = {**given, "t": time}, f" at t = {time:g}"
    if name not in measures.MEASURES:
        raise SuiteError("measure", f"there is no measure {name!r}{nearest(str(name), sorted(measures.MEASURES))}")
    function = measures.MEASURES[name]
    parameters = inspect.signature(function).parameters.values()
    keys = {one.name: one.default is one.empty for one in parameters if one.kind is one.KEYWORD_ONLY}
    wrong = [key for key in given if key not in keys] + [
        key for key, needed in keys.items() if needed and key not in given
    ]
    if wrong:
        raise SuiteError("with", f"{wrong[0]}: {name} takes {', '.join(keys) or 'nothing'}")

    def value(*results: Result) -> float:
        """Return the measure; NaN where one of the runs stopped early."""
        return function(*results, **given) if all(result.last for result in results) else math.nan

    case, words = entry.get("case", runs[0]), entry.get("called", name.replace("_", " ")) + at
    if "within_factor" in entry:
        most = _bound(entry, "within_factor")
        return Criterion(case, words, f"1/{most:g} to {most:g}", runs, value, lambda number: 1 / most <= number <= most)
    if "expected" not in entry:
        return bounded(case, words, _bound(entry, "at_most"), value, runs)
    expected = _bound(entry, "expected")
    within = _bound(entry, "within")
    return bounded(case, f"{words} off {expected:g}", within, lambda *all: abs(value(*all) / expected - 1), runs)


def _differing_arrays(ours: Result, other: Result) -> float:
    """Return how many arrays of samples.h5 differ in a bit; NaN without arrays, or if their names differ."""
    arrays, others = ours.arrays(), other.arrays()
    if not arrays or arrays.keys() != others.keys():
        return math.nan
    return sum(arrays[key].tobytes() != others[key].tobytes() for key in arrays)


def _difference(ours: Result, other: Result) -> float:
    """Return the largest difference of a velocity component of a particle in all samples, over the reference velocity.

    NaN without arrays, or if their names differ.
    """
    arrays, others = (
        {key: array / run.reference_velocity for key, array in run.arrays().items() if key.endswith(("/u", "/v"))}
        for run in (ours, other)
    )
    if not arrays or arrays.keys() != others.keys():
        return math.nan
    return max(np.max(np.abs(arrays[key] - others[key])) for key in arrays)
