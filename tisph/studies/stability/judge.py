"""What became of a cell: stable, inaccurate, stopped, refused or WRONG, by what the run left behind.

Errors are ``Cell.measure``. Two things are known without the exact solution of a user's own flow, and a run is held
to both: the calm run, the same from the lattice, and what ``tisph check`` said of it, its estimate of the error (the
stated error) and its warnings. Where the flow crosses there are bounds of their own (``spread.py``): a lattice is no
calmer there.
"""

from dataclasses import dataclass

from tisph.studies.stability import spread
from tisph.studies.stability.cells import FINISHED, HONEST, REFUSED, STABLE

MULTIPLE, EARLY_MULTIPLE = 2.0, 10.0
"""Error over that of the calm run, up to which a run is stable: from t* = 1 on, and before, while the flow still
remembers how the particles were disordered."""

TRANSVERSE, EARLY_TRANSVERSE = 1e-3, 1e-2
"""Largest velocity across the channel of a stable run, over the reference velocity, likewise."""

DENSITY = 1e-2
"""Largest departure of the density of a stable run. Of the explicit scheme at a sound speed of ten times the velocity
scale; it goes with the square of the Mach number. Of the implicit one whatever the steps."""

EXPLICIT, IMPLICIT, SINGLE, EARLY = 4e-5, 1e-6, 1e-3, 1e-2
"""Floors, errors below which one is not compared with that of the calm run.

Of the explicit scheme: by as much rows that slide past each other change the viscosity, which a lattice at a Reynolds
number so low that none slides does not know. Of the implicit one: that of steps of a tolerance of 3e-7. What single
precision allows. Before t* = 1: what disorder may make of the first moments.
"""

STATED_FACTOR = 3.0
"""Error over the stated one up to which that was right (``tisph verify --estimates``)."""

SILENT, WARNED, LARGEST = 2e-2, 0.1, 0.2
"""A finished run is WRONG if its error is above the stated one times ``STATED_FACTOR`` and above the first, or the
second where ``tisph check`` and ``tisph run`` warned; and above the third whatever was said."""

GROWTH = 2.0
"""Growth over the last quarter of a run from which on something grows: the error over that of the calm run, or a
transverse velocity above a tenth of its bound."""

VERDICTS = ("stable", "inaccurate", "stopped", "refused", "WRONG")

KEEPS = {STABLE: VERDICTS[:1], FINISHED: VERDICTS[:2], HONEST: VERDICTS[:4], REFUSED: VERDICTS[3:4]}
"""Verdicts that keep each promise."""

NUMBERS = ("error", "transverse", "density_variation", "hole", "nearest")
"""What a ``Judgement`` keeps of the last look at a run."""

GROWS = "grows"
"""Word in the reason of a verdict that breaks the promise ``FINISHED`` nevertheless."""


@dataclass(frozen=True)
class Judgement:
    """A verdict of ``VERDICTS``, why it is no better, whether the promise is kept, and the numbers behind it.

    ``error`` and ``calm`` error, ``transverse`` velocity over the reference velocity, ``density_variation``, ``hole``
    and ``nearest`` two particles (``spread.look``): at the last sample; None where there is none.
    """

    verdict: str
    reason: str
    kept: bool
    error: float | None = None
    calm: float | None = None
    transverse: float | None = None
    density_variation: float | None = None
    hole: float | None = None
    nearest: float | None = None

    @property
    def ratio(self):
        """Error over that of the calm run, None where one is missing."""
        return self.error / self.calm if self.error is not None and self.calm else None


def refused(plan):
    """Judge a cell whose config is refused."""
    return Judgement("refused", plan.refusal, "refused" in KEEPS[plan.cell.promise])


def judge(plan, summary, message, calm):
    """Judge the run of a plan by its ``summary``, its error ``message`` and the summary of the ``calm`` run."""
    looks = [_look(plan.cell, sample, summary) for sample in summary["samples"]]
    compared = calm["status"] == "done" and not plan.cell.crosses
    calm_errors = [sample[plan.cell.measure] for sample in calm["samples"]] if compared else []
    verdict, reason = _verdict(plan, summary["status"], message, looks, calm_errors)
    last = looks[-1] if looks else {}
    before = len(looks) <= len(calm_errors)
    return Judgement(
        verdict,
        reason,
        kept=verdict in KEEPS[plan.cell.promise] and not (plan.cell.promise == FINISHED and GROWS in reason),
        calm=calm_errors[len(looks) - 1] if looks and before else None,
        **{name: value for name, value in last.items() if name in NUMBERS},
    )


