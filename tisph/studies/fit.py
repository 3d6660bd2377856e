"""``tisph fit``: values of keys of a config, by least squares, from measurements.

The residuals r are differences of predicted from measured values, as parts of the largest value of a column, or of
each value (``assessment/measurements.py``). A key that extends over a decade or more is fitted in its logarithm. In
z, from 0 to 1 over the bounds of each key, with the Jacobian J = dr/dz and the noise sigma,

    minimise r(z)^2,    cov = (J^T J / sigma^2 + 1)^-1,    z_k +- t_95 cov_kk^(1/2),

t_95 by Student's distribution. The 1 stands for the bounds, which are known without data: it changes nothing where the
data determine a key, and gives a finite interval, beyond the bounds, where they do not. Such a key is undetermined.

sigma is given, or the scatter of replicates, measured at the same place and time, or the root mean square of the
residuals. Noise that is known tests the fit: r^2/sigma^2 has the chi-square distribution, or over the noise of
replicates the F distribution. Noise that is estimated does not; then residuals of neighbouring points must be
uncorrelated. The sum of their products over n pairs has the standard deviation sigma^2 n^(1/2). So has the sum for
their normal scores, in which a few large residuals count no more than many small ones.

Laws are compared by Akaike's information criterion with its correction for few data. A law with more keys counts as
better only where it is twenty times as likely: a law that contains another one is never worse.

Starting points fill the box of bounds evenly; the best of them begins, and a further one where its fit is a misfit.
Sources: G. A. F. Seber and C. J. Wild, Nonlinear Regression (1989), chapters 2 and 5; K. P. Burnham and D. R. Anderson,
Model Selection and Multimodel Inference (2nd ed. 2002), sections 2.4 to 2.6; P. A. P. Moran, Biometrika 37 (1950)
17-23, for residuals of neighbours.
"""

import csv
import itertools
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np

from tisph import registry, scenes
from tisph.assessment import judge
from tisph.assessment.measurements import RELATIVE, Measurements, read
from tisph.config import load
from tisph.config.fields import nearest
from tisph.config.loader import override_texts
from tisph.config.schema import Config
from tisph.config.yaml_text import YamlTextError, parse
from tisph.errors import ConfigError, TisphError
from tisph.folder import replaced
from tisph.report.fit import FitPanel, draw
from tisph.report.labels import axis_label, unit_label
from tisph.scenes._scene import Scene
from tisph.scenes.annulus import Annulus
from tisph.studies.predictions import Predicted, Predictor, history_columns
from tisph.studies.store import claimed
from tisph.text_table import format_table

NUMBERS, TABLE, PICTURE, FITTED, RUNS = "fit.json", "fit.csv", "fit.png", "fitted.yaml", "runs"

DECADE = 10.0
"""Ratio of the bounds from which on a key is fitted in its logarithm."""

CONFIDENCE = 0.975
"""Probability below the upper end of an interval of 95 %."""

UNLIKELY = 1e-3
"""Probability of residuals of a fit that is right, below which it is a misfit."""

CORRELATED = 3.0
"""Sum of products of neighbouring residuals, in standard deviations, that is as unlikely in one of the two tests."""

FEW_PAIRS = 8
"""Least number of pairs of neighbours that are tested."""

LARGE = 0.2
"""Residual, as a part of the data, that is a misfit where no noise is known."""

FEW_REPLICATES = 5
"""Least number of degrees of freedom of replicates that give the noise."""

EVIDENCE = 20.0
"""Ratio of Akaike weights by which a law with more keys must be better."""

STEPS = {True: 1e-3, False: 0.02}
"""Relative change of a value in a difference quotient, of exact predictions and of runs: well above their error."""

FAR = 0.1
"""Step in z where a small one changes nothing."""

STARTS = {True: (9, 3), False: (3, 1)}
"""Starting points, and how many of them are fitted from at most, with exact predictions and with runs."""

TOLERANCES = {True: {"ftol": 1e-5, "xtol": 1e-8, "gtol": 1e-14}, False: {"ftol": 1e-3, "xtol": 1e-3, "gtol": 1e-14}}
MOST_STEPS = {True: 40, False: 6}

FINER, MOST_REFINED = 1.5, 3
"""Ratio of spacings of the test of the numerical error, and how often the spacing is refined at most."""

SMALL = 0.1
"""Largest numerical error over the noise."""

