"""Judgement of a cell from the summary of its run: stable, inaccurate, stopped, refused or a silent failure.

Errors are ``Cell.measure``. A run between plane walls is compared with two things that exist without the exact solution
of a user's own flow: the baseline, the same run from the lattice, and the forecast of ``tisph check``, its warnings and
its predicted error. In two-dimensional flow, where a run from the lattice is no calmer, there are bounds instead: for
the distribution of the particles, for the energy, which may not grow unless walls drive the flow, and for the error.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from tisph.scenes._cell_flow import STRESS_BY_BODIES, STRESS_ON_WALLS
from tisph.studies import stability
from tisph.studies.stability import BOTH_STRESSES, EXACT, FINER, FINISHED, FLAGGED, REFUSED, STABLE, Cell, Plan

BOUNDS = SimpleNamespace(**stability.DATA["bounds"])

SILENT_FAILURE = "silent failure"
VERDICTS = ("stable", "inaccurate", "stopped", "refused", SILENT_FAILURE)

MEETS = {STABLE: VERDICTS[:1], FINISHED: VERDICTS[:2], FLAGGED: VERDICTS[:4], REFUSED: VERDICTS[3:4]}
"""Verdicts that meet each requirement."""

GROWS = "grows"
"""Word in a reason: such a run misses the requirement ``FINISHED``."""


@dataclass(frozen=True)
class Judgement:
    """A verdict of ``VERDICTS``, why it is no better, whether the requirement is met, and the numbers of the run.

    ``error`` and ``baseline_error``, ``transverse_velocity`` over the reference velocity, ``density_variation``,
    ``max_void_radius`` and ``min_distance`` in spacings: at the last sample, None where they do not exist. ``steps``
    and wall-clock ``seconds`` of the run.
    """

    plan: Plan
    verdict: str
    reason: str
    met: bool
    error: float | None = None
    baseline_error: float | None = None
    transverse_velocity: float | None = None
    density_variation: float | None = None
    max_void_radius: float | None = None
    min_distance: float | None = None
    steps: int = 0
    seconds: float = 0.0

    @property
    def cell(self) -> Cell:
        """The cell of the plan."""
        return self.plan.cell

    @property
    def ratio(self) -> float | None:
        """Error over the baseline's error, None where one is missing."""
        return self.error / self.baseline_error if self.error is not None and self.baseline_error else None

    @property
    def short(self) -> str:
        """The verdict in a word, with the error of a run that finished; of a stable run the error alone."""
        number = "" if self.error is None else f"{self.error:.0e}".replace("e-0", "e-")
        if not number or self.verdict in ("stopped", "refused"):
            return self.verdict
        return number if self.verdict == "stable" else f"{self.verdict} {number}"


def refused(plan: Plan) -> Judgement:
    """Judge a cell whose config is refused."""
    return Judgement(plan, "refused", plan.refusal or "", "refused" in MEETS[plan.cell.requirement])


def judge(plan: Plan, summary: dict[str, Any], message: str, baseline: dict[str, Any]) -> Judgement:
    """Judge the run of a plan by its ``summary``, its error ``message`` and the summary of the ``baseline``."""
    cell, samples = plan.cell, summary["samples"]
    found = [_numbers(cell, sample, summary) for sample in samples]
    if cell.measure == FINER and baseline["status"] == "done":
        for each, sample, fine in zip(found, samples, baseline["samples"], strict=False):
            each["error"] = _off_finer(sample, fine)
    compared = baseline["status"] == "done" and not cell.two_dimensional
    errors = [sample[cell.measure] for sample in baseline["samples"]] if compared else []
    # some flows are exact on a lattice, where the error of the baseline is no measure of the error with disorder
    compared_errors = errors if cell.requirement == STABLE else []
    verdict, reason = _verdict(plan, summary["status"], message, found, compared_errors)
    last = found[-1] if found else {}
    cost = summary.get("cost", {})
    return Judgement(
        plan,
        verdict,
        reason,
        met=verdict in MEETS[cell.requirement] and not (cell.requirement == FINISHED and GROWS in reason),
        baseline_error=errors[len(found) - 1] if 0 < len(found) <= len(errors) else None,
        **{name: value for name, value in last.items() if name in Judgement.__dataclass_fields__},
        steps=cost.get("steps", 0),
        seconds=cost.get("wall_total_s", 0.0),
    )


