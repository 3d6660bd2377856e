"""What became of a cell: stable, inaccurate, stopped, refused or a silent failure, by what the run left behind.

Errors are ``Cell.measure``. Two things are known without the exact solution of a user's own flow, and a run is held
to both: the baseline, the same run from the lattice, and what ``tisph check`` said of it, its warnings and, where it
states one, its error. A two-dimensional flow has no calmer run from the lattice: it is held to bounds of its own, an
even distribution of the particles, no gain of energy unless walls drive it, and a small error.
"""

import math
import re
from dataclasses import dataclass

from tisph.scenes._suspension_stress import BODIES, WALLS
from tisph.studies.stability.cells import FINISHED, FLAGGED, REFUSED, STABLE
from tisph.studies.stability.flows import BOTH_STRESSES, EXACT, FINER, FLOWS

MULTIPLE, EARLY_MULTIPLE = 2.0, 10.0
"""Error over that of the baseline, up to which a run is stable: from t* = 1 on, and before, while the flow still
remembers how the particles were disordered."""

TRANSVERSE, EARLY_TRANSVERSE = 1e-3, 1e-2
"""Largest velocity across the channel of a stable run, over the reference velocity, likewise."""

DENSITY = 1e-2
"""Largest departure of the density of a stable run. Of the explicit scheme at a sound speed of ten times the velocity
scale; it is proportional to the square of the Mach number. Of the implicit one whatever the steps."""

EXPLICIT, IMPLICIT, SINGLE, EARLY = 4e-5, 1e-6, 1e-3, 1e-2
"""Floors, errors below which one is not compared with that of the baseline.

Of the explicit scheme: layers that shear change the viscosity by as much, which a lattice at a Reynolds number too low
for that does not show. Of the implicit one: that of steps of a tolerance of 3e-7. What single precision allows. Before
t* = 1: what disorder may change at the start.
"""

PREDICTED_FACTOR = 3.0
"""Error over the predicted one up to which the prediction was right (``benchmarks/estimates.py``)."""

SILENT, LARGEST = 2e-2, 0.2
"""A finished run in a channel is a silent failure if its error is above the first, or above the second where ``tisph
check`` and ``tisph run`` warned; a two-dimensional run if its error is above the second. Where drag is compared it is
one above the first in a sample that says that it is resolved."""

GROWTH = 2.0
"""Growth over the last quarter of a run from which on something grows: the error over that of the baseline, or a
transverse velocity above a tenth of its bound."""

VOID, DISTANCE = 1.15, 0.55
"""Of a stable two-dimensional run: largest radius of a void, least distance of two particles, in spacings."""

GAIN = 1e-3
"""Part by which the kinetic energy, which only decays there, may exceed that of a quarter of the run before: a mean
over unevenly distributed particles scatters by as much."""

ERROR = {"explicit": (1e-2, 2), "implicit 4": (1e-3, 3)}
"""By scheme, of flows in a periodic square: the largest error, 25 particles across, for every length over speed of the
start, in root mean square over that speed, and the order in the spacing with which it has to fall. For comparison:
PySPH's EDAC has 1.5e-2 at t* = 0.5."""

LEAST_ACROSS, ORDER = 12, 3
"""Particles across at which a flow between walls may have its ``Flow.largest`` error, and the order of its fall."""

UNBALANCED = "unbalanced"
"""The error where there is no reference: the sum of the forces on all bodies and walls, over the largest of them."""

STEADY = 1e-2
"""Part of the largest force by which none may have changed since the sample before, for it to be steady: forces scatter
by 3e-3 while particles pass a cylinder of 6 spacings."""

SILENT_FAILURE = "silent failure"
VERDICTS = ("stable", "inaccurate", "stopped", "refused", SILENT_FAILURE)

MEETS = {STABLE: VERDICTS[:1], FINISHED: VERDICTS[:2], FLAGGED: VERDICTS[:4], REFUSED: VERDICTS[3:4]}
"""Verdicts that meet each requirement."""

NUMBERS = ("error", "transverse", "density_variation", "max_void_radius", "min_distance")
"""What a ``Judgement`` keeps of the last sample of a run."""

GROWS = "grows"
"""Word in the reason of a verdict that fails the requirement ``FINISHED`` nevertheless."""


