"""``tisph run --estimate-error``: the error of a run, estimated from the run itself and two coarser ones.

The coarser runs have 1/2 and 1/sqrt(2) of the particles across, or the nearest number that fills the box, and steps
longer by the same factor (``schemes.coarsen_steps``). They are separate processes, kept in a folder of the results.

Fields are compared at the particles of the coarsest run, so that only the two finer runs are interpolated. Each field
at each sample has an observed order; errors of all fields are estimated with the median of these orders, since disorder
makes single orders scatter by one and more. Each number is extrapolated with its own order.

Errors e_i = C h_i^p of three runs of spacings h_1 > h_2 > h_3 make the differences |e_i - e_j| if the errors have one
shape (Richardson), and norms sqrt(e_i^2 + e_j^2) if they are independent, as for disordered particles. For both models
C and p are fitted to the logarithms of the three norms 1-2, 2-3 and 1-3, and the better fit is taken. Spacings may have
any ratios.

Where a coarser run is impossible, or does not end, a finer run is made instead, after the run itself. With the least
expected order the difference of the two gives the largest possible error.

A number whose runs show no order, as forces do that scatter, has no estimated error; the spread of the runs is stated.

Source: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413, for errors of one shape.
"""

import math
import statistics
import sys
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from functools import reduce
from pathlib import Path
from typing import Any, cast

import numpy as np
from pydantic import ValidationError

from tisph import scenes, schemes
from tisph.config.schema import Config
from tisph.errors import ConfigError
from tisph.folder import Folder
from tisph.measures.fits import interpolated
from tisph.measures.heat import flow_quantities
from tisph.results import open_run
from tisph.scenes._scene import Scene
from tisph.simulation.recording import write_summary
from tisph.snapshot import STRESSES, Snapshot
from tisph.studies.processes import Result, read_result
from tisph.studies.store import Store
from tisph.text_table import format_table

FOLDER = "coarser"
"""Folder of the coarser runs, in the folder of the results."""

FACTORS = 2.0, 2.0**0.5
FINER = 1 / 1.5
"""Spacings of the coarser runs and of the finer run, over the spacing of the run."""

NEAR = 1.1
"""Largest ratio of the particles across to the wanted number: less than half the way to the next run."""

PAIRS = ((0, 1), (1, 2), (0, 2))
"""Runs, from coarse to fine, whose differences are the three norms."""

ORDERS = 0.1, 12.0
"""Range in which the order is fitted."""

ROUNDING = 1e-13
"""Largest difference, over the size of the values, that counts as a rounding error."""

LARGEST_MISFIT = math.log(2.0)
"""Largest deviation of the logarithm of a difference from the fit; the scatter of disordered runs is smaller."""

Range = tuple[float, float]


class Coarser:
    """The coarser runs of a ``config``, or the finer one, kept in the results folder ``root``.

    ``message`` says why there is no estimate from coarser runs. ConfigError where the config allows neither.
    """

    def __init__(self, config: Config, root: Path):
        self.config, self.root = config, root
        self.message: str | None = None
        try:
            self.configs = [respaced(config, factor) for factor in FACTORS]
        except ConfigError as error:
            self.configs = [respaced(config, FINER)]
            self.message = str(error)

    @property
    def names(self) -> list[str]:
        """Folders of the runs in ``FOLDER``."""
        return [f"across_{each['discretisation']['particles_across']}" for each in self.configs]

    def run(self) -> None:
        """Run the missing coarser runs, one after the other; announce the finer run where they fail."""
        if not self.message:
            self.message = self._run("coarser")
            if self.message:
                self.configs = []
                with suppress(ConfigError):
                    self.configs = [respaced(self.config, FINER)]
        if self.message and self.configs:
            finer = validated(self.config, self.configs[0])
            known = schemes.estimates(schemes.resolve(finer)[0], scenes.of(finer))
            text = f"after the run a finer one, {finer.particles_across} across, tells the error instead"
            print(f"{self.message}\n{text}: about {known['steps']} steps", file=sys.stderr, flush=True)

    def report(self) -> str:
        """Write the estimates into the ``summary.json`` of the finished run, and return them as text."""
        reason = self.message and (self._run("finer") if self.configs else self.message)
        estimate: dict[str, Any] = {"reason": reason}
        if not reason:
            folders = [self.root / FOLDER / name for name in self.names]
            others = [validated(self.config, each) for each in self.configs]
            folders, configs = [*folders, self.root], [*others, self.config]
            if self.message:
                folders, configs = folders[::-1], configs[::-1]
            estimate |= compare([read_result(folder) for folder in folders], configs)
        summary = read_result(self.root).summary
        write_summary(Folder(self.root).summary, {**summary, "error_estimate": estimate})
        return text(estimate, self.config)

    def _run(self, kind: str) -> str | None:
        """Run ``configs``; return the message of the last run that did not end, None if all ended."""
        configs, failed = dict(zip(self.names, self.configs, strict=True)), None
        with closing(Store(self.root / FOLDER).outcomes(configs, 1)) as ended:
            for name, _, message in ended:
                if message:
                    failed = f"the {kind} run {name} did not finish: {message}"
        return failed