DEGENERATE = 0.99
"""Correlation of two undetermined keys of which the data show a combination."""


@dataclass(frozen=True)
class Key:
    """A free key of the config, and its bounds."""

    name: str
    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether the key is fitted in its logarithm."""
        return self.low > 0.0 and self.high >= DECADE * self.low

    @property
    def width(self) -> float:
        """Width of the bounds, in logarithms or in the largest value."""
        return math.log(self.high / self.low) if self.logarithmic else (self.high - self.low) / abs(self.high)

    def value(self, z: float) -> float:
        """Return the value at ``z``, from 0 at the lower bound to 1 at the upper one."""
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** z)
        return float(self.low + (self.high - self.low) * z)

    def place(self, value: float) -> float:
        """Return z of a ``value``."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low) if value > 0.0 else -1.0
        return (value - self.low) / (self.high - self.low)


def key_of(text: str) -> Key:
    """Return the key of a text KEY=LOW..HIGH; ConfigError for another text."""
    match = re.fullmatch(r"\s*([^=]+?)\s*=\s*(.+?)\s*\.\.\s*(.+?)\s*", text)
    try:
        key = Key(match[1], float(match[2]), float(match[3])) if match else None
    except ValueError:
        key = None
    if key is None or not (math.isfinite(key.low) and math.isfinite(key.high) and key.low < key.high):
        raise ConfigError(f"--free {text}: must look like fluid.rheology.relaxation_time=0.1..10, from low to high")
    return key


@dataclass(frozen=True)
class Noise:
    """``sigma`` as a part of the data, from ``degrees`` of freedom; None where only the residuals tell.

    ``source`` in words. ``within``: sum of squares of replicates about their means.
    """

    sigma: float | None
    degrees: float
    source: str
    within: float = 0.0


def noise_of(data: Measurements, given: float | None) -> Noise:
    """Return the noise that is ``given``, or that replicates show."""
    if given is not None:
        return Noise(given, math.inf, "as given")
    rows = np.stack(list(data.at.values()), axis=1)
    _, which, count = np.unique(rows, axis=0, return_inverse=True, return_counts=True)
    which, degrees, within = which.ravel(), 0, 0.0
    for values, scale in zip(data.measured.values(), data.scales, strict=True):
        parts = np.log(values) if data.kind in RELATIVE else values / scale
        means = np.bincount(which, parts) / count
        within += float(np.sum((parts - means[which]) ** 2))
        degrees += len(parts) - len(count)
    if degrees < FEW_REPLICATES:
        return Noise(None, 0, "estimated from the residuals")
    return Noise(math.sqrt(within / degrees), degrees, f"of replicates, {degrees} degrees of freedom", within)