@dataclass(frozen=True)
class Judgement:
    """A verdict of ``VERDICTS``, why it is no better, whether the requirement is met, and the numbers behind it.

    ``error`` and ``baseline`` error, ``transverse`` velocity over the reference velocity, ``density_variation``,
    ``max_void_radius`` and ``min_distance`` in spacings: at the last sample; None where there is none.
    """

    verdict: str
    reason: str
    met: bool
    error: float | None = None
    baseline: float | None = None
    transverse: float | None = None
    density_variation: float | None = None
    max_void_radius: float | None = None
    min_distance: float | None = None

    @property
    def ratio(self):
        """Error over that of the baseline, None where one is missing."""
        return self.error / self.baseline if self.error is not None and self.baseline else None


def refused(plan):
    """Judge a cell whose config is refused."""
    return Judgement("refused", plan.refusal, "refused" in MEETS[plan.cell.requirement])


def judge(plan, summary, message, baseline):
    """Judge the run of a plan by its ``summary``, its error ``message`` and the summary of the ``baseline``."""
    cell, samples = plan.cell, summary["samples"]
    read = _two_dimensional_sample if cell.two_dimensional else _sample
    found = [read(cell, sample, summary) for sample in samples]
    if cell.measure == FINER and baseline["status"] == "done":
        for each, sample, fine in zip(found, samples, baseline["samples"], strict=False):
            each["error"] = _off_finer(sample, fine)
    compared = baseline["status"] == "done" and not cell.two_dimensional
    errors = [sample[cell.measure] for sample in baseline["samples"]] if compared else []
    # some flows are exact on a lattice, and no measure of others
    compared_errors = errors if cell.requirement == STABLE else []
    verdict, reason = _verdict(plan, summary["status"], message, found, compared_errors)
    last = found[-1] if found else {}
    return Judgement(
        verdict,
        reason,
        met=verdict in MEETS[cell.requirement] and not (cell.requirement == FINISHED and GROWS in reason),
        baseline=errors[len(found) - 1] if 0 < len(found) <= len(errors) else None,
        **{name: value for name, value in last.items() if name in NUMBERS},
    )


def _off_finer(sample, fine):
    """Error of the drags; where bodies are free that of all velocities, over the largest, in lengths and speeds.

    Of Taylor's vortices: that of the torque, and of the radial velocity over the inner speed.
    """
    if "radial_velocity" in sample:
        torque = sample["torque_inner"] / fine["torque_inner"] - 1.0
        return max(abs(torque), abs(sample["radial_velocity"] - fine["radial_velocity"]))
    free = any(name.startswith("angular_velocity") for name in sample)
    rates = [name for name in sample if re.fullmatch(r"(u|v|angular_velocity)(_\d+)?|superficial_velocity", name)]
    if free:
        return max(abs(sample[name] - fine[name]) for name in rates) / max(abs(fine[name]) for name in rates)
    drags = [name for name in sample if re.fullmatch(r"drag(_\d+)?", name)]
    return max(abs(sample[name] / fine[name] - 1.0) for name in drags)


def _sample(cell, sample, summary):
    """What is judged of a ``sample`` of a run in a channel."""
    speed = summary["numbers"]["reference_velocity"]
    return {
        "error": sample[cell.measure],
        "transverse": sample["max_transverse_velocity"] / speed,
        "density_variation": sample["density_variation"],
    }


def _two_dimensional_sample(cell, sample, summary):
    error = sample.get(cell.measure)
    if cell.measure == UNBALANCED:
        error = _unbalanced(sample, summary["samples"])
    if cell.measure == EXACT:
        error = _off_exact(cell, sample)
    if cell.measure == BOTH_STRESSES:
        error = abs(sample[BODIES] / sample[WALLS] - 1.0)
    return {
        "error": error,
        "density_variation": sample["density_variation"],
        "max_void_radius": sample["max_void_radius"],
        "min_distance": sample["min_distance"],
        "energy": sample.get("kinetic_energy"),
        "resolved": sample.get("resolved", True),
    }


def _off_exact(cell, sample):
    """L2 of the velocity, or the error of the loads on walls over the largest, or over that of a shear rate of 1."""
    loads = {name.removesuffix("_exact"): sample[name] for name in sample if name.endswith("_exact")}
    largest = max(2.0 * math.pi / cell.reynolds, *map(abs, loads.values()))
    return max(sample["l2"], *(abs(sample[name] - exact) / largest for name, exact in loads.items()))