def _look(cell, sample, summary):
    if cell.crosses:
        return spread.look(cell, sample, summary)
    speed = summary["numbers"]["reference_velocity"]
    return {
        "error": sample[cell.measure],
        "transverse": sample["max_transverse_velocity"] / speed,
        "density_variation": sample["density_variation"],
    }


def _verdict(plan, status, message, looks, calm_errors):
    """Return verdict and reason; the reason is empty for a stable run."""
    if status == "diverged" and message:
        return "stopped", message
    if status != "done" or not looks:
        return "WRONG", f"ended without a clear error: {message or status}"
    error = looks[-1]["error"]
    if error is not None and not error <= _largest_honest(plan):
        said = "none stated" if plan.stated is None else f"stated {plan.stated:.0e}"
        return "WRONG", f"error {error:.1e}, {said}, {'warned' if plan.warnings else 'no warning'}"
    faults = list(_faults(plan, looks, calm_errors))
    return ("inaccurate", "; ".join(faults)) if faults else ("stable", "")


def _faults(plan, looks, calm_errors):
    if plan.cell.crosses:
        yield from spread.faults(plan, looks)
        return
    yield from _error_faults(plan, looks[-1]["error"], calm_errors)
    yield from _bound_faults(plan, looks[-1])
    yield from _growths(plan, looks, calm_errors)


def _largest_honest(plan):
    return min(max(STATED_FACTOR * _stated(plan), WARNED if plan.warnings else SILENT), LARGEST)


def _stated(plan):
    """Error that was stated; where it was said that none can be, the largest that is not wrong."""
    return LARGEST if plan.stated is None else plan.stated


def _floor(plan):
    """Error below which runs are not compared; steps that are longer err more, whatever the particles do.

    Some flows are exact on a lattice and no measure of others: what is not promised may err as much as was stated.
    """
    double = EXPLICIT if plan.cell.scheme == "explicit" else IMPLICIT
    floor = (double if plan.cell.precision == "f64" else SINGLE) * plan.cell.step**3
    early = EARLY if plan.t_star < 1 else 0.0
    return max(floor, early, 0.0 if plan.cell.promise == STABLE else _stated(plan))


def _error_faults(plan, error, calm_errors):
    multiple = EARLY_MULTIPLE if plan.t_star < 1 else MULTIPLE
    if error > max(STATED_FACTOR * _stated(plan), _floor(plan)) and plan.cell.jitter == 0:
        yield f"error {error:.1e}, stated {plan.stated:.0e}"
    if calm_errors and error > max(multiple * calm_errors[-1], _floor(plan)):
        yield f"error {error / calm_errors[-1]:.3g} times that of the calm run"


def _bound_faults(plan, last):
    transverse = EARLY_TRANSVERSE if plan.t_star < 1 else TRANSVERSE
    if last["transverse"] > transverse:
        yield f"transverse velocity {last['transverse']:.1e} U"
    density = DENSITY * (10.0 / plan.cell.sound) ** 2 if plan.cell.scheme == "explicit" else DENSITY
    if last["density_variation"] > density:
        yield f"density varies by {last['density_variation']:.1e}"


def _growths(plan, looks, calm_errors):
    before, last = looks[-2:]
    bound = EARLY_TRANSVERSE if plan.t_star < 1 else TRANSVERSE
    if last["transverse"] > max(GROWTH * before["transverse"], bound / 10):
        yield f"transverse velocity {GROWS} to {last['transverse']:.1e} U"
    if len(calm_errors) > 1 and last["error"] > _floor(plan):
        growth = last["error"] / calm_errors[-1] / (before["error"] / calm_errors[-2])
        if growth > GROWTH:
            yield f"error over that of the calm run {GROWS} {growth:.3g} times"