@dataclass(frozen=True)
class Fit:
    """The fit of one law: ``z`` of the keys, covariance of z, and ``t``, half of an interval over its error.

    ``misfit`` and ``notes`` in words, ``doubts``: key -> why it is undetermined. ``band``: half of the interval of each
    predicted value, in the units of the residuals.
    """

    law: str
    keys: tuple[Key, ...]
    z: np.ndarray
    covariance: np.ndarray
    t: float
    sigma: float
    residuals: np.ndarray
    predicted: Predicted
    band: np.ndarray
    misfit: str
    doubts: Mapping[str, str]
    akaike: float
    runs: int
    notes: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Fitted value of each key."""
        return {key.name: key.value(z) for key, z in zip(self.keys, self.z, strict=True)}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Interval of 95 % of each key, within its bounds."""
        half = self.t * np.sqrt(np.diag(self.covariance))
        ends = zip(self.keys, np.maximum(self.z - half, 0.0), np.minimum(self.z + half, 1.0), strict=True)
        return {key.name: (key.value(low), key.value(high)) for key, low, high in ends}

    @property
    def correlation(self) -> dict[str, dict[str, float]]:
        """Correlation of each pair of keys."""
        error = np.sqrt(np.diag(self.covariance))
        matrix = self.covariance / np.outer(error, error)
        names = [key.name for key in self.keys]
        return {name: dict(zip(names, map(float, row), strict=True)) for name, row in zip(names, matrix, strict=True)}

    @property
    def rms(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def complaints(self) -> list[str]:
        """What is wrong with the fit, in words: a misfit, else the keys that the data do not determine."""
        return [self.misfit] if self.misfit else [f"{name}: {text}" for name, text in self.doubts.items()]


class Problem:
    """Least squares for the ``keys`` of one law; the noise tests the fit."""

    def __init__(self, law: str, predictor: Predictor, keys: Sequence[Key], noise: Noise) -> None:
        self.law, self.predictor, self.keys, self.noise = law, predictor, tuple(keys), noise
        self.data = predictor.measurements
        self.exact = predictor.exact

    def _values(self, z: np.ndarray) -> dict[str, float]:
        return {key.name: key.value(float(one)) for key, one in zip(self.keys, z, strict=True)}

    def residuals(self, points: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the residuals at each of ``points``, infinite where nothing is predicted."""
        found = self.predictor([self._values(z) for z in points])
        nothing = np.full(self.data.size, np.inf)
        return [nothing if each is None else self.data.residuals(each) for each in found]

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Return dr/dz (values, keys) by difference quotients; a column without a change above the error is 0."""
        base = self.residuals([z])[0]
        found = np.zeros((len(base), len(z)))
        sizes = np.array([min(STEPS[self.exact] / key.width, FAR) for key in self.keys])
        missing = list(range(len(z)))
        for steps in (sizes, np.full(len(z), FAR)):
            moved = [np.where(np.arange(len(z)) == k, z + (steps if z[k] < 0.5 else -steps), z) for k in missing]
            changes = [each - base for each in self.residuals(moved)] if missing else []
            for k, change in zip(list(missing), changes, strict=True):
                if np.isfinite(change).all() and np.abs(change).max() > 10.0 * self.predictor.error:
                    found[:, k] = change / (steps[k] if z[k] < 0.5 else -steps[k])
                    missing.remove(k)
        return found

    def starts(self) -> list[np.ndarray]:
        """Return starting points, the best first: the values of the config, and evenly spread ones."""
        count, most = STARTS[self.exact]
        steps = _root_of_spread(len(self.keys)) ** -np.arange(1.0, len(self.keys) + 1.0)
        points = [(0.5 + index * steps) % 1.0 for index in range(count)]
        own = [value_at(self.predictor.config, key.name) for key in self.keys]
        if all(isinstance(value, int | float) for value in own):
            z = np.array([key.place(float(value)) for key, value in zip(self.keys, own, strict=True)])
            points += [z] if np.all((z > 0.0) & (z < 1.0)) else []
        costs = [float(np.sum(each**2)) for each in self.residuals(points)]
        order = [int(index) for index in np.argsort(costs) if math.isfinite(costs[index])]
        if not order:
            self.predictor.config_at(self._values(np.full(len(self.keys), 0.5)))  # a mistake in a key is an error
            raise ConfigError(f"{self.law}: no flow is predicted within the bounds of --free")
        return [points[index] for index in order[:most]]

    def solve(self) -> Fit:
        """Return the best fit; a further starting point is tried where there is a misfit."""
        found: list[Fit] = []
        for start in self.starts():
            found.append(self.refined(start))
            if not found[-1].misfit:
                break
        return min(found, key=lambda fit: fit.rms)

    def refined(self, start: np.ndarray) -> Fit:
        """Return the fit from a starting point, with runs so fine that their error is below a tenth of the noise."""
        fit = self._from(start)
        if self.exact:
            return fit
        for _ in range(MOST_REFINED):
            factor = self.predictor.factor
            self.predictor.factor = factor / FINER
            fine = self.residuals([fit.z])[0]
            error = float(np.sqrt(np.mean((fine - fit.residuals) ** 2)))
            if error <= SMALL * fit.sigma:
                self.predictor.factor = factor
                note = f"runs differ from finer ones by {error / fit.sigma:.2g} of the noise"
                return replace(fit, notes=(note,))
            fit = self._from(fit.z)
        spacing = self.predictor.factor
        raise TisphError(
            f"the numerical error is above a tenth of the noise, {fit.sigma:.2g}, also with {spacing:.2g} of the "
            "spacing of the config: give a finer config, or data and a flow that need less"
        )

    def _from(self, start: np.ndarray) -> Fit:
        from scipy.optimize import least_squares

        solved = least_squares(
            lambda z: self.residuals([z])[0],
            start,
            self.jacobian,
            (0.0, 1.0),
            max_nfev=MOST_STEPS[self.exact],
            **TOLERANCES[self.exact],
        )
        return self._judged(solved.x)

    def _judged(self, z: np.ndarray) -> Fit:
        """Return the fit at the minimum ``z`` with its intervals and tests."""
        from scipy.special import stdtrit

        residuals, jacobian = self.residuals([z])[0], self.jacobian(z)
        free = self.data.size - len(z)
        squares = float(np.sum(residuals**2))
        known = self.noise.sigma
        sigma = max(math.sqrt(squares / free) if known is None else known, self.predictor.error)
        degrees = free if known is None else self.noise.degrees
        t = float(stdtrit(min(degrees, 1e9), CONFIDENCE))
        covariance = np.linalg.inv(jacobian.T @ jacobian / sigma**2 + np.eye(len(z)))
        misfit = "" if math.sqrt(squares / free) < 10.0 * self.predictor.error else self._misfit(residuals, free)
        predicted = self.predictor([self._values(z)])[0]
        assert predicted is not None
        count, parameters = self.data.size, len(z) + (known is None)
        fitness = squares / sigma**2 if known else count * math.log(max(squares / count, self.predictor.error**2))
        correction = 2.0 * parameters * (parameters + 1) / max(count - parameters - 1, 1)
        return Fit(
            law=self.law,
            keys=self.keys,
            z=z,
            covariance=covariance,
            t=t,
            sigma=sigma,
            residuals=residuals,
            predicted=predicted,
            band=t * np.sqrt(np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian)),
            misfit=misfit,
            doubts=self._doubts(z, covariance, t, jacobian),
            akaike=fitness + 2.0 * parameters + correction,
            runs=sum(each is not None for each in self.predictor.known.values()),
        )

    def _misfit(self, residuals: np.ndarray, free: int) -> str:
        """Return why the residuals are no noise, in words; empty where they may be."""
        from scipy.special import chdtrc, fdtrc

        squares, noise = float(np.sum(residuals**2)), self.noise
        size = math.sqrt(squares / free)
        if noise.sigma is not None and math.isinf(noise.degrees):
            if chdtrc(free, squares / noise.sigma**2) < UNLIKELY:
                return f"misfit: the residuals are {size / noise.sigma:.3g} times the noise that is given"
            return ""
        if noise.sigma is not None:
            between = free - noise.degrees
            ratio = max(squares - noise.within, 0.0) / max(between, 1) / noise.sigma**2
            if between > 0 and fdtrc(between, noise.degrees, ratio) < UNLIKELY:
                return f"misfit: the residuals are {math.sqrt(ratio):.3g} times the scatter of replicates"
            return ""
        if size > LARGE:
            return f"misfit: the residuals are {100 * size:.3g} % of the data: another unit, column, geometry or law"
        pairs = neighbours(self.data)
        for score in (residuals, normal_scores(residuals)):  # of a misfit at a few points, and at most of them
            products = score[pairs[:, 0]] * score[pairs[:, 1]] / np.mean(score**2)
            if len(pairs) >= FEW_PAIRS and np.sum(products) > CORRELATED * math.sqrt(len(pairs)):
                text = f"residuals of neighbouring points are correlated, by {np.mean(products):.2g}, as noise is not"
                return f"misfit: {text}: another unit, column, geometry or law"
        return ""

    def _doubts(self, z: np.ndarray, covariance: np.ndarray, t: float, jacobian: np.ndarray) -> dict[str, str]:
        """Return key -> why the data do not determine it, in words."""
        error = np.sqrt(np.diag(covariance))
        beyond = [(one - t * own < 0.0, one + t * own > 1.0) for one, own in zip(z, error, strict=True)]
        doubts = {}
        for k, key in enumerate(self.keys):
            pairs = [
                other.name
                for j, other in enumerate(self.keys)
                if j != k and any(beyond[j]) and abs(covariance[k, j]) > DEGENERATE * error[k] * error[j]
            ]
            if not jacobian[:, k].any():
                doubts[key.name] = "undetermined: the data do not depend on it"
            elif all(beyond[k]) and pairs:
                doubts[key.name] = f"undetermined: the data show only a combination of it and {' and '.join(pairs)}"
            elif all(beyond[k]):
                doubts[key.name] = "undetermined: every value between its bounds fits the data"
            elif any(beyond[k]):
                bound = f"below {key.low:g}" if beyond[k][0] else f"above {key.high:g}"
                doubts[key.name] = f"undetermined: values beyond its bounds, {bound}, fit the data too"
        return doubts


def _root_of_spread(count: int) -> float:
    """Return the root of x^(n+1) = x + 1, whose negative powers spread points evenly (M. Roberts, 2018)."""
    x = 1.5
    for _ in range(50):
        x = (1.0 + x) ** (1.0 / (count + 1.0))
    return x


def normal_scores(values: np.ndarray) -> np.ndarray:
    """Return the values (n,) that a normal distribution has in the place of each of ``values``, by its rank.

    They are the scores of B. L. van der Waerden, Indag. Math. 14 (1952) 453-458.
    """
    from scipy.special import ndtri

    _, which, count = np.unique(values, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(count) - 0.5 * (count - 1))[which.ravel()]
    return np.asarray(ndtri((ranks - 0.375) / (len(values) + 0.25)))


def neighbours(data: Measurements) -> np.ndarray:
    """Return indices (n, 2) of pairs of neighbouring values of one quantity.

    Over time, rate or frequency the next two of each value; of velocities the two nearest places at one time, and
    successive times at one place.
    """
    columns, rows = list(data.at.values()), len(next(iter(data.at.values())))
    pairs: set[tuple[int, int]] = set()
    if data.kind != "velocity":
        order = np.argsort(columns[0], kind="stable").tolist()
        pairs |= {*itertools.pairwise(order), *zip(order, order[2:], strict=False)}
    else:
        from scipy.spatial import KDTree

        t, x, y = columns
        for time in np.unique(t):
            here = np.flatnonzero(t == time)
            points = np.stack([x[here], y[here]], axis=1)
            nearest = here[KDTree(points).query(points, min(3, len(here)))[1].reshape(len(here), -1)]
            pairs |= {(min(a, b), max(a, b)) for a, *others in nearest.tolist() for b in others if a != b}
        order = np.lexsort((t, y, x)).tolist()
        pairs |= {(a, b) for a, b in itertools.pairwise(order) if x[a] == x[b] and y[a] == y[b]}
    found = np.array(sorted(pairs), dtype=int).reshape(-1, 2)
    return np.concatenate([found + number * rows for number in range(len(data.measured))])


def value_at(config: Config, key: str) -> Any:
    """Return the value of a dotted ``key`` of the config; None where it has none."""
    parts: list[Any] = [int(part) if part.isdecimal() else part for part in key.split(".")]
    with suppress(KeyError, IndexError, TypeError):
        return reduce(getitem, parts, config.resolved())
    return None


RHEOLOGY = "fluid.rheology."


def of_law(law: str, config: Config, keys: Sequence[Key]) -> tuple[str, str, list[Key]]:
    """Return the name of a ``law``, the override that puts it into the ``config``, and the ``keys`` that it has.

    ``law`` is a name, or a map such as {type: power_law, reference_rate: 1.0}. Parameters that are neither free nor in
    the map are those of the config. ConfigError where one is missing.
    """
    try:
        given = parse(law).data
    except YamlTextError:
        given = None
    values = dict(given) if isinstance(given, dict) else {"type": law}
    names, name = registry.names("rheology"), str(values.get("type"))
    if name not in names:
        raise ConfigError(f"--law {law}: must be one of {', '.join(names)}, or a map{nearest(name, names)}")
    fields = registry.load("rheology", name).Parameters.model_fields
    kept = [key for key in keys if not key.name.startswith(RHEOLOGY) or _parameter(key) in fields]
    values |= {_parameter(key): key.value(0.5) for key in kept if key.name == RHEOLOGY + _parameter(key)}
    values = {part: value for part, value in config.resolved()["fluid"]["rheology"].items() if part in fields} | values
    for part, field in fields.items():
        if part not in values and field.is_required():
            text = f"give it with --free, in the config, or as --law '{{type: {name}, {part}: ...}}'"
            raise ConfigError(f"--law {law}: needs {RHEOLOGY}{part}: {text}")
    return name, override_texts({RHEOLOGY.rstrip("."): values})[0], kept


def _parameter(key: Key) -> str:
    """Return the first part of a key of the rheology, such as modes."""
    return key.name.removeprefix(RHEOLOGY).partition(".")[0]


def fit(
    path: str,
    paths: Sequence[Path],
    free: Sequence[str],
    laws: Sequence[str],
    sigma: float | None,
    question: judge.Question,
    overrides: Sequence[str],
    folder: Path | None,
    processes: int,
    say: Callable[..., None],
) -> tuple[list[Fit], Path]:
    """Fit the config in ``path`` to the measurements in ``paths``; return the fits of the laws, the best first.

    ``free``: texts KEY=LOW..HIGH. Leaves numbers, a table, a picture and the fitted config in ``folder``.
    """
    config = load(path, overrides)
    scene = scenes.of(config)
    keys = [key_of(text) for text in free]
    if not keys or len({key.name for key in keys}) < len(keys):
        raise ConfigError("--free: give each key once, at least one: --free fluid.dynamic_viscosity=0.1..10")
    if sigma is not None and not 0.0 < sigma < 1.0:
        raise ConfigError(f"--sigma {sigma:g}: is a part of the data, between 0 and 1, such as 0.01")
    data = read(config, scene, paths, question, history_columns(config, scene))
    if data.size < len(keys) + 2:
        raise ConfigError(f"{paths[0]}: has {data.size} values: {len(keys)} keys need {len(keys) + 2} at least")
    noise = noise_of(data, sigma)
    out = folder or Path("runs") / f"fit-{config.name}"
    with claimed(out, "another fit is running there"):
        problems: dict[str, Problem] = {}
        for law in laws or [""]:
            name, *replacing, own = of_law(law, config, keys) if law else (config.fluid.rheology.type, keys)
            if name in problems:
                raise ConfigError(f"--law {law}: is given twice")
            predictor = Predictor(path, [*overrides, *replacing], data, out / RUNS, processes)
            problems[name] = Problem(name, predictor, own, noise)
            for key in keys:
                if key not in own:
                    say(f"{name} has no {_parameter(key)}: not fitted")
        kind = "exact predictions" if predictor.exact else f"runs, kept in {out / RUNS}"
        say(f"{data.size} values of {', '.join(data.measured)} in {paths[0]}; {kind}", *data.notes, sep="\n  ")
        found = sorted((problem.solve() for problem in problems.values()), key=lambda fit: fit.akaike)
        chosen = best(found)
        found = [chosen, *(each for each in found if each is not chosen)]
        write(problems[chosen.law], found, out)
    say(text(found, noise))
    return found, out


def best(fits: Sequence[Fit]) -> Fit:
    """Return the fit with the fewest keys among those that the best one by ``akaike`` does not beat by ``EVIDENCE``."""
    least = min(each.akaike for each in fits)
    likely = [each for each in fits if each.akaike - least < 2.0 * math.log(EVIDENCE)]
    return min(likely, key=lambda each: (len(each.keys), each.akaike))


def weights(fits: Sequence[Fit]) -> list[float]:
    """Return the Akaike weight of each fit."""
    least = min(each.akaike for each in fits)
    parts = [math.exp(0.5 * (least - each.akaike)) for each in fits]
    return [part / sum(parts) for part in parts]


def numbers(fits: Sequence[Fit], noise: str) -> dict[str, Any]:
    """Return the contents of ``fit.json``: the best fit, and all laws where there are several."""
    fit = fits[0]
    intervals = fit.intervals
    found = {
        "law": fit.law,
        "fits": not fit.misfit,
        "values": {
            name: {"value": value, "interval": list(intervals[name]), "determined": name not in fit.doubts}
            for name, value in fit.values.items()
        },
        "correlation": fit.correlation,
        "residual": fit.rms,
        "sigma": fit.sigma,
        "noise": noise,
        "runs": fit.runs,
        "complaints": fit.complaints,
        "notes": list(fit.notes),
    }
    if len(fits) > 1:
        found["laws"] = {
            each.law: {"akaike": each.akaike, "weight": weight, "residual": each.rms, "values": each.values}
            for each, weight in zip(fits, weights(fits), strict=True)
        }
    return found


def write(problem: Problem, fits: Sequence[Fit], folder: Path) -> None:
    """Write numbers, table, picture and fitted config of the best fit into ``folder``."""
    fit, data = fits[0], problem.data
    with replaced(folder / NUMBERS) as new:
        new.write_text(json.dumps(numbers(fits, problem.noise.source), indent=1) + "\n", encoding="utf-8")
    config = problem.predictor.config_at(fit.values)
    with replaced(folder / FITTED) as new:
        new.write_text(config.resolved_yaml(), encoding="utf-8")
    with replaced(folder / TABLE) as new, new.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["quantity", *data.at, "measured", "fitted", "residual"])
        residuals = iter(fit.residuals)
        for name, values in data.measured.items():
            rows = zip(*data.at.values(), values, fit.predicted[name], strict=True)
            writer.writerows([name, *map(float, row), float(next(residuals))] for row in rows)
    draw(folder / PICTURE, f"{config.name}: fit of {fit.law}", panels(scenes.of(config), data, fit))