def _unbalanced(sample, samples):
    """None where the forces are not yet those of the sample before."""
    at = samples.index(sample)
    drags, before = (_drags(samples[each]) for each in (at, max(at - 1, 0)))
    largest = max(map(abs, drags))
    change = max(abs(one - other) for one, other in zip(drags, before, strict=True))
    return abs(sum(drags)) / largest if at and change <= STEADY * largest else None


def _drags(sample):
    return [sample[name] for name in sample if name.startswith("drag") and not name.startswith("drag_pressure")]


def _verdict(plan, status, message, found, baseline_errors):
    """Return verdict and reason; the reason is empty for a stable run."""
    if status == "diverged" and message:
        return "stopped", message
    if status != "done" or not found:
        return SILENT_FAILURE, f"ended without a clear error: {message or status}"
    error = found[-1]["error"]
    largest = LARGEST if plan.warnings or plan.cell.two_dimensional else SILENT
    if plan.cell.measure in (EXACT, FINER, BOTH_STRESSES):
        error, largest = max((each["error"] or 0.0 for each in found if each["resolved"]), default=0.0), SILENT
    if error is not None and not error <= largest:
        return SILENT_FAILURE, f"error {error:.1e}, {'warned' if plan.warnings else 'no warning'}"
    if plan.cell.two_dimensional:
        faults = list(_two_dimensional_faults(plan, found))
    else:
        faults = [*_channel_faults(plan, found, baseline_errors), *_growths(plan, found, baseline_errors)]
    return ("inaccurate", "; ".join(faults)) if faults else ("stable", "")


def _floor(plan):
    """Error below which runs are not compared; longer steps have larger errors, whatever the particles do."""
    double = EXPLICIT if plan.cell.scheme == "explicit" else IMPLICIT
    floor = (double if plan.cell.precision == "f64" else SINGLE) * plan.cell.step**3
    return max(floor, EARLY if plan.t_star < 1 else 0.0)


def _channel_faults(plan, found, baseline_errors):
    cell, last, early = plan.cell, found[-1], plan.t_star < 1
    error, floor = last["error"], _floor(plan)
    if plan.predicted is not None and error > max(PREDICTED_FACTOR * plan.predicted, floor):
        yield f"error {error:.1e}, predicted {plan.predicted:.0e}"
    multiple = EARLY_MULTIPLE if early else MULTIPLE
    if baseline_errors and error > max(multiple * baseline_errors[-1], floor):
        yield f"error {error / baseline_errors[-1]:.3g} times that of the baseline"
    if last["transverse"] > (EARLY_TRANSVERSE if early else TRANSVERSE):
        yield f"transverse velocity {last['transverse']:.1e} U"
    density = DENSITY * (10.0 / cell.sound) ** 2 if cell.scheme == "explicit" else DENSITY
    if last["density_variation"] > density:
        yield f"density varies by {last['density_variation']:.1e}"


def _growths(plan, found, baseline_errors):
    before, last = found[-2:]
    bound = EARLY_TRANSVERSE if plan.t_star < 1 else TRANSVERSE
    if last["transverse"] > max(GROWTH * before["transverse"], bound / 10):
        yield f"transverse velocity {GROWS} to {last['transverse']:.1e} U"
    if len(baseline_errors) > 1 and last["error"] > _floor(plan):
        growth = last["error"] / baseline_errors[-1] / (before["error"] / baseline_errors[-2])
        if growth > GROWTH:
            yield f"error over that of the baseline {GROWS} {growth:.3g} times"


def _two_dimensional_faults(plan, found):
    """Yield in words what samples, in the order of time, break; of voids and distances at any of them."""
    before, last = found[-2:]
    if last["error"] is not None and last["error"] > _largest_error(plan.cell, plan.t_star):
        yield f"error {last['error']:.1e} U"
    radius, distance = max(each["max_void_radius"] for each in found), min(each["min_distance"] for each in found)
    if radius > VOID:
        yield f"a void has a radius of {radius:.3g} spacings"
    if distance < DISTANCE:
        yield f"two particles are {distance:.3g} spacings apart"
    if not plan.cell.curved_walls and last["energy"] > before["energy"] * (1.0 + GAIN):
        yield f"energy {GROWS} by {last['energy'] / before['energy'] - 1.0:.1e}"


def _largest_error(cell, t_star):
    if cell.curved_walls:
        return FLOWS[cell.flow].largest * (LEAST_ACROSS / cell.across) ** ORDER
    rate, order = ERROR[cell.scheme]
    return rate * max(t_star, 1.0) * (25 / cell.across) ** order
