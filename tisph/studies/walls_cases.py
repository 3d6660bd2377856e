"""The comparison of wall treatments as data: which runs, what is read from them, which treatment comes out best.

Every treatment serves every flow, from a lattice and from disordered particles, at several resolutions. The
recommendation needs no taste: of the treatments whose runs all reached their end, and whose step costs at most
``COST_LIMIT`` times that of ``REFERENCE``, it is the one with the smallest geometric mean of the errors at the
resolution ``MEASURED_AT`` over all flows and arrangements. The geometric mean makes a halved error count the same in
every flow, whatever the size of the errors there; costs are averaged over the flows in the same way.
"""

import math
from dataclasses import asdict, dataclass

import numpy as np

from tisph.measures.metrics import fitted_order
from tisph.studies import flows
from tisph.studies.expressions import Number
from tisph.studies.flows import Flow, across, jitter, treatment

FLOWS = {
    "couette": flows.COUETTE,
    "poiseuille": flows.POISEUILLE,
    "backflow": flows.BACKFLOW,
    "oscillating": flows.OSCILLATING,
    "oldroyd_b_couette": flows.OLDROYD_B_COUETTE,
    "oldroyd_b_poiseuille": flows.OLDROYD_B_POISEUILLE,
}

TIMES = {"oldroyd_b_couette": (0.5, 1.0), "oldroyd_b_poiseuille": (0.5, 1.0)}
"""Times t* of the errors, where they are not those of the flow's samples. An error that changes sign is small once."""

COLUMNS = 10
"""Particles along the channel, as few as the neighbour search allows: nothing depends on x but the disorder."""

ARRANGEMENTS = {"lattice": 0.0, "jitter 0.2": 0.2}
"""Random displacement of the particles at the start, in spacings."""

REFERENCE = "comoving_image"
COST_LIMIT = 1.3

ONE_THREAD = {"runtime": {"threads": 1}}


@dataclass(frozen=True)
class Extent:
    """How much is compared: particles across the gap, which of them counts, arrangements of the particles."""

    resolutions: tuple[int, ...]
    measured_at: int
    arrangements: tuple[str, ...]


FULL = Extent((12, 25, 50, 100), 50, tuple(ARRANGEMENTS))
QUICK = Extent((25, 50), 50, ("lattice",))


@dataclass(frozen=True)
class Case:
    """One row of the table: a flow and a treatment, by name, and an arrangement of the particles."""

    flow: str
    treatment: str
    arrangement: str

    @property
    def times(self):
        """Dimensionless times; the largest error counts."""
        return TIMES.get(self.flow, self._flow.samples)

    @property
    def measure(self):
        """Error that is compared: l2, or rms where u crosses zero."""
        return self._flow.measure

    @property
    def title(self):
        """Name of the flow."""
        return self._flow.title

    def name(self, number):
        """Name of the run at ``number`` particles across."""
        return f"{self.flow}-{self.treatment}-{self.arrangement.replace(' ', '_')}-{number}"

    def config(self, number):
        """Config of the run at ``number`` particles across, on one thread."""
        length = {"geometry": {"length": flows.digits(COLUMNS / number)}}
        disorder = jitter(ARRANGEMENTS[self.arrangement])
        return self._flow.at(
            across(number), length, disorder, treatment(self.treatment), ONE_THREAD, samples=self.times
        )

    @property
    def _flow(self) -> Flow:
        return FLOWS[self.flow]


@dataclass(frozen=True)
class Row:
    """What the runs of a case showed; NaN where a run gave no number.

    ``errors`` by particles across, the largest of all times; ``order`` of their fall; ``wall_shear`` error, see
    ``wall_shear_error``; ``stress_error`` = ``shear_stress_l2``, None without polymer; ``cost``: seconds of a step over
    those of ``REFERENCE``; ``stopped``: messages of runs that did not reach their end.
    """

    case: Case
    errors: dict[int, float]
    order: float
    wall_shear: float
    stress_error: float | None
    cost: float
    stopped: dict[str, str]