def respaced(config: Config, factor: float) -> dict[str, Any]:
    """Return the config, a plain dict without its name, of a run with about 1/``factor`` of the particles across.

    ConfigError where the config allows none.
    """
    resolved, wanted = schemes.resolve(config)[0], config.particles_across / factor
    near = range(int(wanted / NEAR), int(wanted * NEAR) + 2)
    for across in sorted((n for n in near if wanted / NEAR < n < wanted * NEAR), key=lambda n: abs(n - wanted)):
        changed = schemes.coarsen_steps(resolved, config.particles_across / across)
        data = changed.resolved()
        data["discretisation"] |= {"particles_across": across, "spacing": None}
        for key in config.spacings:
            *above, name = (int(part) if part.isdigit() else part for part in key.split("."))
            section: Any = reduce(lambda each, part: each[part], above, cast(Any, data))
            section[name] *= config.particles_across / across
        data["output"] = {"video": None}
        del data["name"]
        with suppress(ValidationError):
            validated(config, data)
            return data
    text = f"--estimate-error: needs a run with about {wanted:.0f} particles across, which this config does not allow"
    raise ConfigError(f"{text}; give more particles across, or a box that they fill")


def validated(config: Config, data: dict[str, Any]) -> Any:
    """Return the config ``data``, under the name of ``config``."""
    return type(config).model_validate({"name": config.name, **data})


def compare(results: Sequence[Result], configs: Sequence[Any]) -> dict[str, Any]:
    """Return estimates as in ``summary.json`` from the results and configs of runs, from coarse to fine.

    They are errors of the last of three runs, or of the first of two runs.
    """
    compared: list[Any] = [scenes.of(each) for each in configs]
    spacings, expected = [scene.spacing for scene in compared], schemes.orders(schemes.resolve(configs[-1])[0])
    snapshots: Any = zip(*(open_run(result.folder).snapshots() for result in results), strict=True)
    norms = [{**field_norms(compared, each), **_profiles(compared, each)} for each in snapshots]
    order = None
    if len(configs) == 3:
        observed = [of_norms(spacings, each, expected) for sample in norms for each in sample.values()]
        orders = [each.order for each in observed if each.order is not None and each.error is not None]
        order = statistics.median(orders) if orders else None
    samples = []
    sampled = zip(*(result.summary["samples"] for result in results), strict=True)
    for fields, numbers in zip(norms, sampled, strict=True):
        judged = [*compared[-1].flow_quantities, *flow_quantities(compared[-1], numbers[-1])]
        values = {name: [each[name] for each in numbers] for name in judged}
        values = {name: each for name, each in values.items() if None not in each}
        if len(configs) == 2:
            errors = {name: of_pair(spacings, each[0], expected) for name, each in fields.items()}
            found = {name: of_pair(spacings, abs(one - other), expected) for name, (one, other) in values.items()}
        else:
            errors = {name: of_norms(spacings, each, expected, order=order) for name, each in fields.items()}
            found = {name: of_number(spacings, each, expected) for name, each in values.items()}
        plain = [{name: asdict(each) for name, each in part.items()} for part in (errors, found)]
        samples.append({"t": numbers[-1]["t"], "fields": plain[0], "numbers": plain[1]})
    return {"particles_across": [each.particles_across for each in configs], "order": order, "samples": samples}