UNITS = dict.fromkeys(("u", "v", "w", "speed"), "velocity") | dict.fromkeys(("y", "r"), "length")
UNITS |= dict.fromkeys(("stress", "n1", "storage_modulus", "loss_modulus"), "stress") | {"viscosity": "viscosity"}
UNITS |= dict.fromkeys(("shear_rate", "angular_frequency", "angular_velocity"), "rate") | {"time": "time"}
"""Name in a picture -> kind of its unit."""


def panels(scene: Scene, data: Measurements, fit: Fit) -> list[FitPanel]:
    """Return what the picture shows of each measured quantity: over its place at each time, or what it depends on.

    Measured velocities in a plane are shown over the fitted ones.
    """
    found = []
    label, first = next(iter(data.at.items()))
    abscissa: np.ndarray | None = first
    curve, names = True, tuple([""])
    group = np.zeros(len(first), dtype=int)
    if data.kind == "velocity":
        times, group = np.unique(data.at["t"], return_inverse=True)
        names = tuple(f"t = {time:.4g}" for time in times)
        abscissa, label, curve = _places(scene, data)
    residuals, bands = (np.split(each, len(data.measured)) for each in (fit.residuals, fit.band))
    for (name, values), scale, off, band in zip(data.measured.items(), data.scales, residuals, bands, strict=True):
        fitted = fit.predicted[name]
        if data.kind in RELATIVE:
            lower, upper = fitted * np.exp(-band), fitted * np.exp(band)
        else:
            lower, upper = fitted - scale * band, fitted + scale * band
        x = fitted if abscissa is None else abscissa
        kind = UNITS.get(name, "")
        words = axis_label(name.replace("_", " "), unit_label(kind, scene.units))
        over = axis_label(label.replace("_", " "), unit_label(UNITS.get(label, ""), scene.units))
        labels = (f"fitted {words}", f"measured {words}") if abscissa is None else (over, words)
        logarithmic = data.kind in RELATIVE
        found.append(
            FitPanel(labels, logarithmic, x, values, fitted, lower, upper, off / fit.sigma, group, names, curve)
        )
    return found