def cases(flow, treatments, extent):
    """Rows of a flow: every arrangement of each of ``treatments``."""
    return [Case(flow, name, arrangement) for name in treatments for arrangement in extent.arrangements]


def runs(cases, extent):
    """Configs of the runs of ``cases`` that give errors, by name."""
    return {case.name(number): case.config(number) for case in cases for number in extent.resolutions}


def rows(cases, outcomes, extent):
    """``Row`` s of the ``cases`` of a flow from the (``Result``, message) of all their runs by name."""
    seconds = {case: step_seconds(outcomes[case.name(extent.measured_at)][0]) for case in cases}
    reference = {case.arrangement: seconds[case] for case in cases if case.treatment == REFERENCE}
    for case in cases:
        results = {number: outcomes[case.name(number)] for number in extent.resolutions}
        yield row(case, results, extent.measured_at, seconds[case] / reference[case.arrangement])


def step_seconds(result):
    """Seconds for a step of a run; NaN where it did not reach its end."""
    cost = result.summary.get("cost") if result.summary["status"] == "done" else None
    return cost["wall_loop_s"] / cost["steps"] if cost else math.nan


def row(case, results, measured_at, cost):
    """The ``Row`` of a case; ``results`` maps particles across to (``Result``, message)."""

    def largest(number, measure):
        result, value = results[number][0], Number(measure, "measure")
        return float(np.max([value(result, result.sample(time)) for time in case.times]))

    errors = {number: largest(number, case.measure) for number in results}
    viscoelastic = "rheology" in FLOWS[case.flow].config["fluid"]
    return Row(
        case=case,
        errors=errors,
        order=fitted_order(errors.keys(), list(errors.values())),
        wall_shear=largest(measured_at, "wall_shear"),
        stress_error=largest(measured_at, "shear_stress_l2") if viscoelastic else None,
        cost=cost,
        stopped={case.name(number): message for number, (_, message) in results.items() if message},
    )


@dataclass(frozen=True)
class Standing:
    """A treatment over all rows: geometric means of its errors and costs, and how many of its runs stopped."""

    treatment: str
    error: float
    cost: float
    stopped: int

    @property
    def eligible(self):
        """Whether every run reached its end, at a cost within the limit."""
        return self.stopped == 0 and math.isfinite(self.error) and self.cost <= COST_LIMIT


def standings(rows, measured_at):
    """``Standing`` of each treatment in ``rows``, in the order in which they appear."""
    by_treatment = {}
    for entry in rows:
        by_treatment.setdefault(entry.case.treatment, []).append(entry)
    return [
        Standing(
            treatment=name,
            error=_geometric_mean([entry.errors[measured_at] for entry in own]),
            cost=_geometric_mean([entry.cost for entry in own]),
            stopped=sum(len(entry.stopped) for entry in own),
        )
        for name, own in by_treatment.items()
    ]


def recommended(found):
    """Name of the eligible treatment with the smallest mean error among the ``Standing`` s; None without one."""
    eligible = [standing for standing in found if standing.eligible]
    return min(eligible, key=lambda standing: standing.error).treatment if eligible else None


def _geometric_mean(values):
    return float(np.exp(np.mean(np.log(values)))) if values else math.nan


def as_data(rows, laplacians, measured_at):
    """Every number of the comparison, to be written as JSON; null where there is none."""
    found = standings(rows, measured_at)
    return {
        "measured_at": measured_at,
        "cost_limit": COST_LIMIT,
        "recommended": recommended(found),
        "treatments": [_without_nan(asdict(standing)) for standing in found],
        "rows": [
            _without_nan({**asdict(entry), "t_star": entry.case.times, "measure": entry.case.measure}) for entry in rows
        ],
        "laplacians": [_without_nan({**asdict(entry), "orders": entry.orders}) for entry in laplacians],
    }


def _without_nan(data):
    if isinstance(data, dict):
        return {str(key): _without_nan(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data
