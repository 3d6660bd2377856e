"""``tisph run --estimate-error``: the error of a run, estimated from the run itself and two coarser ones.

The coarser runs have 1/2 and 1/sqrt(2) of the particles across, or what is nearest and fills the box, and steps longer
by the same factor (``schemes.coarsen_steps``). They are processes of their own, kept in a folder beside the results.

Fields are compared where the particles of the coarsest run are, so that only the finer two are interpolated. Of each
field at each sample there is an observed order; that of the run is their median, and errors are estimated with it:
disorder makes single orders scatter by one and more. Numbers are extrapolated each with its own order.

Where a coarser run is impossible, or does not end, there is a finer one instead, after the run itself, and errors are
those of the least order that is to be expected, the largest ones that the difference of the two allows.
"""

import math
import statistics
import sys
from contextlib import closing, suppress
from dataclasses import asdict, dataclass

import numpy as np
from pydantic import ValidationError

from tisph import scenes, schemes
from tisph.errors import ConfigError
from tisph.folder import Folder
from tisph.measures.fits import interpolated
from tisph.observers._storage import read_snapshots
from tisph.simulation.recording import write_summary
from tisph.snapshot import STRESSES
from tisph.studies.processes import read_result
from tisph.studies.store import Store
from tisph.text_table import format_table

PAIRS = ((0, 1), (1, 2), (0, 2))

ORDERS = 0.1, 12.0
"""Between which orders are looked for."""

ROUNDING = 1e-13
"""Differences over the size of what differs that are rounding errors."""

LARGEST_MISFIT = math.log(2.0)
"""Largest deviation of the logarithm of a difference from the fit: what the scatter of disordered runs makes of it."""


@dataclass(frozen=True)
class Extrapolation:
    """``order`` that was observed and ``error`` of the finest run, in what the differences are in.

    Where no error can be estimated, it is None and ``reason`` says why, in words; ``order`` is None where there is
    none.
    """

    order: float | None
    error: float | None
    reason: str | None = None


def of_number(spacings, values, expected, size=None):
    """Return the Extrapolation of a number with ``values`` in runs of ``spacings``, three each, from coarse to fine.

    ``expected``: smallest and largest order with which an error is estimated; ``size``: what round-off errors refer to,
    the largest value by default. The error is absolute.
    """
    first, second = values[0] - values[1], values[1] - values[2]
    size = max(map(abs, values)) if size is None else size
    if max(abs(first), abs(second)) > ROUNDING * size and first * second <= 0:
        return Extrapolation(None, None, "not monotone: it goes up and down with the spacing")
    return of_norms(spacings, [abs(values[one] - values[other]) for one, other in PAIRS], expected, size)


def of_pair(spacings, difference, expected):
    """Return the Extrapolation of the coarser of two runs of ``spacings`` from the norm of their ``difference``.

    Its order cannot be seen: that is the least of the ``expected``, with which the error is largest.
    """
    if not math.isfinite(difference):
        return Extrapolation(None, None, "not a number in one of the runs")
    return Extrapolation(None, float(difference / (1.0 - (spacings[1] / spacings[0]) ** expected[0])))


def of_norms(spacings, norms, expected, size=1.0, order=None):
    """Return the Extrapolation of a field from the ``norms`` of its differences 1-2, 2-3 and 1-3.

    With an ``order`` the error is that at this one, be the observed one what it may in between ``expected``: that of
    one field at one time scatters.
    """
    if not np.isfinite(norms).all():
        return Extrapolation(None, None, "not a number in one of the runs")
    if max(norms) <= ROUNDING * size:
        return Extrapolation(None, None, "the runs agree but for rounding")
    if not norms[0] > norms[1] > 0.0:
        return Extrapolation(None, None, "does not converge: the finer two runs differ no less than the coarser two")
    observed, misfit, model = _fitted(np.asarray(spacings), np.asarray(norms))
    reason = None
    if misfit > LARGEST_MISFIT:
        reason = "no one order: the three differences do not fit a power of the spacing"
    elif not expected[0] <= observed <= expected[1]:
        reason = f"order {observed:.2g} where {expected[0]:g} to {expected[1]:g} is to be expected"
    if reason:
        return Extrapolation(observed, None, reason)
    scale, _ = _scale(np.asarray(spacings), np.asarray(norms), order or observed, model)
    return Extrapolation(observed, scale * (spacings[2] / spacings[0]) ** (order or observed))