def _numbers(cell: Cell, sample: dict[str, Any], summary: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of a ``sample`` that are judged."""
    error = sample.get(cell.measure) if cell.measure else None
    if cell.measure == stability.UNBALANCED:
        error = _unbalanced(sample, summary["samples"])
    elif cell.measure == EXACT:
        error = _off_exact(cell, sample)
    elif cell.measure == BOTH_STRESSES:
        error = abs(sample[STRESS_BY_BODIES] / sample[STRESS_ON_WALLS] - 1.0)
    found = {"error": error, "density_variation": sample["density_variation"]}
    if not cell.two_dimensional:
        speed = summary["numbers"]["reference_velocity"]
        return {**found, "transverse_velocity": sample["max_transverse_velocity"] / speed}
    return {
        **found,
        "max_void_radius": sample["max_void_radius"],
        "min_distance": sample["min_distance"],
        "energy": sample.get("kinetic_energy"),
        "resolved": sample.get("resolved", True),
    }


def _off_finer(sample: dict[str, Any], fine: dict[str, Any]) -> float:
    """Return the largest difference of a sample to the sample of the finer run.

    Taylor's vortices: of the torque, relative, and of the radial velocity over the inner speed. Free bodies: of all
    velocities, over the largest one. Else of the drags, relative.
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


def _off_exact(cell: Cell, sample: dict[str, Any]) -> float:
    """Return the larger of the L2 error of the velocity and the largest error of the loads on walls.

    Errors of loads are over the largest load, which is at least the load by a shear rate of 1.
    """
    loads = {name.removesuffix("_exact"): sample[name] for name in sample if name.endswith("_exact")}
    largest = max(2.0 * math.pi / cell.reynolds, *map(abs, loads.values()))
    return max(sample["l2"], *(abs(sample[name] - exact) / largest for name, exact in loads.items()))


def _unbalanced(sample: dict[str, Any], samples: list[dict[str, Any]]) -> float | None:
    """Return the sum of all forces over the largest; None while the forces still change from sample to sample."""
    at = samples.index(sample)
    drags, before = (
        [
            value
            for name, value in each.items()
            if name.startswith("drag") and not name.startswith(("drag_pressure", "drag_scatter"))
        ]
        for each in (sample, samples[max(at - 1, 0)])
    )
    largest = max(map(abs, drags))
    change = max(abs(one - other) for one, other in zip(drags, before, strict=True))
    return abs(sum(drags)) / largest if at and change <= BOUNDS.steady * largest else None


def _verdict(
    plan: Plan, status: str, message: str, found: list[dict[str, Any]], baseline_errors: list[float]
) -> tuple[str, str]:
    """Return verdict and reason; the reason is empty for a stable run."""
    if status == "diverged" and message:
        return "stopped", message
    if status != "done" or not found:
        return SILENT_FAILURE, f"ended without a clear error: {message or status}"
    error = found[-1]["error"]
    largest = BOUNDS.largest if plan.warnings or plan.cell.two_dimensional else BOUNDS.silent
    if plan.cell.measure in (EXACT, FINER, BOTH_STRESSES):
        error = max((each["error"] or 0.0 for each in found if each["resolved"]), default=0.0)
        largest = BOUNDS.silent
    if error is not None and not error <= largest:
        return SILENT_FAILURE, f"error {error:.1e}, {'warned' if plan.warnings else 'no warning'}"
    if plan.cell.two_dimensional:
        faults = list(_two_dimensional_faults(plan, found))
    else:
        faults = list(_channel_faults(plan, found, baseline_errors))
    return ("inaccurate", "; ".join(faults)) if faults else ("stable", "")


def _channel_faults(plan: Plan, found: list[dict[str, Any]], baseline_errors: list[float]) -> Iterator[str]:
    """Yield in words the bounds that the last sample breaks, and the growth since the sample before."""
    cell, (before, last), early = plan.cell, found[-2:], plan.t_star < 1
    # the error of longer steps is larger even without disorder
    floor = (BOUNDS.floor[cell.scheme] if cell.precision == "f64" else BOUNDS.single_floor) * cell.step**3
    floor = max(floor, BOUNDS.early_floor if early else 0.0)
    error = last["error"]
    if plan.predicted is not None and error > max(BOUNDS.predicted_factor * plan.predicted, floor):
        yield f"error {error:.1e}, predicted {plan.predicted:.0e}"
    multiple = BOUNDS.early_multiple if early else BOUNDS.multiple
    if baseline_errors and error > max(multiple * baseline_errors[-1], floor):
        yield f"error {error / baseline_errors[-1]:.3g} times that of the baseline"
    transverse = BOUNDS.early_transverse if early else BOUNDS.transverse
    if last["transverse_velocity"] > transverse:
        yield f"transverse velocity {last['transverse_velocity']:.1e} U"
    # the density of the explicit scheme varies with the square of the Mach number
    density = BOUNDS.density * ((10.0 / cell.sound) ** 2 if cell.scheme == "explicit" else 1.0)
    if last["density_variation"] > density:
        yield f"density varies by {last['density_variation']:.1e}"
    if last["transverse_velocity"] > max(BOUNDS.growth * before["transverse_velocity"], transverse / 10):
        yield f"transverse velocity {GROWS} to {last['transverse_velocity']:.1e} U"
    if len(baseline_errors) > 1 and error > floor:
        growth = error / baseline_errors[-1] / (before["error"] / baseline_errors[-2])
        if growth > BOUNDS.growth:
            yield f"error over that of the baseline {GROWS} {growth:.3g} times"


def _two_dimensional_faults(plan: Plan, found: list[dict[str, Any]]) -> Iterator[str]:
    """Yield in words the bounds that the last sample breaks, and the bounds of voids and distances at all samples."""
    cell, (before, last) = plan.cell, found[-2:]
    if cell.kind == "curved_walls":
        largest = stability.flow_of(cell.flow).largest * (12 / cell.across) ** BOUNDS.order
    else:
        rate, order = BOUNDS.periodic[cell.scheme]
        largest = rate * max(plan.t_star, 1.0) * (25 / cell.across) ** order
    if last["error"] is not None and last["error"] > largest:
        yield f"error {last['error']:.1e} U"
    radius, distance = max(each["max_void_radius"] for each in found), min(each["min_distance"] for each in found)
    if radius > BOUNDS.void:
        yield f"a void has a radius of {radius:.3g} spacings"
    if distance < BOUNDS.distance:
        yield f"two particles are {distance:.3g} spacings apart"
    if cell.kind != "curved_walls" and last["energy"] > before["energy"] * (1.0 + BOUNDS.gain):
        yield f"energy {GROWS} by {last['energy'] / before['energy'] - 1.0:.1e}"