def _places(scene: Scene, data: Measurements) -> tuple[np.ndarray | None, str, bool]:
    """Return the coordinate on which velocities depend, its name, and whether they depend on it alone."""
    x, y = data.at["x"], data.at["y"]
    if scene.parallel:
        return y, "y", True
    if isinstance(scene, Annulus):
        return scene.radii(x, y), "r", "v" in data.measured and len(data.measured) == 1
    return (y, "r", True) if scene.axisymmetric and np.ptp(x) == 0.0 else (None, "", False)


def text(fits: Sequence[Fit], noise: Noise) -> str:
    """Return the printed text: a table of values, correlations, the noise, and a table of laws."""
    fit = fits[0]
    rows = [
        (name, f"{value:.6g}", f"{low:.5g} to {high:.5g}", "no" if name in fit.doubts else "yes")
        for (name, value), (low, high) in zip(fit.values.items(), fit.intervals.values(), strict=True)
    ]
    parts = [format_table(("key", "value", "95 % interval", "determined"), rows)]
    names = [key.name for key in fit.keys]
    pairs = [(a, b, fit.correlation[a][b]) for k, a in enumerate(names) for b in names[k + 1 :]]
    parts += [f"correlation of {a} and {b}: {value:.3f}" for a, b, value in pairs]
    parts.append(f"residual {fit.rms:.3g}, noise {fit.sigma:.3g} of the data, {noise.source}; {fit.runs} predictions")
    if len(fits) > 1:
        table = [
            (each.law, str(len(each.keys)), f"{each.rms:.3g}", f"{each.akaike - fit.akaike:+.1f}", f"{weight:.3f}")
            for each, weight in zip(fits, weights(fits), strict=True)
        ]
        parts.append(format_table(("law", "keys", "residual", "Akaike, less that of the first", "weight"), table))
    return "\n".join([*parts, *fit.notes])