def _fitted(spacings, norms):
    """Order and misfit of the model that fits better, and that model."""
    from scipy.optimize import minimize_scalar

    def misfit(order, model):
        return float(np.sum(_scale(spacings, norms, order, model)[1] ** 2))

    found = []
    for model in (np.subtract, np.hypot):
        order = float(minimize_scalar(misfit, bounds=ORDERS, args=(model,), options={"xatol": 1e-9}).x)
        found.append((np.abs(_scale(spacings, norms, order, model)[1]).max(), order, model))
    most, order, model = min(found, key=lambda each: each[0])
    return order, float(most), model


def _scale(spacings, norms, order, model):
    """Error of the coarsest run that fits the ``norms`` best, and the residual of their logarithms."""
    errors = (spacings / spacings[0]) ** order
    left = np.log(norms) - np.log([model(errors[one], errors[other]) for one, other in PAIRS])
    return float(np.exp(left.mean())), left - left.mean()


FOLDER = "coarser"
"""Of the coarser runs, in that of the results."""

FACTORS = 2.0, 2.0**0.5
FINER = 1 / 1.5
"""Spacings over that of the run, of the coarser runs and of the finer one."""

NEAR = 1.1
"""Factor within which the particles across may differ from the wanted ones: less than half the way to the next."""


class Coarser:
    """The coarser runs of a ``config``, or the finer one, to be kept in the results folder ``root``.

    ``message`` says why there is no estimate from coarser ones. ConfigError where the config allows neither.
    """

    def __init__(self, config, root):
        self.config, self.root, self.message = config, root, None
        try:
            self.configs = [_other(config, factor) for factor in FACTORS]
        except ConfigError as error:
            self.configs = [_other(config, FINER)]
            self.message = str(error)

    @property
    def names(self):
        """Folders of the runs in ``FOLDER``."""
        return [f"across_{each['discretisation']['particles_across']}" for each in self.configs]

    def run(self):
        """Run the coarser ones one after the other, but for those that have run; name the finer one where they fail."""
        if not self.message:
            self.message = self._run("coarser")
            if self.message:
                self.configs = []
                with suppress(ConfigError):
                    self.configs = [_other(self.config, FINER)]
        if self.message and self.configs:
            finer = _validated(self.config, self.configs[0])
            known = schemes.estimates(schemes.resolve(finer)[0], scenes.of(finer))
            text = f"after the run a finer one, {finer.particles_across} across, tells the error instead"
            cost = "about {} to {} steps".format(*known["samples"][-1].steps_range(known["steps"]))
            print(f"{self.message}\n{text}: {cost}", file=sys.stderr, flush=True)

    def report(self):
        """Write the estimates into the ``summary.json`` of the finished run, and return them as text."""
        reason = self.message and (self._run("finer") if self.configs else self.message)
        estimate = {"reason": reason}
        if not reason:
            folders = [self.root / FOLDER / name for name in self.names]
            others = [_validated(self.config, each) for each in self.configs]
            folders, configs = [*folders, self.root], [*others, self.config]
            if self.message:
                folders, configs = folders[::-1], configs[::-1]
            estimate |= compare([read_result(folder) for folder in folders], configs)
        summary = read_result(self.root).summary
        write_summary(Folder(self.root).summary, {**summary, "error_estimate": estimate})
        return text(estimate, self.config)

    def _run(self, kind):
        """Run ``configs``; return what did not end, None where all did."""
        configs, failed = dict(zip(self.names, self.configs, strict=True)), None
        with closing(Store(self.root / FOLDER).outcomes(configs, 1)) as ended:
            for name, _, message in ended:
                if message:
                    failed = f"the {kind} run {name} did not finish: {message}"
        return failed


def _other(config, factor):
    """Return the config, a plain dict without its name, of a run with about 1/``factor`` of the particles across."""
    resolved, wanted = schemes.resolve(config)[0], config.particles_across / factor
    near = range(int(wanted / NEAR), int(wanted * NEAR) + 2)
    for across in sorted((n for n in near if wanted / NEAR < n < wanted * NEAR), key=lambda n: abs(n - wanted)):
        changed = schemes.coarsen_steps(resolved, config.particles_across / across)
        data = changed.resolved()
        data["discretisation"] |= {"particles_across": across, "spacing": None}
        data["output"] = {"video": None}
        del data["name"]
        with suppress(ValidationError):
            _validated(config, data)
            return data
    text = f"--estimate-error: needs a run with about {wanted:.0f} particles across, which this config does not allow"
    raise ConfigError(f"{text}; give more particles across, or a box that they fill")


def _validated(config, data):
    return type(config).model_validate({"name": config.name, **data})