def field_norms(
    compared: Sequence[Any], snapshots: Sequence[Snapshot], kind: float | None = None
) -> dict[str, list[float]]:
    """Return name of a field -> norms of its differences between the runs, over the norm of the field.

    ``kind``: of the norm, as for ``numpy.linalg.norm``; infinite for the largest component.
    """
    names: dict[str, tuple[str, ...]] = {"velocity": ("u", "v")}
    if not compared[0].parallel:
        names["pressure"] = ("pressure",)
    if compared[0].polymer:
        names["polymer_stress"] = STRESSES
    names |= {each.name: (each.name,) for each in compared[0].substances}
    coarsest = snapshots[0]
    weight = np.reshape(coarsest.weight, (-1, 1))
    points = np.stack([coarsest.x, coarsest.y], axis=1).astype(float)
    found = {}
    for name, parts in names.items():
        values = [np.stack([each.field(part) for part in parts], axis=1).astype(float) for each in snapshots]
        finer = zip(compared[1:], snapshots[1:], values[1:], strict=True)
        values = [values[0], *(_at(*each, points) for each in finer)]
        if name == "pressure":  # known up to a constant
            values = [each - np.mean(weight * each) for each in values]
        if name == "velocity":
            values = [each - [compared[0].frame_velocity, 0.0] for each in values]
        found[name] = _norms(values if kind else [weight**0.5 * each for each in values], kind)
    return found


def _profiles(compared: Sequence[Any], snapshots: Sequence[Snapshot]) -> dict[str, list[float]]:
    """Return name of a profile of the scene -> norms of its differences, over the norm of the profile.

    A profile is compared at as many points as the coarsest run has particles along its line.
    """
    found = {}
    for profiles in zip(*(scene.all_profiles() for scene in compared), strict=True):
        line = profiles[0].line
        count = round((line.ends[1] - line.ends[0]) / compared[0].spacing)
        x, y = np.broadcast_arrays(*line.points(line.coordinates(2 * count + 1)[1::2]))
        points, values = np.stack([x, y], axis=1), []
        if compared[0].bodies:  # a line may cross them
            points = points[compared[0].contains(points, snapshots[0].t)]
        for scene, profile, snapshot in zip(compared, profiles, snapshots, strict=True):
            values.append(_at(scene, snapshot, np.asarray(profile.of(snapshot), float)[:, None], points))
        found[f"{profiles[0].name} along {line.along}"] = _norms(values)
    return found


def _at(scene: Scene, snapshot: Snapshot, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Interpolate ``values`` (particles, k) of a snapshot to ``points`` (n, 2)."""
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    return interpolated(scene, positions, values, points)


def _norms(values: Sequence[np.ndarray], kind: float | None = None) -> list[float]:
    values = [each.ravel() for each in values]
    size = np.linalg.norm(values[-1], kind) or 1.0
    pairs = PAIRS[: 3 if len(values) == 3 else 1]
    return [float(np.linalg.norm(values[one] - values[last], kind) / size) for one, last in pairs]


@dataclass(frozen=True)
class Extrapolation:
    """The observed ``order``, and the ``error`` of the finest run in the unit of the differences.

    Where no error can be estimated, it is None and ``reason`` says why. ``order`` is None where no order is observed.
    ``spread``: without an error the largest difference between two of the runs, in the same unit. Scatter from
    step to step, as of forces, makes errors of about that size; it bounds no error that all runs have in common.
    """

    order: float | None
    error: float | None
    reason: str | None = None
    spread: float | None = None


def of_number(spacings: Sequence[float], values: Sequence[float], expected: Range) -> Extrapolation:
    """Return the Extrapolation of a number with ``values`` in three runs of ``spacings``, from coarse to fine.

    ``expected``: smallest and largest order with which an error is estimated. The error is absolute.
    """
    first, second = values[0] - values[1], values[1] - values[2]
    size = max(map(abs, values))
    if max(abs(first), abs(second)) > ROUNDING * size and first * second <= 0:
        return Extrapolation(
            None, None, "not monotone: it goes up and down with the spacing", max(values) - min(values)
        )
    return of_norms(spacings, [abs(values[one] - values[other]) for one, other in PAIRS], expected, size)


def of_pair(spacings: Sequence[float], difference: float, expected: Range) -> Extrapolation:
    """Return the Extrapolation of the coarser of two runs of ``spacings`` from the norm of their ``difference``.

    Two runs show no order; the least ``expected`` order gives the largest error.
    """
    if not math.isfinite(difference):
        return Extrapolation(None, None, "not a number in one of the runs")
    return Extrapolation(None, float(difference / (1.0 - (spacings[1] / spacings[0]) ** expected[0])))


def of_norms(
    spacings: Sequence[float], norms: Sequence[float], expected: Range, size: float = 1.0, order: float | None = None
) -> Extrapolation:
    """Return the Extrapolation of a field from the ``norms`` of its differences 1-2, 2-3 and 1-3.

    ``size``: size of the values, to which rounding errors are compared. If ``order`` is given, the error is estimated
    with it, since the observed order of one field at one time scatters.
    """
    if not np.isfinite(norms).all():
        return Extrapolation(None, None, "not a number in one of the runs")
    if max(norms) <= ROUNDING * size:
        return Extrapolation(None, None, "the runs agree but for rounding")
    if not norms[0] > norms[1] > 0.0:
        reason = "does not converge: the finer two runs differ no less than the coarser two"
        return Extrapolation(None, None, reason, float(max(norms)))
    observed, misfit, model = fitted(np.asarray(spacings), np.asarray(norms))
    reason = ""
    if misfit > LARGEST_MISFIT:
        reason = "no one order: the three differences do not fit a power of the spacing"
    elif not expected[0] <= observed <= expected[1]:
        reason = f"order {observed:.2g} where {expected[0]:g} to {expected[1]:g} is to be expected"
    if reason:
        return Extrapolation(observed, None, reason, float(max(norms)))
    coarsest, _ = scale(np.asarray(spacings), np.asarray(norms), order or observed, model)
    return Extrapolation(observed, coarsest * (spacings[2] / spacings[0]) ** (order or observed))


def fitted(spacings: np.ndarray, norms: np.ndarray) -> tuple[float, float, Callable]:
    """Return order and misfit of the model that fits better, and the model: a function of two errors."""
    from scipy.optimize import minimize_scalar

    def misfit(order: float, model: Callable) -> float:
        return float(np.sum(scale(spacings, norms, order, model)[1] ** 2))

    found = []
    for model in (np.subtract, np.hypot):
        order = float(minimize_scalar(misfit, bounds=ORDERS, args=(model,), options={"xatol": 1e-9}).x)
        found.append((np.abs(scale(spacings, norms, order, model)[1]).max(), order, model))
    most, order, model = min(found, key=lambda each: each[0])
    return order, float(most), model


def scale(spacings: np.ndarray, norms: np.ndarray, order: float, model: Callable) -> tuple[float, np.ndarray]:
    """Return the error of the coarsest run that fits the ``norms`` best, and the residuals of their logarithms."""
    errors = (spacings / spacings[0]) ** order
    residuals = np.log(norms) - np.log([model(errors[one], errors[other]) for one, other in PAIRS])
    return float(np.exp(residuals.mean())), residuals - residuals.mean()


def text(estimate: dict[str, Any], config: Config) -> str:
    """Return the estimates as a table under a line about the runs."""
    if estimate["reason"]:
        return f"no estimate of the error: {estimate['reason']}"
    rows = []
    for sample in estimate["samples"]:
        for kind, remark in (("fields", "relative, L2"), ("numbers", "absolute")):
            for name, found in sample[kind].items():
                order = "" if found["order"] is None else f"{found['order']:.2g}"
                error = ("none" if found["spread"] is None else f"spread {found['spread']:.1e}", order, found["reason"])
                if found["error"] is not None:
                    error = (f"{found['error']:.1e}", order, remark)
                rows.append((f"{sample['t']:g} {config.units.time}", name, *error))
    across = estimate["particles_across"]
    order = "none" if estimate["order"] is None else f"{estimate['order']:.2g}"
    head = f"estimated error, from {', '.join(map(str, across[:-1]))} and {across[-1]} particles across; order {order}"
    return f"{head}\n{format_table(('t', 'quantity', 'error', 'order', 'remark'), rows)}"