def compare(results, configs):
    """Return estimates as in ``summary.json`` from ``Result`` and configs of runs, from coarse to fine.

    Of three runs they are those of the last, of two those of the first.
    """
    compared = [scenes.of(each) for each in configs]
    spacings, expected = [scene.spacing for scene in compared], schemes.orders(schemes.resolve(configs[-1])[0])
    snapshots = zip(*(read_snapshots(Folder(result.folder).samples) for result in results), strict=True)
    norms = [{**_fields(compared, each), **_profiles(compared, each)} for each in snapshots]
    order = None if len(configs) == 2 else _median_order(spacings, norms, expected)
    samples = []
    for fields, *numbers in zip(norms, *(result.summary["samples"] for result in results), strict=True):
        values = {name: [each[name] for each in numbers] for name in compared[-1].flow_quantities}
        values = {name: each for name, each in values.items() if None not in each}
        if len(configs) == 2:
            errors = {name: of_pair(spacings, each[0], expected) for name, each in fields.items()}
            found = {name: of_pair(spacings, abs(one - other), expected) for name, (one, other) in values.items()}
        else:
            errors = {name: of_norms(spacings, each, expected, order=order) for name, each in fields.items()}
            found = {name: of_number(spacings, each, expected) for name, each in values.items()}
        samples.append({"t": numbers[-1]["t"], "fields": _plain(errors), "numbers": _plain(found)})
    return {"particles_across": [each.particles_across for each in configs], "order": order, "samples": samples}


def _median_order(spacings, norms, expected):
    """Return the median of the orders that are observed, None without any."""
    observed = [of_norms(spacings, each, expected) for sample in norms for each in sample.values()]
    orders = [each.order for each in observed if each.error is not None]
    return statistics.median(orders) if orders else None


def _plain(found):
    return {name: asdict(each) for name, each in found.items()}


def _fields(compared, snapshots):
    """Norms of the differences of the fields between the runs, over the norm of each field, by name."""
    names = {"velocity": ("u", "v")}
    if not compared[0].parallel:
        names["pressure"] = ("pressure",)
    if compared[0].polymer:
        names["polymer_stress"] = STRESSES
    coarsest = snapshots[0]
    points = np.stack([coarsest.x, coarsest.y], axis=1).astype(float)
    found = {}
    for name, parts in names.items():
        values = [np.stack([getattr(each, part) for part in parts], axis=1).astype(float) for each in snapshots]
        values = [
            values[0],
            *(_at(*each, points) for each in zip(compared[1:], snapshots[1:], values[1:], strict=True)),
        ]
        if name == "pressure":  # of which only differences count
            values = [each - each.mean() for each in values]
        if name == "velocity":
            values = [each - [compared[0].frame_velocity, 0.0] for each in values]
        found[name] = _norms(values)
    return found


def _profiles(compared, snapshots):
    """The same of the profiles of the scene, at as many points as there are particles on the line in the coarsest."""
    found = {}
    for profiles in zip(*(scene.profiles() for scene in compared), strict=True):
        line = profiles[0].line
        count = round((line.ends[1] - line.ends[0]) / compared[0].spacing)
        x, y = np.broadcast_arrays(*line.points(line.coordinates(2 * count + 1)[1::2]))
        points, values = np.stack([x, y], axis=1), []
        if compared[0].bodies:  # a line may lead through them
            points = points[compared[0].contains(points, snapshots[0].t)]
        for scene, profile, snapshot in zip(compared, profiles, snapshots, strict=True):
            values.append(_at(scene, snapshot, np.asarray(profile.of(snapshot), float)[:, None], points))
        found[f"{profiles[0].name} along {line.along}"] = _norms(values)
    return found


def _at(scene, snapshot, values, points):
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    return interpolated(scene, positions, values, points)


def _norms(values):
    size = np.linalg.norm(values[-1]) or 1.0
    pairs = PAIRS[: 3 if len(values) == 3 else 1]
    return [float(np.linalg.norm(values[one] - values[other]) / size) for one, other in pairs]


def text(estimate, config):
    """Return the estimates as a table, and what there is to say of the run."""
    if estimate["reason"]:
        return f"no estimate of the error: {estimate['reason']}"
    across = estimate["particles_across"]
    rows = [
        (f"{sample['t']:g} {config.units.time}", name, *_cells(found, sort))
        for sample in estimate["samples"]
        for sort in ("fields", "numbers")
        for name, found in sample[sort].items()
    ]
    order = "none" if estimate["order"] is None else f"{estimate['order']:.2g}"
    head = f"estimated error, from {', '.join(map(str, across[:-1]))} and {across[-1]} particles across; order {order}"
    return f"{head}\n{format_table(('t', 'quantity', 'error', 'order', 'remark'), rows)}"


def _cells(found, sort):
    order = "" if found["order"] is None else f"{found['order']:.2g}"
    if found["error"] is None:
        return "none", order, found["reason"]
    return f"{found['error']:.1e}", order, "relative, L2" if sort == "fields" else "absolute"
